# SPDX-License-Identifier: Apache-2.0
"""Poses and gravity from other frames of the robot, where tf2_ros is installed."""

from __future__ import annotations

import importlib
from typing import Any

from builtin_interfaces.msg import Time as Stamp
from rclpy.node import Node
from rclpy.time import Time

from spiral_core.errors import InvalidInputError, SpiralError
from spiral_core.rod.types import Vector
from spiral_gripper_ros.messages.conversions import quaternion_from_msg, vector_from_msg
from spiral_gripper_ros.planning.object_pose import Quaternion, object_line, rotated, unit_turn


class TransformError(SpiralError):
    """No usable transform between two frames is known."""


class Transforms:
    """Transforms into the base frame. It listens to ``/tf`` from its first use on.

    Args:
        node: the ROS node that subscribes.
        base: the base frame.
    """

    def __init__(self, node: Node, base: str) -> None:
        self._node, self._base = node, base
        self._tf2: Any = None
        self._buffer: Any = None
        self._listener: Any = None

    def listen(self) -> None:
        """Listen to ``/tf`` and ``/tf_static`` from now on.

        Raises:
            TransformError: tf2_ros cannot be used.
        """
        if self._listener is not None:
            return
        try:
            self._tf2 = importlib.import_module("tf2_ros")
        except Exception as error:  # not installed, or built for another Python
            raise TransformError(
                f"other frames need tf2_ros, which cannot be used: {error}"
            ) from None
        self._buffer = self._tf2.Buffer()
        self._listener = self._tf2.TransformListener(self._buffer, self._node)

    def destroy(self) -> None:
        """End the subscriptions."""
        if self._listener is not None:
            self._listener.unregister()
        self._listener = None

    def line(
        self,
        frame: str,
        stamp: Any,  # noqa: ANN401
        center: Vector,
        axis: Vector,
    ) -> tuple[Vector, Vector]:
        """Return a line of another frame in the base frame.

        Args:
            frame: in which the line is given.
            stamp: time at which it is there.
            center: a point of it [m].
            axis: its direction.

        Raises:
            TransformError: the transform at that time is not known, or no rigid motion.
            InvalidInputError: the point is beyond the reach of any gripper.
        """
        (x, y, z), turn, _ = self._look_up(frame, stamp)
        a, b, c = rotated(turn, center)
        place, _ = object_line((x + a, y + b, z + c), turn)
        return place, rotated(turn, axis)

    def down(self, frame: str) -> tuple[Vector, Any]:
        """Return the direction opposite to the z axis of a frame, in the base frame, and its time.

        Args:
            frame: whose z axis points up.

        Raises:
            TransformError: no transform is known, or it is no rigid motion.
        """
        _, turn, stamp = self._look_up(frame, Stamp())
        return rotated(turn, (0.0, 0.0, -1.0)), stamp

    def _look_up(self, frame: str, stamp: Any) -> tuple[Vector, Quaternion, Any]:  # noqa: ANN401
        """Return the shift [m] and the turn of a frame, a unit quaternion, and their time.

        The shift may be any: the frame of a map is far away.
        """
        self.listen()
        between = f"transform from {frame!r} to {self._base!r} is"
        try:
            found = self._buffer.lookup_transform(self._base, frame, Time.from_msg(stamp))
        except (self._tf2.TransformException, ValueError) as error:  # a stamp may be negative
            raise TransformError(f"no {between} known: {error}") from None
        place, turn = found.transform.translation, found.transform.rotation
        try:
            quaternion = unit_turn(quaternion_from_msg(turn))
        except InvalidInputError:
            raise TransformError(f"the {between} no rigid motion, got {place}, {turn}") from None
        return vector_from_msg(place), quaternion, found.header.stamp
