# SPDX-License-Identifier: Apache-2.0
"""Paths of rods that are held, touch, stick and slide, which the invariants of contact run over."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from core.contact_cases import grip

from benchmarks.contact_paths import random_path
from spiral_core import (
    Capsule,
    Clamped,
    Cone,
    Cylinder,
    Free,
    Guided,
    Obstacle,
    Pinned,
    Plane,
    PointLoad,
    Profile,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    SignedDistance,
    Sphere,
)

Array = np.ndarray


@dataclass(frozen=True)
class Path:
    """Stations, and how they are followed.

    With friction the answer depends on the increments: these are so short that none is decided by
    how many passes the one before took, which rounding may change.
    """

    stations: list[RodProblem]
    elements: int = 60
    largest_increment: float = 1.0


def pulled_out(weight: tuple[float, float, float]) -> Path:
    """Return a coil that closes under its weight, and the cylinder that is then pulled out of it.

    It closes without friction: with it the answer depends on the increments of the way.
    """
    closed = [grip(0.015, 1.1), grip(0.015, 1.1, 0.3)]
    away = [grip(0.015, 1.1, 0.3, shift) for shift in (-1e-3, -3e-3)]
    return Path([replace(station, load=RodLoad(weight)) for station in closed + away])


def among_many() -> Path:
    """Return a rod of coupled, unlike stiffnesses that sinks onto four obstacles above a floor.

    At 1.5 times this load it slips off them.
    """
    bending = ((3e-4, 2e-5, 0.0), (2e-5, 4e-4, 3e-5), (0.0, 3e-5, 9e-4))
    stretch = ((60.0, 3.0, -2.0), (3.0, 20.0, 1.0), (-2.0, 1.0, 25.0))
    between = np.array(((0.03, 0.01, -0.02), (0.02, -0.01, 0.03), (-0.05, 0.02, 0.01)))
    section = Section(np.block([[np.array(bending), between], [between.T, np.array(stretch)]]))
    rod = Rod(0.5, section, 2e-3, rest_strain=(2.0, 1.0, -1.5))
    obstacles = (
        Obstacle.along(Cylinder(0.03), (0.12, 0.0, -0.06), (0.1, 1.0, 0.2), 0.3),
        Obstacle(Sphere(0.03), (0.25, -0.01, -0.09), friction=0.1),
        Obstacle.along(Capsule(0.02, 0.05), (0.36, 0.03, -0.14), (1.0, 1.0, 0.0), 0.2),
        Obstacle.along(Cone(0.03, 0.2), (0.44, 0.0, -0.18), (0.0, 1.0, 0.3), 0.4),
        Obstacle.along(Plane(), (0.0, 0.0, -0.2), (0.1, 0.0, 1.0), 0.5),
    )

    def loaded(part: float, sideways: float) -> RodProblem:
        return RodProblem(
            rod,
            RodLoad((0.0, 0.1 * part, -1.2 * part), (0.0, sideways, 0.0), (1e-3 * part, 0.0, 0.0)),
            base=Clamped((0.0, 0.0, 0.02), (0.0, 0.0, 0.1, np.sqrt(0.99))),
            obstacles=obstacles,
            point_loads=(PointLoad(0.2, (0.02 * part, 0.0, 0.0), (0.0, 0.0, 2e-4 * part)),),
        )

    steps = ((0.0, 0.0), (0.04, 0.0), (0.08, 0.0), (0.08, 7e-4))
    return Path([loaded(*step) for step in steps], largest_increment=0.05)


def pressed_down() -> Path:
    """Return a rod pressed onto a bar, a ball and the floor, and pushed aside at its tip."""
    rod = Rod(0.5, Section((2e-4, 3e-4, 5e-4)), 3e-3, rest_strain=(1.0, 0.5, 2.0))
    obstacles = (
        Obstacle.along(Cylinder(0.03), (0.2, 0.0, -0.05), (0.0, 1.0, 0.0), 0.3),
        Obstacle(Sphere(0.02), (0.4, -0.012, -0.072), friction=0.2),
        Obstacle(Plane(), (0.0, 0.0, -0.06), friction=0.4),
    )
    loads = tuple(PointLoad(at, (0.0, 0.0, -0.06)) for at in (0.1, 0.25, 0.35, 0.45))

    def pushed(push: float) -> RodProblem:
        load = RodLoad(tip_force=(0.0, push, -0.02), tip_moment=(1e-4, 0.0, 0.0))
        return RodProblem(rod, load, obstacles=obstacles, point_loads=loads)

    return Path([pushed(push) for push in (0.0, 4e-3, 4.2e-3)], elements=50)


# Every coupling of twist and both bendings, and it stretches.
HELD = Rod(
    0.4,
    Section(
        ((1.7e-4, 2e-5, 1e-5), (2e-5, 2.7e-4, 3e-5), (1e-5, 3e-5, 3.4e-4)),
        extension=30.0,
        shear=10.0,
    ),
    3e-3,
    rest_strain=(3.0, -1.0, 4.0),
)
HEAVY = RodLoad((0.05, 0.02, -0.4))
LINE = (0.6, 0.0, 0.8)
KINDS: dict[str, Any] = {
    "clamped": Clamped,
    "pinned": lambda place, _: Pinned(place),
    "guided": lambda place, _: Guided(place, LINE),
    "guided, not turning": lambda place, turn: Guided(place, LINE, turn),
    "free": lambda _, __: Free(),
}
FIXING = {"clamped", "pinned"}
# What one end must add to the other so that nothing is left to fall or to spin.
PAIRS = [
    (base, tip)
    for base, tip in product(KINDS, KINDS)
    if {base, tip} & FIXING and {base, tip} != {"pinned", "free"}
]
PLACE, TURN = (0.33, 0.02, 0.01), (0.0, 0.0, math.sin(0.15), math.cos(0.15))


def held(base: str, tip: str, load: RodLoad = HEAVY) -> RodProblem:
    """Return a rod that hangs between two ends of these kinds."""
    ends = KINDS[base]((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), KINDS[tip](PLACE, TURN)
    return RodProblem(HELD, load, *ends)


BETWEEN = {f"{base} to {tip}": held(base, tip) for base, tip in PAIRS}
PATHS = {
    "pulled out": pulled_out((0.05, 0.1, -0.03)),
    "pulled out, weightless": pulled_out((0.0, 0.0, 0.0)),
    "among many": among_many(),
    "pressed down": pressed_down(),
    **{f"random {index}": Path(random_path(index)) for index in (3, 29, 38)},
    **{name: Path([problem], elements=48) for name, problem in BETWEEN.items()},
}

ROUND = 0.03


def round_distance(points: Array) -> tuple[Array, Array]:
    """Return the distance from a cylinder about z, as a user would write it."""
    away = points * (1.0, 1.0, 0.0)
    rho = np.linalg.norm(away, axis=1)
    return rho - ROUND, away / rho[:, None]


SHAPES = {
    "cylinder": Cylinder(ROUND),
    "cone": Cone(ROUND, 0.3),
    "profile": Profile((-0.1, -0.03, 0.03, 0.1), (0.03, 0.035, 0.025, 0.04)),
    "sphere": Sphere(ROUND),
    "capsule": Capsule(ROUND, 0.02),
    "plane": Plane(),
    "signed distance": SignedDistance(round_distance, ROUND),
}
SPAN = Rod(0.4, Section((1.7e-4, 2.7e-4, 2.7e-4)), 3e-3)


def way_of_shape(name: str, count: int) -> list[RodProblem]:
    """Return a shape that is lifted into a rod between two clamps, and turned."""
    turn = np.array((0.15, 0.1, 0.2)) * (0.2 if name == "plane" else 1.0)
    axis = (0.05, 0.02, 1.0) if name == "plane" else (0.3, 1.0, 0.1)
    low = -0.06 if name == "plane" else -SPAN.radius - ROUND - 0.02
    place = Obstacle.along(SHAPES[name], (0.21, 0.003, low), axis)
    return [
        RodProblem(
            SPAN,
            RodLoad((0.0, 0.02, -0.5)),
            tip=Clamped((0.39, 0.0, 0.0)),
            obstacles=(place.moved((0.0, 0.004 * t, 0.02 * t), tuple((t * turn).tolist())),),
        )
        for t in np.linspace(0.0, 1.0, count + 1)
    ]


def way_of_end(base: str, tip: str, count: int) -> list[RodProblem]:
    """Return a rod whose tip is moved by 60 mm."""
    first = held(base, tip)
    way = np.linspace(0.0, 0.06, count + 1)[:, None] * (-1.0, 0.4, 0.2)
    return [replace(first, tip=replace(first.tip, position=tuple(np.add(PLACE, d)))) for d in way]
