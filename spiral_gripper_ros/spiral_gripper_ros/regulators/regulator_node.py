# SPDX-License-Identifier: Apache-2.0
"""The adapter as a node: ``pressure_command`` in, ``measured_pressure`` out."""

from __future__ import annotations

import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Float64

from spiral_gripper_ros.messages.diagnostics import diagnostic_message
from spiral_gripper_ros.messages.qos import MEASUREMENTS, UNLATCHED
from spiral_gripper_ros.parameters.declared import DeclaredParameters
from spiral_gripper_ros.process.guards import ErrorLog, guard_services
from spiral_gripper_ros.regulators.adapter import Link, RegulatorAdapter
from spiral_gripper_ros.regulators.device import PressureDevice
from spiral_gripper_ros.regulators.modbus_device import ModbusDevice
from spiral_gripper_ros.regulators.parameters import (
    MODBUS,
    SERIAL,
    RegulatorParameters,
    require_measured,
    require_timely,
)
from spiral_gripper_ros.regulators.serial_device import SerialDevice
from spiral_gripper_ros.regulators.topic_device import TopicDevice

REGULATOR_NODE = "regulator"
DIAGNOSTICS_PERIOD = 1.0
# Texts of one level are logged no more often than this [s]: a figure in them may change always.
LOG_PERIOD = 5.0


class RegulatorNode(Node):  # type: ignore[misc]
    """Passes ``pressure_command`` on to a regulator; time is the machine's, never simulated.

    Args:
        options: passed on to rclpy's node.

    Raises:
        ValueError: a parameter given at start is bad; the message says why.
    """

    def __init__(self, **options: Any) -> None:  # noqa: ANN401
        super().__init__(REGULATOR_NODE, **options)
        self.errors = ErrorLog(self.get_logger())
        guard_services(self, self.errors)
        declared = DeclaredParameters(self, lambda names: None, RegulatorParameters)
        self.values = declared.values()
        require_timely(self.values)
        require_measured(self.values)
        self.adapter = RegulatorAdapter(self.values, self._device())
        self._told, self._told_at = (b"", ""), 0.0
        self._measured = self.create_publisher(Float64, "measured_pressure", MEASUREMENTS)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(Float64, "pressure_command", self._on_command, UNLATCHED)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / self.values.rate, self._exchange, clock=steady)
        self.create_timer(DIAGNOSTICS_PERIOD, self._diagnose, clock=steady)

    def _device(self) -> PressureDevice:
        if self.values.device == SERIAL:
            return SerialDevice(self.values)
        if self.values.device == MODBUS:
            return ModbusDevice(self.values)
        return TopicDevice(self, self.values)

    def _on_command(self, message: Float64) -> None:
        watch, now = self.adapter.watch, time.monotonic()
        holds = watch.demand(now) > 0.0
        if watch.offer(now, message.data) and holds and message.data == 0.0:
            self._exchange()  # a vent does not wait for the next tick

    def _exchange(self) -> None:
        pressure = self.adapter.step(time.monotonic())
        if pressure is not None:
            self._measured.publish(Float64(data=pressure))
        self._tell()

    def _tell(self) -> None:
        """Log what has changed."""
        level, text = self._state()
        now, has_changed = time.monotonic(), level != self._told[0]
        if (level, text) == self._told or not (has_changed or now - self._told_at > LOG_PERIOD):
            return
        self._told, self._told_at = (level, text), now
        logger = self.get_logger()
        if level == DiagnosticStatus.OK:
            logger.info(text)
        elif level == DiagnosticStatus.WARN:
            logger.warning(text)
        else:
            logger.error(text)

    def _state(self) -> tuple[bytes, str]:
        adapter = self.adapter
        if adapter.link is Link.LOST:
            return DiagnosticStatus.ERROR, f"{adapter.link.value}: {adapter.problem}"
        if adapter.problem:
            return DiagnosticStatus.ERROR, adapter.problem
        if adapter.link is Link.WAITING:
            return DiagnosticStatus.WARN, adapter.link.value
        if adapter.watch.problem:
            return DiagnosticStatus.WARN, adapter.watch.problem
        if adapter.watch.is_waiting:
            return DiagnosticStatus.OK, "connected, vented: waiting for the first pressure_command"
        if adapter.watch.is_silent(time.monotonic()):
            return DiagnosticStatus.WARN, "no pressure_command: vented"
        return DiagnosticStatus.OK, "passes commands on"

    def _diagnose(self) -> None:
        adapter = self.adapter
        values = {
            "link": adapter.link.value,
            "demand [Pa]": adapter.watch.demand(time.monotonic()),
            "commands refused": adapter.watch.refused,
            "link errors": adapter.link_errors,
            "readings refused": adapter.invalid_readings,
        }
        name, stamp = self.get_fully_qualified_name(), self.get_clock().now().to_msg()
        self._diagnostics.publish(
            diagnostic_message(f"{name}: adapter", self.values.device, self._state(), values, stamp)
        )
