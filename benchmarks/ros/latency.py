# SPDX-License-Identifier: Apache-2.0
"""From a changed radius to its pressure, between two processes, next to an empty echo."""

from __future__ import annotations

import os
from dataclasses import dataclass, field

import numpy as np

from benchmarks.results import Section, Table, milli
from benchmarks.ros import echo
from benchmarks.ros.effort import NodeEffort
from benchmarks.ros.probe import Exchange, Probe
from benchmarks.ros.session import PROMPT, process
from benchmarks.ros.sweep import Sweep, echo_sweep, radius_sweep
from benchmarks.ros.usage_of_process import usage

COLUMNS = ("radii", "", "median", "best window", "90 %", "99 %", "most", "answered", "CPU")


@dataclass(slots=True)
class Contender:
    """A process that answers, and what was measured of it at one rate.

    Args:
        name: in the table.
        probe: that speaks to it.
        sweep: what it is sent.
        process_id: of the process.
        windows: what was measured.
        cpu: time that it was running in them [s].
    """

    name: str
    probe: Probe
    sweep: Sweep
    process_id: int
    windows: list[Exchange] = field(default_factory=list)
    cpu: float = 0.0

    def measure_window(self, count: int, rate: float) -> None:
        """Send the next ``count`` values at a rate [Hz]."""
        part = self.sweep.part(len(self.windows) * count, count)
        before = usage(self.process_id).cpu
        self.windows.append(self.probe.exchange(part, rate))
        self.cpu += usage(self.process_id).cpu - before

    def figures(self) -> dict[str, float]:
        """Return what was found, times in seconds."""
        latencies = [t for window in self.windows for t in window.latencies]
        sent = sum(window.sent for window in self.windows)
        median, most_90, most_99 = np.percentile(latencies, (50, 90, 99)).tolist()
        return {
            "median": median,
            "best": min(float(np.median(window.latencies)) for window in self.windows),
            "p90": most_90,
            "p99": most_99,
            "most": max(latencies),
            "answered": len(latencies) / sent,
            "cpu": self.cpu / sent,
        }

    def row(self, rate: float) -> tuple[str, ...]:
        """Return the table's row."""
        found = self.figures()
        times = (milli(found[key]) for key in ("median", "best", "p90", "p99", "most"))
        share, cpu = f"{found['answered']:.1%}", milli(found["cpu"])
        return (f"{rate:.0f} Hz", self.name, *times, share, cpu)


def measure(effort: NodeEffort) -> Section:
    """Measure node and echo in turns, in short windows, so that both meet the same disturbances."""
    rows: list[tuple[str, ...]] = []
    values: dict[str, float] = {}
    probes = Probe("/latency"), Probe("/echo")
    probes[0].follow_status()
    sweeps = radius_sweep(), echo_sweep()
    with process("/latency", PROMPT) as node, process("/echo", module=echo.MODULE) as peer:
        for probe, sweep in zip(probes, sweeps, strict=True):
            probe.approach(sweep)
        for rate in effort.rates:
            gripper = Contender("gripper", probes[0], sweeps[0], node.pid)
            empty = Contender("echo", probes[1], sweeps[1], peer.pid)
            probes[0].solve_times.clear()
            for _ in range(effort.windows):
                gripper.measure_window(effort.messages // effort.windows, rate)
                empty.measure_window(effort.messages // effort.windows, rate)
            rows += [gripper.row(rate), empty.row(rate)]
            for name, found in (("gripper", gripper.figures()), ("echo", empty.figures())):
                values |= {f"{name}_{rate:.0f}_{key}": value for key, value in found.items()}
            values[f"solve_{rate:.0f}"] = float(np.median(probes[0].solve_times))
            values[f"ratio_{rate:.0f}"] = gripper.figures()["median"] / empty.figures()["median"]
    for probe in probes:
        probe.close()
    return Section((_table(effort, rows, values),), values)


def _table(effort: NodeEffort, rows: list[tuple[str, ...]], values: dict[str, float]) -> Table:
    ratios = ", ".join(
        f"{values[f'ratio_{rate:.0f}']:.2f} × the echo at {rate:.0f} Hz, of which "
        f"{milli(values[f'solve_{rate:.0f}'])} are the solve"
        for rate in effort.rates
    )
    return Table(
        "From radius to pressure",
        COLUMNS,
        tuple(rows),
        f"{effort.messages} changed radii at each rate, each answered with the pressure of its "
        f"wrap; publish.rate 50 Hz. Node and echo take turns in {effort.windows} windows; best "
        "window: its median. The echo is a plain rclpy node that sends back what it gets, with the "
        f"same types. Medians: {ratios}. CPU: time of the process per radius, ticks included. "
        f"Load at the end: {os.getloadavg()[0]:.1f}.",
    )
