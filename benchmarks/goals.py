# SPDX-License-Identifier: Apache-2.0
"""What this project aims at (medians on a 2-core machine), next to what was measured."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from benchmarks.results import Table, micro, milli

Values = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Goal:
    """One goal: where its figure is found, and whether a smaller one is better."""

    what: str
    section: str
    key: str
    bound: float
    at_most: bool
    show: Callable[[float], str]

    def met(self, value: float) -> bool:
        """Return whether a measured value meets the goal; never for NaN."""
        return value <= self.bound if self.at_most else value >= self.bound


# How figures are shown.
times = "{:,.0f} ×".format
error = "{:.1e}".format
count = "{:,.0f}".format

GOALS = (
    Goal("warm solve, N = 100", "solves", "warm_100", 50e-6, True, micro),
    Goal("cold ramp, N = 100", "solves", "cold_100", 0.5e-3, True, milli),
    Goal("warm solve, tip error 1e-5 L", "solves", "warm_equal", 60e-6, True, micro),
    Goal("cold ramp, tip error 1e-5 L", "solves", "cold_equal", 0.6e-3, True, milli),
    Goal("perfect-wrap inversion, slowest gripper", "wraps", "invert", 0.5e-3, True, milli),
    Goal("solve_bvp, textbook equations, cold", "bvp", "bvp_plain_cold_ratio", 20.0, False, times),
    Goal("solve_bvp, textbook equations, warm", "bvp", "bvp_plain_warm_ratio", 200.0, False, times),
    Goal("solve_bvp at its best, cold", "bvp", "bvp_best_cold_ratio", 20.0, False, times),
    Goal("solve_bvp at its best, warm", "bvp", "bvp_best_warm_ratio", 200.0, False, times),
    Goal(
        "PyElastica to rest, plain",
        "elastica",
        "elastica_plain_rest_ratio_equal",
        5e3,
        False,
        times,
    ),
    Goal(
        "PyElastica to rest, tuned",
        "elastica",
        "elastica_tuned_rest_ratio_equal",
        5e3,
        False,
        times,
    ),
    Goal("cosseratbench, cantilever: error", "scenarios", "cantilever_error", 5e-4, True, error),
    Goal(
        "... catenary: from the exact elastica, L", "scenarios", "catenary_exact", 2e-5, True, error
    ),
    Goal("... without bending stiffness, L", "scenarios", "catenary_flexible", 2e-5, True, error),
    Goal(
        "... cables nearer than PyElastica's, of 5", "scenarios", "catenary_ahead", 5, False, count
    ),
    Goal("... capstan: slide while held, m", "scenarios", "capstan_held", 1e-5, True, error),
    Goal(
        "... without bending stiffness, m", "scenarios", "capstan_held_flexible", 1e-5, True, error
    ),
    Goal(
        "... capstan: slide when too heavy, m", "scenarios", "capstan_sliding", 0.05, False, error
    ),
    Goal("contact, warm solve, N = 180", "contact", "warm_180", 3e-3, True, milli),
    Goal("pull of an object by 60 mm", "contact", "pull", 0.5, True, milli),
    Goal("cost of contact, order in N", "contact", "order", 1.1, True, "{:.2f}".format),
    Goal("random wraps, wrong without a word", "contact_wraps", "wrong", 0, True, count),
    Goal("random grips, wrong or without an answer", "held", "wrong", 0, True, count),
    Goal(
        "two grips, from an explicit simulation", "explicit", "apart", 0.05, True, "{:.1%}".format
    ),
    *(
        Goal(f"PyElastica on {name}", "scenarios", f"{name}_pyelastica_ratio", 1e3, False, times)
        for name in ("cantilever", "catenary", "capstan")
    ),
)


def goal_rows(goals: Iterable[Goal], values: Mapping[str, Values]) -> list[tuple[str, ...]]:
    """Return the rows of the goals whose figures were measured."""
    rows: list[tuple[str, ...]] = []
    for goal in goals:
        value = values.get(goal.section, {}).get(goal.key)
        if value is not None:
            bound = ("≤ " if goal.at_most else "≥ ") + goal.show(goal.bound)
            shown = goal.show(value) if math.isfinite(value) else "no answer"
            rows.append((goal.what, bound, shown, "yes" if goal.met(value) else "no"))
    return rows


def table_of_goals(rows: Iterable[tuple[str, ...]]) -> Table:
    """Return the table of goals."""
    return Table("Goals", ("what", "goal", "measured", "met"), tuple(rows))


def goal_table(values: Mapping[str, Values]) -> Table:
    """Return the table of the goals whose sections were measured."""
    rows = goal_rows(GOALS, values)
    if sample := values.get("robustness"):
        solved, rods = sample["solved"], sample["rods"]
        share = f"{count(solved)} of {count(rods)}"
        rows.append(
            ("random rods solved and certified", "all", share, "yes" if solved == rods else "no")
        )
    return table_of_goals(rows)
