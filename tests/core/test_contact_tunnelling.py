# SPDX-License-Identifier: Apache-2.0
"""However fast an obstacle moves, it pushes the rod and never passes through it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from core.contact_transforms import imbalance

from spiral_core import (
    Capsule,
    ContactProblem,
    ContactState,
    Cylinder,
    ElasticRod,
    Obstacle,
    Plane,
    Section,
    follow_contact,
)
from spiral_core.rod.contact.shapes import Shape

LENGTH, RADIUS = 0.4, 3e-3
ROD = ElasticRod(LENGTH, Section((1.7e-4, 2.7e-4, 2.7e-4)), RADIUS)


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize(
    "shape", [Cylinder(5e-3), Capsule(5e-3, 0.1), Plane()], ids=lambda s: type(s).__name__
)
def test_rod_is_not_passed_by_what_moves_fast(shape: Shape, friction: float) -> None:
    """In one increment of 20 radii, down through the whole rod if it could."""
    axis = (0.0, 0.0, -1.0) if isinstance(shape, Plane) else (0.0, 1.0, 0.0)
    above = Obstacle.along(shape, (0.2, 0.0, 0.05), axis, friction)
    clear = ContactProblem(ROD, obstacles=(above,))
    struck = replace(clear, obstacles=(above.moved((0.0, 0.0, -0.1)),))
    if isinstance(shape, Plane):  # the clamp would be in it
        struck = replace(clear, obstacles=(above.moved((0.0, 0.0, -0.045), (0.0, 0.35, 0.0)),))
    path = follow_contact([clear, struck], elements=60, largest_increment=1.0)
    state = path.states[-1]
    assert state.normal_forces.sum() > 5e-4
    assert state.gaps[:, 1:].min() > -1e-3 * RADIUS
    assert state.contact_forces.sum(axis=(0, 1))[2] < 0.0
    place = struck.obstacles[0].position
    under = np.interp(place[0], state.positions[:, 0], state.positions[:, 2])
    assert under < place[2]
    assert max(imbalance(struck, state)) < 1e-6 * state.normal_forces.sum()


def test_cylinder_pulled_through_a_coil_at_once_ends_where_small_steps_end() -> None:
    """By 25 of its radii: 1.3 turns come off over the tip, and never through the rod."""
    radius = 6e-3
    strain = np.array((-18.0, 0.0, 90.0))
    rod = ElasticRod(0.25, ROD.section, RADIUS, rest_strain=(-18.0, 0.0, 90.0))
    x, _, z = strain / np.linalg.norm(strain)
    peg = Obstacle.along(Cylinder(radius), (0.0, radius + RADIUS, 0.0), (x, 0.0, z))

    def pulled(shift: float) -> ContactProblem:
        return ContactProblem(rod, obstacles=(peg.moved((0.0, shift, 0.0)),))

    def winding(state: ContactState, shift: float) -> float:
        away = state.positions - np.array((0.0, radius + RADIUS + shift, 0.0))
        angles = np.unwrap(np.arctan2(away[:, 1], away @ (-z, 0.0, x)))
        return float(angles[-1] - angles[0]) / (2.0 * np.pi)

    ways = np.linspace(0.0, 0.15, 31)
    slowly = follow_contact([pulled(w) for w in ways], elements=80)
    turns = [winding(state, w) for state, w in zip(slowly.states, ways, strict=True)]
    assert abs(turns[0]) > 1.0
    assert abs(turns[-1]) < 0.6
    snaps = {int(event.position) for event in slowly.events}
    for way, change in enumerate(np.diff(turns)):
        assert abs(change) < 0.15 or way in snaps
    fast = follow_contact([pulled(0.0), pulled(0.15)], elements=80, largest_increment=1.0)
    assert fast.events  # the same folds: nothing else lets the coil off
    np.testing.assert_allclose(
        fast.states[-1].positions, slowly.states[-1].positions, atol=1e-6 * LENGTH
    )
