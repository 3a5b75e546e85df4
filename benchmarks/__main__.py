# SPDX-License-Identifier: Apache-2.0
"""Measure, show, keep: ``python -m benchmarks``, or some sections only by naming them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from benchmarks import (
    accuracy,
    batches,
    closings,
    command,
    contact,
    contact_wraps,
    edges,
    explicit_grips,
    held,
    motions,
    peers,
    questions,
    robustness,
    scenarios,
    solves,
    startup,
    wraps,
)
from benchmarks.goals import goal_table
from benchmarks.machine import LIBRARIES
from benchmarks.report import PAGE, RESULTS
from benchmarks.results import SMOKE, Effort


def draw(summary: Mapping[str, Any]) -> None:
    """Draw the figures of a summary."""
    from benchmarks import figures  # matplotlib is an extra

    figures.draw(summary)


SUITE = command.Suite(
    program="python -m benchmarks",
    description=__doc__,
    sections={
        "solves": solves.measure,
        "wraps": wraps.measure,
        "batches": batches.measure,
        "startup": startup.measure,
        "accuracy": accuracy.measure,
        "bvp": peers.collocation_section,
        "elastica": peers.dynamics_section,
        "scenarios": scenarios.measure,
        "contact": contact.measure,
        "contact_wraps": contact_wraps.measure,
        "closings": closings.measure,
        "held": held.measure,
        "explicit": explicit_grips.measure,
        "motions": motions.measure,
        "robustness": robustness.measure,
        "edges": edges.measure,
        "questions": questions.measure,
    },
    effort=Effort(),
    smoke=SMOKE,
    goals=goal_table,
    libraries=(*LIBRARIES, "pyelastica", "mujoco", "cosseratbench"),
    latest=RESULTS / "latest.json",
    page=PAGE,
    draw=draw,
)

if __name__ == "__main__":
    command.main(SUITE)
