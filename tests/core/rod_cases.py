# SPDX-License-Identifier: Apache-2.0
"""Rods that several tests use: the paper's tube, random gripper-sized rods, straight rods."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spiral_core import Rod, RodLoad, Section

INNER_RADIUS = 4.7625e-3
OUTER_RADIUS = INNER_RADIUS + 0.794e-3
AREA = math.pi * (OUTER_RADIUS**2 - INNER_RADIUS**2)
SECOND_MOMENT = math.pi / 4.0 * (OUTER_RADIUS**4 - INNER_RADIUS**4)
DENSITY = 950.0
GRAVITY = 9.80665
WEIGHT = DENSITY * GRAVITY * AREA  # [N/m]


@dataclass(frozen=True)
class Case:
    """A rod and what pulls at it."""

    rod: Rod
    load: RodLoad


def gripper_rod(
    length: float = 0.36,
    modulus: float = 0.78e6,
    curvature: float = 21.0,
    torsion: float = -13.5,
    gravity: tuple[float, float, float] = (1.0, 0.0, 0.0),
    tip_force: tuple[float, float, float] = (0.0, 0.0, 0.0),
    tip_moment: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Case:
    """Return a rod of the paper's tube; ``gravity`` is in units of standard gravity."""
    rod = Rod(
        length,
        Section.inextensible(modulus * SECOND_MOMENT, modulus / 3.0 * 2.0 * SECOND_MOMENT),
        rest_strain=(torsion, 0.0, curvature),
    )
    x, y, z = (WEIGHT * g for g in gravity)
    return Case(rod, RodLoad((x, y, z), tip_force, tip_moment))


def random_direction(rng: np.random.Generator) -> tuple[float, float, float]:
    """Return a unit vector, all directions alike."""
    v = rng.normal(size=3)
    x, y, z = (v / np.linalg.norm(v)).tolist()
    return (x, y, z)


def straight_rod(length: float = 0.5, bending: float = 2.0e-4, torsional: float = 1.3e-4) -> Rod:
    """Return a rod without rest strain."""
    return Rod(length, Section.inextensible(bending, torsional))
