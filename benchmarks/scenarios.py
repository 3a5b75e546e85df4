# SPDX-License-Identifier: Apache-2.0
"""cosseratbench's cantilever, catenary and capstan, by our rod and by its other solvers."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec

import numpy as np
from cosseratbench.experiment import Experiment, Result, run
from cosseratbench.registry import load_experiment, load_solver
from cosseratbench.scenario import Material, Scenario

from benchmarks.cosserat_adapter import SpiralSolver
from benchmarks.hanging_cable import hanging_cable
from benchmarks.results import Effort, Section, Table, milli
from benchmarks.timing import median_time

# What each peer's adapter needs.
LIBRARIES = {"pyelastica": "elastica", "mujoco": "mujoco"}
# Only the fast peer sweeps the variants; the other takes minutes for one of them.
SWEEPING = "pyelastica"
# The metric that judges, its unit, and how it is varied, one value at a time as cosseratbench does.
METRICS = {"cantilever": "tip_deflection_error", "catenary": "shape_error", "capstan": "slide"}
# A rod with this fraction of the radius and the same EA and weight: its EI is 1e4 times smaller.
THIN = 0.01


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


def thin(experiment: Experiment) -> Experiment:
    """Return an experiment with a rod that stretches and weighs as it does but hardly resists."""

    def build(**values: float) -> Scenario:
        scenario = experiment.build(**values)
        (rod,) = scenario.rods
        stiffer = 1.0 / THIN**2
        old = rod.material
        material = Material(
            stiffer * old.youngs_modulus, stiffer * old.shear_modulus, stiffer * old.density
        )
        return replace(scenario, rods=(replace(rod, radius=THIN * rod.radius, material=material),))

    return replace(experiment, build=build)


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
        "it. Capstan: how far the rope slides [m]; below an overhang of 1 it should not; "
        "its start has no bending stiffness, and the rope settles by 1e-5 m or so.",
    )


def times_table(
    scores: dict[Variant, dict[str, Result]], peers: list[str], repeats: int
) -> tuple[Table, dict[str, float]]:
    """Return the times of the ordinary cases, and each peer's over ours."""
    rows: list[tuple[str, ...]] = []
    values: dict[str, float] = {}
    for name in METRICS:
        experiment = load_experiment(name)
        call = partial(
            SpiralSolver().run,
            experiment.scenario,
            n_elements=experiment.n_elements,
            n_frames=experiment.n_frames,
        )
        ours = values[f"{name}_time"] = median_time(call, repeats, warmup=1)
        cells = [name, str(experiment.n_elements), milli(ours)]
        for peer in peers:
            theirs = scores[Variant(name)][peer].wall_time
            if theirs is None:
                cells += ["failed", ""]
                continue
            values |= {f"{name}_{peer}": theirs, f"{name}_{peer}_ratio": theirs / ours}
            cells += [f"{theirs:.2f} s", f"{theirs / ours:,.0f} ×"]
        rows.append(tuple(cells))
    columns = [column for peer in peers for column in (peer, "/ ours")]
    title = "cosseratbench: wall times of the ordinary cases"
    return Table(title, ("experiment", "elements", "spiral", *columns), tuple(rows)), values


def goal_values(scores: dict[Variant, dict[str, Result]]) -> dict[str, float]:
    """Return the figures that goals are set for."""
    ours = {v: r["spiral"].metrics.get(METRICS[v.experiment], math.nan) for v, r in scores.items()}
    hanging = [v for v in scores if v.experiment == "catenary"]
    overhang = {v: dict(v.values).get("overhang", 0.8) for v in scores if v.experiment == "capstan"}

    def thinned(variant: Variant) -> float:
        flexible = thin(load_experiment(variant.experiment))
        metrics = run(flexible, SpiralSolver(), values=variant.values).metrics
        return metrics.get(METRICS[variant.experiment], math.nan)

    held = [v for v, fraction in overhang.items() if fraction < 1.0]
    # NaN where one of them has no answer: no goal is met with it.
    values = {
        "cantilever_error": ours[Variant("cantilever")],
        "catenary_exact": np.max([exact_distance(scores[v]["spiral"], posed(v)) for v in hanging]),
        "catenary_flexible": np.max([thinned(v) for v in hanging]),
        "capstan_held": np.max([ours[v] for v in held]),
        "capstan_held_flexible": np.max([thinned(v) for v in held]),
        "capstan_sliding": np.min([ours[v] for v, fraction in overhang.items() if fraction > 1.0]),
    }
    if all(SWEEPING in scores[v] for v in hanging):
        values["catenary_ahead"] = float(
            sum(ours[v] < scores[v][SWEEPING].metrics["shape_error"] for v in hanging)
        )
    return {name: float(value) for name, value in values.items()}


def measure(effort: Effort) -> Section:
    """Measure ours on every variant, peers on some, and times of the ordinary cases."""
    peers = [name for name in effort.peers if find_spec(LIBRARIES[name])]
    scores = {variant: score(variant, peers) for variant in variants()}
    table, values = times_table(scores, peers, max(1, effort.long // 10))
    missing = [name for name in effort.peers if name not in peers]
    if missing:
        table = replace(table, note=f"Not installed: {', '.join(missing)}.")
    return Section((scores_table(scores, peers), table), values | goal_values(scores))
