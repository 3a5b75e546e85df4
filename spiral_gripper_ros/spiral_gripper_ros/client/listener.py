# SPDX-License-Identifier: Apache-2.0
"""A node that keeps the newest message of each topic, for programs that watch a gripper."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

# The executor looks so often whether what it waits for has happened [s].
SPIN_PERIOD = 0.05


class Listener(Node):  # type: ignore[misc]
    """A node that is spun within its calls only.

    Args:
        name: of the node.
        namespace: of the topics.
    """

    def __init__(self, name: str, namespace: str) -> None:
        super().__init__(name, namespace=namespace)
        self._newest: dict[str, tuple[float, Any]] = {}
        self._spinner = SingleThreadedExecutor()
        self._spinner.add_node(self)

    def destroy_node(self) -> None:
        """End listening, and destroy the node."""
        self._spinner.shutdown()
        super().destroy_node()

    def keep(self, kind: Any, topic: str, quality: QoSProfile | int) -> None:  # noqa: ANN401
        """Subscribe to a topic and keep its newest message."""

        def note(message: Any) -> None:  # noqa: ANN401
            self._newest[topic] = (time.monotonic(), message)

        self.create_subscription(kind, topic, note, quality)

    def newest(self, topic: str, longest_age: float = math.inf) -> Any:  # noqa: ANN401
        """Return a topic's newest message, or None if there is none as young as that [s]."""
        received_at, message = self._newest.get(topic, (-math.inf, None))
        return message if time.monotonic() - received_at <= longest_age else None

    def received_at(self, topic: str) -> float:
        """Return when a topic's newest message came, by the monotonic clock [s]."""
        return self._newest.get(topic, (-math.inf, None))[0]

    def spin(self, duration: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Handle what arrives until a condition holds; return whether it did in time [s]."""
        end = time.monotonic() + duration
        while not until():
            left = end - time.monotonic()
            if not left > 0.0:
                return False
            self._spinner.spin_once(timeout_sec=min(left, SPIN_PERIOD))
        return True


ListenerT = TypeVar("ListenerT", bound=Listener)


@contextmanager
def listening(make: Callable[[], ListenerT]) -> Iterator[ListenerT]:
    """Yield a listener while ROS runs, which leaves the signals alone."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        listener = make()
        try:
            yield listener
        finally:
            listener.destroy_node()
    finally:
        rclpy.try_shutdown()
