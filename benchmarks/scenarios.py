# SPDX-License-Identifier: Apache-2.0
"""cosseratbench's cantilever, catenary and capstan: ``python -m benchmarks.scenarios``.

Our rod beside each of its other solvers that is installed (``make bench`` installs them).
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec

import numpy as np
from cosseratbench.experiment import Result, run
from cosseratbench.registry import load_experiment, load_solver
from cosseratbench.scenario import Scenario

from benchmarks.command import wide_console
from benchmarks.hanging_cable import hanging_cable
from benchmarks.report import show
from benchmarks.results import Table, milli
from benchmarks.timing import median_time
from spiral_gripper.interop.cosseratbench import SpiralSolver

# What each peer's adapter needs.
LIBRARIES = {"pyelastica": "elastica", "mujoco": "mujoco"}
# Only the fast peer sweeps the variants; the other takes minutes for one of them.
SWEEPING = "pyelastica"
# The metric that judges, its unit, and how it is varied, one value at a time as cosseratbench does.
METRICS = {"cantilever": "tip_deflection_error", "catenary": "shape_error", "capstan": "slide"}
REPEATS = 30


@dataclass(frozen=True, slots=True)
class Variant:
    """One scenario, and what it changes."""

    experiment: str
    change: tuple[str, float] | None = None

    @property
    def values(self) -> dict[str, float]:
        """The changed value, by name."""
        return dict([self.change]) if self.change else {}

    @property
    def label(self) -> str:
        """The changed value, as text."""
        return "{} {:g}".format(*self.change) if self.change else "default"


def variants() -> list[Variant]:
    """Return the ordinary case of each experiment and every single change that it declares."""
    found = []
    for name in METRICS:
        found.append(Variant(name))
        for parameter in load_experiment(name).parameters:
            changed = (value for value in parameter.values if value != parameter.default)
            found += [Variant(name, (parameter.name, value)) for value in changed]
    return found


def exact_distance(result: Result, scenario: Scenario) -> float:
    """Return a cable's largest distance from the exact elastica with its EI, in lengths."""
    (rod,) = scenario.rods
    if result.trajectory is None:
        return math.nan
    nodes = result.trajectory.positions[0][-1]
    exact = hanging_cable(
        axial=rod.material.youngs_modulus * rod.area,
        bending=rod.material.youngs_modulus * rod.second_moment_of_area,
        weight=rod.material.density * rod.area * float(np.linalg.norm(scenario.gravity)),
        length=rod.length,
        span=rod.centerline[-1][0] - rod.centerline[0][0],
        count=len(nodes) - 1,
    )
    return float(np.linalg.norm(nodes - exact, axis=1).max()) / rod.length


def outcome(result: Result, metric: str) -> str:
    """Return a result's metric as text, or why there is none."""
    value = result.metrics.get(metric, math.nan)
    return f"{value:.1e}" if math.isfinite(value) else result.outcome


def posed(variant: Variant) -> Scenario:
    """Return the scenario of a variant."""
    return load_experiment(variant.experiment).scenario_for(**variant.values)


def score(variant: Variant, peers: list[str]) -> dict[str, Result]:
    """Return the results of ours and of the peers that take part in this variant."""
    experiment = load_experiment(variant.experiment)
    results = {"spiral": run(experiment, SpiralSolver(), values=variant.values)}
    for peer in peers:
        if not variant.values or peer == SWEEPING:
            results[peer] = run(experiment, load_solver(peer), values=variant.values)
    return results


def scores_table(scores: dict[Variant, dict[str, Result]], peers: list[str]) -> Table:
    """Return each variant's metric, and for the cables the distance from the exact elastica."""
    rows = []
    for variant, results in scores.items():
        metric = METRICS[variant.experiment]
        known = [outcome(results[n], metric) if n in results else "" for n in ("spiral", *peers)]
        exact = [
            f"{exact_distance(results[name], posed(variant)):.1e}"
            if variant.experiment == "catenary" and name in results
            else ""
            for name in ("spiral", SWEEPING)
        ]
        rows.append((variant.experiment, variant.label, *known, *exact))
    return Table(
        "cosseratbench: cantilever, catenary, capstan",
        ("experiment", "variant", "spiral", *peers, "spiral, exact", f"{SWEEPING}, exact"),
        tuple(rows),
        "Cantilever: relative error of the tip's deflection, of which 4.1e-4 is the reference's, "
        "which is linear. Catenary: largest distance of a node from the curve without bending "
        "stiffness, in lengths; exact: from the same material point of the exact elastica, with "
        "it. Capstan: how far the rope slides, in meters; below an overhang of 1 it should not.",
    )


def times_table(scores: dict[Variant, dict[str, Result]], peers: list[str]) -> Table:
    """Return the times of the ordinary cases, and each peer's over ours."""
    rows: list[tuple[str, ...]] = []
    for name in METRICS:
        experiment = load_experiment(name)
        call = partial(
            SpiralSolver().run,
            experiment.scenario,
            n_elements=experiment.n_elements,
            n_frames=experiment.n_frames,
        )
        ours = median_time(call, REPEATS, warmup=1)
        cells = [name, str(experiment.n_elements), milli(ours)]
        for peer in peers:
            theirs = scores[Variant(name)][peer].wall_time
            if theirs is None:
                cells += ["failed", ""]
                continue
            cells += [f"{theirs:.2f} s", f"{theirs / ours:,.0f} ×"]
        rows.append(tuple(cells))
    columns = [column for peer in peers for column in (peer, "/ ours")]
    title = "cosseratbench: wall times of the ordinary cases"
    return Table(title, ("experiment", "elements", "spiral", *columns), tuple(rows))


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scenarios", description=__doc__)
    parser.add_argument("--peers", nargs="*", default=list(LIBRARIES), choices=list(LIBRARIES))
    peers = [name for name in parser.parse_args().peers if find_spec(LIBRARIES[name])]
    scores = {variant: score(variant, peers) for variant in variants()}
    console = wide_console()
    show(scores_table(scores, peers), console)
    show(times_table(scores, peers), console)


if __name__ == "__main__":
    main()
