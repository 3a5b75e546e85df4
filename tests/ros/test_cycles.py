# SPDX-License-Identifier: Apache-2.0
"""The cycles of benchmarks/ros/cycles.py: no unsafe command, and unsafe ones are noticed."""

import time

import pytest
from geometry_msgs.msg import Vector3Stamped

from benchmarks.ros.cycles import Rig, UnsafeCommandError, run_cycles


@pytest.fixture
def rig():
    rig = Rig(seed=3)
    rig.radius = 0.02
    rig.run(1.5)
    assert rig.node.runtime.control.snapshot().wrapped
    yield rig
    rig.node.destroy_node()


def test_some_cycles_with_faults_are_safe():
    rig = run_cycles(8, seed=2)
    assert rig.commands > 800
    assert rig.wrapped > 0


# A command, and why it is unsafe.
UNSAFE = {
    "nan": "outside",
    "-1": "outside",
    "1e9": "outside",
    "9e4": "within",
    "0": "let go because of NONE",
}


@pytest.mark.parametrize("unsafe", UNSAFE)
def test_an_unsafe_command_is_noticed(rig, unsafe):
    with pytest.raises(UnsafeCommandError, match=UNSAFE[unsafe]):
        rig.node.runtime.outputs.publish_pressure(float(unsafe))


def test_the_gravity_of_a_trembling_arm_does_not_let_wrapped_flip(rig):
    gravities, runtime = set(), rig.node.runtime
    while len(gravities) < 8:
        message = Vector3Stamped()
        message.vector.x = 9.80665 + rig.random.gauss(0.0, 0.3)
        message.vector.y = rig.random.gauss(0.0, 0.3)
        rig.hear("gravity", message)
        time.sleep(0.02)  # the shapes are solved anew in the background
        rig.tick()
        gravities.add(runtime.loaded.planner.gravity)
        assert runtime.control.snapshot().wrapped
