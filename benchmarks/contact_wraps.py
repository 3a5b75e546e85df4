# SPDX-License-Identifier: Apache-2.0
"""Random rods closing on random cylinders: solved and certified, or a reason; never silently wrong.

python -m benchmarks.contact_wraps [FIRST] [LAST]    (2,000 by default: more than an hour)
"""

from __future__ import annotations

import math
import sys
import time
from collections import Counter

import numpy as np

from spiral_core import (
    ContactProblem,
    ContactState,
    Cylinder,
    ElasticRod,
    Obstacle,
    RodLoad,
    Section,
    solve_contact,
)

COUNT = 2000
DENSITY, GRAVITY = 950.0, 9.81
# Of the rod's radius, and of the forces.
PENETRATION, IMBALANCE = 1e-3, 1e-6


def random_wrap(seed: int) -> ContactProblem:
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
    section = Section((2.0 / 3.0 * bending, bending, bending))
    obstacle = Obstacle.along(Cylinder(radius), (*place.tolist(),), (*axis.tolist(),), friction)
    return ContactProblem(
        ElasticRod(length, section, outer, (torsion, 0.0, curvature)),
        RodLoad(distributed=(*down.tolist(),)),
        obstacles=(obstacle,),
    )


def verdict(problem: ContactProblem, state: ContactState) -> str:
    """Return the status of a state, or what is wrong with one that claims to be an answer."""
    if not state.stable:
        return state.status.name
    weight = np.asarray(problem.load.distributed) * problem.rod.length
    total = state.base_reaction[:3] + state.contact_forces.sum(axis=(0, 1)) + weight
    scale = max(float(np.linalg.norm(weight)), float(state.normal_forces.sum()), 1e-6)
    if np.abs(total).max() > IMBALANCE * scale:
        return "WRONG: forces do not balance"
    if state.gaps.min() < -PENETRATION * problem.rod.radius:
        return "WRONG: penetrates"
    return "CONVERGED, touching" if state.contact_lengths[0] > 0.0 else "CONVERGED, clear"


def main() -> None:
    """Solve the sample and print how it went."""
    first, last = (int(a) for a in (sys.argv[1:3] if len(sys.argv) > 2 else (0, COUNT)))
    found: Counter[str] = Counter()
    times, iterations = [], []
    for seed in range(first, last):
        problem = random_wrap(seed)
        begin = time.process_time()
        state = solve_contact(problem, throw=False)
        times.append(time.process_time() - begin)
        iterations.append(state.iterations)
        found[verdict(problem, state)] += 1
    for name, count in found.most_common():
        print(f"{count:6d}  {name}")
    for name, values in (("CPU time [s]", times), ("iterations", iterations)):
        median, high, most = np.quantile(values, (0.5, 0.99, 1.0))
        print(f"{name}: median {median:.3g}, 99th percentile {high:.3g}, most {most:.3g}")


if __name__ == "__main__":
    main()
