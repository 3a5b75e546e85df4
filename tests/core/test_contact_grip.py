# SPDX-License-Identifier: Apache-2.0
"""The gripper on a cylinder: the known onset of the wrap, balance, friction and its memory."""

from functools import cache

import numpy as np
import pytest
from core.contact_cases import LENGTH, OUTER, grip

from spiral_core import ContactStatus, follow_contact, solve_contact

RADIUS = 0.015


@cache
def closed(fraction: float, elements: int = 90):
    return solve_contact(grip(RADIUS, fraction), elements=elements)


def test_the_whole_coil_closes_at_the_wrap_stretch():
    before, after = closed(0.95), closed(1.1)
    assert before.contact_lengths[0] < 0.1 * LENGTH
    assert after.contact_lengths[0] > 0.7 * LENGTH
    assert after.normal_forces.sum() == pytest.approx(0.643, rel=0.02)  # N = 90 against finer


def test_nothing_penetrates_and_everything_balances():
    state = closed(1.1)
    assert state.stable
    assert state.gaps.min() > -1e-3 * OUTER
    total = state.base_reaction[:3] + state.contact_forces.sum(axis=(0, 1))
    np.testing.assert_allclose(total, 0.0, atol=1e-6 * state.normal_forces.sum())
    lever = np.cross(state.positions, state.contact_forces[0]).sum(axis=0)
    np.testing.assert_allclose(
        lever + state.base_reaction[3:], 0.0, atol=1e-6 * state.normal_forces.sum() * LENGTH
    )


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
    assert here.status is ContactStatus.CONVERGED
    assert np.abs(here.positions - pulled.positions).max() < 1e-9 * LENGTH
