# SPDX-License-Identifier: Apache-2.0
import math

import pytest
from ros.fakes import FakePlan

from spiral_gripper_ros.control.grasp import Grasp, GraspGoal
from spiral_gripper_ros.control.limits import AbortPolicy, Limits
from spiral_gripper_ros.control.pressure_monitor import PERSISTENCE
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State

LIMITS = Limits(
    pressure_cap=1.0e5,
    grasp_timeout=3.0,
    pressure_settle_time=0.5,
    pressure_tolerance=1.0e3,
)
FAILED = Refusal(Reason.GRASP_TIMEOUT, "too late")


def snapshot(command=0.0, target=5.0e4, radius=0.02):
    return Snapshot(
        state=State.GRASPING,
        refusal=NOT_REFUSED,
        radius=radius,
        plan=FakePlan(target),
        radius_age=None,
        pressure_target=target,
        pressure_command=command,
        accepted=0,
        refused={},
    )


def test_a_goal_comes_before_the_parameters():
    goal = GraspGoal(None, timeout=1.0, abort_policy=AbortPolicy.HOLD)
    grasp = Grasp(goal, 10.0, snapshot(), LIMITS)
    assert grasp.abort_policy is AbortPolicy.HOLD
    assert not grasp.is_late(11.0)
    assert grasp.is_late(math.nextafter(11.0, 12.0))
    assert grasp.elapsed(10.5) == 0.5


def test_as_commanded_it_is_settled_after_the_settling_time_at_the_target():
    grasp = Grasp(GraspGoal(0.02), 0.0, snapshot(), LIMITS)
    assert not grasp.is_settled(1.0, False, LIMITS)
    grasp.commanded(1.0, 5.0e4, 5.0e4)
    assert not grasp.is_settled(1.49, False, LIMITS)
    assert grasp.is_settled(1.5, False, LIMITS)
    grasp.commanded(1.6, 5.0e4, 6.0e4)
    assert not grasp.is_settled(1.6, False, LIMITS)
    grasp.commanded(1.7, 6.0e4, 6.0e4)
    assert not grasp.is_settled(2.1, False, LIMITS)


def test_as_measured_it_is_settled_once_the_pressure_has_stayed_at_the_target():
    grasp = Grasp(GraspGoal(0.02), 0.0, snapshot(), LIMITS)
    grasp.commanded(1.0, 5.0e4, 5.0e4)
    grasp.measured(1.0, 4.91e4, 5.0e4, LIMITS)
    assert not grasp.is_settled(9.0, True, LIMITS)
    grasp.measured(1.0 + 0.99 * PERSISTENCE, 5.0e4, 5.0e4, LIMITS)
    assert not grasp.is_settled(9.0, True, LIMITS)
    grasp.measured(1.0 + 1.01 * PERSISTENCE, 5.0e4, 5.0e4, LIMITS)
    assert grasp.is_settled(1.0 + 1.01 * PERSISTENCE, True, LIMITS)
    grasp.measured(1.3, 4.8e4, 5.0e4, LIMITS)
    assert not grasp.is_settled(1.3, True, LIMITS)


def test_what_was_measured_before_the_command_arrived_does_not_count():
    grasp = Grasp(GraspGoal(0.02), 0.0, snapshot(), LIMITS)
    grasp.measured(0.0, 5.0e4, 5.0e4, LIMITS)
    grasp.measured(1.0, 5.0e4, 5.0e4, LIMITS)
    assert not grasp.is_settled(1.0, True, LIMITS)
    grasp.commanded(1.0, 4.9e4, 5.0e4)
    grasp.commanded(1.1, 5.0e4, 5.0e4)
    assert not grasp.is_settled(1.1, True, LIMITS)


@pytest.mark.parametrize(
    ("start", "command", "target", "expected"),
    [
        (0.0, 0.0, 5.0e4, 0.0),
        (0.0, 1.0e4, 5.0e4, 0.2),
        (0.0, 5.0e4, 5.0e4, 1.0),
        (8.0e4, 5.0e4, 4.0e4, 0.75),
        (5.0e4, 5.0e4, 5.0e4, 1.0),
        (2.0e4, 1.0e4, 5.0e4, 0.0),
        (2.0e4, 6.0e4, 5.0e4, 1.0),
        (5.0e4, 4.0e4, 5.0e4, 0.0),
    ],
)
def test_progress_is_the_commands_part_of_the_way(start, command, target, expected):
    grasp = Grasp(GraspGoal(0.02), 0.0, snapshot(command=start), LIMITS)
    assert grasp.progress(command, target) == pytest.approx(expected)
