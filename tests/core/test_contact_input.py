# SPDX-License-Identifier: Apache-2.0
"""What makes no sense is refused, and the message names the field, the value and what would do."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

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
)
from spiral_core.rod.contact.solve import follow_contact, solve_contact

NAN = math.nan
PLAIN = Section((2e-4, 3e-4, 3e-4))
ROD = Rod(0.4, PLAIN, 3e-3)
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


BAD: dict[str, tuple[str, Callable[[], object]]] = {
    "matrix not symmetric": ("stiffness", lambda: Section(((1, 1, 0), (0, 1, 0), (0, 0, 1)))),
    "matrix not positive": ("stiffness", lambda: Section(((1, 2, 0), (2, 1, 0), (0, 0, 1)))),
    "stiffness nan": ("stiffness", lambda: Section((1.0, NAN, 1.0))),
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
    "gradient of norm three": (
        "function",
        lambda: SignedDistance(
            lambda p: (p[:, 2], np.tile((0.0, 0.0, 3.0), (len(p), 1))), 0.1
        ).distance(np.zeros((2, 3))),
    ),
    "spline below zero": (
        "radii",
        lambda: Profile((0, 0.01, 0.02, 0.03), (0.1, 1e-3, 1e-3, 0.1)).distance(np.ones((1, 3))),
    ),
    "orientation held by and by": (
        "problems",
        lambda: follow_contact(
            [
                replace(PROBLEM, tip=Guided((0.4, 0, 0), orientation=held))
                for held in (None, (0.0, 0.0, 0.0, 1.0))
            ]
        ),
    ),
    "extension nan": ("extension", lambda: Section((1.0, 1.0, 1.0), NAN)),
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
    "obstacle without a shape": ("shape", lambda: Obstacle(3)),
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
}


def test_sections_given_as_arrays_are_equal() -> None:
    assert Section(np.eye(6)) == Section(tuple(map(tuple, np.eye(6).tolist())))
    assert Section(np.array([1.0, 2.0, 3.0])) == Section((1.0, 2.0, 3.0))


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_refused_and_named(name: str) -> None:
    field, make = BAD[name]
    with pytest.raises(InvalidInputError) as caught:
        make()
    assert caught.value.field == field
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
