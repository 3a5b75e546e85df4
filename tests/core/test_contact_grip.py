# SPDX-License-Identifier: Apache-2.0
"""The gripper on a cylinder: the known onset of the wrap, balance, friction and its memory."""

from functools import cache

import numpy as np
import pytest
from core.contact_cases import LENGTH, grip

from spiral_core import RodStatus
from spiral_core.rod.contact.solve import follow_contact, solve_contact

pytestmark = pytest.mark.long

RADIUS = 0.015


@cache
def closed(fraction: float, elements: int = 90):
    return solve_contact(grip(RADIUS, fraction), elements=elements)


def test_the_whole_coil_closes_at_the_wrap_stretch():
    before, after = closed(0.95), closed(1.1)
    assert before.contact_lengths[0] < 0.1 * LENGTH
    assert after.contact_lengths[0] > 0.7 * LENGTH
    assert after.normal_forces.sum() == pytest.approx(0.643, rel=0.02)  # N = 90 against finer


def test_pulled_away_it_holds_more_than_pushed_towards_the_base():
    path = {}
    for sign in (1.0, -1.0):
        stations = [grip(RADIUS, 1.1, 0.3, sign * 1e-3 * i) for i in (0, 1, 3)]
        states = follow_contact(stations, start=closed(1.1)).states
        assert all(state.stable for state in states)
        axis = np.array(states[0].on_obstacle().force)
        assert np.linalg.norm(axis) < 10.0
        path[sign] = abs(states[-1].on_obstacle().force[2])
    assert path[-1.0] > 3.0 * path[1.0]


def test_a_held_state_does_not_creep():
    start = closed(1.1)
    pulled = follow_contact([grip(RADIUS, 1.1, 0.3, -2e-3)], start=start).states[-1]
    here = pulled
    for _ in range(50):
        here = solve_contact(grip(RADIUS, 1.1, 0.3, -2e-3), start=here)
    assert here.status is RodStatus.CONVERGED
    assert np.abs(here.positions - pulled.positions).max() < 1e-9 * LENGTH


def test_a_ramp_can_end_at_its_first_loss():
    start = follow_contact([grip(RADIUS, 1.1, 0.3)], start=closed(1.1)).states[-1]
    stations = [grip(RADIUS, fraction, 0.3) for fraction in np.linspace(1.1, 0.0, 12)]
    weightless = follow_contact(stations, start=start, stop_at_event=True)
    assert len(weightless.states) == 12  # opening is no loss
    assert not weightless.events
    torn = [grip(RADIUS, 1.1, 0.3, -step) for step in np.linspace(0.0, LENGTH, 40)]
    path = follow_contact(torn, start=start, stop_at_event=True)
    (event,) = path.events
    assert event.after is None
    assert event.last is event.before
    assert event.contact_lost == pytest.approx(float(event.before.contact_lengths.sum()))
    assert event.before.stable
    assert len(path.states) == int(event.position) < 40


def test_a_pull_takes_few_iterations():
    start = follow_contact([grip(RADIUS, 1.1, 0.3)], start=closed(1.1)).states[-1]
    stations = [grip(RADIUS, 1.1, 0.3, -1e-3 * step) for step in range(1, 31)]
    path = follow_contact(stations, start=start, stop_at_event=True)
    assert not path.events
    assert len(path.states) == 30
    # About 6 a station; an increment that starts again from a wide barrier takes 20.
    assert sum(state.iterations for state in path.states) < 12 * 30
    shift = np.subtract(stations[-1].obstacles[0].position, stations[0].obstacles[0].position)
    shift /= np.linalg.norm(shift)
    forces = [-float(state.on_obstacle().force @ shift) for state in path.states]
    assert 10 < int(np.argmax(forces)) < 29  # the peak is passed
    assert max(forces) == pytest.approx(0.70, rel=0.03)  # N = 90 against finer


@pytest.mark.slow
@pytest.mark.parametrize(("pull", "share"), [(1e-5, 0.0), (0.011, 0.97), (0.016, 0.99)])
def test_ten_thousand_increments_without_motion_move_nothing(pull, share):
    """Pulled by little, so that some of it sticks; and near the largest force, where all slides."""
    steps = np.append(np.arange(1e-3, pull, 1e-3), pull)
    stations = [grip(RADIUS, 1.1, 0.3, -step) for step in (0.0, *steps)]
    first = follow_contact(stations, start=closed(1.1, 45)).states[-1]
    shift = np.subtract(stations[-1].obstacles[0].position, stations[0].obstacles[0].position)
    force = -float(first.on_obstacle().force @ shift) / pull
    assert force > share * 0.688  # its largest, after 21 mm
    assert (0 < first.sticking.sum() < first.touching.sum()) == (share == 0.0)
    here = first
    for _ in range(10_000):
        here = solve_contact(stations[-1], start=here)
    assert np.abs(here.positions - first.positions).max() < 1e-9 * LENGTH
