# SPDX-License-Identifier: Apache-2.0
"""What makes no sense is refused, and the message names the field and what would do."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from core.questions import Question, wrong_arguments
from numpy.typing import NDArray

from spiral_core import (
    Capsule,
    Clamped,
    Cone,
    Cylinder,
    Damping,
    Guided,
    Inertia,
    InvalidInputError,
    Obstacle,
    Pinned,
    Plane,
    PointLoad,
    Profile,
    Rod,
    RodLoad,
    RodProblem,
    RodState,
    Section,
    SignedDistance,
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
PLAIN = Section((2e-4, 3e-4, 3e-4))
ROD = Rod(0.4, PLAIN, 3e-3)
FREE = Rod(0.3, Section.inextensible(3e-4, 2e-4), rest_strain=(-5.0, 0.0, 10.0))
LOAD = RodLoad((0.24, 0.05, 0.0), (0.01, 0.0, 0.02))
CLEAR = Obstacle.along(Cylinder(0.03), (0.2, 0.0, -0.07), (0.0, 1.0, 0.0))
PROBLEM = RodProblem(ROD, obstacles=(CLEAR,))
STATE = solve_rod(FREE, LOAD, elements=10)
NO_STARTS = (
    *(np.eye(2), np.full((5, 3), NAN), "x"),
    replace(STATE, orientations=STATE.orientations[:5]),
    replace(STATE, orientations=STATE.orientations[:1], arc_lengths=np.zeros(1)),
    replace(STATE, orientations=STATE.orientations * NAN),
)
NO_COUNTS = (1, True, 2.5, 20_001)
TWISTED = tuple(replace(PROBLEM, tip=Guided(orientation=q)) for q in (None, (0.0, 0.0, 0.0, 1.0)))


def six(above: float, below: float) -> Array:
    """Return a 6x6 stiffness whose twist and stretch are coupled by fractions of their own."""
    matrix = np.diag((1e-4, 1e-4, 1e-4, 1e2, 1e2, 1e2))
    matrix[0, 3], matrix[3, 0] = 0.1 * above, 0.1 * below
    return matrix


def of_section(bending: Any = 6e-4, **given: Any) -> Rod:
    """Return a rod some of whose stiffnesses are changed."""
    varying = Section.varying(**{"bending": bending, "torsional": 5e-4} | given)
    return replace(FREE, section=varying)


def among(shape: Any, elements: int | None = None) -> object:
    """Solve a rod next to an obstacle of a shape."""
    problem = replace(PROBLEM, obstacles=(replace(CLEAR, shape=shape),))
    return solve_contact(problem, elements=elements)


def solved() -> RodState:
    """Return a state to start from."""
    return solve_contact(PROBLEM, elements=16)


def distances(function: Callable[[Array], tuple[Array, Array]]) -> object:
    return among(SignedDistance(function, 0.03))


THINGS = [
    *(PLAIN, ROD, LOAD, Pinned(), Clamped(), Guided(orientation=(0.0, 0.0, 0.0, 1.0)), CLEAR),
    *(PointLoad(0.1), RodProblem(ROD), Cylinder(0.1), Sphere(0.1), Cone(0.1, 0.1)),
    *(Capsule(0.1, 0.1), SignedDistance(distances, 0.1), Inertia(1.0, 1.0), Damping(0.0, 0.0)),
]


@pytest.mark.parametrize("thing", THINGS)
def test_every_field_is_checked(thing: Any) -> None:
    for field in {each.name for each in fields(thing)} - {"inside", "function"}:
        for value in (NAN, "x", -1.0)[: 2 if field in ("slope", "at") else 3]:
            with pytest.raises(InvalidInputError, match=field) as caught:
                replace(thing, **{field: value})
            assert caught.value.field == field


# A call with good arguments; and for each of them, what it must not be.
ARGUMENTS: list[Question] = [
    (
        Section,
        {"stiffness": six(0.5, 0.5)},
        {
            "stiffness": (
                ((1, 1, 0), (0, 1, 0), (0, 0, 1)),
                ((1, 2, 0), (2, 1, 0), (0, 0, 1)),
                *(np.eye(2), (0.0, 1.0, 1.0), (1.0, 1.0), six(0.1, 0.2), six(1.1, 1.1)),
            ),
            "extension": (1.0,),
            "shear": (1.0,),
        },
    ),
    (partial(Section, (1.0, 1.0, 1.0)), {}, {"extension": (0.0,)}),
    (
        Section.inextensible,
        {"bending": 4e-4, "torsional": 9e-4},
        {"bending": (0.0,), "torsional": (NAN,), "sideways": (0.0,), "coupling": (6e-4, -6e-4)},
    ),
    (
        lambda **given: solve_rod(of_section(**given), LOAD),
        {},
        {
            "bending": (-1.0, lambda s: NAN * s, lambda s: s[:, None] + 1.0),
            "torsional": (-1.0, lambda s: NAN * s),
            "sideways": (0.0,),
            "coupling": (NAN, lambda s: s[:2]),
        },
    ),
    (
        lambda **given: solve_rod(replace(FREE, **given), LOAD),
        {"section": PLAIN},
        {
            "section": (
                lambda _: PLAIN,
                of_section(torsional=lambda s: s - 0.2).section,
                of_section(coupling=lambda s: 6e-4 + 0.0 * s).section,
            ),
            "rest_strain": (lambda s: np.ones(len(s)),),
        },
    ),
    (
        partial(Section.round, 1e-3),
        {"young": 1e6, "shear_modulus": 4e5},
        {"bore": (1e-3, -1e-4), "young": (0.0,), "shear_modulus": (0.0,)},
    ),
    (
        partial(replace, ROD),
        {},
        {
            "length": (0.0,),
            "friction_radius": (4e-3,),
            "breaks": ((0.3, 0.2), (0.4,), (0.0,), (0.2, 0.2), ("a",), (NAN,)),
        },
    ),
    (partial(RodProblem, ROD), {}, {"obstacles": ((Plane(),), CLEAR), "point_loads": ((0.1,),)}),
    (lambda at: RodProblem(ROD, point_loads=(PointLoad(at),)), {"at": 0.4}, {"at": (0.5,)}),
    (
        Profile,
        {"heights": (0.0, 0.01, 0.02, 0.03), "radii": (0.1, 0.1, 0.1, 0.1)},
        # One number; not increasing; too few; and a spline that passes through the axis.
        {"heights": (0.1, (0.0, 0.0, 0.02, 0.03)), "radii": ((1.0,), (0.1, 1e-3, 1e-3, 0.1))},
    ),
    (partial(Obstacle.along, Plane(), (0, 0, 0)), {"axis": (0, 0, 1)}, {"axis": ((0, 0, 0),)}),
    (CLEAR.moved, {}, {"translation": ((NAN, 0, 0),), "rotation": ((0.0, 0.0),)}),
    # Too few elements to see the obstacle.
    (partial(among, Cylinder(1e-3)), {"elements": 800}, {"elements": (12, 12.0)}),
    (
        distances,
        {"function": lambda p: (p[:, 2] + 1.0, 0.0 * p + (0.0, 0.0, 1.0))},
        {
            "function": (
                lambda p: (p, p),
                lambda p: (p[:, 2] + 1.0, 0.0 * p + (0.0, 0.0, 3.0)),
            )
        },
    ),
    (
        solve_rod,
        {"rod": FREE, "load": LOAD},
        {
            "rod": ("rod", RodProblem(FREE)),
            "load": (3.0,),
            "element": ("mixed",),
            "elements": NO_COUNTS,
            "start": NO_STARTS,
        },
    ),
    (
        lambda distributed: solve_rod(FREE, RodLoad(distributed)),
        {"distributed": (0.0, 0.0, 1.0)},
        {"distributed": (np.zeros_like,)},
    ),
    # Each element would turn too far.
    (partial(solve_rod, replace(FREE, length=1.0), LOAD), {"elements": 8}, {"elements": (5,)}),
    # In what units?
    *(
        (partial(solve_rod, rod), {}, {"elements": (None,)})
        for rod in (
            replace(FREE, length=300000.0),
            RodProblem(replace(FREE, section=Section.inextensible(1e-300, 1e-300)), LOAD),
            RodProblem(FREE, RodLoad((1e300, 0.0, 0.0))),
            RodProblem(replace(ROD, radius=0.0), obstacles=(Obstacle(Sphere(1e-9), (0, 0, 1)),)),
        )
    ),
    (
        follow_path,
        {"rods": (FREE, FREE), "loads": LOAD},
        {
            "rods": ((), FREE, [FREE, replace(FREE, breaks=(0.1,))]),
            "loads": ([LOAD], [LOAD] * 3, 3.0),
        },
    ),
    (
        partial(follow_rod, [RodProblem(FREE, LOAD)] * 2, stop_at_event=True),
        {"start": None},
        {"start": (STATE, STATE.positions)},
    ),
    (
        partial(find_equilibria, FREE, LOAD),
        {"starts": 2},
        {"seed": (-1,), "starts": (0, True, 2.5)},
    ),
    (
        lambda radius: find_equilibria(replace(FREE, radius=radius), LOAD, starts=1),
        {"radius": 0.0},
        {"radius": (1e-3,)},
    ),
    (
        partial(solve_rods, bending=1.0, torsional=1.0, distributed=((1, 0, 0),) * 3),
        {"lengths": 0.3, "rest_strains": (0, 0, 1), "elements": 20},
        {
            "lengths": (-1.0, NAN, (0.3, 0.4)),
            "rest_strains": ((0, 1),),
            "elements": (1, True, 20_001),
        },
    ),
    (
        follow_contact,
        {"problems": [PROBLEM]},
        {
            "problems": (
                *([], PROBLEM, TWISTED),
                [PROBLEM, replace(PROBLEM, obstacles=(Obstacle(Plane(), (0, 0, -1)),))],
                [PROBLEM, replace(PROBLEM, tip=Pinned((0.3, 0, 0)))],
                [PROBLEM, replace(PROBLEM, rod=replace(ROD, radius=0.5))],
            ),
            "largest_increment": (0.0, NAN),
            "smallest_increment": (0.0, 2.0),
        },
    ),
    (
        lambda **given: follow_contact(start=solved(), **given),
        {"problems": [PROBLEM]},
        {
            "problems": (
                [replace(PROBLEM, obstacles=())],
                [replace(PROBLEM, point_loads=(PointLoad(0.123),))],
            ),
        },
    ),
    (
        lambda elements: follow_contact([PROBLEM], start=solved(), elements=elements),
        {"elements": 16},
        {"elements": (13,)},
    ),
    (lambda index: solved().on_obstacle(index), {"index": 0}, {"index": (1,)}),
]


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


def jumping(s: Array) -> Array:
    """Return what jumps, by little, where no break says so."""
    return 1.0 + 1e-3 * (s > 0.1234)


JUMPS = {
    "section": of_section(coupling=lambda s: 1e-5 * jumping(s)),
    "rest_strain": replace(FREE, rest_strain=lambda s: jumping(s)[:, None] * (-5.0, 0.0, 10.0)),
}


@pytest.mark.parametrize("field", JUMPS)
def test_a_jump_that_no_break_declares_is_refused(field: str) -> None:
    for ask in (solve_rod, find_equilibria, lambda rod, load: follow_path([rod], load)):
        with pytest.raises(InvalidInputError, match=r"breaks.*a jump at 0\.1234 m") as caught:
            ask(JUMPS[field], LOAD)
        assert caught.value.field == field
    assert solve_rod(replace(JUMPS[field], breaks=(0.1234,)), LOAD).stable
