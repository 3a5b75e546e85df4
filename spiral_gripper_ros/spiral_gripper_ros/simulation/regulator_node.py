# SPDX-License-Identifier: Apache-2.0
"""The simulated regulator as a node, with the topics of a real regulator's driver."""

from __future__ import annotations

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from spiral_gripper_ros.messages.diagnostics import diagnostic_message
from spiral_gripper_ros.messages.qos import MEASUREMENTS, UNLATCHED
from spiral_gripper_ros.parameters.declared import DeclaredParameters
from spiral_gripper_ros.simulation.pacing import RateGate
from spiral_gripper_ros.simulation.regulator import (
    Fault,
    SimulatedRegulator,
    SimulatedRegulatorParameters,
)

REGULATOR_NODE = "simulated_regulator"
DIAGNOSTICS_RATE = 1.0


def injection_service(fault: Fault) -> str:
    """Return the name, below the node's, of the service that injects a fault."""
    return "clear_fault" if fault is Fault.NONE else f"inject_{fault.value}"


class RegulatorNode(Node):  # type: ignore[misc]
    """Hears `pressure_command`, publishes `measured_pressure`; its faults can be injected.

    The caller advances its time with :meth:`step`.

    Args:
        options: passed on to rclpy's node.

    Raises:
        ValueError: a parameter given at start is bad; the message says why.
    """

    def __init__(self, **options: Any) -> None:  # noqa: ANN401
        super().__init__(REGULATOR_NODE, **options)
        self._declared = DeclaredParameters(self, self._apply, SimulatedRegulatorParameters)
        self.values = self._declared.values()
        self.regulator = SimulatedRegulator(self.values)
        self._measuring, self._diagnosing = RateGate(), RateGate()
        self._measured = self.create_publisher(Float64, "measured_pressure", MEASUREMENTS)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(Float64, "pressure_command", self._on_command, UNLATCHED)
        for fault in Fault:
            name = f"~/{injection_service(fault)}"
            self.create_service(Trigger, name, self._injecting(fault))
        self._apply(set())

    def step(self, duration: float, now: float, stamp: Any) -> None:  # noqa: ANN401
        """Let time pass, and report.

        Args:
            duration: how much [s].
            now: time of the simulation afterwards [s].
            stamp: the same for messages.
        """
        self.regulator.step(duration)
        if self._measuring.due(now, self.values.measured_rate):
            pressure = self.regulator.report()
            if pressure is not None:
                self._measured.publish(Float64(data=pressure))
        if self._diagnosing.due(now, DIAGNOSTICS_RATE):
            self._diagnose(stamp)

    def _on_command(self, message: Float64) -> None:
        self.regulator.command(message.data)

    def _apply(self, names: set[str]) -> None:
        """Let parameters take effect at once."""
        del names
        self.values = self._declared.values()
        self.regulator.model = self.values
        fault = Fault(self.values.fault)
        if fault is not self.regulator.fault:
            self.get_logger().info(f"fault: {self.regulator.fault.value} -> {fault.value}")
        self.regulator.fault = fault

    def _injecting(self, fault: Fault) -> Any:  # noqa: ANN401
        def inject(request: Any, response: Any) -> Any:  # noqa: ANN401
            del request
            result = self.set_parameters([Parameter("fault", value=fault.value)])[0]
            response.success = result.successful
            response.message = result.reason or f"fault: {fault.value}"
            return response

        return inject

    def _diagnose(self, stamp: Any) -> None:  # noqa: ANN401
        regulator = self.regulator
        status = DiagnosticStatus.OK, "follows its commands"
        if regulator.watchdog_vented:
            status = DiagnosticStatus.WARN, "no command: vented by its own watchdog"
        if regulator.fault is not Fault.NONE:
            status = DiagnosticStatus.ERROR, f"injected fault: {regulator.fault.value}"
        values = {
            "fault": regulator.fault.value,
            "target [Pa]": regulator.target,
            "pressure [Pa]": regulator.pressure,
            "commands refused": regulator.refused,
        }
        name = f"{self.get_fully_qualified_name()}: regulator"
        self._diagnostics.publish(diagnostic_message(name, "simulated", status, values, stamp))
