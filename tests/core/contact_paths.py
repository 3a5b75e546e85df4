# SPDX-License-Identifier: Apache-2.0
"""Paths of rods that are held, touch, stick and slide, which the invariants of contact run over."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

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

    stations: list
    elements: int = 60

    def followed(self):
        """Return the states; nothing snaps."""
        found = follow_contact(self.stations, elements=self.elements)
        assert not found.events
        return found.states


HELD = Rod(0.4, SIX, 3e-3, rest_strain=(3.0, -1.0, 4.0))
HEAVY = RodLoad((0.05, 0.02, -0.4))
LINE = (0.6, 0.0, 0.8)
PLACE, TURN = (0.33, 0.02, 0.01), (0.0, 0.0, math.sin(0.15), math.cos(0.15))
TIPS = {
    "clamped": Clamped(PLACE, TURN),
    "pinned": Pinned(PLACE),
    "guided": Guided(PLACE, LINE),
    "guided, not turning": Guided(PLACE, LINE, TURN),
    "free": Free(),
}


def held(base, tip, load=HEAVY):
    """Return a rod that hangs between two ends of these kinds."""
    return RodProblem(HELD, load, Pinned() if base == "pinned" else Clamped(), TIPS[tip])


# The other orders are these read backwards. Nothing is left to fall or to spin.
BETWEEN = {
    f"{base} to {tip}": held(base, tip)
    for base, tip in product(("clamped", "pinned"), TIPS)
    if (base, tip) != ("pinned", "free")
}
PATHS = {
    # A coil closes without friction, so that the way's increments decide nothing; then its
    # cylinder is pulled out of it.
    "pulled out, weightless": Path(
        [grip(0.015, 1.1, *to) for to in ((0.0, 0.0), (0.3, 0.0), (0.3, -1e-3), (0.3, -3e-3))]
    ),
    # Onto a bar, a ball and the floor, and pushed aside at its tip.
    "pressed down": Path(
        [
            RodProblem(
                Rod(0.5, Section((2e-4, 3e-4, 5e-4)), 3e-3, rest_strain=(1.0, 0.5, 2.0)),
                RodLoad((0, 0, 0), (0, aside, -0.02), (1e-4, 0, 0)),
                obstacles=(
                    bar(0.03, 0.2, -0.05, 0.3),
                    Obstacle(Sphere(0.02), (0.4, -0.012, -0.072), friction=0.2),
                    floor(-0.06, 0.4),
                ),
                point_loads=tuple(
                    PointLoad(at, (0, 0, -0.06), (0, 1e-4, 2e-4)) for at in (0.1, 0.25, 0.35, 0.45)
                ),
            )
            for aside in (0, 4e-3, 4.2e-3)
        ],
        elements=50,
    ),
    **{f"random {index}": Path(random_path(index)) for index in (3, 29, 38)},
    **{name: Path([held], elements=48) for name, held in BETWEEN.items()},
}
SPAN = Rod(0.4, Section((1.7e-4, 2.7e-4, 2.7e-4)), 3e-3)
