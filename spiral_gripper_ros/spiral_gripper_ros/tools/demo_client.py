# SPDX-License-Identifier: Apache-2.0
"""The demo's own node: publishes radii, listens to what the gripper's node answers."""

from __future__ import annotations

import math
from typing import Any

from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.client.listener import Listener
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.messages.qos import LATEST
from spiral_gripper_ros.simulation.replay import RadiusSample
from spiral_gripper_ros.tools.demo_report import DemoReport

_NOT_REFUSED = (Reason.NONE, Reason.NO_RADIUS, Reason.RELEASED, Reason.NOT_ACTIVE)


class DemoClient(Listener):
    """Publishes radii to the node and records what it publishes.

    Args:
        namespace: of the gripper's node.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__("spiral_gripper_demo", namespace)
        self.report: DemoReport | None = None
        self.status: Any = None
        self.label = ""
        self._sent_radius = math.nan
        self._last_reason = Reason.NONE
        self._radii = self.create_publisher(Float64, "object_radius", qos_profile_sensor_data)
        self._release = self.create_client(Trigger, "release")
        self.create_subscription(Float64, "pressure_command", self._on_pressure, 10)
        self.create_subscription(GripStatus, "status", self._on_status, LATEST)

    @property
    def ready(self) -> bool:
        """Whether the node is active and listens."""
        return self.status is not None and self._radii.get_subscription_count() > 0

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
        return self.spin(timeout, future.done) and bool(future.result().success)

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
