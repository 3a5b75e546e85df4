# SPDX-License-Identifier: Apache-2.0
"""The demo's own node: publishes radii, listens to what the gripper's node answers."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.demo.report import DemoReport
from spiral_gripper_ros.node.qos import LATEST
from spiral_gripper_ros.simulation.replay import RadiusSample

_NOT_REFUSED = (Reason.NONE, Reason.NO_RADIUS, Reason.RELEASED, Reason.NOT_ACTIVE)


class DemoClient(Node):  # type: ignore[misc]
    """Speaks to the node as any user's node would.

    Args:
        namespace: of the gripper's node.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__("spiral_gripper_demo", namespace=namespace)
        self.report: DemoReport | None = None
        self.status: Any = None
        self.label = ""
        self._sent_radius = math.nan
        self._last_reason = Reason.NONE
        self._radii = self.create_publisher(Float64, "object_radius", qos_profile_sensor_data)
        self._release = self.create_client(Trigger, "release")
        self.create_subscription(Float64, "pressure_command", self._on_pressure, 10)
        self.create_subscription(GripStatus, "status", self._on_status, LATEST)
        self._spinner = SingleThreadedExecutor()
        self._spinner.add_node(self)

    @property
    def ready(self) -> bool:
        """Whether the node is active and listens."""
        return self.status is not None and self._radii.get_subscription_count() > 0

    def spin(self, duration: float) -> None:
        """Handle what arrives within ``duration`` [s]."""
        self._spinner.spin_once(timeout_sec=duration)

    def spin_until(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Handle what arrives until a condition holds; return whether it did before ``timeout``."""
        deadline = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > deadline:
                return False
            self.spin(0.05)
        return True

    def send(self, sample: RadiusSample) -> None:
        """Publish one estimate."""
        self.label = sample.label
        self._sent_radius = sample.radius
        self._radii.publish(Float64(data=sample.radius))
        if self.report is not None:
            self.report.sent += 1

    def release(self, timeout: float) -> bool:
        """Call `release`; return whether it succeeded within ``timeout`` [s]."""
        if not self._release.wait_for_service(timeout):
            return False
        future = self._release.call_async(Trigger.Request())
        return self.spin_until(future.done, timeout) and bool(future.result().success)

    def _on_pressure(self, message: Float64) -> None:
        if self.report is not None:
            self.report.pressures.append(message.data)

    def _on_status(self, status: GripStatus) -> None:
        self.status = status
        if self.report is None:
            return
        if status.object_radius == self._sent_radius:
            self.report.solve_times.append(status.solve_time)
            self._sent_radius = math.nan
        reason = Reason(status.reason)
        if reason is not self._last_reason and reason not in _NOT_REFUSED:
            self.report.refused[reason] += 1
        self._last_reason = reason
        at_target = status.pressure_command == status.pressure_target
        if at_target and status.valid and status.regime == GripStatus.REGIME_PERFECT_WRAP:
            self.report.wrap(status.object_radius, status.pressure_command)
