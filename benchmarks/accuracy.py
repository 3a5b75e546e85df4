# SPDX-License-Identifier: Apache-2.0
"""Error and cost against the number of elements N, and the N that an error needs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np

from benchmarks.cases import WARM_CHANGE, usual_case
from benchmarks.reference import Reference, shoot
from benchmarks.results import Effort, Section, Table, micro
from benchmarks.timing import median_time
from spiral_core import RodState, solve_rod

# Equal accuracy: the tip is wrong by at most this fraction of the length.
TIP_ERROR = 1e-5
REFERENCE_SITES = 480
COUNTS = (10, 15, 20, 30, 40, 60, 80, 120, 160, 240)
LONG_COUNTS = (25, 50, 100, 200, 400, 800, 1600)
# The error follows its order only between too few elements and rounding.
ORDER_COUNTS = (40, 160)


@lru_cache
def usual_reference(fraction: float = 1.0) -> Reference:
    """Return the exact shape of the usual rod with its rest strain scaled."""
    case = usual_case(fraction)
    return shoot(case, solve_rod(case.rod, case.load, elements=100), REFERENCE_SITES)


def usual_state(elements: int, fraction: float = 1.0, start: RodState | None = None) -> RodState:
    """Return the usual rod's state through the public interface."""
    case = usual_case(fraction)
    return solve_rod(case.rod, case.load, elements=elements, start=start, estimate_error=False)


def errors(elements: int, fraction: float = 1.0) -> tuple[float, float]:
    """Return the tip's error and the largest one of a node, as fractions of the length.

    Nodes are compared only where ``elements`` divides the reference's sites.
    """
    state, reference = usual_state(elements, fraction), usual_reference(fraction)
    stride = REFERENCE_SITES // elements
    nodes = slice(None) if stride * elements == REFERENCE_SITES else slice(-1, None)
    sites = slice(None, None, stride) if nodes == slice(None) else slice(-1, None)
    off = np.linalg.norm(state.positions[nodes] - reference.positions[sites], axis=1)
    off /= usual_case().length
    return float(off[-1]), float(off.max())


@lru_cache
def elements_for(error: float) -> int:
    """Return the fewest elements whose tip error, warm and cold, is at most ``error`` x L."""
    for elements in itertools.count(6, 2):
        if all(errors(elements, f)[0] <= error for f in (1.0, 1.0 + WARM_CHANGE)):
            return elements
    raise AssertionError("unreachable")


def warm_call(elements: int) -> Callable[[], None]:
    """Return a call that solves the usual rod from its last state, to and fro by 1 % of u*."""
    cases = itertools.cycle((usual_case(1.0 + WARM_CHANGE), usual_case()))
    last = usual_state(elements)

    def call() -> None:
        nonlocal last
        case = next(cases)
        last = solve_rod(case.rod, case.load, elements=elements, start=last, estimate_error=False)

    return call


def order(finest: float, coarsest: float, counts: tuple[int, int]) -> float:
    """Return the observed order of convergence between two numbers of elements."""
    return math.log(coarsest / finest) / math.log(counts[1] / counts[0])


def measure(effort: Effort) -> Section:
    """Measure error and cost against N."""
    rows: list[tuple[str, ...]] = []
    values: dict[str, float] = {}
    for elements in COUNTS:
        tip, shape = errors(elements)
        values[f"tip_error_{elements}"], values[f"shape_error_{elements}"] = tip, shape
        rows.append((str(elements), f"{tip:.1e}", f"{shape:.1e}"))
    coarse, fine = ORDER_COUNTS
    for what in ("tip", "shape"):
        values[f"order_{what}"] = order(
            values[f"{what}_error_{fine}"], values[f"{what}_error_{coarse}"], ORDER_COUNTS
        )
    costs = []
    for elements in LONG_COUNTS:
        repeats = max(3, effort.long * 100 // (100 + elements))
        warm = median_time(warm_call(elements), repeats)
        cold = median_time(partial(usual_state, elements), repeats)
        values[f"warm_{elements}"], values[f"cold_{elements}"] = warm, cold
        costs.append((str(elements), micro(warm), micro(cold), micro(warm / elements)))
    growth = [
        order(values[f"{kind}_100"], values[f"{kind}_1600"], (100, 1600))
        for kind in ("warm", "cold")
    ]
    values["growth_warm"], values["growth_cold"] = growth
    return Section(
        (
            Table(
                "Error against the number of elements N (usual rod, fractions of its length)",
                ("N", "tip", "worst node"),
                tuple(rows),
                f"Observed order from N = {coarse} to {fine}: {values['order_tip']:.2f} (tip), "
                f"{values['order_shape']:.2f} (worst node). Reference: shooting from the tip "
                "with DOP853, rtol 1e-12.",
            ),
            Table(
                "Cost against the number of elements N (usual rod, public interface)",
                ("N", "warm", "cold", "warm, per element"),
                tuple(costs),
                f"From N = 100 to 1600 the time grows as N^{growth[0]:.2f} (warm) and "
                f"N^{growth[1]:.2f} (cold).",
            ),
        ),
        values,
    )
