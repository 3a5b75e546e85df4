# SPDX-License-Identifier: Apache-2.0
"""Times of many rods at once, on one core and on two."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np

from benchmarks.accuracy import TIP_ERROR, elements_for
from benchmarks.cases import SEED, usual_case
from benchmarks.results import Effort, Section, Table, micro, milli
from benchmarks.timing import median_time
from spiral_core import solve_rods
from spiral_core.rod.batch import RodBatch

THREADS = 2


def measure(effort: Effort) -> Section:
    """Measure a batch of the usual rod with 0.5 to 1.2 times its curvature and torsion."""
    rng = np.random.default_rng(SEED)
    case = usual_case()
    rest = np.array(case.rest_strain) * rng.uniform(0.5, 1.2, (effort.batch, 3))

    def run(elements: int, executor: ThreadPoolExecutor | None) -> RodBatch:
        return solve_rods(
            np.full(effort.batch, case.length),
            case.bending,
            case.torsional,
            rest,
            case.distributed,
            elements=elements,
            executor=executor,
        )

    rows: list[tuple[str, ...]] = []
    values: dict[str, float] = {}
    for name, elements in (("equal", elements_for(TIP_ERROR)), ("100", 100)):
        repeats = max(1, effort.long // 40)
        one = median_time(partial(run, elements, None), repeats, warmup=1)
        with ThreadPoolExecutor(THREADS) as executor:
            two = median_time(partial(run, elements, executor), repeats, warmup=1)
        stable = int(run(elements, None).stable.sum())
        values |= {f"one_{name}": one, f"two_{name}": two}
        rows.append(
            (
                str(elements),
                f"{stable} of {effort.batch}",
                milli(one),
                milli(two),
                f"{one / two:.2f}",
                micro(two / effort.batch),
            )
        )
    return Section(
        (
            Table(
                f"Batch of {effort.batch:,} cold solves (solve_rods)",
                ("N", "certified", "1 thread", "2 threads", "speed-up", "per rod"),
                tuple(rows),
            ),
        ),
        values,
    )
