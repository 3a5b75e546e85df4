# SPDX-License-Identifier: Apache-2.0
"""The usual rod by scipy's solve_bvp and by PyElastica, against ours at equal accuracy."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks import collocation, dynamics
from benchmarks.accuracy import TIP_ERROR, elements_for, usual_reference, usual_state, warm_call
from benchmarks.cases import WARM_CHANGE, Case, usual_case
from benchmarks.collocation import Collocation
from benchmarks.results import Effort, Section, Table, micro, milli, three_digits
from benchmarks.timing import median_time

NODES = (12, 16, 24, 32, 48, 64)
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
# PyElastica is near where its tip is within this fraction of the length.
NEAR = 5e-3
# Found by trying: 15 elements never come near, a time step of 2.5e-4 s diverges, and a damping of
# 10 or 20 /s is slower than 15 /s.
TUNED = dynamics.Settings(elements=18, time_step=2.2e-4, damping=15.0)
# 100 elements never come near; 0.01 s/m of an element's length is half of what diverges above.
PLAIN = dynamics.Settings(elements=150, time_step=2.4e-5, damping=15.0, exact_clamp=False)

BvpSolve = Callable[[Case, Collocation, float], Collocation]


@dataclass(frozen=True, slots=True)
class BvpTime:
    """The fastest settings whose tip is right, and their time [s]."""

    time: float
    nodes: int
    tolerance: float


def fastest(solve: BvpSolve, warm: bool, effort: Effort, nodes: tuple[int, ...] = NODES) -> BvpTime:
    """Return the fastest settings of solve_bvp with a tip error of at most 1e-5 L.

    Warm: the guess is the solution, with its mesh, at a rest strain 1 % smaller. Cold: the unloaded
    helix.
    """
    case = usual_case(1.0 + WARM_CHANGE) if warm else usual_case()
    tip = usual_reference(1.0 + WARM_CHANGE if warm else 1.0).tip
    found = []
    for count, tolerance in itertools.product(nodes, TOLERANCES):
        guess = collocation.helix_guess(case, count)
        if warm:
            before = usual_case()
            guess = solve(before, collocation.helix_guess(before, count), tolerance)
        result = solve(case, guess, tolerance)
        if result.success and np.linalg.norm(result.tip - tip) <= TIP_ERROR * case.length:
            call = _call(solve, case, guess, tolerance)
            found.append((median_time(call, max(1, effort.long // 60), 1), count, tolerance, call))
    _, count, tolerance, call = min(found, key=lambda item: item[0])
    return BvpTime(median_time(call, max(3, effort.long // 5), 1), count, tolerance)


def _call(
    solve: BvpSolve, case: Case, guess: Collocation, tolerance: float
) -> Callable[[], object]:
    """Return a call of a solve."""
    return lambda: solve(case, guess, tolerance)


def collocation_section(effort: Effort, nodes: tuple[int, ...] = NODES) -> Section:
    """Measure solve_bvp as one writes it, and with everything that makes it fast."""
    few = elements_for(TIP_ERROR)
    rows: list[tuple[str, ...]] = []
    values: dict[str, float] = {}
    for name, label, solve in (
        ("plain", "textbook equations", collocation.solve_plainly),
        ("best", "at its best", collocation.solve),
    ):
        for warm in (False, True):
            kind = "warm" if warm else "cold"
            repeats = effort.short if warm else effort.long
            bvp = fastest(solve, warm, effort, nodes)
            own = median_time(warm_call(few) if warm else lambda: usual_state(few), repeats)
            ratio = bvp.time / own
            values |= {f"bvp_{name}_{kind}": bvp.time, f"bvp_{name}_{kind}_ratio": ratio}
            rows.append(
                (
                    f"{label}, {kind}",
                    milli(bvp.time),
                    f"{bvp.nodes}, {bvp.tolerance:g}",
                    micro(own),
                    f"{three_digits(ratio)} ×",
                )
            )
    table = Table(
        f"scipy.integrate.solve_bvp on the usual rod, tip error of both at most {TIP_ERROR:g} L",
        ("solve_bvp", "time", "first nodes, tol", f"ours, N = {few}", "ratio"),
        tuple(rows),
        "Textbook equations: position, quaternion, force and moment (13 unknowns), vectorized. At "
        "its best: 7 unknowns and analytic Jacobians. Both with the fastest of "
        f"{len(nodes) * len(TOLERANCES)} settings that meet the error. Cold: from the unloaded "
        "helix; ours from the rod without rest strain, along the loading path, with certificate.",
    )
    return Section((table,), values)


def dynamics_section(effort: Effort) -> Section:
    """Measure PyElastica relaxing the usual rod, tuned and plain; empty if it is not installed."""
    title = "PyElastica on the usual rod, released as its unloaded helix"
    if not dynamics.available():
        note = "Skipped: PyElastica is not installed (pip install 'pyelastica>=1.0,<2')."
        return Section((Table(title, (), (), note),))
    case, reference = usual_case(), usual_reference()
    elements = elements_for(NEAR)
    own = {
        "equal": median_time(lambda: usual_state(elements), effort.long),
        "100": median_time(lambda: usual_state(100), effort.long),
    }
    dynamics.relax(case, reference.base_strain, reference.tip, TUNED, 0.01, NEAR)  # compile
    rows: list[tuple[str, ...]] = []
    values = {"elements_near": float(elements)}
    for name, label, settings in (("tuned", "tuned", TUNED), ("plain", "plain", PLAIN)):
        run = dynamics.relax(
            case, reference.base_strain, reference.tip, settings, effort.simulated, NEAR
        )
        for when, seconds in (("near", run.near), ("rest", run.rest)):
            values[f"elastica_{name}_{when}"] = seconds
            for accuracy, mine in own.items():
                values[f"elastica_{name}_{when}_ratio_{accuracy}"] = seconds / mine
        rows.append(
            (
                label,
                str(settings.elements),
                f"{settings.time_step:g} s",
                f"{run.error:.2%}",
                _seconds(run.near),
                _ratio(run.near / own["equal"]),
                _seconds(run.rest),
                _ratio(run.rest / own["equal"]),
                _ratio(run.rest / own["100"]),
            )
        )
    columns = ("settings", "elements", "time step", "tip error", f"to {NEAR:.1%} L", "/ ours")
    table = Table(
        title,
        (*columns, "to rest", "/ ours", "/ ours, N = 100"),
        tuple(rows),
        "Wall time of its steps alone, compiled beforehand, until the tip is near for good, and "
        f"until, besides, no node is faster than {dynamics.REST_SPEED:g} L/s. Tuned: elements, "
        "time step and damping for this very rod, and its clamp (which holds the middle of the "
        "first element) turned by the exact solution; plain: without knowing the answer, the same "
        f"error takes more elements. Ours: a cold solve with certificate, N = {elements} (tip "
        f"error at most 0.5 % L, {micro(own['equal'])}) or N = 100 ({micro(own['100'])}).",
    )
    return Section((table,), values)


def _seconds(value: float) -> str:
    """Return a time in seconds as text."""
    return "never" if math.isnan(value) else f"{value:.3f} s"


def _ratio(value: float) -> str:
    """Return a ratio as text."""
    return "never" if math.isnan(value) else f"{value:,.0f} ×"
