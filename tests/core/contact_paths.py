# SPDX-License-Identifier: Apache-2.0
"""Paths of rods that are held, touch, stick and slide, which the invariants of contact run over."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from core.contact_cases import bar, floor, grip
from core.rod_cases import SIX
from numpy.testing import assert_allclose

from benchmarks.contact_paths import random_path
from spiral_core import (
    Clamped,
    Free,
    Guided,
    Obstacle,
    Pinned,
    PointLoad,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    Sphere,
)
from spiral_core.rod.contact.solve import follow_contact


def agree(found, expected, within=1e-6):
    """Check that two arrays are the same, to a part of the largest value."""
    size = np.abs(expected).max(initial=1e-12)
    assert_allclose(found, expected, rtol=0.0, atol=within * size)


@dataclass(frozen=True)
class Path:
    """Stations, and on how many elements they are followed."""

    stations: list[RodProblem]
    elements: int = 60

    def followed(self):
        """Return the states; nothing snaps."""
        found = follow_contact(self.stations, elements=self.elements)
        assert not found.events
        return found.states


def pulled_out(*weight):
    """Return a coil that closes under its weight, and the cylinder that is then pulled out of it.

    It closes without friction: with it the answer depends on the increments of the way.
    """
    way = ((0.0, 0.0), (0.3, 0.0), (0.3, -1e-3), (0.3, -3e-3))
    return Path([replace(grip(0.015, 1.1, *step), load=RodLoad(weight)) for step in way])


def pressed_down():
    """Return a rod pressed onto a bar, a ball and the floor, and pushed aside at its tip."""
    rod = Rod(0.5, Section((2e-4, 3e-4, 5e-4)), 3e-3, rest_strain=(1.0, 0.5, 2.0))
    obstacles = (
        bar(0.03, 0.2, -0.05, 0.3),
        Obstacle(Sphere(0.02), (0.4, -0.012, -0.072), friction=0.2),
        floor(-0.06, 0.4),
    )
    loads = [PointLoad(at, (0.0, 0.0, -0.06), (0.0, 1e-4, 2e-4)) for at in (0.1, 0.25, 0.35, 0.45)]
    pushes = [
        RodLoad((0.0, 0.0, 0.0), (0.0, y, -0.02), (1e-4, 0.0, 0.0)) for y in (0, 4e-3, 4.2e-3)
    ]
    given = {"obstacles": obstacles, "point_loads": (*loads,)}
    return Path([RodProblem(rod, load, **given) for load in pushes], elements=50)


HELD = Rod(0.4, SIX, 3e-3, rest_strain=(3.0, -1.0, 4.0))
HEAVY = RodLoad((0.05, 0.02, -0.4))
LINE = (0.6, 0.0, 0.8)
PLACE, TURN = (0.33, 0.02, 0.01), (0.0, 0.0, math.sin(0.15), math.cos(0.15))
KINDS: dict[str, Any] = {
    "clamped": Clamped,
    "pinned": lambda place, _: Pinned(place),
    "guided": lambda place, _: Guided(place, LINE),
    "guided, not turning": lambda place, turn: Guided(place, LINE, turn),
    "free": lambda _, __: Free(),
}


def held(base, tip, load=HEAVY):
    """Return a rod that hangs between two ends of these kinds."""
    ends = KINDS[base]((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), KINDS[tip](PLACE, TURN)
    return RodProblem(HELD, load, *ends)


# The other orders are these read backwards. Nothing is left to fall or to spin.
BETWEEN = {
    f"{base} to {tip}": held(base, tip)
    for base, tip in combinations_with_replacement(KINDS, 2)
    if "guided" not in base and (base, tip) != ("pinned", "free") and base != "free"
}
TOUCHING = {
    "pulled out": pulled_out(0.05, 0.1, -0.03),
    "pulled out, weightless": pulled_out(0.0, 0.0, 0.0),
    "pressed down": pressed_down(),
    **{f"random {index}": Path(random_path(index)) for index in (3, 29, 38)},
}
PATHS = TOUCHING | {name: Path([held], elements=48) for name, held in BETWEEN.items()}
SPAN = Rod(0.4, Section((1.7e-4, 2.7e-4, 2.7e-4)), 3e-3)
