# SPDX-License-Identifier: Apache-2.0
"""From one station to the next, and where a rod goes that could go to either side."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from core.test_contact_closed_forms import rope
from scipy.spatial.transform import Rotation

from spiral_core import (
    Clamped,
    Cylinder,
    Free,
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

RADIUS = 2e-3
ROD = Rod(0.5, Section((1e-3, 1e-3, 1e-3)), RADIUS)
HEAVY = RodLoad((0.0, 0.0, -0.05))
PUSH = (0.0, 0.0, -0.01)


@pytest.mark.parametrize("at", [0.213, 0.4999])
@pytest.mark.parametrize("what", ["break", "load"])
def test_rod_with_a_break_or_load_anywhere_is_followed(what, at):
    rod = replace(ROD, breaks=(at,)) if what == "break" else ROD
    problem = RodProblem(rod, HEAVY, point_loads=(PointLoad(at, PUSH),) * (what == "load"))
    state = solve_contact(problem, elements=40)
    for asked in (None, 40, len(state.arc_lengths) - 1):
        again = solve_contact(problem, start=state, elements=asked)
        np.testing.assert_allclose(again.positions, state.positions, atol=1e-9)
    with pytest.raises(InvalidInputError, match="elements"):
        solve_contact(problem, start=state, elements=50)


def test_rod_that_grows_onto_the_floor_is_the_longer_rod():
    """Nodes keep their fractions of the pieces next to a load, which stays."""
    loads = (PointLoad(0.213, PUSH), PointLoad(0.3, PUSH))
    floor = Obstacle(Plane(), (0.0, 0.0, -0.35))
    short, long, other = (
        RodProblem(
            replace(ROD, length=length, rest_strain=(0.0, 0.2, 0.1)),
            *(HEAVY, Clamped(), Free(), (floor,), loads[:count]),
        )
        for length, count in ((0.5, 1), (0.55, 1), (0.55, 2))
    )
    first, state = follow_contact([short, long], elements=40).states
    assert not first.touching.any()
    assert state.touching.any()
    assert {0.213, 0.55} <= {*state.arc_lengths.round(15)}
    fresh = solve_contact(long, elements=40)
    assert state.tip_position == pytest.approx(fresh.tip_position, abs=1e-7)
    with pytest.raises(InvalidInputError, match="as many breaks and point loads"):
        follow_contact([short, other], elements=40)


def test_places_that_differ_by_rounding_are_one():
    rod = replace(ROD, breaks=(0.1 + 0.1 + 0.1,))
    loads = (PointLoad(0.3, PUSH), PointLoad(0.5 - 1e-16), PointLoad(1e-17))
    state = solve_contact(RodProblem(rod, HEAVY, point_loads=loads), elements=40)
    assert state.stable
    assert np.diff(state.arc_lengths).min() > 0.01


@pytest.mark.parametrize("held", [None, (0.0, 0.0, 0.0, 1.0)])
def test_guide_may_turn(held):
    """The end is on the line of each station, and only along it is it free."""
    along = (math.cos(0.5), 0.0, math.sin(0.5))
    level, tilted = (
        RodProblem(ROD, HEAVY, tip=Guided((0.45, 0.0, 0.0), line, held))
        for line in ((1.0, 0.0, 0.0), along)
    )
    path = follow_contact([level, tilted], elements=40)
    assert not path.events
    fresh = solve_contact(tilted, elements=40)
    assert path.states[-1].tip_position == pytest.approx(fresh.tip_position, abs=1e-7)
    assert path.states[-1].tip_reaction[:3] @ along < 1e-7


@pytest.mark.parametrize(
    ("height", "status"),
    [
        (0.1 * RADIUS, RodStatus.CONVERGED),
        (-0.01, RodStatus.INSIDE_OBSTACLE),
    ],
)
def test_end_held_inside_of_an_obstacle_is_no_answer(height, status):
    """Nothing pushes it; its surface may overlap, as of a rod clamped into a wall."""
    floor = Obstacle(Plane(), (0.0, 0.0, -0.02))
    sunk = RodProblem(ROD, HEAVY, tip=Pinned((0.47, 0.03, height - 0.02)), obstacles=(floor,))
    assert solve_contact(sunk, elements=40, throw=False).status is status


def test_obstacle_moved_over_the_base_is_no_answer():
    ball = Obstacle(Sphere(0.02), (-0.03, 0.0, 0.01))  # behind the base, and then over it
    stations = [RodProblem(ROD, obstacles=(ball.moved((way, 0.0, 0.0)),)) for way in (0.0, 0.015)]
    path = follow_contact(stations, elements=40)
    assert path.states[0].stable
    assert all(not state.stable for state in path.states[1:])


@pytest.mark.parametrize(
    ("turn", "lean", "bend", "side"),
    [
        ((0.0, 0.0, 0.0), 0.0, 0.0, (1.0, 0.0)),
        ((0.4, -1.1, 2.0), 0.0, 0.0, (1.0, 0.0)),
        ((0.0, 0.0, 0.0), -1e-11, 0.0, (1.0, 0.0)),
        ((0.0, 0.0, 0.0), 1e-4, 0.0, (-0.6, -0.8)),
        ((0.0, 0.0, 0.0), 0.0, 1e-3, (-0.6, -0.8)),
    ],
)
def test_column_falls_to_the_side_to_which_it_bends_or_its_sections_y_axis(turn, lean, bend, side):
    """Nothing else says to which side: neither rounding does, nor a weight that leans by as much.

    A rough ball that stands elsewhere is not met. Once fallen, nothing resists its turning about
    the base's axis: a lean of 1e-9, next to what a solve leaves, turns it by 14 degrees on one
    processor and by 26 on another.
    """
    turned = Rotation.from_rotvec(turn)
    weight = turned.apply((-1.0, -0.6 * lean, -0.8 * lean))
    place = turned.apply((0.2, -0.1 * side[0], 0.0))
    problem = RodProblem(
        replace(ROD, rest_strain=(0.0, -bend * side[1], bend * side[0])),
        RodLoad((*weight,)),
        Clamped((0.0, 0.0, 0.0), (*turned.as_quat(),)),
        obstacles=(Obstacle(Sphere(0.03), (*place,), friction=0.3),),
    )
    state = solve_contact(problem, elements=40)
    assert state.stable
    tip = turned.inv().apply(state.tip_position)[1:]
    assert tip @ side > 0.9 * np.linalg.norm(tip) > 0.09


def test_rod_on_top_of_a_ball_falls_beside_it():
    ball = Obstacle(Sphere(0.03), (0.2, 0.0, -0.05))
    rod = replace(ROD, length=0.4)
    state = solve_contact(RodProblem(rod, RodLoad((0.0, 0.0, -3.0)), obstacles=(ball,)))
    assert state.stable
    assert not state.touching.any()
    assert state.tip_position[2] < -0.35


@pytest.mark.parametrize(
    ("bending", "status"), [(1e-6, RodStatus.CONVERGED), (1e-8, RodStatus.NOT_HELD)]
)
def test_rope_pulled_too_hard_for_its_elements_is_no_answer(bending, status):
    """Pulled over a rough cylinder: its tension is six times its load, whose elements it bends."""
    length = 0.4 - 1e-3
    rod = Rod(length, Section((bending,) * 3, extension=20.0), 1e-4, friction_radius=0.0)
    bar = Obstacle.along(Cylinder(0.05), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 0.6)
    start = rope(length, 0.05 + 1e-4, 0.12, 160)
    load = RodLoad(tip_force=(0.0, 0.0, -0.1))
    loose, *ways = (
        RodProblem(rod, load, Pinned((*(start[0] - (0.0, 0.0, way)),)), obstacles=(bar,))
        for way in (0.0, 1e-3, 2e-3, 3e-3, 4e-3)
    )
    states = follow_contact(ways, start=solve_contact(loose, start=start, elements=160)).states
    assert states[-1].status is status
