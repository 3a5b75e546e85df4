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
from spiral_core import follow_path
from spiral_core.rod._arrays import discretize
from spiral_core.rod._continuation import path_elements, settle, walk_and_refine
from spiral_core.rod.types import DEFAULT_TOLERANCE

STATIONS = 50


def warm_kernel(elements: int) -> Callable[[], None]:
    """Return a call of the warm solve's kernel alone, on arrays prepared beforehand."""
    cases = (usual_case(1.0 + WARM_CHANGE), usual_case())
    arrays = [discretize(case.rod, case.load, elements) for case in cases]
    systems = itertools.cycle([a.system for a in arrays])
    tolerance = DEFAULT_TOLERANCE * arrays[0].moment_scale
    q = usual_state(elements).orientations.copy()

    def call() -> None:
        settle(q, next(systems), tolerance)

    return call


def cold_kernel(elements: int) -> Callable[[], None]:
    """Return a call of the cold solve's kernel alone, on arrays prepared beforehand."""
    case = usual_case()
    turn = math.hypot(*case.rest_strain) * case.length
    coarse = discretize(case.rod, case.load, path_elements(elements, turn)).system
    fine = discretize(case.rod, case.load, elements)
    tolerance = DEFAULT_TOLERANCE * fine.moment_scale

    def call() -> None:
        walk_and_refine(coarse, fine.system, tolerance)

    return call


def sweep(elements: int) -> Callable[[], None]:
    """Return a call that follows the usual rod's path in 50 stations, looking for folds."""
    case = usual_case()
    fractions = np.linspace(0.0, 1.0, STATIONS + 1)[1:].tolist()
    rods = [case.scaled(fraction).rod for fraction in fractions]

    def call() -> None:
        follow_path(rods, case.load, elements=elements)

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
                "its certificate of stability; the kernel is the compiled part alone, on arrays "
                f"prepared beforehand. N = {few} is the smallest with a tip error of "
                f"{TIP_ERROR:g} L. The sweep is follow_path, which looks for folds on the way.",
            ),
        ),
        values,
    )
