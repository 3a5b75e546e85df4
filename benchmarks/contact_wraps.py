# SPDX-License-Identifier: Apache-2.0
"""Random rods closing on random cylinders: certified, or a reason; never wrong without a word.

From the straight rod beside its cylinder, in one call of ``solve_contact``, without a path.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from typing import NamedTuple

import numpy as np

from benchmarks.results import Effort, Section, Table, milli
from benchmarks.sample import solve_all, spread
from spiral_core import Cylinder, Obstacle, Rod, RodLoad, RodProblem, RodState
from spiral_core import (
    Section as Stiffness,
)
from spiral_core.rod.contact.solve import solve_contact

DENSITY, GRAVITY = 950.0, 9.81
# Of the rod's radius, and of the forces.
PENETRATION, IMBALANCE = 1e-3, 1e-6


def random_wrap(seed: int) -> RodProblem:
    """Return a tube beside a cylinder whose coil is up to 1.6 times as tight as it."""
    random = np.random.default_rng(seed)
    length, young = random.uniform(0.15, 0.6), random.uniform(0.5e6, 3e6)
    inner = random.uniform(3e-3, 7e-3)
    outer = 1.17 * inner
    bending = 0.25 * math.pi * young * (outer**4 - inner**4)
    radius = random.uniform(8e-3, 35e-3)
    curvature = min(60.0, random.uniform(1.0, 1.6) / (radius + outer))
    torsion = curvature * random.uniform(-0.9, 0.9)
    down = random.normal(size=3)
    down *= DENSITY * GRAVITY * math.pi * (outer**2 - inner**2) / np.linalg.norm(down)
    down *= random.choice([0.0, 1.0, 1.0])
    axis = np.array((torsion, 0.0, curvature)) / math.hypot(torsion, curvature)
    axis += random.normal(size=3) * random.choice([0.0, 0.05, 0.2])
    place = np.array((0.0, radius + outer + random.uniform(0.0, 0.5) * radius, 0.0))
    place += axis * random.uniform(-0.05, 0.05)
    friction = float(random.choice([0.0, 0.0, 0.1, 0.3, 0.6]))
    section = Stiffness((2.0 / 3.0 * bending, bending, bending))
    obstacle = Obstacle.along(Cylinder(radius), (*place.tolist(),), (*axis.tolist(),), friction)
    return RodProblem(
        Rod(length, section, outer, (torsion, 0.0, curvature)),
        RodLoad(distributed=(*down.tolist(),)),
        obstacles=(obstacle,),
    )


def verdict(problem: RodProblem, state: RodState) -> str:
    """Return the status of a state, or what is wrong with one that claims to be an answer."""
    if not state.stable:
        return state.status.name
    weight = np.asarray(problem.load.distributed) * problem.rod.length
    total = state.base_reaction[:3] + state.contact_forces.sum(axis=(0, 1)) + weight
    scale = max(float(np.linalg.norm(weight)), float(state.normal_forces.sum()), 1e-6)
    if np.abs(total).max() > IMBALANCE * scale:
        return "WRONG: forces do not balance"
    # The base is held where it is drawn, a little in the cylinder or not: nothing pushes it out.
    if state.gaps[:, 1:].min() < -PENETRATION * problem.rod.radius:
        return "WRONG: penetrates"
    return "CONVERGED, touching" if state.contact_lengths[0] > 0.0 else "CONVERGED, clear"


class Outcome(NamedTuple):
    """How one rod of the sample went; time in seconds."""

    seed: int
    verdict: str
    iterations: int
    time: float


def wrap_one(seed: int) -> Outcome:
    """Solve one of the sample, and judge it."""
    problem = random_wrap(seed)
    begin = time.process_time()
    state = solve_contact(problem, throw=False)
    spent = time.process_time() - begin
    return Outcome(seed, verdict(problem, state), state.iterations, spent)


def measure(effort: Effort) -> Section:
    """Measure the robustness of the contact solver."""
    outcomes = solve_all(wrap_one, effort.contacts)
    kinds = Counter(outcome.verdict for outcome in outcomes)
    solved = sum(count for name, count in kinds.items() if name.startswith("CONVERGED"))
    wrong = sum(count for name, count in kinds.items() if name.startswith("WRONG"))
    times = np.array([outcome.time for outcome in outcomes])
    iterations = np.array([outcome.iterations for outcome in outcomes])
    first = {outcome.verdict: outcome.seed for outcome in reversed(outcomes)}
    rows = [(name, f"{count:,}") for name, count in kinds.most_common()]
    rows += [
        ("Newton passes", spread(iterations, "{:.0f}".format)),
        ("processor time", spread(times, milli)),
    ]
    table = Table(
        f"Robustness of contact: {len(outcomes):,} random rods close on random cylinders",
        ("what", "rods, or median / 99th percentile / most"),
        tuple(rows),
        "From the straight rod, in one call. Tubes of 3 to 7 mm and 0.15 to 0.6 m, cylinders of 8 "
        "to 35 mm with the axis of the free coil or up to some 20° from it, friction 0 to 0.6, any "
        "gravity or none. Converged: certified, in balance to 1e-6 and penetrating by less than "
        "1e-3 of the radius (but for the held base), from contact forces and positions. Other "
        "names are statuses: "
        "the rod touches itself, or slides and is lost. First of each: "
        + ", ".join(f"{seed} {name}" for name, seed in first.items())
        + ".",
    )
    values = {
        "rods": len(outcomes),
        "solved": solved,
        "wrong": wrong,
        "time_median": float(np.median(times)),
        "iterations_median": float(np.median(iterations)),
    }
    return Section((table,), {name: float(value) for name, value in values.items()})
