# SPDX-License-Identifier: Apache-2.0
"""The other side of the node: sends radii, and takes the time until their pressures arrive."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64

from benchmarks.ros.sweep import Sweep
from spiral_gripper_msgs.msg import GripStatus, Wrap
from spiral_gripper_ros.messages.qos import NEWEST

# The first start ever compiles for some 15 s, on a slow machine for longer.
START_TIMEOUT = 300.0
# How long to wait for the last answers [s].
LAST_ANSWERS = 0.3
RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)


@dataclass(frozen=True, slots=True)
class Exchange:
    """What came back.

    Args:
        sent: values sent.
        latencies: time from sending a value to its answer [s], of those that were answered.
        duration: of the sending [s].
    """

    sent: int
    latencies: tuple[float, ...]
    duration: float

    @property
    def answered(self) -> float:
        """Share of the values that were answered."""
        return len(self.latencies) / self.sent


class Probe:
    """A small node that speaks to one gripper's node, or to an echo.

    Args:
        namespace: of that node.
        executor: what the probe's callbacks run on; None: one of its own.
    """

    def __init__(self, namespace: str, executor: SingleThreadedExecutor | None = None) -> None:
        self.node = Node(
            "benchmark_probe",
            namespace=namespace,
            start_parameter_services=False,
            enable_rosout=False,
        )
        self.status: Any = None  # the newest, once followed
        self.accepted = 0  # radii, by the newest diagnostics
        self._follows_status = False
        self._planned_for: float | None = None
        self.solve_times: list[float] = []
        self._pending: dict[float, float] = {}
        self._latencies: list[float] = []
        self._radius = self.node.create_publisher(Float64, "object_radius", NEWEST)
        self.node.create_subscription(Float64, "pressure_command", self._on_answer, RELIABLE)
        self.executor = executor or SingleThreadedExecutor()
        self.executor.add_node(self.node)

    def follow_status(self) -> None:
        """Subscribe to `status`, `wrap` and the diagnostics as well."""
        self._follows_status = True
        self.node.create_subscription(Wrap, "wrap", self._on_wrap, RELIABLE)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)
        self.node.create_subscription(GripStatus, "status", self._on_status, RELIABLE)

    def close(self) -> None:
        """Leave the graph."""
        self.executor.remove_node(self.node)
        self.node.destroy_node()

    def connected(self) -> bool:
        """Return whether somebody listens and answers."""
        answers = self.node.count_publishers("pressure_command")
        return bool(self._radius.get_subscription_count() > 0 and answers > 0)

    def spin_until(self, condition: Callable[[], bool], timeout: float = START_TIMEOUT) -> None:
        """Handle what arrives until a condition holds.

        Raises:
            TimeoutError: it does not within ``timeout`` [s].
        """
        end = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(f"nothing for {timeout} s in {self.node.get_namespace()}")
            self.executor.spin_once(timeout_sec=0.02)

    def send(self, value: float, answer: float) -> None:
        """Send a value, and remember when; ``answer`` is what is expected back."""
        self._pending[answer] = time.perf_counter()
        self._radius.publish(Float64(data=value))

    def approach(self, sweep: Sweep) -> None:
        """Send the last value of a sweep, which comes before the first, until it is answered."""
        self._latencies.clear()
        self.spin_until(self.connected)

        def is_answered() -> bool:
            self.send(sweep.values[-1], sweep.answers[-1])
            return bool(self._latencies) and (self.status is not None or not self._follows_status)

        self.spin_until(is_answered)
        self.take()

    def exchange(self, sweep: Sweep, rate: float) -> Exchange:
        """Send the values of a sweep at a rate [Hz], and take the times of the answers."""
        self.take()
        start = following = time.perf_counter()
        for value, answer in zip(sweep.values, sweep.answers, strict=True):
            self.send(value, answer)
            following += 1.0 / rate
            self.spin_until_time(following)
        duration = time.perf_counter() - start
        self.spin_until_time(time.perf_counter() + LAST_ANSWERS)
        return Exchange(len(sweep.values), self.take(), duration)

    def spin_until_time(self, end: float) -> None:
        """Handle what arrives until a moment [s, of ``time.perf_counter``]."""
        while (left := end - time.perf_counter()) > 0.0:
            self.executor.spin_once(timeout_sec=left)

    def take(self) -> tuple[float, ...]:
        """Return the latencies since the last time [s], and forget what is not answered."""
        latencies = tuple(self._latencies)
        self._latencies.clear()
        self._pending.clear()
        return latencies

    def _on_answer(self, message: Float64) -> None:
        now = time.perf_counter()
        sent = self._pending.pop(message.data, None)
        if sent is not None:
            self._latencies.append(now - sent)

    def _on_status(self, message: GripStatus) -> None:
        self.status = message

    def _on_wrap(self, message: Wrap) -> None:
        for plan in message.plan:
            if plan.object_radius != self._planned_for:
                self.solve_times.append(plan.solve_time)
            self._planned_for = plan.object_radius

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        own = f"{self.node.get_namespace()}/spiral_gripper: grip"
        for status in message.status:
            if status.name == own:
                self.accepted = int({v.key: v.value for v in status.values}["radii accepted"])
