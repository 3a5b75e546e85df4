# SPDX-License-Identifier: Apache-2.0
"""Random rods: how many are solved and certified, in how many iterations, how slowly at worst."""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np

from benchmarks import collocation
from benchmarks.cases import random_case
from benchmarks.results import Effort, Section, Table, milli
from benchmarks.sample import solve_all, spread
from spiral_core import RodState, solve_rod

CHUNK = 100
# Two tips are the same equilibrium's within this fraction of the length: solve_bvp is not exact.
SAME_TIP = 1e-2
COLLOCATION_TOLERANCE = 1e-3
COLLOCATION_NODES = 50
RAMP_STEPS = 10


class Outcome(NamedTuple):
    """How one rod of the sample went; time in seconds."""

    rod: int
    status: str
    stable: bool
    iterations: int
    folds: int
    elements: int
    smallest_pivot: float
    time: float


def solve_one(index: int) -> Outcome:
    """Solve one rod cold, with the number of elements that the solver itself chooses."""
    case = random_case(index)
    begin = time.perf_counter()
    state = solve_rod(case.rod, case.load, estimate_error=False, throw=False)
    spent = time.perf_counter() - begin
    return Outcome(
        index,
        state.status.name,
        state.stable,
        state.iterations,
        state.folds,
        len(state.arc_lengths) - 1,
        state.smallest_pivot,
        spent,
    )


def sample_table(outcomes: list[Outcome]) -> tuple[Table, dict[str, float]]:
    """Return the table and the figures of the sample."""
    iterations = np.array([o.iterations for o in outcomes])
    times = np.array([o.time for o in outcomes])
    smooth = np.array([o.folds == 0 for o in outcomes])
    bad = [o for o in outcomes if not o.stable]
    slowest = max(outcomes, key=lambda o: o.time)
    good = len(outcomes) - len(bad)
    rows = (
        ("solved and certified", f"{good:,} of {len(outcomes):,}"),
        ("Newton iterations", spread(iterations, "{:.0f}".format)),
        ("... where nothing snapped", spread(iterations[smooth], "{:.0f}".format)),
        ("time of a cold solve", spread(times, milli)),
        ("... where nothing snapped", spread(times[smooth], milli)),
        ("elements chosen", spread(np.array([o.elements for o in outcomes]), "{:.0f}".format)),
        ("snapped on the loading path", f"{int((~smooth).sum()):,}"),
        ("smallest pivot of all", f"{min(o.smallest_pivot for o in outcomes):.1e} EI/L"),
        ("slowest", f"rod {slowest.rod}: {slowest.folds} folds, {milli(slowest.time)}"),
    )
    failures = "; ".join(f"rod {o.rod}: {o.status}" for o in bad[:20])
    note = (
        "L 0.1 to 1 m, E 0.5 to 3 MPa, κ 3 to 60 /m, |τ| up to 0.95 κ, every direction of gravity, "
        "tip forces up to the rod's weight in every direction; two processes at a time."
    )
    values = {
        "solved": float(good),
        "rods": float(len(outcomes)),
        "iterations_median": float(np.median(iterations)),
        "iterations_max": float(iterations.max()),
        "time_median": float(np.median(times)),
        "time_max": float(times.max()),
        "snapped": float((~smooth).sum()),
    }
    title = f"Robustness: {len(outcomes):,} random rods, cold"
    columns = ("what", "median / 99th percentile / most")
    return Table(title, columns, rows, f"{note} {failures}".strip()), values


def collocate(index: int, ramped: bool) -> tuple[bool, bool, float]:
    """Return whether solve_bvp succeeds, whether its tip is ours, and its time [s]."""
    case = random_case(index)
    ours: RodState = solve_rod(case.rod, case.load)
    begin = time.perf_counter()
    if ramped:
        found = collocation.ramp(case, RAMP_STEPS, COLLOCATION_NODES, COLLOCATION_TOLERANCE)
    else:
        guess = collocation.helix_guess(case, COLLOCATION_NODES)
        found = collocation.solve(case, guess, COLLOCATION_TOLERANCE)
    spent = time.perf_counter() - begin
    off = float(np.linalg.norm(found.tip - ours.tip_position)) / case.length
    return found.success, found.success and off <= SAME_TIP, spent


def collocation_table(count: int) -> tuple[Table, dict[str, float]]:
    """Return how solve_bvp does on the first rods of the sample."""
    rows: list[tuple[str, ...]] = []
    values: dict[str, float] = {}
    for name, ramped in (("from the unloaded helix", False), (f"{RAMP_STEPS}-step ramp", True)):
        with np.errstate(all="ignore"):
            results = [collocate(index, ramped) for index in range(count)]
        success, same = (sum(r[i] for r in results) for i in (0, 1))
        times = np.array([r[2] for r in results])
        key = "ramp" if ramped else "helix"
        values |= {f"bvp_{key}_success": success, f"bvp_{key}_same": same, "bvp_rods": count}
        rows.append((name, f"{success} of {count}", f"{same} of {count}", spread(times, milli)))
    return Table(
        f"solve_bvp on the first {count} of them",
        ("start", "reports success", "on the loading path's branch", "time"),
        tuple(rows),
        f"tol {COLLOCATION_TOLERANCE:g}, at most 2,000 nodes, analytic Jacobian. The same branch: "
        f"its tip is within {SAME_TIP:.0%} of the length from ours. solve_bvp cannot tell a stable "
        "equilibrium from an unstable one.",
    ), {name: float(value) for name, value in values.items()}


def measure(effort: Effort) -> Section:
    """Measure the whole sample, and solve_bvp on a part of it."""
    sample, values = sample_table(solve_all(solve_one, effort.rods, CHUNK))
    peer, more = collocation_table(effort.collocation_rods)
    return Section((sample, peer), values | more)
