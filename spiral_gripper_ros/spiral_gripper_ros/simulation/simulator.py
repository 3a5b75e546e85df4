# SPDX-License-Identifier: Apache-2.0
"""The simulator: its two nodes, the time that passes for them, and what is true.

The one has the topics of a real regulator's driver, the other those of a camera's.
"""

from __future__ import annotations

import math
import time
from contextlib import suppress
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseArray
from rclpy.clock import Clock as RclpyClock
from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64, Header, String
from std_srvs.srv import Trigger

from spiral_core.rod.state import RodState
from spiral_gripper import load_description
from spiral_gripper.files.grips import read_grips
from spiral_gripper.files.storage import FileError
from spiral_gripper_ros.messages.conversions import backbone_to_msg
from spiral_gripper_ros.messages.diagnostics import diagnostic_message
from spiral_gripper_ros.messages.qos import MEASUREMENTS, UNLATCHED
from spiral_gripper_ros.parameters.declared import DeclaredParameters
from spiral_gripper_ros.process.guards import ErrorLog, guard_services
from spiral_gripper_ros.simulation.pacing import STEP, Pacing, RateGate
from spiral_gripper_ros.simulation.radius_estimator import RadiusEstimator, RadiusParameters
from spiral_gripper_ros.simulation.regulator import (
    REGULATOR_NODE,
    Fault,
    SimulatedRegulator,
    SimulatedRegulatorParameters,
    injection_service,
)
from spiral_gripper_ros.simulation.simulated_gripper import Grip, SimulatedGripper

# The node that publishes what a camera's node would.
RADIUS_NODE = "radius_source"
BACKBONE_POINTS = 50
DIAGNOSTICS_RATE = 1.0
# What the pressure must change by for the shape to be solved anew [Pa]: its tip moves by some
# micrometers then.
FINEST = 1.0
_TOPICS = {
    "measured_pressure": Float64,
    "simulated/pressure": Float64,
    "simulated/object_radius": Float64,
    "simulated/grip": String,
    "simulated/backbone": PoseArray,
}


class Simulator(Node):  # type: ignore[misc]
    """A regulator, a gripper and an estimator of radii, on one clock.

    It hears `pressure_command` and publishes `measured_pressure`; its faults can be injected. The
    true state is published below `simulated/`, for displays, plots and tests.

    Args:
        options: passed on to both nodes.

    Attributes:
        nodes: itself, and the one that publishes what a camera's node would.
        regulator: what is simulated of it.

    Raises:
        ValueError: a parameter is bad.
        SpiralError: the gripper's description cannot be used, or it cannot coil.
    """

    def __init__(self, **options: Any) -> None:  # noqa: ANN401
        super().__init__(REGULATOR_NODE, **options)
        changed = self._on_change
        self._declared = DeclaredParameters(self, changed, SimulatedRegulatorParameters)
        values = self._values = self._declared.values()
        self.regulator = SimulatedRegulator(values)
        description, table = load_description(values.gripper), None
        with suppress(FileError):  # there is none
            table = read_grips(description)
        self._gripper = SimulatedGripper(description.gripper, values.stiffness_factor, table)
        radii = Node(RADIUS_NODE, **options)
        self._declared_radii = DeclaredParameters(radii, changed, RadiusParameters)
        radius = self._gripper.middle_radius
        self._estimator = RadiusEstimator(self._declared_radii.values(), radius)
        self._on_change(set())
        self._estimates = radii.create_publisher(Float64, "object_radius", qos_profile_sensor_data)
        self._told = {
            topic: self.create_publisher(kind, topic, MEASUREMENTS)
            for topic, kind in _TOPICS.items()
        }
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(Float64, "pressure_command", self._on_command, UNLATCHED)
        for fault in Fault:
            name = f"~/{injection_service(fault)}"
            self.create_service(Trigger, name, partial(self._inject, fault))
        self._measuring, self._telling, self._diagnosing = RateGate(), RateGate(), RateGate()
        self._solved: tuple[float, float | None] = (math.nan, None)  # pressure and radius
        self._shape: RodState | None = None
        self._grip = Grip.UNKNOWN
        self._pacing = Pacing(values.publish_clock)
        self._time = self.create_publisher(Clock, "/clock", 10) if values.publish_clock else None
        steady = RclpyClock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(STEP, self._on_tick, clock=steady)
        self.nodes, self.errors = (self, radii), ErrorLog(self.get_logger())
        for one in self.nodes:
            guard_services(one, self.errors)

    def _on_command(self, message: Float64) -> None:
        self.regulator.command(message.data)

    def _on_change(self, names: set[str]) -> None:
        """Let parameters of both nodes take effect at once."""
        del names
        self._estimator.values = self._declared_radii.values()
        self._values = self.regulator.model = self._declared.values()
        fault = Fault(self._values.fault)
        if fault is not self.regulator.fault:
            self.get_logger().info(f"fault: {self.regulator.fault.value} -> {fault.value}")
        self.regulator.fault = fault

    def _inject(self, fault: Fault, request: Any, response: Any) -> Any:  # noqa: ANN401
        del request
        result = self.set_parameters([Parameter("fault", value=fault.value)])[0]
        response.success = result.successful
        response.message = result.reason or f"fault: {fault.value}"
        return response

    def _on_tick(self) -> None:
        reading, values = time.monotonic(), self._values
        # Of the clock that time follows: /clock, or one without leaps.
        if self.get_parameter("use_sim_time").value:
            reading = float(self.get_clock().now().nanoseconds) * 1e-9
        duration = self._pacing.step(reading)
        now, stamp = self._pacing.now, self.get_clock().now().to_msg()
        if self._time is not None:
            stamp = Time(nanoseconds=self._pacing.nanoseconds).to_msg()
            self._time.publish(Clock(clock=stamp))
            period = round(STEP / values.real_time_factor * 1e9)
            if self._timer.timer_period_ns != period:
                self._timer.timer_period_ns = period
        self.regulator.step(duration)
        if self._measuring.due(now, values.measured_rate):
            pressure = self.regulator.report()
            if pressure is not None:
                self._told["measured_pressure"].publish(Float64(data=pressure))
        if self._diagnosing.due(now, DIAGNOSTICS_RATE):
            self._diagnose(stamp)
        for estimate in self._estimator.estimates(now):
            self._estimates.publish(Float64(data=estimate))
        if self._telling.due(now, values.truth_rate):
            self._tell(Header(stamp=stamp, frame_id=values.frame_id))

    def _tell(self, header: Any) -> None:  # noqa: ANN401
        """Publish the real pressure, the real object, and how the real gripper holds it."""
        pressure, radius = self.regulator.pressure, self._estimator.true_radius()
        if radius != self._solved[1] or not abs(pressure - self._solved[0]) < FINEST:
            self._solved = pressure, radius
            self._shape = self._gripper.shape(pressure)
            self._grip = self._gripper.grip(pressure, radius, self._shape)
        told = {
            "simulated/pressure": Float64(data=pressure),
            "simulated/object_radius": Float64(data=radius or 0.0),  # 0: there is none
            "simulated/grip": String(data=self._grip.value),
        }
        if self._shape is not None:
            backbone = backbone_to_msg(self._shape, BACKBONE_POINTS, header)
            told["simulated/backbone"] = backbone
        for topic, message in told.items():
            self._told[topic].publish(message)

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
