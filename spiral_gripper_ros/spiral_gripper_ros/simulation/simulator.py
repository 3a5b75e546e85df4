# SPDX-License-Identifier: Apache-2.0
"""The simulator: its two nodes, and the time that passes for them."""

from __future__ import annotations

import time
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.clock import Clock as RclpyClock
from rclpy.clock import ClockType
from rclpy.executors import Executor
from rosgraph_msgs.msg import Clock

from spiral_gripper import load_gripper
from spiral_gripper_ros.process.guards import ErrorLog, guard_services
from spiral_gripper_ros.simulation.pacing import STEP, Pacing, RateGate
from spiral_gripper_ros.simulation.radius_node import RadiusNode
from spiral_gripper_ros.simulation.regulator_node import RegulatorNode
from spiral_gripper_ros.simulation.simulated_gripper import SimulatedGripper
from spiral_gripper_ros.simulation.truth import Truth


class Simulator:
    """A regulator, a gripper and an estimator of radii, on one clock.

    Args:
        executor: that runs the nodes.
        options: passed on to both nodes.

    Raises:
        ValueError: a parameter is bad.
        SpiralError: the gripper's description cannot be used, or it cannot coil.
    """

    def __init__(self, executor: Executor, **options: Any) -> None:  # noqa: ANN401
        self._regulator = RegulatorNode(**options)
        values = self._regulator.values
        gripper = SimulatedGripper(load_gripper(values.gripper), values.stiffness_factor)
        self._radii = RadiusNode(gripper.middle_radius, **options)
        self._truth = Truth(self._regulator, gripper)
        self._telling = RateGate()
        publishes_clock = values.publish_clock
        self._pacing = Pacing(publishes_clock)
        self._clock = (
            self._regulator.create_publisher(Clock, "/clock", 10) if publishes_clock else None
        )
        self._timer = self._regulator.create_timer(
            STEP, self._on_tick, clock=RclpyClock(clock_type=ClockType.STEADY_TIME)
        )
        self.nodes = (self._regulator, self._radii)
        self.executor = executor
        self.errors = ErrorLog(self._regulator.get_logger())
        for node in self.nodes:
            guard_services(node, self.errors)
            executor.add_node(node)

    def _on_tick(self) -> None:
        duration = self._pacing.step(self._reading())
        now, stamp = self._pacing.now, self._stamp()
        if self._clock is not None:
            self._clock.publish(Clock(clock=stamp))
            self._keep_pace()
        self._regulator.step(duration, now, stamp)
        self._radii.step(now)
        if self._telling.due(now, self._regulator.values.truth_rate):
            self._truth.publish(
                self._regulator.regulator.pressure,
                self._radii.estimator.true_radius(),
                self._regulator.header(stamp),
            )

    def _reading(self) -> float:
        """Return what the clock reads that time follows [s]: /clock, or one that never leaps."""
        if self._regulator.get_parameter("use_sim_time").value:
            return float(self._regulator.get_clock().now().nanoseconds) * 1e-9
        return time.monotonic()

    def _stamp(self) -> Any:  # noqa: ANN401
        if self._clock is None:
            return self._regulator.get_clock().now().to_msg()
        seconds, nanoseconds = divmod(self._pacing.nanoseconds, 1_000_000_000)
        return Time(sec=seconds, nanosec=nanoseconds)

    def _keep_pace(self) -> None:
        """Let a changed real_time_factor take effect."""
        period = round(STEP / self._regulator.values.real_time_factor * 1e9)
        if self._timer.timer_period_ns != period:
            self._timer.timer_period_ns = period
