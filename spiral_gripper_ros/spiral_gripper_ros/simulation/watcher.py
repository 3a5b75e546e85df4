# SPDX-License-Identifier: Apache-2.0
"""The eyes of ``spiral-gripper simulate``: hears what node and simulator publish."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float64, String

from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.node.conversions import REGIME_NAMES
from spiral_gripper_ros.node.qos import LATEST
from spiral_gripper_ros.simulation.view import View

# What is older than this [s] is no longer shown.
FRESH = 1.0
# What is a state rather than trouble: the state says it already.
_NO_TROUBLE = (Reason.NONE, Reason.NOT_ACTIVE)


class Watcher(Node):  # type: ignore[misc]
    """Remembers the newest of everything.

    Args:
        namespace: of the gripper's node and of the simulator.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__("spiral_gripper_simulation", namespace=namespace)
        self.command: float | None = None
        self._newest: dict[str, tuple[float, Any]] = {}
        self.create_subscription(Float64, "pressure_command", self._on_command, LATEST)
        self.create_subscription(GripStatus, "status", self._noting("status"), LATEST)
        for kind, topic in (
            (FluidPressure, "measured_pressure"),
            (Float64, "simulated/object_radius"),
            (String, "simulated/grip"),
        ):
            self.create_subscription(kind, topic, self._noting(topic), qos_profile_sensor_data)
        self._spinner = SingleThreadedExecutor()
        self._spinner.add_node(self)

    def destroy_node(self) -> None:
        """End listening, and destroy the node."""
        self._spinner.shutdown()
        super().destroy_node()

    @property
    def ready(self) -> bool:
        """Whether the node is active and the simulator runs."""
        status = self._fresh("status")
        active = status is not None and status.state != State.INACTIVE
        return active and self._fresh("simulated/grip") is not None

    def spin(self, duration: float) -> None:
        """Handle what arrives within a time [s]."""
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0.0:
            self._spinner.spin_once(timeout_sec=left)

    def view(self, elapsed: float) -> View:
        """Return what there is to show, a time [s] after the node became active."""
        status = self._fresh("status") or GripStatus()
        measured = self._fresh("measured_pressure")
        troubles = _troubles(status)
        radius, grip = self._fresh("simulated/object_radius"), self._fresh("simulated/grip")
        return View(
            elapsed=elapsed,
            radius=(_in(1e3, radius and radius.data), _in(1e3, status.object_radius)),
            command=None if self.command is None else 1e-3 * self.command,
            measured=None if measured is None else 1e-3 * measured.fluid_pressure,
            regime=REGIME_NAMES[status.measured_regime if status.measured else status.regime],
            wrapped=bool(status.wrapped),
            grip="-" if grip is None else grip.data,
            state=State(status.state).name.lower().replace("_", " "),
            trouble="; ".join(troubles.values()),
            reasons=tuple(troubles),
        )

    def _on_command(self, message: Float64) -> None:
        self.command = message.data

    def _noting(self, topic: str) -> Callable[[Any], None]:
        def note(message: Any) -> None:  # noqa: ANN401
            self._newest[topic] = (time.monotonic(), message)

        return note

    def _fresh(self, topic: str) -> Any:  # noqa: ANN401
        """Return the newest message of a topic, or None if there is none or it is old."""
        at, message = self._newest.get(topic, (0.0, None))
        return message if time.monotonic() - at <= FRESH else None


def _in(factor: float, value: float | None) -> float | None:
    """Return a value in other units; what is 0 or None is not known."""
    return factor * value if value else None


def _troubles(status: GripStatus) -> dict[int, str]:
    """Return the reasons for what is wrong, each with its text for people."""
    troubles = {}
    if status.pressure_fault != Reason.NONE:
        troubles[status.pressure_fault] = status.pressure_fault_text
    if status.reason not in (*_NO_TROUBLE, status.pressure_fault):
        troubles[status.reason] = status.reason_text
    return troubles
