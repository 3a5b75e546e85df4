# SPDX-License-Identifier: Apache-2.0
"""The ears of the smoke test: what node and simulator publish while a grasp goes on."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float64, String

from spiral_gripper_ros.node.qos import LATEST

# Room for all that comes while something else is waited for [messages].
ROOM = 100


class SmokeListener(Node):  # type: ignore[misc]
    """Remembers all commands, and the newest of the rest.

    Args:
        namespace: of node and simulator.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__("spiral_gripper_smoke", namespace=namespace)
        self.commands: list[float] = []
        self._newest: dict[str, Any] = {}
        self.create_subscription(Float64, "pressure_command", self._on_command, ROOM)
        self._note(PoseArray, "backbone", LATEST)
        for kind, topic in (
            (FluidPressure, "measured_pressure"),
            (Float64, "simulated/object_radius"),
            (String, "simulated/grip"),
        ):
            self._note(kind, topic, qos_profile_sensor_data)
        self._spinner = SingleThreadedExecutor()
        self._spinner.add_node(self)

    def close(self) -> None:
        """Destroy the node."""
        self._spinner.shutdown()
        self.destroy_node()

    def hear(self, duration: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Handle what arrives until a condition holds; return whether it did in time [s]."""
        end = time.monotonic() + duration
        while not until():
            left = end - time.monotonic()
            if not left > 0.0:
                return False
            self._spinner.spin_once(timeout_sec=min(left, 0.05))
        return True

    @property
    def measured(self) -> float | None:
        """The newest measured pressure [Pa]."""
        message = self._newest.get("measured_pressure")
        return None if message is None else float(message.fluid_pressure)

    @property
    def radius(self) -> float | None:
        """Radius of the object that is really there [m]."""
        message = self._newest.get("simulated/object_radius")
        return None if message is None or not message.data > 0.0 else float(message.data)

    @property
    def grip(self) -> str:
        """How the simulated gripper holds it."""
        message = self._newest.get("simulated/grip")
        return "" if message is None else str(message.data)

    @property
    def poses(self) -> tuple[tuple[float, float, float], ...]:
        """Positions of the newest backbone [m]."""
        message = self._newest.get("backbone")
        poses = [] if message is None else message.poses
        return tuple((p.position.x, p.position.y, p.position.z) for p in poses)

    def _on_command(self, message: Float64) -> None:
        self.commands.append(message.data)

    def _note(self, kind: Any, topic: str, quality: Any) -> None:  # noqa: ANN401
        self.create_subscription(
            kind, topic, lambda message: self._newest.update({topic: message}), quality
        )
