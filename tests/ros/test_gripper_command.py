# SPDX-License-Identifier: Apache-2.0
"""What the commands of parallel grippers mean for this one, and what they are answered."""

import math

import pytest
from ros.control_bench import rows, value

from spiral_core import NotGrippableError
from spiral_gripper_ros.actions.gripper_command import goal_from_command
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import AbortPolicy, Limits
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.planning.planner import NoPlanner

OPEN = 0.1
LIMITS = Limits(pressure_cap=1.0e5, grip_ratio=1.1)


def held(radius, overpressure=None):
    """Return the goal of a command: whatever ends it, the pressure stays."""
    return GraspGoal(radius, overpressure=overpressure, abort_policy=AbortPolicy.HOLD)


def test_a_position_is_the_diameter_of_an_object_or_means_release(planner):
    for position, opening, effort, expected in (
        (0.04, OPEN, 0.0, held(0.02)),
        (0.05, 0.05, 0.0, ReleaseGoal()),  # though it could be gripped
        (0.0499, 0.05, 0.0, held(0.02495)),
        (0.09, OPEN, 1.0, GraspGoal(0.045)),  # refused when it is started
    ):
        assert goal_from_command([position], [effort], opening, planner, LIMITS) == expected


IMPOSSIBLE = """
nan 0 RADIUS_NOT_FINITE
0 0 RADIUS_NOT_POSITIVE
0.04 nan INVALID_REQUEST
0.04 -1 INVALID_REQUEST
0.1 inf INVALID_REQUEST
"""


def test_an_impossible_command_is_refused(planner):
    for row in rows(IMPOSSIBLE):
        position, effort, reason = map(value, row.split())
        refusal = goal_from_command([position], [effort], OPEN, planner, LIMITS)
        assert refusal.reason.name == reason


def test_a_limit_of_the_force_lowers_the_overpressure_or_is_refused(planner):
    plan = planner.plan(0.02)
    bare, grip = (planner.contact_force(plan, f * plan.pressure) for f in (1.0, 1.1))
    assert bare == pytest.approx(plan.line_force(plan.pressure) * plan.wrap.contact_length)

    def goal(limit):
        return goal_from_command([0.04], [limit], OPEN, planner, LIMITS)

    assert "max_effort" in goal(0.999 * bare).text
    for part in (0.001, 0.1, 0.9):
        limit = bare + part * (grip - bare)
        kept = goal(limit).overpressure
        force = planner.contact_force(plan, plan.pressure + kept)
        assert force == pytest.approx(limit, rel=1e-3)  # the overpressure is found to 1 Pa
    # A number: what is recommended once contact is known may press harder.
    assert goal(1.001 * grip) == held(0.02, pytest.approx(0.1 * plan.pressure))


def test_diameter_and_force_are_those_of_the_pressure(planner):
    plan, curve = planner.plan(0.02), planner.curve
    error = NotGrippableError(0.02, "nothing can be", -1.0, None)
    nothing = NoPlanner((9.80665, 0.0, 0.0), error)
    assert planner.contact_force(plan, 0.5 * plan.pressure) == 0.0
    assert nothing.contact_force(plan, plan.pressure) == 0.0
    for pressure, diameter in (
        (planner.plan(0.035).pressure, pytest.approx(0.07, rel=1e-8)),  # to 1e-9 of the radius
        (0.99 * curve.pressure_min, OPEN),
        (math.nan, OPEN),
        (curve.pressure_max + 5.0e3, 2.0 * curve.radius_min),
    ):
        assert planner.wrapped_diameter(pressure, OPEN) == diameter
        assert nothing.wrapped_diameter(pressure, OPEN) == OPEN
