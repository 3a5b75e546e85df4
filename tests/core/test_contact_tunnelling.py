# SPDX-License-Identifier: Apache-2.0
"""However fast an obstacle moves, it pushes the rod and never passes through it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from core.contact_cases import line
from core.contact_paths import SPAN

from spiral_core import (
    Capsule,
    Cylinder,
    Obstacle,
    Pinned,
    Profile,
    Rod,
    RodProblem,
    RodStatus,
    Section,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

pytestmark = pytest.mark.long

ACROSS = (0.0, 1.0, 0.0)


def test_cylinder_pulled_through_a_coil_at_once_ends_where_small_steps_end():
    """By 25 of its radii: 1.3 turns come off over the tip, and never through the rod."""
    strain = (-18.0, 0.0, 90.0)
    rod = replace(SPAN, length=0.25, rest_strain=strain)
    peg = Obstacle.along(Cylinder(6e-3), (0.0, 6e-3 + SPAN.radius, 0.0), strain)
    ways = np.linspace(0.0, 0.15, 31)
    pulled = [RodProblem(rod, obstacles=(peg.moved((0.0, way, 0.0)),)) for way in ways]
    slowly, fast = (follow_contact(stations, elements=80) for stations in (pulled, pulled[::30]))
    turns = np.array([state.turns[0] for state in slowly.states])
    assert abs(turns[-1]) < 0.6 < 1.0 < abs(turns[0])
    snaps = {int(event.position) for event in slowly.events}
    assert {*np.flatnonzero(np.abs(np.diff(turns)) >= 0.15)} <= snaps
    for event in fast.events:  # every step of a snap takes an iteration or more
        assert event.after.iterations >= len(event.after.trail) - 1
    (event,) = follow_contact(pulled[::30], elements=80, stop_at_event=True).events
    assert event.after is None
    assert event.contact_lost == pytest.approx(event.before.contact_lengths.sum())
    last, expected = fast.states[-1].positions, slowly.states[-1].positions
    np.testing.assert_allclose(last, expected, atol=4e-7)


def lowered(needle, aside=0.0, elements=40, steps=21):
    """Lower a needle through a cord pulled to four times its length.

    Its elements are longer than the needle is thick.
    """
    above, *ways = (
        RodProblem(
            Rod(0.1, Section((1e-5, 1e-5, 1e-5), extension=1.0), 1e-4),
            base=Pinned(),
            tip=Pinned((0.4, 0.0, 0.0)),
            obstacles=(Obstacle.along(needle, (0.2013, aside, height), ACROSS),),
        )
        for height in np.linspace(0.05, -0.05, steps)
    )
    start = solve_contact(above, start=line(0.4, elements), elements=elements)
    path = follow_contact(ways, start=start)
    return path, [state.turns[0] for state in path.states]


def test_needle_does_not_pass_between_two_nodes():
    """Nodes alone would see it approach, touch nothing, and leave on the other side."""
    needle = Profile((-0.1, 0.0, 0.1), (3e-3, 2.5e-3, 3e-3))
    path, turns = lowered(needle)
    assert np.abs(np.diff(turns)).max() < 0.1
    assert len(turns) < 20
    assert path.events[-1].last.status is RodStatus.NOT_HELD  # take more elements
    assert not lowered(needle, steps=2)[1]


def test_needle_pushes_a_cord_of_enough_elements_and_passes_beyond_its_end():
    """The axis of a capsule goes on there, but not its solid."""
    (turns,) = lowered(Cylinder(2.5e-3), elements=320, steps=2)[1]
    assert -0.7 < turns < -0.5  # still below it
    path, turns = lowered(Capsule(2.5e-3, 0.02), aside=0.02)
    assert not path.events
    assert turns == [0.0] * 20
