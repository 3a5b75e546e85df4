# SPDX-License-Identifier: Apache-2.0
"""However fast an obstacle moves, it pushes the rod and never passes through it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.contact_paths import imbalance
from spiral_core import (
    Capsule,
    Cone,
    Cylinder,
    InvalidInputError,
    Obstacle,
    Pinned,
    Plane,
    Profile,
    Rod,
    RodProblem,
    RodStatus,
    Section,
    Sphere,
)
from spiral_core.rod.contact.obstacles import turns_about
from spiral_core.rod.contact.shapes import Shape
from spiral_core.rod.contact.solve import follow_contact, solve_contact

pytestmark = pytest.mark.long

LENGTH, RADIUS = 0.4, 3e-3
ROD = Rod(LENGTH, Section((1.7e-4, 2.7e-4, 2.7e-4)), RADIUS)


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize(
    "shape", [Cylinder(5e-3), Capsule(5e-3, 0.1), Plane()], ids=lambda s: type(s).__name__
)
def test_rod_is_not_passed_by_what_moves_fast(shape: Shape, friction: float) -> None:
    """In one increment of 20 radii, down through the whole rod if it could."""
    axis = (0.0, 0.0, -1.0) if isinstance(shape, Plane) else (0.0, 1.0, 0.0)
    above = Obstacle.along(shape, (0.2, 0.0, 0.05), axis, friction)
    clear = RodProblem(ROD, obstacles=(above,))
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
    rod = Rod(0.25, ROD.section, RADIUS, rest_strain=(-18.0, 0.0, 90.0))
    x, _, z = strain / np.linalg.norm(strain)
    peg = Obstacle.along(Cylinder(radius), (0.0, radius + RADIUS, 0.0), (x, 0.0, z))

    def pulled(shift: float) -> RodProblem:
        return RodProblem(rod, obstacles=(peg.moved((0.0, shift, 0.0)),))

    ways = np.linspace(0.0, 0.15, 31)
    slowly = follow_contact([pulled(w) for w in ways], elements=80)
    turns = [float(state.turns[0]) for state in slowly.states]
    assert abs(turns[0]) > 1.0
    assert abs(turns[-1]) < 0.6
    snaps = {int(event.position) for event in slowly.events}
    for way, change in enumerate(np.diff(turns)):
        assert abs(change) < 0.15 or way in snaps
    fast = follow_contact([pulled(0.0), pulled(0.15)], elements=80, largest_increment=1.0)
    assert fast.events  # the same folds: nothing else lets the coil off
    for event in fast.events:  # every step of a snap takes an iteration or more
        assert event.after.iterations >= len(event.after.trail) - 1
    np.testing.assert_allclose(
        fast.states[-1].positions, slowly.states[-1].positions, atol=1e-6 * LENGTH
    )


def stretched(height: float, needle: Shape) -> RodProblem:
    """Return a cord pulled to four times its length, its elements longer than a needle is thick."""
    rod = Rod(0.1, Section((1e-5, 1e-5, 1e-5), extension=1.0), 1e-4)
    lowered = Obstacle.along(needle, (0.2013, 0.0, height), (0.0, 1.0, 0.0))
    return RodProblem(rod, base=Pinned(), tip=Pinned((0.4, 0.0, 0.0)), obstacles=(lowered,))


NEEDLES = [Cylinder(2.5e-3), Cone(2.5e-3, 1e-3), Capsule(2.5e-3, 0.1),
           Profile((-0.1, 0.0, 0.1), (3e-3, 2.5e-3, 3e-3))]  # fmt: skip


@pytest.mark.parametrize("needle", NEEDLES, ids=lambda s: type(s).__name__)
def test_needle_does_not_pass_between_two_nodes(needle: Shape) -> None:
    """Nodes alone would see it approach, touch nothing, and leave on the other side."""
    line = np.linspace((0.0, 0.0, 0.0), (0.4, 0.0, 0.0), 41)
    start = solve_contact(stretched(0.05, needle), start=line, elements=40)
    lowered = [stretched(height, needle) for height in np.linspace(0.05, -0.05, 21)]
    path = follow_contact(lowered, start=start)
    turns = np.array([state.turns[0] for state in path.states])
    assert np.abs(np.diff(turns)).max() < 0.1
    assert len(path.states) < 21
    assert path.events[-1].last.status is RodStatus.NOT_HELD  # take more elements
    jump = follow_contact([lowered[-1]], start=start, largest_increment=1.0)
    assert not jump.states


def test_cord_passes_beyond_the_end_of_a_capsule() -> None:
    """Its axis goes on there, but not its solid."""
    line = np.linspace((0.0, 0.0, 0.0), (0.4, 0.0, 0.0), 41)

    def lowered(height: float) -> RodProblem:
        problem = stretched(height, Capsule(2.5e-3, 0.02))
        aside = problem.obstacles[0].moved((0.0, 0.02, 0.0))
        return replace(problem, obstacles=(aside,))

    start = solve_contact(lowered(0.05), start=line, elements=40)
    path = follow_contact([lowered(h) for h in np.linspace(0.05, -0.05, 21)], start=start)
    assert len(path.states) == 21
    assert not path.events
    assert all(state.turns[0] == 0.0 for state in path.states)


def test_needle_pushes_a_cord_of_enough_elements() -> None:
    line = np.linspace((0.0, 0.0, 0.0), (0.4, 0.0, 0.0), 321)
    needle = Cylinder(2.5e-3)
    start = solve_contact(stretched(0.05, needle), start=line, elements=320)
    state = solve_contact(stretched(-0.05, needle), start=start)
    assert state.normal_forces.sum() > 1.0
    assert -0.7 < state.turns[0] < -0.5  # still below it


def coil(torsion: float, radius: float = RADIUS) -> RodProblem:
    """Return a coil of some turns, its pitch with the sign of its torsion."""
    rest_strain = (torsion, 0.0, 60.0)
    return RodProblem(Rod(LENGTH, ROD.section, radius, rest_strain=rest_strain))


@pytest.mark.parametrize("stations", [2, 5])
def test_rod_that_passes_through_itself_between_two_stations_is_reported(stations: int) -> None:
    """A coil whose pitch changes its sign: clear at both ends of the way."""
    path = follow_contact([coil(t) for t in np.linspace(30.0, -30.0, stations)], elements=80)
    touch = path.self_contact
    last = path.states[-1]
    assert path.states[0].stable
    assert last.self_clearance > 0.0
    assert last.status is RodStatus.SELF_CONTACT
    assert not last.stable
    with pytest.raises(InvalidInputError, match="start"):
        follow_contact([coil(-30.0)], start=last)
    # Turns of one pitch touch where it is two radii: torsion / curvature^2 = radius / pi or so.
    assert touch.position / (stations - 1) == pytest.approx(0.45, abs=0.05)
    turn = 2.0 * np.pi / 60.0
    first, second = touch.places
    assert second - first == pytest.approx(turn, rel=0.15)
    before = follow_contact([coil(30.0), coil(10.0)], elements=80)
    assert before.self_contact is None
    assert before.states[-1].stable


@pytest.mark.parametrize("elements", [40, 60, 80, 120])
@pytest.mark.parametrize("radius", [RADIUS, 1e-3, 1e-4])
def test_thin_rod_of_long_elements_does_not_pass_through_itself(
    radius: float, elements: int
) -> None:
    """Its turns cross between nodes; thin ones within one increment, whose ends are clear."""
    path = follow_contact([coil(30.0, radius), coil(-30.0, radius)], elements=elements)
    assert path.states[-1].status is RodStatus.SELF_CONTACT
    # Thin ones are found at the end of the increment in which they passed.
    assert path.self_contact.position == pytest.approx(0.5, abs=0.06)
    first, second = path.self_contact.places
    assert second - first == pytest.approx(2.0 * np.pi / 60.0, rel=0.05)


def test_turns_are_those_of_a_helix_about_each_axis() -> None:
    """Two and a quarter, right-handed; beyond the ends of a capsule nothing counts."""
    angle = np.linspace(0.0, 4.5 * np.pi, 200)
    helix = np.column_stack((0.02 * np.cos(angle), 0.02 * np.sin(angle), 0.01 * angle - 0.03))
    turn, shift = np.array((0.6, 0.0, 0.8)), np.array((0.3, -0.2, 0.1))
    upright = Obstacle(Cylinder(0.01))
    assert turns_about(upright, helix) == pytest.approx(2.25)
    assert turns_about(upright, helix[::-1]) == pytest.approx(-2.25)
    tilted = Obstacle.along(Cylinder(0.01), tuple(shift), tuple(turn))
    frame = np.column_stack((np.cross((0.0, 1.0, 0.0), turn), (0.0, 1.0, 0.0), turn))
    assert turns_about(tilted, helix @ frame.T + shift) == pytest.approx(2.25)
    assert turns_about(Obstacle(Capsule(0.01, 0.05)), helix) == pytest.approx(
        0.05 / 0.01 / 2 / np.pi
    )
    cone = Obstacle(Cone(0.01, -0.2))  # its apex at 50 mm
    assert turns_about(cone, helix) == pytest.approx(0.08 / 0.01 / 2.0 / np.pi)
    for shape in (Plane(), Sphere(0.01), Cylinder(0.05, inside=True)):
        assert np.isnan(turns_about(Obstacle(shape), helix))
