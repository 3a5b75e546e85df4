# SPDX-License-Identifier: Apache-2.0
"""From one station to the next: meshes with breaks and loads, ends that turn, what is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from spiral_core import (
    Clamped,
    Cylinder,
    Guided,
    InvalidInputError,
    Obstacle,
    Pinned,
    Plane,
    PointLoad,
    Rod,
    RodLoad,
    RodProblem,
    RodStatus,
    Section,
    Sphere,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

LENGTH, RADIUS = 0.5, 2e-3
PLAIN = Section((1e-3, 1e-3, 1e-3))
ROD = Rod(LENGTH, PLAIN, RADIUS)
HEAVY = RodLoad((0.0, 0.0, -0.05))
PUSH = (0.0, 0.0, -0.01)


@pytest.mark.parametrize("at", [0.213, 0.0731, 0.4999])
@pytest.mark.parametrize("what", ["break", "load"])
def test_rod_with_a_break_or_load_anywhere_is_followed(what: str, at: float) -> None:
    rod = replace(ROD, breaks=(at,)) if what == "break" else ROD
    loads = (PointLoad(at, PUSH),) if what == "load" else ()
    problem = RodProblem(rod, HEAVY, point_loads=loads)
    state = solve_contact(problem, elements=40)
    for asked in (None, 40, len(state.arc_lengths) - 1):
        again = solve_contact(problem, start=state, elements=asked)
        np.testing.assert_allclose(again.positions, state.positions, atol=1e-9)
    with pytest.raises(InvalidInputError, match="elements"):
        solve_contact(problem, start=state, elements=50)
    assert len(follow_contact([problem, problem], elements=40).states) == 2


def test_load_stays_where_it_is_while_the_rod_grows() -> None:
    """Nodes keep their fractions of the pieces on its two sides."""

    def loaded(length: float) -> RodProblem:
        return RodProblem(replace(ROD, length=length), HEAVY, point_loads=(PointLoad(0.213, PUSH),))

    state = follow_contact([loaded(0.5), loaded(0.52)], elements=40).states[-1]
    assert np.abs(state.arc_lengths - 0.213).min() < 1e-15
    fresh = solve_contact(loaded(0.52), elements=40)
    assert state.tip_position == pytest.approx(fresh.tip_position, abs=1e-7)
    extra = (PointLoad(0.213, PUSH), PointLoad(0.3, PUSH))
    grown = replace(loaded(0.52), point_loads=extra)
    with pytest.raises(InvalidInputError, match="as many breaks and point loads"):
        follow_contact([loaded(0.5), grown], elements=40)


def test_places_that_differ_by_rounding_are_one() -> None:
    rod = replace(ROD, breaks=(0.1 + 0.1 + 0.1,))
    loads = (PointLoad(0.3, PUSH), PointLoad(0.5 - 1e-16), PointLoad(1e-17))
    state = solve_contact(RodProblem(rod, HEAVY, point_loads=loads), elements=40)
    assert state.stable
    assert np.diff(state.arc_lengths).min() > 0.01


@pytest.mark.parametrize("largest", [1.0, 0.5, 0.1])
@pytest.mark.parametrize("held", [None, (0.0, 0.0, 0.0, 1.0)])
def test_guide_may_turn(held: tuple[float, ...] | None, largest: float) -> None:
    """The end is on the line of each station, and only along it is it free."""

    def guided(angle: float) -> RodProblem:
        along = (math.cos(angle), 0.0, math.sin(angle))
        return RodProblem(ROD, HEAVY, tip=Guided((0.45, 0.0, 0.0), along, held))

    path = follow_contact([guided(0.0), guided(0.5)], elements=40, largest_increment=largest)
    assert not path.events
    fresh = solve_contact(guided(0.5), elements=40)
    assert path.states[-1].tip_position == pytest.approx(fresh.tip_position, abs=1e-7)
    assert path.states[-1].tip_reaction[:3] @ (math.cos(0.5), 0.0, math.sin(0.5)) < 1e-7


def test_end_held_inside_of_an_obstacle_is_no_answer() -> None:
    """Nothing pushes it; its surface may overlap, as of a rod clamped into a wall."""
    floor = Obstacle(Plane(), (0.0, 0.0, -0.02))
    for height, status in (
        (-0.02 + RADIUS, RodStatus.CONVERGED),
        (-0.02 + 0.1 * RADIUS, RodStatus.CONVERGED),
        (-0.03, RodStatus.INSIDE_OBSTACLE),
    ):
        tip = Pinned((0.47, 0.03, height))
        sunk = RodProblem(ROD, HEAVY, tip=tip, obstacles=(floor,))
        assert solve_contact(sunk, elements=40, throw=False).status is status


def test_obstacle_moved_over_the_base_is_no_answer() -> None:
    ball = Obstacle(Sphere(0.02), (-0.03, 0.0, 0.01))  # behind the base, and then over it
    stations = [RodProblem(ROD, obstacles=(ball.moved((way, 0.0, 0.0)),)) for way in (0.0, 0.015)]
    path = follow_contact(stations, elements=40)
    assert path.states[0].stable
    assert all(not state.stable for state in path.states[1:])


@pytest.mark.parametrize("tip", [(0.45, 0.0, 0.0), (0.45, 0.02, 0.03)])
def test_tip_brought_nearer_past_an_obstacle_far_away(tip: tuple[float, float, float]) -> None:
    """The way may fail at its first increment, before anything has touched."""
    far = Obstacle(Plane(), (0.0, 0.0, -3.0))
    problem = RodProblem(ROD, tip=Clamped(tip), obstacles=(far,))
    state = solve_contact(problem, elements=40, throw=False)
    alone = solve_contact(replace(problem, obstacles=()), elements=40, throw=False)
    assert state.status is alone.status
    assert state.gaps.min() > 2.0


def test_rope_pulled_too_hard_for_its_elements_is_no_answer() -> None:
    """Pulled over a rough cylinder: its tension is six times its load, whose elements it bends."""

    def pulled(bending: float, way: float) -> RodProblem:
        around = 0.05 + 1e-4
        rod = Rod(0.4 - 1e-3, Section((bending,) * 3, extension=20.0), 1e-4, friction_radius=0.0)
        bar = Obstacle.along(Cylinder(0.05), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 0.6)
        return RodProblem(
            rod, RodLoad(tip_force=(0.0, 0.0, -0.1)), Pinned((-around, 0.0, -0.12 - way)),
            obstacles=(bar,),
        )  # fmt: skip

    around, hanging = 0.05 + 1e-4, 0.12
    length = 0.4 - 1e-3

    def draped(s: float) -> tuple[float, float, float]:
        angle = min(max((s - hanging) / around, 0.0), math.pi)
        below = min(s - hanging, 0.0) + min(hanging + math.pi * around - s, 0.0)
        return (-around * math.cos(angle), 0.0, around * math.sin(angle) + below)

    start = np.array([draped(s) for s in np.linspace(0.0, length, 161)])
    for bending, status in ((1e-6, "CONVERGED"), (1e-8, "NOT_HELD")):
        loose = solve_contact(pulled(bending, 0.0), start=start, elements=160)
        ways = [pulled(bending, way) for way in (1e-3, 2e-3, 3e-3, 4e-3)]
        states = follow_contact(ways, start=loose).states
        assert states[-1].status.name == status
