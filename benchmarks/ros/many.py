# SPDX-License-Identifier: Apache-2.0
"""Several grippers in one process: do they disturb each other?"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial

import numpy as np
from rcl_interfaces.msg import ParameterType
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from std_msgs.msg import Float64

from benchmarks.results import MEGABYTE, Section, Table, milli
from benchmarks.ros import many_grippers
from benchmarks.ros.effort import NodeEffort
from benchmarks.ros.probe import Probe
from benchmarks.ros.session import process
from benchmarks.ros.sweep import Sweep, radius_sweep
from benchmarks.ros.usage_of_process import usage
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.qos import NEWEST

RATE = 50.0
TIMEOUT = 30.0


@dataclass(frozen=True, slots=True)
class Found:
    """What one process with several grippers did.

    Args:
        start: time until all are active [s].
        latencies: of all grippers [s].
        answered: share of the radii.
        cpu: share of a processor.
        memory: resident [bytes].
        threads: of the process.
        isolated: whether a fault and a parameter of one left the others alone.
    """

    start: float
    latencies: tuple[float, ...]
    answered: float
    cpu: float
    memory: int
    threads: int
    isolated: bool


def is_active(probe: Probe) -> bool:
    """Return whether the probe's node has said that it is active."""
    return probe.status is not None and bool(probe.status.state != State.INACTIVE)


def measure(effort: NodeEffort) -> Section:
    """Measure one gripper alone, and all of them."""
    runs = {
        "1 gripper": run(effort, 1),
        f"{effort.grippers} grippers": run(effort, effort.grippers),
    }
    many = runs[f"{effort.grippers} grippers"]
    median, late = np.percentile(many.latencies, (50, 99)).tolist()
    return Section(
        (
            Table(
                "Grippers in one process",
                ("", "start", "median", "99 %", "answered", "CPU", "memory", "threads", "isolated"),
                tuple(_row(name, found) for name, found in runs.items()),
                f"Every gripper is sent {RATE:g} changed radii per second, one after the other. "
                "Isolated: while the pressure of one does not follow (FAULT, vented) and its "
                "parameters are changed, the others go on as they were.",
            ),
        ),
        {
            "median": median,
            "p99": late,
            "answered": many.answered,
            "cpu": many.cpu,
            "start": many.start,
            "isolated": float(many.isolated),
        },
    )


def run(effort: NodeEffort, grippers: int) -> Found:
    """Start a process with some grippers, feed all of them, and disturb one."""
    sweep, executor = radius_sweep(), SingleThreadedExecutor()
    probes = [Probe(f"/many/gripper_{k}", executor) for k in range(grippers)]
    for probe in probes:
        probe.follow_status()
    begin = time.perf_counter()
    settings = {"SPIRAL_GRIPPERS": str(grippers)}
    with process("/", environment=settings, module=many_grippers.MODULE) as running:
        for probe in probes:
            probe.spin_until(partial(is_active, probe))
        start = time.perf_counter() - begin
        for probe in probes:
            probe.approach(sweep)
        before, fed_from = usage(running.pid), time.perf_counter()
        feed(probes, sweep.part(0, effort.many_messages))
        after, duration = usage(running.pid), time.perf_counter() - fed_from
        latencies = [probe.take() for probe in probes]
        isolated = are_isolated(probes, sweep)
    for probe in probes:
        probe.close()
    executor.shutdown()
    together = tuple(t for each in latencies for t in each)
    return Found(
        start=start,
        latencies=together,
        answered=len(together) / (effort.many_messages * grippers),
        cpu=(after.cpu - before.cpu) / duration,
        memory=after.memory,
        threads=after.threads,
        isolated=isolated,
    )


def feed(probes: list[Probe], sweep: Sweep) -> None:
    """Send the values to all grippers at ``RATE``, evenly spread over each period."""
    following = time.perf_counter()
    for value, answer in zip(sweep.values, sweep.answers, strict=True):
        for probe in probes:
            probe.send(value, answer)
            following += 1.0 / RATE / len(probes)
            probe.spin_until_time(following)


def are_isolated(probes: list[Probe], sweep: Sweep) -> bool:
    """Let the first gripper fail and change its parameters; return whether the others go on."""
    first, others = probes[0], probes[1:]
    measured = first.node.create_publisher(Float64, "measured_pressure", NEWEST)
    parameters = AsyncParameterClient(first.node, "spiral_gripper")
    future = parameters.set_parameters([Parameter("publish.rate", value=20.0)])
    first.spin_until(future.done, TIMEOUT)
    end = time.perf_counter() + TIMEOUT
    position = 0
    while first.status.state != State.FAULT and time.perf_counter() < end:
        measured.publish(Float64(data=0.0))
        feed(probes, sweep.part(position, 1))
        position += 1
    for probe in others:
        probe.take()
    silent, end = others, time.perf_counter() + TIMEOUT
    while silent and time.perf_counter() < end:
        feed(others, sweep.part(position, 10))
        position += 10
        silent = [probe for probe in silent if not probe.take()]
    followed = not silent and all(probe.status.state == State.TRACKING for probe in others)
    return first.status.state == State.FAULT and followed and _rates(others) <= {50.0}


def _rates(probes: list[Probe]) -> set[float]:
    """Return the values of `publish.rate`."""
    found = set()
    for probe in probes:
        future = AsyncParameterClient(probe.node, "spiral_gripper").get_parameters(["publish.rate"])
        probe.spin_until(future.done, TIMEOUT)
        (value,) = future.result().values
        found.add(value.double_value if value.type == ParameterType.PARAMETER_DOUBLE else 0.0)
    return found


def _row(name: str, found: Found) -> tuple[str, ...]:
    median, late = np.percentile(found.latencies, (50, 99)).tolist()
    return (
        name,
        f"{found.start:.1f} s",
        milli(median),
        milli(late),
        f"{found.answered:.1%}",
        f"{found.cpu:.0%}",
        f"{found.memory / MEGABYTE:.0f} MB",
        str(found.threads),
        "yes" if found.isolated else "no",
    )
