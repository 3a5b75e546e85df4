# SPDX-License-Identifier: Apache-2.0
"""The gripper on a cylinder: its wrap, friction and its memory, and what was once lost."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from core.contact_cases import LENGTH, grip

from benchmarks.grips import grip_one
from benchmarks.held import random_setup
from spiral_core import Pull, grip_window, holding_force, lay_into_coil
from spiral_core.grip.window import WindowEnd
from spiral_core.rod.contact.solve import follow_contact, solve_contact
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long


@pytest.mark.parametrize(("pull", "share"), [(1e-5, 0.0), (0.016, 0.99)])
def test_increments_without_motion_move_nothing(pull, share):
    """A coil closed without friction, and then its cylinder is pulled, after that it lies still.

    Pulled by little, so that some of it sticks; and near the largest force, where all slides.
    """
    stations = [grip(0.015, 1.1, 0.3, -shift) for shift in (*np.arange(0.0, pull, 1e-3), pull)]
    start = solve_contact(grip(0.015, 1.1), elements=45)
    here = first = follow_contact(stations, start=start).states[-1]
    force = np.linalg.norm(first.on_obstacle().force)
    assert force > share * 0.688  # its largest, after 21 mm
    assert (0 < first.sticking.sum() < first.touching.sum()) == (share == 0.0)
    for _ in range(50):
        here = solve_contact(stations[-1], start=here)
    assert np.abs(here.positions - first.positions).max() < 1e-9 * LENGTH


@pytest.mark.slow
@pytest.mark.parametrize("index", range(6))
def test_random_grip_is_certified(index):
    assert grip_one(index).verdict == "certified"


def weightless():
    """Return a coil whose forces inside exceed its loads."""
    gripper = load_gripper("paper_design_70").with_mount((0.0, 0.0, 0.0), None)
    return lay_into_coil(gripper, 0.012, friction=1.0)


@pytest.mark.parametrize(
    ("make", "end"),
    [
        # The rounding of its forces exceeded a tolerance by its loads.
        (weightless, WindowEnd.LIMIT),
        # Where the interior point left forces at nodes that do not touch, sliding began anew.
        (partial(random_setup, 546), WindowEnd.LOST),
        # It rests on a saddle, or creeps: with friction both were once the end of the answer.
        (partial(random_setup, 62), WindowEnd.PASSED_BY),
        # Less than a tenth of the tube touched when it snapped: "finds no rest" was the answer.
        (partial(random_setup, 793), WindowEnd.LOST),
    ],
)
def test_grip_that_was_once_lost_is_followed_and_stays_where_it_is(make, end):
    window = grip_window(make())
    assert window.end is end
    for point in window.points[1:]:
        again = solve_contact(window.setup.closing_problem(point.pressure), start=point.state)
        np.testing.assert_allclose(again.positions, point.state.positions, rtol=0.0, atol=1e-9)
    if window.onset_wrap is not None:
        assert holding_force(window.at(window.onset_wrap), Pull.AWAY).force > 0.02
