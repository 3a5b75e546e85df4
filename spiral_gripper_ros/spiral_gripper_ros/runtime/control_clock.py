# SPDX-License-Identifier: Apache-2.0
"""The clock of the control loop."""

from __future__ import annotations

import threading

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from spiral_gripper_ros.control.timing import MonotonicClock
from spiral_gripper_ros.process.guards import ErrorLog, log_on_error

STEADY = Clock(clock_type=ClockType.STEADY_TIME)


class ControlClock:
    """A clock that no correction of the wall clock disturbs, or the simulated one.

    Which of them is decided at each activation, by the parameter ``use_sim_time``. While a
    simulated clock stands still no time passes: nothing is ramped, no time-out acts but that of a
    release, no tick or radius sends a command.

    Args:
        node: the ROS node whose clock it is.
        errors: where exceptions in callbacks of the clock are noted.
    """

    def __init__(self, node: Node, errors: ErrorLog) -> None:
        self._node = node
        self._errors = errors
        self.clock = STEADY
        self._steps, self._lock = MonotonicClock(), threading.Lock()
        self._last = 0.0
        self._moved_at = 0.0

    def guard(self) -> None:
        """Let bad samples of /clock (negative ones, say) be logged instead of raised by rclpy."""
        clock = self._node.resolve_topic_name("/clock")
        for subscription in self._node.subscriptions:
            is_guarded = hasattr(subscription.callback, "__wrapped__")
            if subscription.topic_name == clock and not is_guarded:
                subscription.callback = log_on_error(self._errors, subscription.callback)

    def choose(self) -> None:
        """Use the simulated clock if ``use_sim_time`` is set, else the steady one."""
        self.guard()
        simulated = self._node.get_parameter("use_sim_time").value
        self.clock = self._node.get_clock() if simulated else STEADY
        self._steps.change()
        self._last, self._moved_at = self.now(), _seconds(STEADY)

    @property
    def is_simulated(self) -> bool:
        """Whether it is the simulated clock."""
        return self.clock is not STEADY

    def now(self) -> float:
        """Return the time [s], which never runs backwards: a reset simulation lets none pass.

        Threads of the background may ask too.
        """
        with self._lock:
            return self._steps.advance(_seconds(self.clock))

    def standstill(self) -> float:
        """Return for how long this has been found to return the same time [s of real time]."""
        now = self.now()
        if now != self._last:
            self._last, self._moved_at = now, _seconds(STEADY)
        return _seconds(STEADY) - self._moved_at


def _seconds(clock: Clock) -> float:
    return float(clock.now().nanoseconds) * 1e-9
