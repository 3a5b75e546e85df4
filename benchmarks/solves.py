# SPDX-License-Identifier: Apache-2.0
"""Times of single solves of the usual rod: warm, cold, compiled kernel alone, and a sweep."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks.accuracy import (
    TIP_ERROR,
    elements_for,
    errors,
    usual_state,
    warm_call,
)
from benchmarks.cases import WARM_CHANGE, usual_case
from benchmarks.results import Effort, Section, Table, micro, milli
from benchmarks.timing import median_time
from spiral_core.rod._continuation import solve_uniform
from spiral_core.rod._mesh import path_count
from spiral_core.rod._profiles import uniform_rod
from spiral_core.rod.path import follow_path

STATIONS = 50


def warm_kernel(elements: int) -> Callable[[], None]:
    """Return a call of the warm solve's kernel alone."""
    cases = (usual_case(1.0 + WARM_CHANGE), usual_case())
    rods = itertools.cycle([uniform_rod(case.rod, case.load) for case in cases])
    q = usual_state(elements).orientations.copy()

    def call() -> None:
        solve_uniform(q, next(rods), 0)

    return call


def cold_kernel(elements: int) -> Callable[[], None]:
    """Return a call of the cold solve's kernel alone."""
    case = usual_case()
    turn = math.hypot(*case.rest_strain) * case.length
    few = path_count(elements, turn, case.torsional / case.bending)
    rod, q = uniform_rod(case.rod, case.load), np.empty((elements + 1, 4))

    def call() -> None:
        solve_uniform(q, rod, few)

    return call


def sweep(elements: int) -> Callable[[], None]:
    """Return a call that follows the usual rod's path in 50 stations, looking for folds."""
    case = usual_case()
    fractions = np.linspace(0.0, 1.0, STATIONS + 1)[1:].tolist()
    stations = [(case.scaled(fraction).rod, case.load) for fraction in fractions]

    def call() -> None:
        follow_path(stations, elements=elements)

    return call


def measure(effort: Effort) -> Section:
    """Measure the single solves at N = 100 and at equal accuracy."""
    few = elements_for(TIP_ERROR)
    rows: list[tuple[str, ...]] = []
    values = {"elements_equal": float(few)}
    for name, elements in (("equal", few), ("100", 100)):
        warm = median_time(warm_call(elements), effort.short)
        warm_bare = median_time(warm_kernel(elements), effort.short)
        cold = median_time(partial(usual_state, elements), effort.long)
        cold_bare = median_time(cold_kernel(elements), effort.long)
        path = median_time(sweep(elements), max(3, effort.long // 10))
        values |= {f"warm_{name}": warm, f"cold_{name}": cold, f"sweep_{name}": path}
        values |= {f"warm_kernel_{name}": warm_bare, f"cold_kernel_{name}": cold_bare}
        tip = max(errors(elements)[0], errors(elements, 1.0 + WARM_CHANGE)[0])
        rows.append(
            (
                str(elements),
                f"{tip:.1e} L",
                micro(warm),
                micro(warm_bare),
                milli(cold),
                milli(cold_bare),
                milli(path),
            )
        )
    return Section(
        (
            Table(
                "Solves of the usual rod",
                ("N", "tip error", "warm", "its kernel", "cold", "its kernel", "50-step sweep"),
                tuple(rows),
                f"Warm: from the last state, after a change of u* by {WARM_CHANGE:.0%}. Cold: the "
                "loading path from the rod without rest strain. Both through solve_rod, each with "
                "its certificate of stability; the kernel is the compiled part alone. "
                f"N = {few} is the smallest with a tip error of "
                f"{TIP_ERROR:g} L. The sweep is follow_path, which looks for folds on the way.",
            ),
        ),
        values,
    )
