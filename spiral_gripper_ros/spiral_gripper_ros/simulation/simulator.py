# SPDX-License-Identifier: Apache-2.0
"""The simulator: its two nodes, the time that passes for them, and what is true."""

from __future__ import annotations

import math
import time
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseArray
from rclpy.clock import Clock as RclpyClock
from rclpy.clock import ClockType
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64, Header, String

from spiral_core.rod.state import RodState
from spiral_gripper import load_gripper
from spiral_gripper_ros.messages.conversions import backbone_to_msg
from spiral_gripper_ros.messages.qos import MEASUREMENTS
from spiral_gripper_ros.parameters.declared import DeclaredParameters
from spiral_gripper_ros.process.guards import ErrorLog, guard_services
from spiral_gripper_ros.simulation.pacing import STEP, Pacing, RateGate
from spiral_gripper_ros.simulation.radius_estimator import RadiusEstimator, RadiusParameters
from spiral_gripper_ros.simulation.regulator_node import RegulatorNode
from spiral_gripper_ros.simulation.simulated_gripper import Grip, SimulatedGripper

# The node that publishes what a camera's node would.
RADIUS_NODE = "radius_source"
BACKBONE_POINTS = 50
# What the pressure must change by for the shape to be solved anew [Pa]: its tip moves by some
# micrometers then.
FINEST = 1.0
_TRUTH = {
    "simulated/pressure": Float64,
    "simulated/object_radius": Float64,
    "simulated/grip": String,
    "simulated/backbone": PoseArray,
}


class Simulator:
    """A regulator, a gripper and an estimator of radii, on one clock.

    Their true state is published below `simulated/`, for displays, plots and tests.

    Args:
        executor: that runs the nodes.
        options: passed on to both nodes.

    Raises:
        ValueError: a parameter is bad.
        SpiralError: the gripper's description cannot be used, or it cannot coil.
    """

    def __init__(self, executor: Executor, **options: Any) -> None:  # noqa: ANN401
        node = self._node = RegulatorNode(**options)
        values = node.values
        self._gripper = SimulatedGripper(load_gripper(values.gripper), values.stiffness_factor)
        radii = Node(RADIUS_NODE, **options)
        self._declared = DeclaredParameters(radii, self._apply, RadiusParameters)
        self._estimator = RadiusEstimator(self._declared.values(), self._gripper.middle_radius)
        self._estimates = radii.create_publisher(Float64, "object_radius", qos_profile_sensor_data)
        self._told = {
            topic: node.create_publisher(kind, topic, MEASUREMENTS)
            for topic, kind in _TRUTH.items()
        }
        self._telling = RateGate()
        self._solved: tuple[float, float | None] = (math.nan, None)  # pressure and radius
        self._shape: RodState | None = None
        self._grip = Grip.UNKNOWN
        self._pacing = Pacing(values.publish_clock)
        self._clock = node.create_publisher(Clock, "/clock", 10) if values.publish_clock else None
        steady = RclpyClock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(STEP, self._on_tick, clock=steady)
        self.nodes, self.executor = (node, radii), executor
        self.errors = ErrorLog(node.get_logger())
        for one in self.nodes:
            guard_services(one, self.errors)
            executor.add_node(one)

    def _apply(self, names: set[str]) -> None:
        """Let the parameters of the estimator take effect at once."""
        del names
        self._estimator.values = self._declared.values()

    def _on_tick(self) -> None:
        node = self._node
        reading = time.monotonic()  # of the clock that time follows: /clock, or one without leaps
        if node.get_parameter("use_sim_time").value:
            reading = float(node.get_clock().now().nanoseconds) * 1e-9
        duration = self._pacing.step(reading)
        now, stamp = self._pacing.now, node.get_clock().now().to_msg()
        if self._clock is not None:
            seconds, nanoseconds = divmod(self._pacing.nanoseconds, 1_000_000_000)
            stamp = Time(sec=seconds, nanosec=nanoseconds)
            self._clock.publish(Clock(clock=stamp))
            period = round(STEP / node.values.real_time_factor * 1e9)
            if self._timer.timer_period_ns != period:
                self._timer.timer_period_ns = period
        node.step(duration, now, stamp)
        for estimate in self._estimator.estimates(now):
            self._estimates.publish(Float64(data=estimate))
        if self._telling.due(now, node.values.truth_rate):
            self._tell(Header(stamp=stamp, frame_id=node.values.frame_id))

    def _tell(self, header: Any) -> None:  # noqa: ANN401
        """Publish the real pressure, the real object, and how the real gripper holds it."""
        pressure, radius = self._node.regulator.pressure, self._estimator.true_radius()
        if radius != self._solved[1] or not abs(pressure - self._solved[0]) < FINEST:
            self._solved = pressure, radius
            self._shape = self._gripper.shape(pressure)
            self._grip = self._gripper.grip(pressure, radius, self._shape)
        self._told["simulated/pressure"].publish(Float64(data=pressure))
        self._told["simulated/object_radius"].publish(
            Float64(data=radius or 0.0)
        )  # 0: there is none
        self._told["simulated/grip"].publish(String(data=self._grip.value))
        if self._shape is not None:
            backbone = backbone_to_msg(self._shape, BACKBONE_POINTS, header)
            self._told["simulated/backbone"].publish(backbone)
