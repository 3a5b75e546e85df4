# SPDX-License-Identifier: Apache-2.0
"""A callback that is repeated while it is wanted."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.clock import Clock
from rclpy.node import Node
from rclpy.timer import Timer

# Slower than once in this time [s] nothing is repeated; a timer cannot wait for any time.
LONGEST_PERIOD = 3600.0


class Repetition:
    """Calls a callback at a rate that may change; at 0 Hz it stops.

    Args:
        node: the ROS node whose timer it is.
        callback: raises nothing.
    """

    def __init__(self, node: Node, callback: Callable[[], None]) -> None:
        self._node, self._callback = node, callback
        self._timer: Timer | None = None

    def start(self, rate: float, clock: Clock) -> None:
        """Repeat at a rate [Hz] from now on, by a clock."""
        self.stop()
        if rate > 0.0:
            period = min(1.0 / rate, LONGEST_PERIOD)
            self._timer = self._node.create_timer(period, self._callback, clock=clock)

    def stop(self) -> None:
        """Call no more."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
        self._timer = None
