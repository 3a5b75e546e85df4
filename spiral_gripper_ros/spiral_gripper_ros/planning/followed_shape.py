# SPDX-License-Identifier: Apache-2.0
"""A shape that follows a pressure, solved only when the pressure has changed. No ROS."""

from __future__ import annotations

from spiral_core.errors import SpiralError
from spiral_gripper_ros.planning.planner import AnyPlanner, GripShape


class FollowedShape:
    """The shape at the newest pressure, within the tolerance ``step``.

    Args:
        step: changes of the pressure up to this [Pa] keep the shape, >= 0.
    """

    def __init__(self, step: float) -> None:
        self.shape: GripShape | None = None
        self._step = step
        self._planner: AnyPlanner | None = None
        self._radius: float | None = None
        self._pressure: float | None = None

    def update(self, planner: AnyPlanner, pressure: float | None, radius: float | None) -> bool:
        """Solve the shape at a pressure [Pa] if anything has changed; return whether it has.

        ``shape`` is then the new one, or None if it cannot be certified or no pressure is known.
        """
        if planner is self._planner and radius == self._radius and self._is_close(pressure):
            return False
        self._planner, self._radius, self._pressure = planner, radius, pressure
        try:
            self.shape = None if pressure is None else planner.shape(pressure, radius)
        except SpiralError:
            self.shape = None
        return self.shape is not None

    def _is_close(self, pressure: float | None) -> bool:
        if pressure is None or self._pressure is None:
            return pressure is self._pressure
        return abs(pressure - self._pressure) <= self._step
