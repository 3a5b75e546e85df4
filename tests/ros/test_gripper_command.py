# SPDX-License-Identifier: Apache-2.0
"""What the commands of parallel grippers mean for this one; no ROS."""

import math

import pytest

from spiral_core import NotGrippableError
from spiral_gripper_ros.actions.gripper_command import goal_from_command
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import AbortPolicy, Limits
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.planning.planner import GripperPlanner, NoPlanner

OPEN, DIAMETER = 0.1, 0.04
LIMITS = Limits(pressure_cap=1.0e5)
TIGHT = Limits(pressure_cap=1.0e5, grip_ratio=1.1)


def held(radius, overpressure=None):
    """Return the goal of a command: whatever ends it, the pressure stays."""
    return GraspGoal(radius, overpressure=overpressure, abort_policy=AbortPolicy.HOLD)


@pytest.fixture(scope="module")
def planner(gripper):
    return GripperPlanner(gripper)


@pytest.fixture(scope="module")
def nothing():
    return NoPlanner((9.80665, 0.0, 0.0), NotGrippableError(0.02, "nothing can be", -1.0, None))


@pytest.mark.parametrize(
    ("position", "opening", "effort", "expected"),
    [
        (DIAMETER, OPEN, 0.0, held(0.02)),
        (OPEN, OPEN, 0.0, ReleaseGoal()),
        (0.05, 0.05, 0.0, ReleaseGoal()),  # though it could be gripped
        (0.0499, 0.05, 0.0, held(0.02495)),
        (0.09, OPEN, 1.0, GraspGoal(0.045)),  # refused when it is started
    ],
)
def test_a_position_is_the_diameter_of_an_object_or_means_release(
    planner, position, opening, effort, expected
):
    goal = goal_from_command([position], [effort], opening, planner, LIMITS)
    assert goal == expected


@pytest.mark.parametrize(
    ("position", "effort", "reason"),
    [
        (math.nan, 0.0, Reason.RADIUS_NOT_FINITE),
        (0.0, 0.0, Reason.RADIUS_NOT_POSITIVE),
        (DIAMETER, math.nan, Reason.INVALID_REQUEST),
        (DIAMETER, -1.0, Reason.INVALID_REQUEST),
        (OPEN, math.inf, Reason.INVALID_REQUEST),
    ],
)
def test_an_impossible_command_is_refused(planner, position, effort, reason):
    refusal = goal_from_command([position], [effort], OPEN, planner, LIMITS)
    assert refusal.reason is reason


def test_a_limit_of_the_force_lowers_the_overpressure_or_is_refused(planner):
    plan = planner.plan(0.02)
    bare, grip = (planner.contact_force(plan, f * plan.pressure) for f in (1.0, 1.1))
    assert bare == pytest.approx(plan.line_force(plan.pressure) * plan.wrap.contact_length)

    def goal(limit):
        return goal_from_command([DIAMETER], [limit], OPEN, planner, TIGHT)

    assert "max_effort" in goal(0.999 * bare).text
    for part in (0.001, 0.1, 0.9):
        limit = bare + part * (grip - bare)
        kept = goal(limit)
        assert kept == held(0.02, kept.overpressure)
        force = planner.contact_force(plan, plan.pressure + kept.overpressure)
        assert force == pytest.approx(limit, rel=1e-3)  # the overpressure is found to 1 Pa
    # A number: what is recommended once contact is known may press harder.
    assert goal(1.001 * grip) == held(0.02, pytest.approx(0.1 * plan.pressure))


def test_the_force_grows_with_the_pressure_and_is_never_negative(planner, nothing):
    plan = planner.plan(0.02)
    more, at_it, less = (
        planner.contact_force(plan, pressure)
        for pressure in (plan.pressure + 1.0e4, plan.pressure, 0.5 * plan.pressure)
    )
    assert more > 10.0 * at_it > less == nothing.contact_force(plan, plan.pressure) == 0.0


def test_the_diameter_of_a_pressure_is_that_of_the_object_it_wraps(planner, nothing):
    for radius in (6e-3, 0.035):
        # The wrap is found to 1e-9 of the radius.
        wanted = pytest.approx(2.0 * radius, rel=1e-8)
        assert planner.wrapped_diameter(planner.plan(radius).pressure, OPEN) == wanted
    low, high = planner.curve.pressure_min, planner.curve.pressure_max
    smallest = 2.0 * planner.curve.radius_min
    for pressure, diameter in ((0.99 * low, OPEN), (math.nan, OPEN), (high, smallest)):
        assert planner.wrapped_diameter(pressure, OPEN) == diameter
    assert planner.wrapped_diameter(high + 5.0e3, OPEN) == smallest
    assert nothing.wrapped_diameter(1.0e5, OPEN) == OPEN


def test_a_joint_state_is_a_command_if_it_is_a_single_one():
    assert goal_from_command([0.04], [], OPEN, None, LIMITS) == held(0.02)
    for position, effort in (([], []), ([0.02, 0.02], []), ([0.02], [1.0, 1.0])):
        refusal = goal_from_command(position, effort, OPEN, None, LIMITS)
        assert refusal.reason is Reason.INVALID_REQUEST
