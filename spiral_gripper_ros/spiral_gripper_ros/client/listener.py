# SPDX-License-Identifier: Apache-2.0
"""A connection that keeps the newest message of each topic, for programs that watch a gripper."""

from __future__ import annotations

import math
import time
from typing import Any

from rclpy.qos import QoSProfile

from spiral_gripper_ros.client.answers import no_node_in
from spiral_gripper_ros.client.connection import Connection

# Longest time for an answer [s].
ANSWER_TIMEOUT = 10.0


class Listener(Connection):
    """Keeps the newest message of each topic that it subscribes to.

    Args:
        namespace: of the topics.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__(namespace, ANSWER_TIMEOUT, lambda: no_node_in(namespace))
        self._newest: dict[str, tuple[float, Any]] = {}

    def keep(self, kind: Any, topic: str, quality: QoSProfile | int) -> None:  # noqa: ANN401
        """Subscribe to a topic and keep its newest message."""

        def note(message: Any) -> None:  # noqa: ANN401
            self._newest[topic] = (time.monotonic(), message)

        self.node.create_subscription(kind, topic, note, quality)

    def newest(self, topic: str, longest_age: float = math.inf) -> Any:  # noqa: ANN401
        """Return a topic's newest message, or None if there is none as young as that [s]."""
        received_at, message = self._newest.get(topic, (-math.inf, None))
        return message if time.monotonic() - received_at <= longest_age else None

    def received_at(self, topic: str) -> float:
        """Return when a topic's newest message came, by the monotonic clock [s]."""
        return self._newest.get(topic, (-math.inf, None))[0]

    def spin(self, duration: float) -> None:
        """Handle what arrives for a time [s]."""
        self.spin_until(lambda: False, duration)
