# SPDX-License-Identifier: Apache-2.0
"""What the commands of parallel grippers mean for this one, and what they are answered."""

import math

import pytest
from ros.control_bench import rows
from ros.records import agrees, told

from spiral_core import NotGrippableError
from spiral_gripper_ros.actions.gripper_command import goal_from_command
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.planning.planner import GripperPlanner

OPEN = 0.1
LIMITS = Limits(pressure_cap=1.0e5, grip_ratio=1.1)
# Position, opening, max_effort: what could be gripped may mean a release; 90 mm cannot be.
COMMANDS = """
0.04 0.1 0
0.04 0.1 1000
0.04 0.1 1e-3
0.05 0.05 0
0.0499 0.05 0
0.09 0.1 1
nan 0.1 0
0 0.1 0
0.04 0.1 nan
0.04 0.1 -1
0.1 0.1 inf
"""


def test_a_command_means_the_goal_or_the_refusal_on_record(planner):
    found = []
    for row in rows(COMMANDS):
        position, opening, effort = map(float, row.split())
        goal = goal_from_command([position], [effort], opening, planner, LIMITS)
        found.append(f"# {row}: {type(goal).__name__}\n{told(goal)}")
    agrees("commands", "".join(found))


def test_a_limit_of_the_force_lowers_the_overpressure_or_is_refused(planner):
    plan = planner.plan(0.02)
    bare, grip = (planner.contact_force(plan, f * plan.pressure) for f in (1.0, 1.1))
    assert bare == pytest.approx(plan.line_force(plan.pressure) * plan.wrap.contact_length)

    for part in (0.001, 0.1, 0.9):
        limit = bare + part * (grip - bare)
        goal = goal_from_command([0.04], [limit], OPEN, planner, LIMITS)
        force = planner.contact_force(plan, plan.pressure + goal.overpressure)
        assert force == pytest.approx(limit, rel=1e-9)


def test_diameter_and_force_are_those_of_the_pressure(planner):
    plan, curve = planner.plan(0.02), planner.curve
    nothing = GripperPlanner(planner.gripper, NotGrippableError(0.02, "nothing", -1.0, None))
    assert planner.contact_force(plan, 0.5 * plan.pressure) == 0.0
    for pressure, diameter in (
        (planner.plan(0.035).pressure, pytest.approx(0.07, rel=1e-8)),  # to 1e-9 of the radius
        (0.99 * curve.pressure_min, OPEN),
        (math.nan, OPEN),
        (curve.pressure_max + 5.0e3, 2.0 * curve.radius_min),
    ):
        assert planner.wrapped_diameter(pressure, OPEN) == diameter
        assert nothing.wrapped_diameter(pressure, OPEN) == OPEN
