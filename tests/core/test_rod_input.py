# SPDX-License-Identifier: Apache-2.0
"""What makes no sense is refused, and the message names the field and what would do."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from core.questions import Question, wrong_arguments
from numpy.typing import NDArray

from spiral_core import (
    Capsule,
    Clamped,
    Cone,
    Cylinder,
    Free,
    Guided,
    InvalidInputError,
    Obstacle,
    Pinned,
    Plane,
    PointLoad,
    Profile,
    Rod,
    RodLoad,
    RodProblem,
    RodStatus,
    Section,
    SignedDistance,
    SolverError,
    Sphere,
    find_equilibria,
    follow_rod,
    solve_rod,
    solve_rods,
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact
from spiral_core.rod.path import follow_path

Array = NDArray[np.float64]
NAN = math.nan
NO_NUMBERS = (0.0, -1.0, NAN, math.inf, True, "1")
PLAIN = Section((2e-4, 3e-4, 3e-4))
ROD = Rod(0.4, PLAIN, 3e-3)
FREE = Rod(0.3, Section.inextensible(3e-4, 2e-4), rest_strain=(-5.0, 0.0, 10.0))
LOAD = RodLoad((0.24, 0.05, 0.0), (0.01, 0.0, 0.02))
CLEAR = Obstacle.along(Cylinder(0.03), (0.2, 0.0, -0.07), (0.0, 1.0, 0.0))
PROBLEM = RodProblem(ROD, obstacles=(CLEAR,))


def solved() -> object:
    """Return a state to start from."""
    return solve_contact(PROBLEM, elements=16)


def six(above: float, below: float) -> tuple[tuple[float, ...], ...]:
    """Return a 6x6 stiffness whose twist and stretch are coupled by fractions of their own."""
    matrix = np.diag((1e-4, 1e-4, 1e-4, 1e2, 1e2, 1e2))
    matrix[0, 3], matrix[3, 0] = 0.1 * above, 0.1 * below
    return tuple(tuple(row) for row in matrix.tolist())


# A call with good arguments; and for each of them, what it must not be.
PROFILES = {
    "bending": (lambda s: NAN * s, lambda s: s[:, None] + 1.0),
    "torsional": (lambda s: NAN * s,),
    "coupling": (lambda s: NAN * s, lambda s: s[:2]),
}
NO_STATES = (
    *(np.zeros((1, 3)), np.eye(2), np.zeros((5, 3)), np.full((5, 3), NAN)),
    "x",
)
STATE = solve_rod(FREE, LOAD, elements=10)
NO_STARTS = (
    replace(STATE, orientations=STATE.orientations[:5]),
    replace(STATE, orientations=STATE.orientations[:1], arc_lengths=np.zeros(1)),
    replace(STATE, orientations=STATE.orientations * NAN),
)
NO_COUNTS = (-5, 0, 1, True, 2.5, 12.5, "a", 20_001)
TURNED_OTHERWISE = [
    replace(PROBLEM, tip=Guided((0.4, 0, 0), orientation=held))
    for held in (None, (0.0, 0.0, 0.0, 1.0))
]


def distances(function: Callable[[Array], tuple[Array, Array]], problem: RodProblem = PROBLEM):
    """Solve a problem with an obstacle whose distance is a user's."""
    return solve_contact(replace(problem, obstacles=(Obstacle(SignedDistance(function, 0.03)),)))


