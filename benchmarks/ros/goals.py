# SPDX-License-Identifier: Apache-2.0
"""What the node aims at on an idle machine with two processors, next to what was measured."""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.goals import Goal, Values, goal_rows, table_of_goals
from benchmarks.results import Table, milli

# How figures are shown.
hertz = "{:,.0f} Hz".format
megabytes = "{:.1f} MB".format
whole = "{:.0f}".format
share = "{:.0%}".format
seconds = "{:.1f} s".format

GOALS = (
    Goal("radius to pressure at 50 Hz, median", "latency", "gripper_50_median", 1e-3, True, milli),
    Goal("... 99 %", "latency", "gripper_50_p99", 5e-3, True, milli),
    Goal("... at 200 Hz, median", "latency", "gripper_200_median", 1e-3, True, milli),
    Goal("... 99 %", "latency", "gripper_200_p99", 5e-3, True, milli),
    Goal("highest rate without backlog", "rate", "sustained", 200.0, False, hertz),
    Goal("answers beyond it, 99 %", "rate", "worst_p99", 10e-3, True, milli),
    Goal(
        "memory gained in a minute of 1 kHz", "endurance", "memory_growth_mb", 1.0, True, megabytes
    ),
    Goal("memory gained in 90 life cycles", "lifecycle", "memory_growth_mb", 1.0, True, megabytes),
    Goal("threads gained", "lifecycle", "thread_growth", 0.0, True, whole),
    Goal("open files gained", "lifecycle", "file_growth", 0.0, True, whole),
    Goal("entities gained", "lifecycle", "entity_growth", 0.0, True, whole),
    Goal("ten grippers in one process, 99 %", "many", "p99", 20e-3, True, milli),
    Goal("their processor time", "many", "cpu", 1.0, True, share),
    Goal("start, kernels cached", "startup", "warm", 5.0, True, seconds),
    Goal("first start ever", "startup", "compiling", 60.0, True, seconds),
)


def goal_table(values: Mapping[str, Values]) -> Table:
    """Return the table of the goals whose sections were measured."""
    return table_of_goals(goal_rows(GOALS, values))
