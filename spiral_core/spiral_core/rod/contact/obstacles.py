# SPDX-License-Identifier: Apache-2.0
"""A rigid obstacle: a shape at a place, with its coefficient of friction."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.rod._algebra import composed, matrices, quaternions_between
from spiral_core.rod.contact.shapes import Array, Range, Shape
from spiral_core.rod.types import Vector
from spiral_core.validation import (
    keep_unit_vector,
    keep_vector,
    require_finite,
    require_vector,
)

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
        shape = self.shape
        sized = not isinstance(shape, type) and getattr(shape, "feature_radius", 0.0) > 0.0
        if not (sized and hasattr(shape, "distance")):
            raise InvalidInputError("shape", shape, "a shape, such as Cylinder(radius)")
        keep_vector(self, "position", 3)
        keep_unit_vector(self, "orientation", 4)
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
        turn = np.array(require_vector("rotation", rotation, 3))
        angle = math.hypot(*turn)
        axis = 0.5 * np.sinc(angle / math.tau) * turn
        turned = np.array([(*axis, math.cos(0.5 * angle))])
        orientation = composed(turned, np.array([self.orientation]))[0].tolist()
        position = np.add(self.position, shift).tolist()
        return replace(self, position=(*position,), orientation=(*orientation,))


@lru_cache(maxsize=32)
def frame_of(orientation: Quaternion) -> Array:
    """Return the rotation matrix (3, 3) from the frame of an obstacle to the base frame."""
    frame: Array = matrices(np.array([orientation]))[0]
    frame.setflags(write=False)  # it is everybody's
    return frame


def seen_from(obstacle: Obstacle, points: Array) -> Array:
    """Return points (n, 3) [m] in the obstacle's frame."""
    local: Array = (points - np.asarray(obstacle.position)) @ frame_of(obstacle.orientation)
    return local


def in_base_frame(obstacle: Obstacle, local: Array) -> Array:
    """Return points (n, 3) [m] of the obstacle's frame in the base frame."""
    points: Array = local @ frame_of(obstacle.orientation).T + np.asarray(obstacle.position)
    return points


def obstacle_between(first: Obstacle, last: Obstacle, at: float) -> Obstacle:
    """Return an obstacle between two poses."""
    if first == last:
        return last
    position = (1.0 - at) * np.array(first.position) + at * np.array(last.position)
    turn = quaternions_between(np.array([first.orientation]), np.array([last.orientation]), at)[0]
    friction = (1.0 - at) * first.friction + at * last.friction
    return replace(
        last, position=(*position.tolist(),), orientation=(*turn.tolist(),), friction=friction
    )


def turns_about(obstacle: Obstacle, points: Array) -> float:
    """Return the turns of a curve (n, 3) [m] about an obstacle's z axis, counterclockwise positive.

    What lies beyond the axis' ends, as above a cone's apex, does not count; NaN for shapes without
    such an axis.
    """
    axis = _axis_range(obstacle)
    if axis is None:
        return math.nan
    local = seen_from(obstacle, points)
    first, last = local[:-1], local[1:]
    rise = last[:, 2] - first[:, 2]
    ends = []
    for z, along in ((first[:, 2], rise), (last[:, 2], -rise)):
        beyond = np.clip(z, *axis) - z
        with np.errstate(divide="ignore", invalid="ignore"):
            ends.append(np.where(beyond == 0.0, 0.0, np.clip(beyond / along, 0.0, 1.0)))
    beside = 1.0 - ends[0] - ends[1] > 0.0
    legs = last - first
    swept = _swept(first + ends[0][:, None] * legs, last - ends[1][:, None] * legs)
    return float(np.sum(swept[beside])) / math.tau


def passes_through(obstacle: Obstacle, start: Array, end: Array) -> bool:
    """Return whether an element passed an obstacle's axis while its nodes (n, 3) moved.

    ``start`` and ``end`` are seen from the obstacle. The angle between an
    element's ends changes by what they turn about the axis, each by less than half a turn; if it
    has passed, by a turn more or less.
    """
    axis = _axis_range(obstacle)
    if axis is None:
        return False
    moved = _swept(start, end)
    change = _swept(end[:-1], end[1:]) - _swept(start[:-1], start[1:]) - np.diff(moved)
    inside = np.all([(axis[0] <= z) & (z <= axis[1]) for z in (start[:, 2], end[:, 2])], axis=0)
    return bool(np.any((np.abs(change) > math.pi) & inside[:-1] & inside[1:]))


def _axis_range(obstacle: Obstacle) -> Range | None:
    """Return the heights between which an obstacle's z axis lies in its solid, if any."""
    axis: Range | None = getattr(obstacle.shape, "axis_range", None)
    return axis


def _swept(first: Array, last: Array) -> Array:
    """Return the angles (n,) about z by which points (n, 3) turn, each by less than half a turn."""
    x = first[:, 0] * last[:, 0] + first[:, 1] * last[:, 1]
    y = first[:, 0] * last[:, 1] - first[:, 1] * last[:, 0]
    angles: Array = np.arctan2(y, x)
    return angles
