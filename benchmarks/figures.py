# SPDX-License-Identifier: Apache-2.0
"""Draw error and cost against N from a summary: docs/figures/rod_accuracy.png."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib as mpl
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter, ScalarFormatter

from benchmarks.accuracy import COUNTS, LONG_COUNTS, ORDER_COUNTS
from benchmarks.report import ROOT

FIGURE = ROOT / "docs" / "figures" / "rod_accuracy.png"


def draw(summary: Mapping[str, Any]) -> None:
    """Write the figure."""
    mpl.use("Agg")
    values = summary["sections"]["accuracy"]["values"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.0), layout="constrained")
    draw_errors(left, values)
    draw_times(right, values)
    for axes in (left, right):
        axes.xaxis.set_major_formatter(ScalarFormatter())
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_xlabel("elements N")
        axes.grid(alpha=0.3, which="both", linewidth=0.5)
        axes.legend(frameon=False)
    FIGURE.parent.mkdir(exist_ok=True)
    figure.savefig(FIGURE, dpi=120)
    plt.close(figure)


def draw_errors(axes: Axes, values: Mapping[str, float]) -> None:
    """Draw the error of the tip and of the worst node."""
    for what, label, color, width in (
        ("shape", "worst node", "#e8b5a9", 5.0),
        ("tip", "tip", "#40201a", 1.5),
    ):
        found = [values[f"{what}_error_{n}"] for n in COUNTS]
        axes.loglog(COUNTS, found, "o-", color=color, ms=2.0 + width, lw=width, label=label)
    anchor = 3.0 * values[f"tip_error_{ORDER_COUNTS[0]}"]
    slope = [anchor * (n / ORDER_COUNTS[0]) ** -4.0 for n in ORDER_COUNTS]
    axes.loglog(ORDER_COUNTS, slope, "--", color="#888888", label="order 4")
    axes.set_ylabel("error / length")


def draw_times(axes: Axes, values: Mapping[str, float]) -> None:
    """Draw the time of a cold and of a warm solve."""
    for kind, color in (("cold", "#c8553d"), ("warm", "#7ba7b4")):
        times = [1e6 * values[f"{kind}_{n}"] for n in LONG_COUNTS]
        axes.loglog(LONG_COUNTS, times, "o-", color=color, ms=4, label=kind)
    ends = (LONG_COUNTS[2], LONG_COUNTS[-1])
    base = 0.6e6 * values[f"warm_{ends[0]}"]
    axes.loglog(ends, [base * n / ends[0] for n in ends], "--", color="#888888", label="order 1")
    axes.set_ylim(10.0, 1000.0)
    axes.yaxis.set_major_formatter(ScalarFormatter())
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_ylabel("time of a solve [µs]")