ARGUMENTS: list[Question] = [
    (
        Section,
        {"stiffness": (1.0, 1.0, 1.0)},
        {
            "stiffness": (
                ((1, 1, 0), (0, 1, 0), (0, 0, 1)),
                ((1, 2, 0), (2, 1, 0), (0, 0, 1)),
                ((1, 0), (0, 1, 0), (0, 0, 1)),
                (0.0, 1.0, 1.0),
                (1.0, NAN, 1.0),
                (1.0, 1.0),
                six(0.1, 0.2),
                six(1.1, 1.1),
            ),
            "extension": (NAN, 0.0),
            "shear": (-1.0,),
        },
    ),
    (Section, {"stiffness": six(0.5, 0.5)}, {"extension": (1.0,), "shear": (1.0,)}),
    (
        Section.inextensible,
        {"bending": 4e-4, "torsional": 9e-4},
        {
            "bending": NO_NUMBERS,
            "torsional": NO_NUMBERS,
            "sideways": (0.0, math.inf),
            "coupling": (6e-4, -6e-4, NAN),
        },
    ),
    (
        Section.varying,
        {"bending": 4e-4, "torsional": 9e-4},
        {"bending": NO_NUMBERS, "torsional": (-1.0,), "sideways": (0.0,), "coupling": (NAN,)},
    ),
    (
        lambda **given: solve_rod(replace(FREE, section=Section.varying(**given)), LOAD),
        {"bending": 6e-4, "torsional": 5e-4},
        PROFILES,
    ),
    (
        lambda section: solve_rod(replace(FREE, section=section), LOAD),
        {"section": PLAIN},
        {
            "section": (
                lambda _: PLAIN,
                Section.varying(lambda s: 0.0 * s, 5e-4),
                Section.varying(6e-4, lambda s: s - 0.2),
                Section.varying(6e-4, 5e-4, sideways=lambda s: s - 1.0),
                Section.varying(6e-4, 5e-4, coupling=lambda s: 6e-4 + 0.0 * s),
            )
        },
    ),
    (
        Section.round,
        {"radius": 1e-3, "young": 1e6, "shear_modulus": 4e5},
        {"bore": (1e-3, -1e-4), "young": (0.0,), "radius": (NAN,), "shear_modulus": (0.0,)},
    ),
    (
        Rod,
        {"length": 0.4, "section": PLAIN, "radius": 1e-3},
        {
            "length": NO_NUMBERS,
            "section": (3e-4,),
            "radius": (-1e-3,),
            "friction_radius": (2e-3, NAN),
            "rest_strain": ((0, NAN, 0), (1.0, math.inf, 0.0)),
            "breaks": ((0.3, 0.2), (0.4,), (0.0,), (0.2, 0.2), ("a",), 0.1, (NAN,)),
        },
    ),
    (
        RodLoad,
        {},
        dict.fromkeys(
            ("distributed", "tip_force", "tip_moment"),
            ((1.0, 2.0), (1.0, 2.0, NAN), 3.0, "abc"),
        ),
    ),
    (Pinned, {}, {"position": ((0.0, NAN, 0.0),)}),
    (Clamped, {}, {"orientation": ((0, 0, 0, 2),)}),
    (Guided, {}, {"direction": ((0, 0, 0),)}),
    (PointLoad, {"at": 0.1}, {"force": ((NAN, 0, 0),), "moment": ((math.inf, 0, 0),)}),
    (
        RodProblem,
        {"rod": ROD},
        {
            "rod": (3,),
            "load": ((0.0, 0.0, -1.0),),
            "base": ("clamped",),
            "tip": (None,),
            "obstacles": ((Plane(),), CLEAR),
            "point_loads": (PointLoad(0.1), (0.1,)),
        },
    ),
    (lambda at: RodProblem(ROD, point_loads=(PointLoad(at),)), {"at": 0.4}, {"at": (0.5,)}),
    (Cylinder, {"radius": 0.1}, {"radius": (-1.0, NAN)}),
    (Sphere, {"radius": 0.1}, {"radius": (0.0,)}),
    (Cone, {"radius": 0.1, "slope": 0.1}, {"slope": (NAN,)}),
    (Capsule, {"radius": 0.1, "length": 0.1}, {"length": (0.0,)}),
    (
        Profile,
        {"heights": (0.0, 0.01, 0.02, 0.03), "radii": (0.1, 0.1, 0.1, 0.1)},
        {
            "heights": ((0.03, 0.02, 0.01, 0.0), (0.0, 0.0, 0.02, 0.03)),
            # Too few; and a spline that passes through the axis.
            "radii": ((1.0,), (0.1, 1e-3, 1e-3, 0.1)),
        },
    ),
    (SignedDistance, {"function": distances, "feature_radius": 0.1}, {"feature_radius": (NAN,)}),
    (
        Obstacle,
        {"shape": Plane()},
        {"shape": (3,), "friction": (-0.1, NAN), "orientation": ((0, 0, 0, 2.0),)},
    ),
    (
        lambda axis: Obstacle.along(Plane(), (0, 0, 0), axis),
        {"axis": (0, 0, 1)},
        {"axis": ((0, 0, 0),)},
    ),
    (CLEAR.moved, {}, {"translation": ((NAN, 0, 0),), "rotation": ((0.0, 0.0),)}),
    (
        lambda **given: solve_rod(**({"rod": FREE, "load": LOAD} | given)),
        {},
        {
            "rod": ("rod", RodProblem(FREE)),
            "load": ((1.0, 0.0, 0.0),),
            "element": ("mixed",),
            "elements": NO_COUNTS,
            "start": (*NO_STATES, *NO_STARTS),
        },
    ),
    *(
        (
            lambda elements, rod=rod, load=load: solve_rod(rod, load, elements=elements),
            {},
            {"elements": (None,)},
        )
        # In what units?
        for rod, load in (
            (Rod(300000.0, PLAIN, rest_strain=(0.0, 0.0, 20.0)), LOAD),
            (Rod(0.3, PLAIN, rest_strain=(0.0, 0.0, 1e300)), LOAD),
            (
                Rod(0.3, Section.inextensible(1e-300, 1e-300), rest_strain=(0.0, 0.0, 20.0)),
                LOAD,
            ),
            (Rod(0.3, PLAIN, rest_strain=(0.0, 0.0, 20.0)), RodLoad((1e300, 0.0, 0.0))),
        )
    ),
    (
        lambda elements: solve_rod(
            replace(FREE, rest_strain=(0.0, 0.0, 40.0)), LOAD, elements=elements
        ),
        {"elements": 30},
        {"elements": (3,)},
    ),
    (
        lambda rest_strain: solve_rod(replace(FREE, rest_strain=rest_strain), LOAD),
        {"rest_strain": (0.0, 0.0, 1.0)},
        {"rest_strain": (lambda s: np.ones(len(s)),)},
    ),
    (
        lambda distributed: solve_rod(FREE, RodLoad(distributed), elements=10),
        {"distributed": (0.0, 0.0, 1.0)},
        {"distributed": (lambda s: np.full((len(s), 3), NAN),)},
    ),
    (
        lambda rods=(FREE, FREE), loads=LOAD, **given: follow_path(rods, loads, **given),
        {},
        {
            "rods": ((), FREE, [FREE, replace(FREE, breaks=(0.1,))]),
            "loads": ([LOAD], [LOAD] * 3, 3.0),
            "elements": NO_COUNTS,
            "start": (*NO_STATES, *NO_STARTS),
        },
    ),
    (
        lambda start: follow_rod([RodProblem(FREE, LOAD)] * 2, start=start, stop_at_event=True),
        {"start": None},
        {"start": (STATE, STATE.positions)},
    ),
    (
        lambda **given: find_equilibria(FREE, LOAD, **({"starts": 2} | given)),
        {},
        {"elements": NO_COUNTS, "seed": (-1,), "starts": (0, -1, True, 2.5)},
    ),
    (
        lambda radius: find_equilibria(replace(FREE, radius=radius), LOAD, starts=2),
        {"radius": 0.0},
        {"radius": (1e-3,)},
    ),
    (
        solve_rods,
        {
            "lengths": 0.3,
            "bending": 1.0,
            "torsional": 1.0,
            "rest_strains": (0, 0, 1),
            "distributed": (1, 0, 0),
            "elements": 20,
        },
        {
            "lengths": (-1.0,),
            "bending": (NAN,),
            "rest_strains": ((0, 1),),
            "elements": NO_COUNTS,
        },
    ),
    (
        lambda elements: solve_contact(
            replace(PROBLEM, obstacles=(replace(CLEAR, shape=Cylinder(1e-3)),)), elements=elements
        ),
        {"elements": 800},
        {"elements": (12, 12.0)},
    ),
    (
        lambda elements: solve_contact(
            RodProblem(replace(ROD, radius=0.0), obstacles=(replace(CLEAR, shape=Sphere(1e-9)),)),
            elements=elements,
        ),
        {},
        {"elements": (None,)},
    ),
    (
        follow_contact,
        {"problems": [PROBLEM]},
        {
            "problems": (
                [],
                PROBLEM,
                TURNED_OTHERWISE,
                [PROBLEM, replace(PROBLEM, tip=Pinned((0.3, 0, 0)))],
                [PROBLEM, replace(PROBLEM, rod=replace(ROD, radius=0.5))],
                [PROBLEM, replace(PROBLEM, obstacles=())],
            ),
            "largest_increment": (0.0, NAN),
            "smallest_increment": (0.0, 2.0),
        },
    ),
    (
        lambda **given: follow_contact(**({"problems": [PROBLEM], "start": solved()} | given)),
        {},
        {
            "problems": (
                [replace(PROBLEM, obstacles=())],
                [replace(PROBLEM, point_loads=(PointLoad(0.123),))],
            ),
            "elements": (13,),
        },
    ),
    (lambda index: solved().on_obstacle(index), {"index": 0}, {"index": (1,)}),
    (
        distances,
        {"function": lambda p: (p[:, 2] + 1.0, 0.0 * p + (0.0, 0.0, 1.0))},
        {
            "function": (
                lambda p: (p, p),
                lambda p: (p[:, 2] + 1.0, 0.0 * p + (0.0, 0.0, 3.0)),
                lambda p: (p[:, 0] * NAN, p * NAN),
            )
        },
    ),
]


