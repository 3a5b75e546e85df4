# SPDX-License-Identifier: Apache-2.0
"""The gripper on a cylinder: its wrap, friction and its memory, and what was once lost."""

from __future__ import annotations

from functools import cache, partial

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

AXIS = np.subtract(
    grip(0.015, 1.1, 0.3, 1.0).obstacles[0].position, grip(0.015, 1.1).obstacles[0].position
)


@cache
def closed(fraction, elements=90):
    """Return the coil that has closed without friction."""
    return solve_contact(grip(0.015, fraction), elements=elements)


def pulled(*shifts, elements=90):
    """Return the coil whose cylinder is moved along its axis, with friction."""
    stations = [grip(0.015, 1.1, 0.3, shift) for shift in (0.0, *shifts)]
    return follow_contact(stations, start=closed(1.1, elements), stop_at_event=True).states


def force(state):
    """Return what pulls the cylinder along its axis."""
    return float(state.on_obstacle().force @ AXIS)


@pytest.mark.parametrize("count", [50, pytest.param(10_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("pull", "share"), [(1e-5, 0.0), (0.016, 0.99)])
def test_increments_without_motion_move_nothing(pull, share, count):
    """Pulled by little, so that some of it sticks; and near the largest force, where all slides."""
    here = first = pulled(*-np.append(np.arange(1e-3, pull, 1e-3), pull), elements=45)[-1]
    assert force(first) > share * 0.688  # its largest, after 21 mm
    assert (0 < first.sticking.sum() < first.touching.sum()) == (share == 0.0)
    for _ in range(count):
        here = solve_contact(grip(0.015, 1.1, 0.3, -pull), start=here)
    assert here.stable
    assert np.abs(here.positions - first.positions).max() < 1e-9 * LENGTH


def test_a_path_can_end_at_its_first_loss():
    (start,) = pulled()
    torn = [grip(0.015, 1.1, 0.3, -step) for step in np.linspace(0.0, LENGTH, 40)]
    path = follow_contact(torn, start=start, stop_at_event=True)
    (event,) = path.events
    assert event.after is None
    assert event.last is event.before
    assert event.contact_lost == pytest.approx(float(event.before.contact_lengths.sum()))
    assert len(path.states) == int(event.position) < 40


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
        pytest.param(partial(random_setup, 475), WindowEnd.PASSED_BY, marks=pytest.mark.slow),
        pytest.param(partial(random_setup, 936), WindowEnd.LOST, marks=pytest.mark.slow),
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
