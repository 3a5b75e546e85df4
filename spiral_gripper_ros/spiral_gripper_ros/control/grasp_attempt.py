# SPDX-License-Identifier: Apache-2.0
"""One accepted grasp, from its goal to its end: is the wrap reached, or is it too late?"""

from __future__ import annotations

from spiral_gripper_ros.control.grasp import AbortPolicy, GraspGoal
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.pressure_monitor import PERSISTENCE


class GraspAttempt:
    """Watches the command and the measured pressure on their way to the target.

    Args:
        goal: what was asked for.
        now: time of its acceptance [s].
        command: the command then [Pa].
        limits: what counts where the goal does not say.
    """

    def __init__(self, goal: GraspGoal, now: float, command: float, limits: Limits) -> None:
        self.timeout = limits.grasp_timeout if goal.timeout is None else goal.timeout
        self.abort_policy: AbortPolicy = goal.abort_policy or limits.grasp_abort_policy
        self.started = now
        self._start_command = command
        self._arrived: float | None = None  # since when the command is at its target
        self._near: tuple[float, float] | None = None  # first and last measurement that was there

    def commanded(self, now: float, command: float, target: float) -> None:
        """Note a command and where it is heading [Pa]."""
        if command != target:
            self._arrived = self._near = None
        elif self._arrived is None:
            self._arrived = now

    def measured(self, now: float, pressure: float, target: float, limits: Limits) -> None:
        """Note a measured pressure, smoothed, and where it should get [Pa]."""
        if abs(pressure - target) <= limits.pressure_tolerance:
            self._near = (now if self._near is None else self._near[0], now)
        else:
            self._near = None

    def is_settled(self, now: float, is_measured: bool, limits: Limits) -> bool:
        """Return whether the pressure is at its target to stay, as measured or as commanded."""
        if self._arrived is None:
            return False
        if is_measured:
            return self._near is not None and self._near[1] - self._near[0] >= PERSISTENCE
        return now - self._arrived >= limits.pressure_settle_time

    def is_late(self, now: float) -> bool:
        """Return whether its time is up."""
        return self.elapsed(now) > self.timeout

    def elapsed(self, now: float) -> float:
        """Return the time since its acceptance [s]."""
        return now - self.started

    def progress(self, command: float, target: float) -> float:
        """Return the command's part of the way to its target, 0 to 1."""
        way = target - self._start_command
        if way == 0.0:
            return 1.0 if command == target else 0.0
        return min(max((command - self._start_command) / way, 0.0), 1.0)
