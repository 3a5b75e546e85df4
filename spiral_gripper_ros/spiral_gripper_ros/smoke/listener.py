# SPDX-License-Identifier: Apache-2.0
"""The subscriptions of the smoke test to node and simulator."""

from __future__ import annotations

from geometry_msgs.msg import PoseArray
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float64, String

from spiral_gripper_ros.client.listener import Listener
from spiral_gripper_ros.messages.qos import LATEST

# Room for all that comes while something else is waited for [messages].
ROOM = 100


class SmokeListener(Listener):
    """Keeps all commands, and the newest message of the other topics.

    Args:
        namespace: of node and simulator.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__("spiral_gripper_smoke", namespace)
        self.commands: list[float] = []
        self.create_subscription(Float64, "pressure_command", self._on_command, ROOM)
        self.keep(PoseArray, "backbone", LATEST)
        self.keep(FluidPressure, "measured_pressure", qos_profile_sensor_data)
        self.keep(Float64, "simulated/object_radius", qos_profile_sensor_data)
        self.keep(String, "simulated/grip", qos_profile_sensor_data)

    @property
    def measured(self) -> float | None:
        """The newest measured pressure [Pa]."""
        message = self.newest("measured_pressure")
        return None if message is None else float(message.fluid_pressure)

    @property
    def radius(self) -> float | None:
        """Radius of the object that is really there [m]."""
        message = self.newest("simulated/object_radius")
        return None if message is None or not message.data > 0.0 else float(message.data)

    @property
    def grip(self) -> str:
        """How the simulated gripper holds it."""
        message = self.newest("simulated/grip")
        return "" if message is None else str(message.data)

    @property
    def poses(self) -> tuple[tuple[float, float, float], ...]:
        """Positions of the newest backbone [m]."""
        message = self.newest("backbone")
        poses = [] if message is None else message.poses
        return tuple((p.position.x, p.position.y, p.position.z) for p in poses)

    def _on_command(self, message: Float64) -> None:
        self.commands.append(message.data)