def varying(name: str, profile: Callable[[Array], Array]) -> Section:
    """Return a section one of whose stiffnesses is a function."""
    return Section.varying(**{"bending": 6e-4, "torsional": 5e-4, name: profile})


def step(size: float) -> Callable[[Array], Array]:
    """Return a function that jumps where no break says so."""
    return lambda s: 1.0 + size * (s > 0.1234)


JUMPS = {
    "bending": lambda at: {"section": varying("bending", lambda s: 3e-4 * at(s))},
    "torsional": lambda at: {"section": varying("torsional", lambda s: 2e-4 * at(s))},
    "coupling": lambda at: {"section": varying("coupling", lambda s: 1e-5 * at(s))},
    "rest strain": lambda at: {"rest_strain": lambda s: at(s)[:, None] * (-5.0, 0.0, 10.0)},
}


@pytest.mark.parametrize("name", JUMPS)
@pytest.mark.parametrize("size", [1e-3, 1.0, 20.0])
def test_a_jump_that_no_break_declares_is_refused(name: str, size: float) -> None:
    given = JUMPS[name](step(size))
    rod = replace(FREE, **given)
    for ask in (
        lambda: solve_rod(rod, LOAD),
        lambda: find_equilibria(rod, LOAD),
        lambda: follow_path([rod], LOAD),
    ):
        with pytest.raises(InvalidInputError, match=r"breaks.*a jump at 0\.1234 m") as caught:
            ask()
        assert caught.value.field == next(iter(given))
    assert solve_rod(replace(rod, breaks=(0.1234,)), LOAD).stable


