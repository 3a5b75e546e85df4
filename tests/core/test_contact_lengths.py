# SPDX-License-Identifier: Apache-2.0
"""A rod that grows or is paid out along a path: its nodes keep their fractions of its length."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.contact_paths import imbalance
from spiral_core import (
    Cylinder,
    Obstacle,
    Pinned,
    Rod,
    RodLoad,
    RodProblem,
    Section,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

SPAN, WEIGHT = 0.6, 1.0


def cable(length: float) -> RodProblem:
    """Return a cable between two pins, above a bar."""
    bar = Obstacle.along(Cylinder(0.05), (0.3, 0.0, -0.22), (0.0, 1.0, 0.0))
    rod = Rod(length, Section((1e-4, 1e-4, 1e-4), extension=200.0), 2e-3)
    load = RodLoad((0.0, 0.0, -WEIGHT))
    return RodProblem(rod, load, Pinned(), Pinned((SPAN, 0.0, 0.0)), (bar,))


def coil(length: float) -> RodProblem:
    """Return a coil on a cylinder."""
    peg = Obstacle.along(Cylinder(0.015), (0.0, 0.0206, 0.0), (-18.0, 0.0, 40.7))
    rod = Rod(length, Section((1.7e-4, 2.7e-4, 2.7e-4)), 5.6e-3, (-20.0, 0.0, 45.0))
    return RodProblem(rod, obstacles=(peg,))


def test_cable_that_is_paid_out_sinks_onto_a_bar() -> None:
    """Each state is the one found at its own length, and in balance."""
    x = np.linspace(0.0, SPAN, 61)
    arch = np.column_stack((x, 0.0 * x, -0.1 * np.sin(np.pi * x / SPAN)))
    start = solve_contact(cable(0.65), start=arch, elements=60)
    lengths = (0.66, 0.75, 0.7)
    path = follow_contact([cable(length) for length in lengths], start=start)
    assert not path.events
    assert not start.touching.any()
    assert path.states[1].normal_forces.sum() > 0.2 * WEIGHT * 0.75
    for state, length in zip(path.states, lengths, strict=True):
        assert state.arc_lengths[-1] == length
        assert max(imbalance(cable(length), state)) < 1e-6 * WEIGHT * length
        fresh = solve_contact(cable(length), start=state.positions, elements=60)
        np.testing.assert_allclose(state.positions, fresh.positions, atol=1e-7 * length)
        assert state.energy == pytest.approx(fresh.energy, rel=1e-9)


def test_coil_that_grows_is_the_longer_coil() -> None:
    start = solve_contact(coil(0.3), elements=80)
    path = follow_contact([coil(0.32), coil(0.36)], start=start)
    fresh = solve_contact(coil(0.36), elements=80)
    assert not path.events
    state = path.states[-1]
    assert state.stable
    assert state.contact_lengths[0] > start.contact_lengths[0] + 0.04
    np.testing.assert_allclose(state.positions, fresh.positions, atol=1e-6 * 0.36)
