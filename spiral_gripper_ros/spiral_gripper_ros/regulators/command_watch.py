# SPDX-License-Identifier: Apache-2.0
"""The set-point of a device: the newest valid command while commands come, else 0."""

from __future__ import annotations

import math

from spiral_core.validation import require_positive


class CommandWatch:
    """The watchdog of an adapter: silence vents, until 0 Pa has been commanded.

    A node that was held up goes on with the command that it had: following it would inflate an
    empty gripper in one step, past the node's ramp. So would the first command after a start, or
    after the device was lost or has vented by itself: these wait for 0 Pa too.

    A command that is not a finite gauge pressure from 0 to ``pressure_limit`` is counted and
    ignored: the last valid one stands, and the watchdog's time goes on.

    Args:
        pressure_limit: largest gauge pressure that is passed on [Pa], > 0.
        timeout: silence after which the demand is 0 [s], > 0.

    Attributes:
        refused: number of refused commands.
        problem: why the last command was refused; empty after an accepted one.
        is_latched: whether it waits for a command of 0 Pa; set it where the device was lost or
            has vented.

    Example:
        >>> watch = CommandWatch(pressure_limit=1e5, timeout=0.5)
        >>> watch.demand(0.0)
        0.0
        >>> watch.offer(0.0, 0.0), watch.offer(0.1, 4e4), watch.demand(0.5), watch.demand(0.7)
        (True, True, 40000.0, 0.0)
        >>> watch.offer(0.8, 4e4), watch.demand(0.8), watch.offer(0.9, 0.0), watch.is_latched
        (False, 0.0, True, False)
    """

    def __init__(self, pressure_limit: float, timeout: float) -> None:
        self._limit = require_positive("pressure_limit", pressure_limit)
        self._timeout = require_positive("watchdog_timeout", timeout)
        self._command = 0.0
        self._heard: float | None = None
        self.is_latched = True
        self.refused = 0
        self.problem = ""

    @property
    def is_waiting(self) -> bool:
        """Whether no command has come yet."""
        return self._heard is None

    def offer(self, now: float, pressure: float) -> bool:
        """Hear a command [Pa] at a time [s]; return whether it is taken."""
        if not (math.isfinite(pressure) and 0.0 <= pressure <= self._limit):
            self.refused += 1
            self.problem = (
                f"pressure_command must be from 0 to {self._limit:g} Pa (pressure_limit), "
                f"got {pressure:.6g} Pa"
            )
            return False
        if self.is_silent(now):
            self.is_latched = True
        if pressure == 0.0:
            self.is_latched = False
        self._command, self._heard, self.problem = pressure, now, ""
        if self.is_latched:
            self.problem = (
                "vented after a start, a lost link or a silence, or by the device: waiting for a "
                "pressure_command of 0 Pa (release)"
            )
        return not self.is_latched

    def is_silent(self, now: float) -> bool:
        """Return whether commands have stopped."""
        return self._heard is not None and not now - self._heard < self._timeout

    def demand(self, now: float) -> float:
        """Return the gauge pressure [Pa] for the device at a time [s]."""
        stopped = self._heard is None or self.is_latched or self.is_silent(now)
        return 0.0 if stopped else self._command
