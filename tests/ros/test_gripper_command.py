# SPDX-License-Identifier: Apache-2.0
"""What the commands of parallel grippers mean for this one; no ROS."""

import math
from dataclasses import replace

import pytest

from spiral_core import NotGrippableError
from spiral_gripper_ros.actions.gripper_command import (
    OpeningCommand,
    command_from_joint,
    contact_force,
    goal_from_command,
    wrapped_diameter,
)
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import AbortPolicy, Limits
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.planning.planner import GripperPlanner, NoPlanner

OPEN = 0.1
LIMITS = Limits(pressure_cap=1.0e5)
TIGHT = Limits(pressure_cap=1.0e5, grip_ratio=1.1)
DIAMETER = 0.04


def held(radius):
    """Return the goal of a command: whatever ends it, the pressure stays."""
    return GraspGoal(radius, abort_policy=AbortPolicy.HOLD)


@pytest.fixture(scope="module")
def planner(gripper):
    return GripperPlanner(gripper)


@pytest.fixture(scope="module")
def nothing():
    return NoPlanner((9.80665, 0.0, 0.0), NotGrippableError(0.02, "nothing can be", -1.0, None))


def test_the_position_is_the_diameter_of_the_object(planner):
    assert goal_from_command(OpeningCommand(DIAMETER), OPEN, planner, LIMITS) == held(0.02)


@pytest.mark.parametrize("position", [OPEN, 0.15, 1.0e3])
def test_from_the_opening_on_a_position_means_release(planner, position):
    assert goal_from_command(OpeningCommand(position), OPEN, planner, LIMITS) == ReleaseGoal()


def test_an_opening_within_the_grippable_range_still_means_release(planner):
    assert goal_from_command(OpeningCommand(0.05), 0.05, planner, LIMITS) == ReleaseGoal()
    assert goal_from_command(OpeningCommand(0.0499), 0.05, planner, LIMITS) == held(0.02495)


@pytest.mark.parametrize(
    ("position", "effort", "reason"),
    [
        (math.nan, 0.0, Reason.RADIUS_NOT_FINITE),
        (math.inf, 0.0, Reason.RADIUS_NOT_FINITE),
        (-math.inf, 0.0, Reason.RADIUS_NOT_FINITE),
        (0.0, 0.0, Reason.RADIUS_NOT_POSITIVE),
        (-0.01, 0.0, Reason.RADIUS_NOT_POSITIVE),
        (DIAMETER, math.nan, Reason.INVALID_REQUEST),
        (DIAMETER, -1.0, Reason.INVALID_REQUEST),
        (OPEN, math.inf, Reason.INVALID_REQUEST),
    ],
)
def test_an_impossible_command_is_refused(planner, position, effort, reason):
    refusal = goal_from_command(OpeningCommand(position, effort), OPEN, planner, LIMITS)
    assert isinstance(refusal, Refusal)
    assert refusal.reason is reason
    assert refusal.text


def test_a_limit_below_the_force_of_the_wrap_is_refused_one_above_is_kept(planner):
    plan = planner.plan(0.02)
    force = contact_force(plan, planner, plan.pressure)
    assert force == pytest.approx(plan.line_force * plan.wrap.contact_length)
    kept = goal_from_command(OpeningCommand(DIAMETER, 1.001 * force), OPEN, planner, LIMITS)
    assert kept == replace(held(0.02), overpressure=0.0)  # LIMITS: the bare wrap
    refusal = goal_from_command(OpeningCommand(DIAMETER, 0.999 * force), OPEN, planner, LIMITS)
    assert refusal.reason is Reason.INVALID_REQUEST
    assert "max_effort" in refusal.text


@pytest.mark.parametrize("part", [0.0, 0.1, 0.9])
def test_a_limit_below_the_force_of_the_default_grip_lowers_its_overpressure(planner, part):
    plan = planner.plan(0.02)
    bare, grip = (contact_force(plan, planner, f * plan.pressure) for f in (1.0, 1.1))
    limit = bare + part * (grip - bare)
    goal = goal_from_command(OpeningCommand(DIAMETER, limit), OPEN, planner, TIGHT)
    force = contact_force(plan, planner, plan.pressure + goal.overpressure)
    assert 0.0 <= goal.overpressure < 0.1 * plan.pressure
    assert force == pytest.approx(limit, rel=1e-3)  # the overpressure is found to 1 Pa
    loose = goal_from_command(OpeningCommand(DIAMETER, 1.001 * grip), OPEN, planner, TIGHT)
    # A number: what is recommended once contact is known may press harder.
    assert loose == replace(held(0.02), overpressure=pytest.approx(0.1 * plan.pressure))


def test_what_cannot_be_gripped_is_left_to_the_grasp_to_refuse(planner, nothing):
    assert goal_from_command(OpeningCommand(0.09, 1.0), OPEN, planner, LIMITS) == GraspGoal(0.045)
    assert goal_from_command(OpeningCommand(DIAMETER, 1.0), OPEN, nothing, LIMITS) == GraspGoal(
        0.02
    )


def test_the_force_grows_with_the_pressure_and_is_never_negative(planner, nothing):
    plan = planner.plan(0.02)
    assert contact_force(plan, planner, plan.pressure + 1.0e4) > 10.0 * contact_force(
        plan, planner, plan.pressure
    )
    assert contact_force(plan, planner, 0.5 * plan.pressure) == 0.0
    assert contact_force(plan, nothing, plan.pressure) == 0.0


@pytest.mark.parametrize("radius", [0.006, 0.02, 0.035])
def test_the_diameter_of_a_pressure_is_that_of_the_object_it_wraps(planner, radius):
    pressure = planner.plan(radius).pressure
    # The wrap is found to 1e-9 of the radius.
    assert wrapped_diameter(pressure, OPEN, planner) == pytest.approx(2.0 * radius, rel=1e-8)


def test_a_pressure_that_wraps_nothing_is_an_open_gripper(planner, nothing):
    low, high = planner.curve.pressure_min, planner.curve.pressure_max
    assert wrapped_diameter(0.0, OPEN, planner) == OPEN
    assert wrapped_diameter(0.99 * low, OPEN, planner) == OPEN
    assert wrapped_diameter(math.nan, OPEN, planner) == OPEN
    assert wrapped_diameter(1.0e5, OPEN, nothing) == OPEN
    assert wrapped_diameter(1.0e5, OPEN, None) == OPEN
    smallest = 2.0 * planner.curve.radius_min
    assert wrapped_diameter(high, OPEN, planner) == smallest
    assert wrapped_diameter(high + 5.0e3, OPEN, planner) == smallest


@pytest.mark.parametrize(
    ("position", "effort"), [([], []), ([0.02, 0.02], []), ([0.02], [1.0, 1.0])]
)
def test_a_joint_state_that_is_no_single_command_is_refused(position, effort):
    assert command_from_joint(position, effort).reason is Reason.INVALID_REQUEST


def test_a_joint_state_is_a_command():
    assert command_from_joint([0.04], [2.0]) == OpeningCommand(0.04, 2.0)
