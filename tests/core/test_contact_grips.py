# SPDX-License-Identifier: Apache-2.0
"""Random grips are certified and in balance; the judge sees what is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.grips import faults, grip_one, random_grip
from benchmarks.held import random_setup
from spiral_core import Pull, grip_window, holding_force, lay_into_coil
from spiral_core.grip.window import WindowEnd
from spiral_core.rod.contact.solve import follow_contact, solve_contact
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long


@pytest.mark.slow
@pytest.mark.parametrize("index", range(6))
def test_random_grip_is_certified(index: int) -> None:
    assert grip_one(index).verdict == "certified"


def test_judge_sees_forces_that_do_not_balance() -> None:
    stations = random_grip(3).stations()
    state = follow_contact(stations).states[-1]
    assert faults(stations[-1], state) == []
    lighter = replace(state, contact_forces=0.99 * state.contact_forces)
    assert {"force", "moment"} <= set(faults(stations[-1], lighter))
    sunk = state.positions + np.array([0.0, 1e-3, 0.0])
    assert "penetration" in faults(stations[-1], replace(state, positions=sunk))
    assert "not stable" in faults(stations[-1], replace(state, smallest_pivot=-1.0))


def test_grip_with_friction_solved_again_stays_where_it_is() -> None:
    """Where the interior point left forces at nodes that do not touch, sliding began anew."""
    window = grip_window(random_setup(546))
    for point in window.points:
        problem = window.setup.closing_problem(point.pressure)
        again = solve_contact(problem, start=point.state)
        np.testing.assert_allclose(again.positions, point.state.positions, rtol=0.0, atol=1e-9)
    assert holding_force(window.at(window.onset_wrap), Pull.AWAY).force > 0.1


def test_coil_whose_forces_inside_exceed_its_loads_is_followed() -> None:
    """Without gravity the rounding of its forces exceeded a tolerance by its loads."""
    gripper = load_gripper("paper_design_70").with_mount((0.0, 0.0, 0.0), None)
    window = grip_window(lay_into_coil(gripper, 0.012, friction=1.0))
    assert window.end is WindowEnd.LIMIT
    for point in window.points[1:]:
        again = solve_contact(window.setup.closing_problem(point.pressure), start=point.state)
        np.testing.assert_allclose(again.positions, point.state.positions, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("seed", "end"),
    [
        (62, WindowEnd.PASSED_BY),
        pytest.param(475, WindowEnd.PASSED_BY, marks=pytest.mark.slow),
        pytest.param(936, WindowEnd.LOST, marks=pytest.mark.slow),
    ],
)
def test_tube_balanced_on_a_point_that_slides_falls_off_it(seed: int, end: WindowEnd) -> None:
    """It rests on a saddle, or creeps: with friction both were once the end of the answer."""
    assert grip_window(random_setup(seed)).end is end


def test_snap_of_a_coil_that_has_nearly_lifted_off_is_its_loss() -> None:
    """Less than a tenth of the tube touched when it snapped: "finds no rest" was the answer."""
    window = grip_window(random_setup(793))
    assert window.end is WindowEnd.LOST
    assert 1.0 < window.loss / window.onset_wrap < 1.1
