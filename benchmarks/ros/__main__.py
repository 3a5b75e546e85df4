# SPDX-License-Identifier: Apache-2.0
"""Measure the node: ``python -m benchmarks.ros``, or some sections only by naming them."""

from __future__ import annotations

from benchmarks import command
from benchmarks.machine import LIBRARIES
from benchmarks.report import RESULTS, ROOT, Page
from benchmarks.ros import endurance, latency, lifecycle, many, rate, startup
from benchmarks.ros.effort import SMOKE, NodeEffort
from benchmarks.ros.goals import goal_table
from benchmarks.ros.session import own_domain

PROGRAM = "python -m benchmarks.ros"
PAGE = Page(
    ROOT / "docs" / "node_benchmarks.md",
    RESULTS / "ros_summary.json",
    PROGRAM,
)
SUITE = command.Suite(
    program=PROGRAM,
    description=__doc__,
    sections={
        "latency": latency.measure,
        "rate": rate.measure,
        "endurance": endurance.measure,
        "lifecycle": lifecycle.measure,
        "many": many.measure,
        "startup": startup.measure,
    },
    effort=NodeEffort(),
    smoke=SMOKE,
    goals=goal_table,
    libraries=(*LIBRARIES, "rclpy", "ros-rmw-fastrtps-cpp"),
    latest=RESULTS / "ros_latest.json",
    page=PAGE,
)

if __name__ == "__main__":
    with own_domain():
        command.main(SUITE)
