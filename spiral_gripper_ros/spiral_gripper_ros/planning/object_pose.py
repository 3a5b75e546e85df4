# SPDX-License-Identifier: Apache-2.0
"""The measured pose of the object: checked, with its age, compared with the pose of the wrap.

No ROS.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.rod.types import Vector
from spiral_core.wrap.placement import ObjectPlacement, distances_from_axis
from spiral_gripper_ros.control.radius_gate import age_problem

# x y z w.
Quaternion: TypeAlias = tuple[float, float, float, float]

# The norm of a quaternion may differ from 1 by this much: single precision, and digits of a file.
NORM_TOLERANCE = 1e-3
# Farther from the base than this [m] no object is within reach of any gripper.
LARGEST_DISTANCE = 1e3


@dataclass(frozen=True, slots=True)
class SeenObject:
    """An object at its place, in the base frame.

    Args:
        center: any point of its axis [m].
        axis: direction of its axis, a unit vector; which of the two does not matter.
        seen_at: when it was there [s].
    """

    center: Vector
    axis: Vector
    seen_at: float


class ObjectWatch:
    """Remembers the newest usable pose of the object.

    Attributes:
        problem: why the newest pose is not used; empty: it is, or none has come.
        refused: poses that were not used.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Forget everything."""
        self._seen: SeenObject | None = None
        self.problem, self.refused = "", 0

    def offer(self, center: Vector, axis: Vector, seen_at: float, age: float, limit: float) -> None:
        """Take where the object is if that is young enough; else the last one stands.

        Args:
            center: a point of its axis [m].
            axis: direction of its axis, a unit vector.
            seen_at: its stamp as a time [s] of the clock that :meth:`seen` is asked with.
            age: time since then [s].
            limit: largest age [s], on either side of now.

        Example:
            >>> watch = ObjectWatch()
            >>> watch.offer((0.1, 0.0, 0.0), (0.0, 0.0, 1.0), seen_at=5.0, age=0.1, limit=1.0)
            >>> watch.seen(5.5, limit=1.0).axis, watch.seen(6.5, limit=1.0)
            ((0.0, 0.0, 1.0), None)
        """
        problem = age_problem("object_pose", age, "object_pose.timeout", limit)
        if problem:
            self.refuse(problem)
        else:
            self.problem, self._seen = "", SeenObject(center, axis, seen_at)

    def refuse(self, problem: str) -> None:
        """Note that a pose is not used, and why."""
        self.problem = problem
        self.refused += 1

    def seen(self, now: float, limit: float) -> SeenObject | None:
        """Return where the object is at a time [s], if that is known since ``limit`` [s]."""
        if self._seen is None or not now - self._seen.seen_at <= limit:
            return None
        return self._seen


def object_line(center: Vector, turn: Quaternion) -> tuple[Vector, Vector]:
    """Return a point of an object's axis [m] and its direction, from the object's pose.

    Args:
        center: position [m].
        turn: orientation, whose z axis is the object's axis.

    Raises:
        InvalidInputError: it is no pose.
    """
    if not math.hypot(*center) <= LARGEST_DISTANCE:  # NaN is not
        requirement = f"3 finite numbers within {LARGEST_DISTANCE:g} m"
        raise InvalidInputError("the position of object_pose", center, requirement)
    return center, rotated(unit_turn(turn), (0.0, 0.0, 1.0))


def unit_turn(turn: Quaternion) -> Quaternion:
    """Return a unit quaternion without the errors of its digits.

    Raises:
        InvalidInputError: it is none.
    """
    size = math.hypot(*turn)
    if not abs(size - 1.0) <= NORM_TOLERANCE:
        raise InvalidInputError("the orientation of object_pose", turn, "a unit quaternion")
    x, y, z, w = (component / size for component in turn)
    return x, y, z, w


def misplacement(seen: SeenObject, expected: ObjectPlacement) -> tuple[float, float]:
    """Return how far an object's axis is from where a wrap expects it.

    Returns:
        The distance [m] of the seen axis, a line, from the middle of what the wrap covers, and
        the angle [rad] between the two axes, at most a right one.

    Example:
        >>> expected = ObjectPlacement((0.1, 0.0, 0.0), (0.0, 0.0, 1.0), 0.02, 0.1, 0.0)
        >>> misplacement(SeenObject((0.1, 0.003, 0.5), (0.0, 0.0, -1.0), 0.0), expected)
        (0.003, 0.0)
    """
    (offset,) = distances_from_axis(np.array([expected.center]), seen.center, seen.axis).tolist()
    across, along = np.cross(seen.axis, expected.axis), np.dot(seen.axis, expected.axis)
    return offset, math.atan2(math.hypot(*across), abs(along))


def rotated(turn: Quaternion, vector: Vector) -> Vector:
    r"""Return a vector, rotated: :math:`v + 2 w (u \times v) + 2 u \times (u \times v)`.

    Args:
        turn: unit quaternion of vector part u and scalar part w.
        vector: v.

    Example:
        >>> rotated((0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)), (1.0, 0.0, 0.0))[1]
        1.0000000000000002
    """
    once = np.cross(turn[:3], vector)
    x, y, z = (vector + 2.0 * (turn[3] * once + np.cross(turn[:3], once))).tolist()
    return x, y, z
