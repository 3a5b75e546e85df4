# SPDX-License-Identifier: Apache-2.0
"""What makes no sense is refused, and the message names the field and what would do."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
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


def batch(
    length: float = 0.3,
    bending: float = 1.0,
    strain: tuple[float, ...] = (0, 0, 1),
    elements: object = 20,
) -> object:
    """Return a batch of one rod."""
    return solve_rods(length, bending, 1.0, strain, (1, 0, 0), elements=elements)


BAD: dict[str, tuple[str, Callable[[], object]]] = {
    "matrix not symmetric": ("stiffness", lambda: Section(((1, 1, 0), (0, 1, 0), (0, 0, 1)))),
    "matrix not positive": ("stiffness", lambda: Section(((1, 2, 0), (2, 1, 0), (0, 0, 1)))),
    "stiffness zero": ("stiffness", lambda: Section((0.0, 1.0, 1.0))),
    "two stiffnesses": ("stiffness", lambda: Section((1.0, 1.0))),
    "stiffness no matrix": ("stiffness", lambda: Section(((1, 0), (0, 1, 0), (0, 0, 1)))),
    "6x6 not symmetric": ("stiffness", lambda: Section(six(0.1, 0.2))),
    "6x6 not positive": ("stiffness", lambda: Section(six(1.1, 1.1))),
    "6x6 and extension": ("extension", lambda: Section(six(0.5, 0.5), extension=1.0)),
    "6x6 and shear": ("shear", lambda: Section(six(0.5, 0.5), shear=1.0)),
    "no rod": ("rod", lambda: RodProblem(3)),
    "one station": ("problems", lambda: follow_contact(PROBLEM)),
    "start a word": ("start", lambda: solve_contact(PROBLEM, start="x")),
    "no shape": ("shape", lambda: Obstacle(3)),
    "orientation held by and by": (
        "problems",
        lambda: follow_contact(
            [
                replace(PROBLEM, tip=Guided((0.4, 0, 0), orientation=held))
                for held in (None, (0.0, 0.0, 0.0, 1.0))
            ]
        ),
    ),
    "shear negative": ("shear", lambda: Section((1.0, 1.0, 1.0), shear=-1.0)),
    "bore too wide": ("bore", lambda: Section.round(1e-3, 1e6, 4e5, bore=1e-3)),
    "young zero": ("young", lambda: Section.round(1e-3, 0.0, 4e5)),
    "length zero": ("length", lambda: Rod(0.0, PLAIN)),
    "length infinite": ("length", lambda: Rod(math.inf, PLAIN)),
    "section a number": ("section", lambda: Rod(0.4, 3e-4)),
    "radius negative": ("radius", lambda: Rod(0.4, PLAIN, -1e-3)),
    "friction radius too large": (
        "friction_radius",
        lambda: Rod(0.4, PLAIN, 1e-3, friction_radius=2e-3),
    ),
    "rest strain nan": ("rest_strain", lambda: Rod(0.4, PLAIN, rest_strain=(0, NAN, 0))),
    "breaks not increasing": ("breaks", lambda: Rod(0.4, PLAIN, breaks=(0.3, 0.2))),
    "break at the end": ("breaks", lambda: Rod(0.4, PLAIN, breaks=(0.4,))),
    "pin nan": ("position", lambda: Pinned((0.0, NAN, 0.0))),
    "clamp not a unit": ("orientation", lambda: Clamped(orientation=(0, 0, 0, 2))),
    "guide without direction": ("direction", lambda: Guided(direction=(0, 0, 0))),
    "point load nan": ("force", lambda: PointLoad(0.1, (NAN, 0, 0))),
    "couple infinite": ("moment", lambda: PointLoad(0.1, moment=(math.inf, 0, 0))),
    "point load beyond the rod": (
        "at",
        lambda: RodProblem(ROD, point_loads=(PointLoad(0.5),)),
    ),
    "base no end": ("base", lambda: RodProblem(ROD, base="clamped")),
    "tip no end": ("tip", lambda: RodProblem(ROD, tip=None)),
    "obstacle a shape": ("obstacles", lambda: RodProblem(ROD, obstacles=(Plane(),))),
    "one obstacle": ("obstacles", lambda: RodProblem(ROD, obstacles=CLEAR)),
    "one point load": ("point_loads", lambda: RodProblem(ROD, point_loads=PointLoad(0.1))),
    "point load a number": ("point_loads", lambda: RodProblem(ROD, point_loads=(0.1,))),
    "one break": ("breaks", lambda: Rod(0.4, PLAIN, breaks=0.1)),
    "load a vector": ("load", lambda: RodProblem(ROD, load=(0.0, 0.0, -1.0))),
    "profile through its axis": (
        "radii",
        lambda: Profile((0.0, 0.01, 0.02, 0.03), (0.1, 0.001, 0.001, 0.1)),
    ),
    "radius of a sphere": ("radius", lambda: Sphere(0.0)),
    "slope nan": ("slope", lambda: Cone(0.1, NAN)),
    "capsule without length": ("length", lambda: Capsule(0.1, 0.0)),
    "heights decrease": ("heights", lambda: Profile((1.0, 0.0), (1.0, 1.0))),
    "radii miss one": ("radii", lambda: Profile((0.0, 1.0), (1.0,))),
    "feature radius nan": ("feature_radius", lambda: SignedDistance(lambda p: (p, p), NAN)),
    "axis zero": ("axis", lambda: Obstacle.along(Plane(), (0, 0, 0), (0, 0, 0))),
    "friction negative": ("friction", lambda: replace(CLEAR, friction=-0.1)),
    "friction nan": ("friction", lambda: Obstacle(Plane(), friction=NAN)),
    "obstacle not a unit": ("orientation", lambda: Obstacle(Plane(), orientation=(0, 0, 0, 2.0))),
    "cylinder nan": ("radius", lambda: Cylinder(NAN)),
    "heights alike": ("heights", lambda: Profile((0.0, 0.0), (1.0, 1.0))),
    "translation nan": ("translation", lambda: CLEAR.moved((NAN, 0, 0))),
    "rotation of two": ("rotation", lambda: CLEAR.moved(rotation=(0.0, 0.0))),
    "elements fractional": ("elements", lambda: solve_contact(PROBLEM, elements=12.0)),
    "elements one": ("elements", lambda: solve_contact(PROBLEM, elements=1)),
    "elements too few": (
        "elements",
        lambda: solve_contact(
            replace(PROBLEM, obstacles=(replace(CLEAR, shape=Cylinder(1e-3)),)), elements=12
        ),
    ),
    "elements too many": (
        "elements",
        lambda: solve_contact(
            replace(
                PROBLEM,
                obstacles=(replace(CLEAR, shape=Sphere(1e-9)),),
                rod=replace(ROD, radius=0.0),
            )
        ),
    ),
    "start of one point": ("start", lambda: solve_contact(PROBLEM, start=np.zeros((1, 3)))),
    "start in two dimensions": ("start", lambda: solve_contact(PROBLEM, start=np.eye(2))),
    "start standing still": ("start", lambda: solve_contact(PROBLEM, start=np.zeros((5, 3)))),
    "start nan": ("start", lambda: solve_contact(PROBLEM, start=np.full((5, 3), NAN))),
    "no stations": ("problems", lambda: follow_contact([])),
    "increment zero": (
        "largest_increment",
        lambda: follow_contact([PROBLEM], largest_increment=0.0),
    ),
    "increment nan": (
        "largest_increment",
        lambda: follow_contact([PROBLEM], largest_increment=NAN),
    ),
    "smallest increment zero": (
        "smallest_increment",
        lambda: follow_contact([PROBLEM], smallest_increment=0.0),
    ),
    "smallest increment above the largest": (
        "smallest_increment",
        lambda: follow_contact([PROBLEM], largest_increment=0.1, smallest_increment=0.2),
    ),
    "stations of other ends": (
        "problems",
        lambda: follow_contact([PROBLEM, replace(PROBLEM, tip=Pinned((0.3, 0, 0)))]),
    ),
    "stations of another rod": (
        "problems",
        lambda: follow_contact([PROBLEM, replace(PROBLEM, rod=replace(ROD, radius=0.5))]),
    ),
    "stations of other shapes": (
        "problems",
        lambda: follow_contact([PROBLEM, replace(PROBLEM, obstacles=())]),
    ),
    "stations of other shapes than the start's": (
        "problems",
        lambda: follow_contact([replace(PROBLEM, obstacles=())], start=solved()),
    ),
    "stations of other point loads": (
        "problems",
        lambda: follow_contact([replace(PROBLEM, point_loads=(PointLoad(0.123),))], start=solved()),
    ),
    "start of other elements": (
        "elements",
        lambda: follow_contact([PROBLEM], start=solved(), elements=13),
    ),
    "index of no obstacle": ("index", lambda: solved().on_obstacle(1)),
    "user's distances of another shape": (
        "function",
        lambda: solve_contact(
            replace(PROBLEM, obstacles=(Obstacle(SignedDistance(lambda p: (p, p), 0.03)),))
        ),
    ),
    "user's gradients of norm three": (
        "function",
        lambda: solve_contact(
            replace(
                PROBLEM,
                obstacles=(
                    Obstacle(SignedDistance(lambda p: (p[:, 2] + 1.0, 0 * p + (0, 0, 3)), 0.03)),
                ),
            )
        ),
    ),
    "user's distances nan": (
        "function",
        lambda: solve_contact(
            replace(
                PROBLEM,
                obstacles=(Obstacle(SignedDistance(lambda p: (p[:, 0] * NAN, p * NAN), 0.03)),),
            )
        ),
    ),
    "bending nan": ("bending", lambda: Section.inextensible(NAN, 1e-4)),
    "torsional negative": ("torsional", lambda: Section.inextensible(1e-4, -1.0)),
    "sideways zero": ("sideways", lambda: Section.inextensible(1e-4, 1e-4, sideways=0.0)),
    "coupling too strong": ("coupling", lambda: Section.inextensible(4e-4, 9e-4, coupling=-6e-4)),
    "coupling nan": ("coupling", lambda: Section.inextensible(1e-4, 1e-4, coupling=NAN)),
    "varying bending nan": ("bending", lambda: Section.varying(NAN, 1e-4)),
    "varying torsional negative": ("torsional", lambda: Section.varying(1e-4, -1.0)),
    "varying bending a word": ("bending", lambda: Section.varying("x", 1e-4)),
    "break at the base": ("breaks", lambda: Rod(0.4, PLAIN, breaks=(0.0,))),
    "breaks alike": ("breaks", lambda: Rod(0.4, PLAIN, breaks=(0.2, 0.2))),
    "break a word": ("breaks", lambda: Rod(0.4, PLAIN, breaks=("a",))),
    "weight of two": ("distributed", lambda: RodLoad((1.0, 2.0))),
    "tip force nan": ("tip_force", lambda: RodLoad(tip_force=(1.0, 2.0, NAN))),
    "tip moment a word": ("tip_moment", lambda: RodLoad(tip_moment="abc")),
    "no load": ("load", lambda: solve_rod(FREE, (1.0, 0.0, 0.0))),
    "no rod to solve": ("rod", lambda: solve_rod("rod", LOAD)),
    "problem and load": ("rod", lambda: solve_rod(RodProblem(FREE), LOAD)),
    "element a word": ("element", lambda: solve_rod(FREE, LOAD, element="mixed")),
    "elements too few for the rest strain": (
        "elements",
        lambda: solve_rod(replace(FREE, rest_strain=(0.0, 0.0, 40.0)), LOAD, elements=3),
    ),
    "no rods": ("rods", lambda: follow_path([], LOAD)),
    "rods a rod": ("rods", lambda: follow_path(FREE, LOAD)),
    "a load too many": ("loads", lambda: follow_path([FREE], [LOAD, LOAD])),
    "a load too few": ("loads", lambda: follow_path([FREE, FREE], [LOAD])),
    "loads a number": ("loads", lambda: follow_path([FREE], 3.0)),
    "other breaks": ("rods", lambda: follow_path([FREE, replace(FREE, breaks=(0.1,))], LOAD)),
    "seed negative": ("seed", lambda: find_equilibria(FREE, LOAD, seed=-1)),
    "radius of equilibria": ("radius", lambda: find_equilibria(ROD, LOAD)),
    "start of the other element": (
        "start",
        lambda: follow_rod(
            [RodProblem(FREE, LOAD)] * 2,
            start=solve_rod(FREE, LOAD, elements=10),
            stop_at_event=True,
        ),
    ),
    "batch length": ("lengths", lambda: batch(length=-1.0)),
    "batch bending": ("bending", lambda: batch(bending=NAN)),
    "batch of two strains": ("rest_strains", lambda: batch(strain=(0, 1))),
}

for bad in (0, -1, True, 2.5):
    BAD[f"starts {bad}"] = ("starts", lambda bad=bad: find_equilibria(FREE, LOAD, starts=bad))
for bad in (-5, 0, 1, True, 2.5, "a", 20_001):
    BAD |= {
        f"elements {bad} of a rod": (
            "elements", lambda bad=bad: solve_rod(FREE, LOAD, elements=bad)
        ),
        f"elements {bad} of a path": (
            "elements", lambda bad=bad: follow_path([FREE], LOAD, elements=bad)
        ),
        f"elements {bad} of equilibria": (
            "elements", lambda bad=bad: find_equilibria(FREE, LOAD, elements=bad)
        ),
        f"elements {bad} of a batch": (
            "elements",
            lambda bad=bad: batch(elements=bad),
        ),
    }  # fmt: skip
for name, rod, weight in (
    ("long", Rod(300000.0, PLAIN, rest_strain=(0.0, 0.0, 20.0)), 0.2),
    ("curled", Rod(0.3, PLAIN, rest_strain=(0.0, 0.0, 1e300)), 0.2),
    ("soft", Rod(0.3, Section.inextensible(1e-300, 1e-300), rest_strain=(0.0, 0.0, 20.0)), 0.2),
    ("heavy", Rod(0.3, PLAIN, rest_strain=(0.0, 0.0, 20.0)), 1e300),
):
    BAD[f"endless elements, {name}"] = (
        "elements must be at most 20000",
        lambda rod=rod, weight=weight: solve_rod(rod, RodLoad((weight, 0.0, 0.0))),
    )
STATE = solve_rod(FREE, LOAD, elements=10)
for name, start in {
    "short": replace(STATE, orientations=STATE.orientations[:5]),
    "single": replace(STATE, orientations=STATE.orientations[:1], arc_lengths=np.zeros(1)),
    "nan": replace(STATE, orientations=STATE.orientations * NAN),
    "a word": "a",
    "orientations": STATE.orientations,
}.items():
    BAD[f"start {name}"] = ("start", lambda start=start: solve_rod(FREE, LOAD, start=start))
    BAD[f"start {name}, path"] = (
        "start",
        lambda start=start: follow_path([FREE], LOAD, start=start),
    )


def varying(name: str, profile: Callable[[Array], Array]) -> Section:
    """Return a section one of whose stiffnesses is a function."""
    return Section.varying(**{"bending": 6e-4, "torsional": 5e-4, name: profile})


# Profiles that give no rod: the field that names them, and the rod.
for name, field, rod in (
    ("bending nan", "bending", replace(FREE, section=varying("bending", lambda s: NAN * s))),
    ("torsional nan", "torsional", replace(FREE, section=varying("torsional", lambda s: NAN * s))),
    ("coupling nan", "coupling", replace(FREE, section=varying("coupling", lambda s: NAN * s))),
    ("bending zero", "section", replace(FREE, section=varying("bending", lambda s: 0.0 * s))),
    ("torsion below 0", "section", replace(FREE, section=varying("torsional", lambda s: s - 0.2))),
    ("sideways below 0", "section", replace(FREE, section=varying("sideways", lambda s: s - 1.0))),
    ("too coupled", "section", replace(FREE, section=varying("coupling", lambda s: 6e-4 + 0 * s))),
    ("two couplings", "coupling", replace(FREE, section=varying("coupling", lambda s: s[:2]))),
    ("columns", "bending", replace(FREE, section=varying("bending", lambda s: s[:, None] + 1.0))),
    ("a section", "section", replace(FREE, section=lambda s: PLAIN)),
    ("flat strain", "rest_strain", replace(FREE, rest_strain=lambda s: np.ones(len(s)))),
):
    BAD[f"profile {name}"] = (field, lambda rod=rod: solve_rod(rod, LOAD))
BAD["profile weight nan"] = (
    "distributed",
    lambda: solve_rod(FREE, RodLoad(lambda s: np.full((len(s), 3), NAN)), elements=10),
)


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


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_refused_and_named(name: str) -> None:
    field, make = BAD[name]
    with pytest.raises(InvalidInputError) as caught:
        make()
    assert caught.value.field == field.split()[0]
    assert field in str(caught.value)


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
