# SPDX-License-Identifier: Apache-2.0
"""How many changed radii per second the node answers, and what happens beyond."""

from __future__ import annotations

import numpy as np

from benchmarks.results import Section, Table, milli
from benchmarks.ros.effort import NodeEffort
from benchmarks.ros.probe import Exchange, Probe
from benchmarks.ros.session import PROMPT, process
from benchmarks.ros.sweep import radius_sweep
from benchmarks.ros.usage_of_process import usage

# A rate is sustained if so many radii are answered, each by its own pressure, and the answers to
# the second half are no later than so many times those to the first: no backlog grows.
ANSWERED = 0.99
SENT = 0.98
GROWTH = 2.0


def measure(effort: NodeEffort) -> Section:
    """Try ever higher rates on one process."""
    sweep, probe = radius_sweep(), Probe("/rate")
    rows: list[tuple[str, ...]] = []
    values = {"sustained": 0.0, "worst_p99": 0.0}
    with process("/rate", PROMPT) as node:
        probe.approach(sweep)
        for rate in effort.ladder:
            part = sweep.part(0, int(rate * effort.step_seconds))
            before = usage(node.pid).cpu
            found = probe.exchange(part, rate)
            cpu = (usage(node.pid).cpu - before) / found.duration
            true_rate = found.sent / found.duration
            sustained = is_sustained(found, rate)
            if sustained:
                values["sustained"] = rate
            median, late = np.percentile(found.latencies, (50, 99)).tolist()
            values["worst_p99"] = max(values["worst_p99"], late)
            values |= {f"answered_{rate:.0f}": found.answered, f"p99_{rate:.0f}": late}
            answers = f"{len(found.latencies) / found.duration:,.0f} Hz"
            shares = (f"{found.answered:.1%}", answers, milli(median), milli(late), f"{cpu:.0%}")
            rows.append((f"{true_rate:,.0f} Hz", *shares, "yes" if sustained else "no"))
    probe.close()
    return Section(
        (
            Table(
                "Changed radii per second",
                ("sent", "answered", "answers", "median", "99 %", "CPU", "sustained"),
                tuple(rows),
                f"{effort.step_seconds:g} s at each rate. Sustained: at least {ANSWERED:.0%} are "
                "answered and the answers do not become later. Beyond, the newest radius wins: the "
                "others are never looked at, and the answers that come are not late.",
            ),
        ),
        values,
    )


def is_sustained(found: Exchange, rate: float) -> bool:
    """Return whether a rate [Hz] was sent and almost all answered, without a growing backlog."""
    if found.sent < SENT * rate * found.duration or found.answered < ANSWERED:
        return False
    first, second = (float(np.median(part)) for part in np.array_split(found.latencies, 2))
    return second <= GROWTH * first
