# SPDX-License-Identifier: Apache-2.0
"""A minute at a thousand radii per second: memory, answers, load."""

from __future__ import annotations

import time

import numpy as np

from benchmarks.results import MEGABYTE, Section, Table, milli
from benchmarks.ros.effort import NodeEffort
from benchmarks.ros.probe import Probe
from benchmarks.ros.session import PROMPT, process
from benchmarks.ros.sweep import radius_sweep
from benchmarks.ros.usage_of_process import usage

# Pieces of the run, after each of which the memory is looked at; the first is the warm-up.
PIECES = 6
# In which the node's diagnostics come once more [s].
DIAGNOSED = 1.5


def measure(effort: NodeEffort) -> Section:
    """Run, and look at the process every few seconds."""
    sweep, probe = radius_sweep(), Probe("/endurance")
    probe.follow_status()
    rate, seconds = effort.endurance_rate, effort.endurance_seconds / PIECES
    rows: list[tuple[str, ...]] = []
    memory: list[int] = []
    latencies: list[float] = []
    sent, cpu = 0, 0.0
    with process("/endurance", PROMPT) as node:
        probe.approach(sweep)
        first = probe.accepted
        for piece in range(PIECES):
            before = usage(node.pid)
            count = int(rate * seconds)
            found = probe.exchange(sweep.part(piece * count, count), rate)
            after = usage(node.pid)
            memory.append(after.memory)
            latencies += found.latencies
            sent += found.sent
            cpu += (after.cpu - before.cpu) / PIECES / found.duration
            late = milli(float(np.percentile(found.latencies, 99)))
            share = f"{found.answered:.1%}"
            rows.append(
                (f"{seconds * (piece + 1):g} s", share, late, f"{after.memory / MEGABYTE:.1f} MB")
            )
        probe.spin_until_time(time.perf_counter() + DIAGNOSED)
        taken = (probe.accepted - first) / sent
    probe.close()
    growth = (memory[-1] - memory[0]) / MEGABYTE
    return Section(
        (
            Table(
                f"{rate:,.0f} changed radii per second for {effort.endurance_seconds:g} s",
                ("until", "answered", "99 %", "resident memory"),
                tuple(rows),
                f"{sent:,} sent; the node looked at {taken:.1%} and answered "
                f"{len(latencies) / sent:.1%}, the newest first; it used {cpu:.0%} of a processor. "
                f"From the first row to the last its memory changed by {growth:+.1f} MB.",
            ),
        ),
        {
            "memory_growth_mb": growth,
            "answered": len(latencies) / sent,
            "taken": taken,
            "p99": float(np.percentile(latencies, 99)),
            "cpu": cpu,
        },
    )
