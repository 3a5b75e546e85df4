# SPDX-License-Identifier: Apache-2.0
"""From one station to the next, and where a rod goes that could go to either side."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from core.contact_cases import bar, down, floor
from core.test_contact_closed_forms import rope
from scipy.spatial.transform import Rotation

from spiral_core import (
    Clamped,
    Guided,
    InvalidInputError,
    Obstacle,
    Pinned,
    PointLoad,
    Rod,
    RodLoad,
    RodProblem,
    RodStatus,
    Section,
    Sphere,
)
from spiral_core.rod.contact._mesh import between, discretize
from spiral_core.rod.contact.obstacles import obstacle_between
from spiral_core.rod.contact.solve import follow_contact, solve_contact

RADIUS = 2e-3
ROD = Rod(0.5, Section((1e-3, 1e-3, 1e-3)), RADIUS)
HEAVY = down(0.05)
PUSH = (0.0, 0.0, -0.01)


@pytest.mark.parametrize("at", [0.213, 0.4999])
def test_rod_with_a_break_or_load_anywhere_is_followed(at):
    broken = RodProblem(replace(ROD, breaks=(at,)), HEAVY)
    for problem in (broken, RodProblem(ROD, HEAVY, point_loads=(PointLoad(at, PUSH),))):
        state = solve_contact(problem, elements=40)
        for asked in (None, 40, len(state.arc_lengths) - 1):
            again = solve_contact(problem, start=state, elements=asked)
            np.testing.assert_allclose(again.positions, state.positions, atol=1e-9)
        with pytest.raises(InvalidInputError, match="elements"):
            solve_contact(problem, start=state, elements=50)


def grown(length=0.5):
    """Return a rod over the floor, with a load on it."""
    return RodProblem(
        replace(ROD, length=length, rest_strain=(0.0, 0.2, 0.1)),
        HEAVY,
        obstacles=(floor(-0.35),),
        point_loads=(PointLoad(0.213, PUSH),),
    )


def guided(angle, held):
    """Return a rod whose tip is on a line, and only along it is it free."""
    along = (math.cos(angle), 0.0, math.sin(angle))
    return RodProblem(ROD, HEAVY, tip=Guided((0.45, 0.0, 0.0), along, held))


@pytest.mark.parametrize(
    ("first", "last"),
    [
        (grown(), grown(0.55)),
        *((guided(0.0, q), guided(0.5, q)) for q in (None, (0.0, 0.0, 0.0, 1.0))),
    ],
)
def test_rod_that_grows_onto_a_floor_or_whose_guide_turns_ends_where_a_fresh_one_is(first, last):
    """Nodes keep their fractions of the pieces next to a load, which stays."""
    path = follow_contact([first, last], elements=40)
    assert not path.events
    start, state = path.states
    assert not start.touching.any()
    assert state.touching.any() == bool(last.obstacles)
    assert {load.at for load in last.point_loads} <= {*state.arc_lengths.round(15)}
    assert state.arc_lengths[-1] == last.rod.length
    fresh = solve_contact(last, elements=40)
    assert state.tip_position == pytest.approx(fresh.tip_position, abs=1e-7)


def test_part_of_a_way_has_part_of_its_rest_strain_and_turn():
    """The energy of the rest strain goes with its square."""
    rods = (replace(ROD, rest_strain=(0.0, bend, 0.0)) for bend in (0.2, 0.6))
    first, last = (discretize(RodProblem(rod), 8) for rod in rods)
    assert between(first, last, 0.5).rest_energy == pytest.approx(4.0 * first.rest_energy)
    ball, part, turned = (
        Obstacle(Sphere(0.02)).moved(rotation=(turn, 0.0, 0.0)) for turn in (0.0, 0.6, 2.4)
    )
    assert obstacle_between(ball, turned, 0.25).orientation == pytest.approx(part.orientation)


def test_places_that_differ_by_rounding_are_one():
    rod = replace(ROD, breaks=(0.1 + 0.1 + 0.1,))
    loads = (PointLoad(0.3, PUSH), PointLoad(0.5 - 1e-16), PointLoad(1e-17))
    state = solve_contact(RodProblem(rod, HEAVY, point_loads=loads), elements=40)
    assert np.diff(state.arc_lengths).min() > 0.01


def test_loads_too_near_to_each_other_or_to_the_tip_are_called_that():
    for at in (0.5 - 1e-7, 0.2 + 1e-7):
        loads = (PointLoad(0.2, PUSH), PointLoad(at, PUSH))
        with pytest.raises(InvalidInputError, match="apart and from the ends"):
            solve_contact(RodProblem(ROD, point_loads=loads), elements=40)


def test_end_held_inside_of_an_obstacle_is_no_answer():
    """Nothing pushes it; its surface may overlap, as of a rod clamped into a wall."""
    for off, status in ((0.1 * RADIUS, RodStatus.CONVERGED), (-0.01, RodStatus.INSIDE_OBSTACLE)):
        tip = Pinned((0.47, 0.03, off - 0.02))
        sunk = RodProblem(ROD, HEAVY, tip=tip, obstacles=(floor(-0.02),))
        assert solve_contact(sunk, elements=40, throw=False).status is status


def test_obstacle_moved_over_the_base_is_no_answer():
    ball = Obstacle(Sphere(0.02), (-0.03, 0.0, 0.01))  # behind the base, and then over it
    stations = [RodProblem(ROD, obstacles=(ball.moved((way, 0.0, 0.0)),)) for way in (0.0, 0.015)]
    path = follow_contact(stations, elements=40)
    assert path.states[0].stable
    assert all(not state.stable for state in path.states[1:])


@pytest.mark.parametrize(
    ("lean", "bend", "side"),
    [
        (0.0, 0.0, (1.0, 0.0)),
        (-1e-11, 0.0, (1.0, 0.0)),
        (1e-4, 0.0, (-0.6, -0.8)),
        (0.0, 1e-3, (-0.6, -0.8)),
    ],
)
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.4, -1.1, 2.0)])
def test_column_falls_to_the_side_to_which_it_bends_or_its_sections_y_axis(turn, lean, bend, side):
    """Nothing else says to which side: neither rounding does, nor a weight that leans by as much.

    A rough ball that stands elsewhere is not met. Once fallen, nothing resists its turning about
    the base's axis: a lean of 1e-9, next to what a solve leaves, turns it by 14 degrees on one
    processor and by 26 on another.
    """
    turned = Rotation.from_rotvec(turn)
    place = turned.apply((0.2, -0.1 * side[0], 0.0))
    problem = RodProblem(
        replace(ROD, rest_strain=(0.0, -bend * side[1], bend * side[0])),
        RodLoad(turned.apply((-1.0, -0.6 * lean, -0.8 * lean))),
        Clamped((0.0, 0.0, 0.0), (*turned.as_quat(),)),
        obstacles=(Obstacle(Sphere(0.03), (*place,), friction=0.3),),
    )
    state = solve_contact(problem, elements=40)
    tip = turned.inv().apply(state.tip_position)[1:]
    assert tip @ side > 0.9 * np.linalg.norm(tip) > 0.09


def test_rod_on_top_of_a_ball_falls_beside_it():
    ball = Obstacle(Sphere(0.03), (0.2, 0.0, -0.05))
    state = solve_contact(RodProblem(ROD, down(3.0), obstacles=(ball,)))
    assert not state.touching.any()
    assert state.tip_position[2] < -0.35


@pytest.mark.parametrize(
    ("bending", "status"), [(1e-6, RodStatus.CONVERGED), (1e-8, RodStatus.NOT_HELD)]
)
def test_rope_pulled_too_hard_for_its_elements_is_no_answer(bending, status):
    """Pulled over a rough cylinder: its tension is six times its load, whose elements it bends."""
    section = Section((bending,) * 3, extension=20.0)
    rod = Rod(0.399, section, 1e-4, friction_radius=0.0)
    start, load = rope(0.399, 0.05 + 1e-4, 0.12, 160), down(0.0, 0.1)
    loose, *ways = (
        RodProblem(
            rod,
            load,
            Pinned((*(start[0] - (0.0, 0.0, 1e-3 * way)),)),
            obstacles=(bar(0.05, 0.0, 0.0, 0.6),),
        )
        for way in range(5)
    )
    states = follow_contact(ways, start=solve_contact(loose, start=start, elements=160)).states
    assert states[-1].status is status
