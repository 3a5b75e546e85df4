# SPDX-License-Identifier: Apache-2.0
"""The rods that are measured: this project's usual one, and random ones of a gripper's size."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from spiral_core import Rod, RodLoad, Section

INNER_RADIUS = 4.7625e-3
OUTER_RADIUS = INNER_RADIUS + 0.794e-3
DENSITY = 950.0
AREA = math.pi * (OUTER_RADIUS**2 - INNER_RADIUS**2)
SECOND_MOMENT = math.pi / 4.0 * (OUTER_RADIUS**4 - INNER_RADIUS**4)
WEIGHT = DENSITY * 9.80665 * AREA  # [N/m]
# A warm solve follows a change of the rest strain by this fraction.
WARM_CHANGE = 0.01
SEED = 2018
Array: TypeAlias = NDArray[np.float64]
Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Case:
    """A uniform rod and what pulls at it; ``rod`` and ``load`` are made of the rest."""

    length: float
    bending: float
    torsional: float
    rest_strain: Vector
    distributed: Vector
    tip_force: Vector = (0.0, 0.0, 0.0)
    rod: Rod = field(init=False)
    load: RodLoad = field(init=False)

    def __post_init__(self) -> None:
        rod = Rod(
            self.length,
            Section.inextensible(self.bending, self.torsional),
            rest_strain=self.rest_strain,
        )
        object.__setattr__(self, "rod", rod)
        object.__setattr__(self, "load", RodLoad(self.distributed, self.tip_force))

    @property
    def stiffness(self) -> Array:
        """Diagonal (3,) of K [N m^2]."""
        return np.array([self.torsional, self.bending, self.bending])

    def scaled(self, fraction: float) -> Case:
        """Return the same rod with its rest strain scaled."""
        a, b, c = self.rest_strain
        return replace(self, rest_strain=(fraction * a, fraction * b, fraction * c))


def tube_case(
    length: float,
    modulus: float,
    rest_strain: Vector,
    gravity: Vector,
    tip_force: Vector = (0.0, 0.0, 0.0),
) -> Case:
    """Return a rod of the paper's tube; ``gravity`` is a direction."""
    bending = modulus * SECOND_MOMENT
    x, y, z = (WEIGHT * g for g in gravity)
    return Case(length, bending, 2.0 / 3.0 * bending, rest_strain, (x, y, z), tip_force)


def usual_case(fraction: float = 1.0) -> Case:
    """Return the usual rod, hanging; its rest strain is scaled by ``fraction``."""
    return tube_case(0.36, 0.78e6, (-13.5, 0.0, 21.0), (1.0, 0.0, 0.0)).scaled(fraction)


def random_case(index: int) -> Case:
    """Return one rod of the random sample; the same index gives the same rod."""
    rng = np.random.default_rng([SEED, index])
    length, modulus = rng.uniform(0.1, 1.0), rng.uniform(0.5e6, 3.0e6)
    curvature = rng.uniform(3.0, 60.0)
    torsion = rng.uniform(-0.95, 0.95) * curvature
    gravity = random_direction(rng)
    force = rng.uniform() * WEIGHT * length
    fx, fy, fz = (force * d for d in random_direction(rng))
    return tube_case(length, modulus, (torsion, 0.0, curvature), gravity, (fx, fy, fz))


def random_direction(rng: np.random.Generator) -> Vector:
    """Return a unit vector, all directions alike."""
    vector = rng.normal(size=3)
    x, y, z = (vector / np.linalg.norm(vector)).tolist()
    return (x, y, z)
