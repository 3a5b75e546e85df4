# SPDX-License-Identifier: Apache-2.0
"""A rigid obstacle: a shape at a place, with its coefficient of friction."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeAlias

from spiral_core.errors import InvalidInputError
from spiral_core.rod.contact.shapes import Shape
from spiral_core.rod.types import Vector
from spiral_core.validation import require_finite, require_unit_vector, require_vector

Quaternion: TypeAlias = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A rigid shape somewhere in space that a rod touches and slides on.

    Args:
        shape: in its own frame.
        position: of the shape's origin in the base frame [m].
        orientation: unit quaternion, scalar last, shape's frame to base frame.
        friction: Coulomb's coefficient between rod and obstacle, >= 0.
    """

    shape: Shape
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)
    friction: float = 0.0

    def __post_init__(self) -> None:
        require_vector("position", self.position, 3)
        require_unit_vector("orientation", self.orientation, 4)
        if not require_finite("friction", self.friction) >= 0.0:
            raise InvalidInputError("friction", self.friction, "a finite number >= 0")

    @classmethod
    def along(cls, shape: Shape, point: Vector, axis: Vector, friction: float = 0.0) -> Obstacle:
        """Return the shape with its z axis along ``axis`` (any length) through ``point``."""
        x, y, z = require_vector("axis", axis, 3)
        norm = math.hypot(x, y, z)
        if not norm > 0.0:
            raise InvalidInputError("axis", axis, "three numbers that are not all zero")
        x, y, z = x / norm, y / norm, z / norm
        # Half the turn from e_z to the axis; the opposite of e_z is reached about e_x.
        w = math.sqrt(max(0.0, 0.5 * (1.0 + z)))
        orientation = (-0.5 * y / w, 0.5 * x / w, 0.0, w) if w > 1e-8 else (1.0, 0.0, 0.0, 0.0)
        size = math.sqrt(sum(c * c for c in orientation))
        a, b, c, d = (v / size for v in orientation)
        return cls(shape, point, (a, b, c, d), friction)

    def moved(
        self, translation: Vector = (0.0, 0.0, 0.0), rotation: Vector = (0.0, 0.0, 0.0)
    ) -> Obstacle:
        """Return the obstacle moved [m], and turned about its position by a vector [rad]."""
        shift = require_vector("translation", translation, 3)
        turn = require_vector("rotation", rotation, 3)
        angle = math.hypot(*turn)
        half = 0.5 * angle
        s = math.sin(half) / angle if angle > 0.0 else 0.5
        a = (s * turn[0], s * turn[1], s * turn[2], math.cos(half))
        b = self.orientation
        product = (
            a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
            a[3] * b[1] + a[1] * b[3] + a[2] * b[0] - a[0] * b[2],
            a[3] * b[2] + a[2] * b[3] + a[0] * b[1] - a[1] * b[0],
            a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
        )
        x, y, z = (p + d for p, d in zip(self.position, shift, strict=True))
        return replace(self, position=(x, y, z), orientation=product)