@pytest.mark.parametrize(("number", "field", "value"), list(wrong_arguments(ARGUMENTS)))
def test_a_wrong_argument_is_refused_by_name(number: int, field: str, value: object) -> None:
    call, good, _ = ARGUMENTS[number]
    with pytest.raises(InvalidInputError) as caught:
        call(**(good | {field: value}))
    assert caught.value.field == field
    assert field in str(caught.value)


def test_good_arguments_are_taken() -> None:
    for call, good, wrong in ARGUMENTS:
        if good or "elements" not in wrong:
            call(**good)


@pytest.mark.parametrize(
    ("problem", "status"),
    [
        (
            replace(PROBLEM, obstacles=(replace(CLEAR, position=(0.2, 0.0, -0.03)),)),
            RodStatus.INSIDE_OBSTACLE,
        ),
        (
            RodProblem(ROD, RodLoad((0.0, 0.0, -1.0)), base=Free()),
            RodStatus.NOT_HELD,
        ),
        (
            RodProblem(
                Rod(0.4, PLAIN, 3e-3, rest_strain=(0.0, 0.0, 120.0)),
            ),
            RodStatus.SELF_CONTACT,
        ),
    ],
)
def test_what_has_no_answer_has_a_status_that_says_why(
    problem: RodProblem, status: RodStatus
) -> None:
    state = solve_contact(problem, throw=False)
    assert state.status is status
    assert not state.stable
    with pytest.raises(SolverError) as caught:
        solve_contact(problem)
    assert caught.value.status is status
    assert status.value in str(caught.value)
    # What is no answer is no start either.
    with pytest.raises(InvalidInputError) as refused:
        follow_contact([problem], start=state)
    assert refused.value.field == "start"
