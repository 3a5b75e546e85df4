# SPDX-License-Identifier: Apache-2.0
"""The cycles of benchmarks/ros/cycles.py: no unsafe command, and unsafe ones are noticed."""

import math
import time

import pytest
from geometry_msgs.msg import Vector3Stamped

from benchmarks.ros.cycles import FAULTS, Rig, UnsafeCommandError, run_cycles
from spiral_gripper_ros.control.grasp import GraspOutcome, GraspReport
from spiral_gripper_ros.control.release import Release


@pytest.fixture
def rig():
    rig = Rig(seed=3)
    yield rig
    rig.node.destroy_node()


def test_some_cycles_with_faults_are_safe():
    rig = run_cycles(8, seed=2)
    assert rig.commands > 800
    assert rig.wrapped > 0


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_after_each_fault_the_next_cycle_wraps_again(rig, fault):
    rig.radius = 0.02
    rig.run(1.5)
    assert rig.node.runtime.control.snapshot().wrapped
    fault(rig)
    rig.allowed |= {refusal.reason for refusal in [rig.node.runtime.control.snapshot().refusal]}
    rig.run(1.0)
    rig._release()
    rig.run(0.5)  # a gripper that kept its pressure while the link was cut empties
    rig.call("rearm")
    rig.radius = 0.02
    rig.run(2.5)
    assert rig.node.runtime.control.snapshot().wrapped


@pytest.mark.parametrize("unsafe", [math.nan, -1.0, 1.0e9, 5.0e4])
def test_an_unsafe_command_is_noticed(rig, unsafe):
    rig.run(0.1)
    with pytest.raises(UnsafeCommandError):
        rig.node.runtime.outputs.publish_pressure(unsafe)


def test_an_object_that_is_dropped_for_no_reason_is_noticed(rig):
    rig.radius = 0.02
    rig.run(1.5)
    with pytest.raises(UnsafeCommandError, match="let go because of NONE"):
        rig.node.runtime.outputs.publish_pressure(0.0)


def test_a_release_that_succeeds_untruly_is_noticed(rig, monkeypatch):
    rig.radius = 0.02
    rig.run(1.5)
    done = GraspReport(GraspOutcome.SUCCEEDED)
    monkeypatch.setattr(Release, "update", lambda release, *_: setattr(release, "report", done))
    Rig.release_with_a_cut_link(rig)
    with pytest.raises(UnsafeCommandError, match="untrue: a release"):
        rig.tick()


def test_the_gravity_of_a_trembling_arm_does_not_let_wrapped_flip(rig):
    rig.radius = 0.02
    rig.run(1.5)
    gravities, wrapped = set(), []
    while len(gravities) < 8:
        message = Vector3Stamped()
        message.vector.x = 9.80665 + rig.random.gauss(0.0, 0.3)
        message.vector.y = rig.random.gauss(0.0, 0.3)
        rig.hear("gravity", message)
        time.sleep(0.02)  # the shapes are solved anew in the background
        rig.tick()
        gravities.add(rig.node.runtime.loaded.planner.gravity)
        wrapped.append(rig.node.runtime.control.snapshot().wrapped)
    assert all(wrapped)
