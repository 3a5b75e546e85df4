# SPDX-License-Identifier: Apache-2.0
"""The process that solves grips, and who asks it."""

import math

import pytest
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from ros.harness import DESIGN_DEADLINE, RunningNode, all_finite

from spiral_core.errors import NotGrippableError
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.planning.grip_figures import GripQuestion
from spiral_gripper_ros.planning.grip_worker import (
    GripProcess,
    SharedGripProcess,
)
from spiral_gripper_ros.planning.worker_process import EndedError


def test_a_process_solves_grips_until_it_is_ended(gripper):
    process = GripProcess()
    with pytest.raises(NotGrippableError):
        process.answer(GripQuestion(gripper, 0.2))
    worker = process._process
    grip = process.answer(GripQuestion(gripper, 0.011, rate=1.5e4))
    assert process._process is worker
    # The prototype of the project's grip model: wrapped within 5 % of the tip criterion, held away
    # from the base far better than towards it.
    assert grip.onset_wrap == pytest.approx(grip.tip_pressure, rel=0.05)
    assert grip.away[-1] > 3.0 * grip.towards[-1] > 0.0
    assert (grip.settling > 0.0).any()
    assert (grip.settling < 1.0).all()  # held, it swings for less than a second
    process.end()
    assert worker.poll() is not None
    with pytest.raises(EndedError):
        process.answer(GripQuestion(gripper, 0.011))


def test_a_process_that_is_killed_is_an_answer_and_the_next_question_starts_another(gripper):
    process = GripProcess()
    with pytest.raises(NotGrippableError):
        process.answer(GripQuestion(gripper, 0.2))
    process._process.kill()
    with pytest.raises(EndedError):
        process.answer(GripQuestion(gripper, 0.2))
    with pytest.raises(NotGrippableError):
        process.answer(GripQuestion(gripper, 0.2))
    process.end()


def test_a_grip_that_nobody_waits_for_is_ended_and_the_next_process_loads_meanwhile(gripper):
    process = GripProcess()
    with pytest.raises(EndedError, match="nobody waits"):
        process.answer(GripQuestion(gripper, 0.011), lambda: False)
    assert process._process is None  # not even asked
    looks = iter([True, True])
    with pytest.raises(EndedError, match="nobody waits"):
        process.answer(GripQuestion(gripper, 0.011), lambda: next(looks, False))
    waiting = process._process
    assert waiting.poll() is None
    with pytest.raises(NotGrippableError):
        process.answer(GripQuestion(gripper, 0.2))
    assert process._process is waiting
    process.end()


def test_all_nodes_of_a_program_share_one_process_that_ends_with_the_last(gripper):
    one, other = SharedGripProcess(), SharedGripProcess()
    for share in (one, other):
        with pytest.raises(NotGrippableError):
            share.answer(GripQuestion(gripper, 0.2))
    assert one._shared is other._shared
    worker = one._shared._process
    one.end()
    one.end()
    with pytest.raises(EndedError):
        one.answer(GripQuestion(gripper, 0.2))
    assert worker.poll() is None
    with pytest.raises(NotGrippableError):
        other.answer(GripQuestion(gripper, 0.2))
    other.end()
    assert worker.poll() is not None
    later = SharedGripProcess()
    with pytest.raises(NotGrippableError):
        later.answer(GripQuestion(gripper, 0.2))
    later.end()


def with_grip(client, **fields):
    """Ask for a plan with its grip, patiently: the first may have to compile."""
    request = PlanWrap.Request(object_radius=0.011, compute_grip=True, **fields)
    return client.call(PlanWrap, "plan_wrap", request, deadline=DESIGN_DEADLINE)


@pytest.mark.slow
def test_plan_wrap_computes_the_grip_if_it_is_asked_for(client, namespace):
    with RunningNode(namespace) as node:
        client.wait_until_active()
        assert not client.plan_wrap(0.011).grip.known
        laid = with_grip(client, overpressure=8.0e3, payload=0.02)
        assert laid.success, laid.message
        assert all_finite(laid)
        grip = laid.grip
        assert grip.known
        assert not grip.at_pose
        assert grip.friction_coefficient == 0.3
        assert grip.holding_force_away > grip.holding_force_towards > 0.0
        weight = 0.02 * 9.80665
        assert grip.payload_margin == pytest.approx(grip.holding_force_down - weight)
        # Put where the free coil would wrap it, given as a pose, it is held alike.
        axis, center = laid.object_axis, laid.object_center
        w = math.sqrt(0.5 * (1.0 + axis.z))
        turn = Quaternion(x=-0.5 * axis.y / w, y=0.5 * axis.x / w, w=w)
        pose = Pose(position=Point(x=center.x, y=center.y, z=center.z), orientation=turn)
        placed = with_grip(client, overpressure=8.0e3, object_pose=[pose])
        assert placed.grip.at_pose
        assert placed.grip.normal_force == pytest.approx(grip.normal_force, rel=0.2)
        nowhere = Pose(position=Point(x=math.nan))
        bad = with_grip(client, object_pose=[nowhere])
        assert bad.reason == Reason.INVALID_REQUEST
        assert not client.plan_wrap(0.011, gravity=[Vector3(z=-9.8)]).grip.known
        assert node.stop() == 0
        assert "Traceback" not in node.log()
