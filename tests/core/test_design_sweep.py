# SPDX-License-Identifier: Apache-2.0
"""Sweeps: the same answers on any executor, the map's cells, the Pareto set's definition."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from types import SimpleNamespace

import numpy as np
import pytest
from core.design_cases import CATALOG, PAPER_EXAMPLE, angles, answered, designed
from core.recorded import recorded
from numpy.testing import assert_allclose

from spiral_core import Constraint, feasibility_map, pareto_set, solve_points

pytestmark = pytest.mark.long

WANTED = replace(PAPER_EXAMPLE, tubes=CATALOG[9:13])


@pytest.fixture(scope="module")
def points():
    """Return every candidate of four tubes, solved here."""
    return solve_points(WANTED, WANTED.candidates())


def costs(point):
    return point.pressure, point.strain, point.length


def test_points_come_in_order_with_their_figures(points):
    assert [point.candidate for point in points] == list(WANTED.candidates())
    design, same = designed(WANTED, tubes=CATALOG[12:13]), points[14]  # 70 degrees
    assert same.feasible
    assert same.candidate.fiber_angle_beta == design.actuator.fibers.beta
    assert costs(same) == (design.smallest.pressure, design.smallest.strain, design.length)
    # A placeholder of 0 m, +100 %, was the tightest constraint of nearly every design.
    assert Constraint.SMALLEST_RADIUS not in {point.binding.constraint for point in points}


@contextmanager
def dask_cluster():
    """Yield a local Dask cluster as an executor."""
    from distributed import Client

    with Client(
        n_workers=1, processes=False, threads_per_worker=2, dashboard_address=":0"
    ) as there:
        yield there.get_executor()


@pytest.mark.slow
# Dask's own teardown leaves closing connections to the garbage collector.
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::DeprecationWarning")
@pytest.mark.parametrize(
    "executor",
    [
        partial(ThreadPoolExecutor, 2),
        partial(ProcessPoolExecutor, 2, mp_context=get_context("spawn")),
        dask_cluster,
    ],
)
def test_any_executor_gives_the_same_answers(executor, points):
    calls = []
    with executor() as pool:
        there = solve_points(
            WANTED, WANTED.candidates()[:8], pool, lambda *call: calls.append(call)
        )
    assert there == points[:8]
    assert calls == [(number, 8) for number in range(1, 9)]


def test_map_has_the_points_in_its_cells():
    betas, radii, calls = angles(60.0, 70.0), (3.96875e-3, 4.7625e-3, 6.35e-3), []
    progress = lambda *call: calls.append(call)  # noqa: E731
    result = feasibility_map(PAPER_EXAMPLE, betas, radii, 0.79375e-3, progress=progress)
    assert calls[-1] == (6, 6)
    recorded("sweep/map", result)
    assert_allclose(result.room[1, 1], answered(PAPER_EXAMPLE).binding.relative)


def test_pareto_set_is_what_nothing_beats(points):
    """Of these four tubes, and of figures at random, where each of the three counts."""
    rows = np.random.default_rng(4).integers(1, 9, (60, 3)).tolist()
    names = "pressure", "strain", "length"
    made = [SimpleNamespace(feasible=True, **dict(zip(names, row, strict=True))) for row in rows]
    for among in (points, made):
        feasible, best = [point for point in among if point.feasible], pareto_set(among)
        figures = np.array([costs(point) for point in feasible])
        for point in feasible:
            no_worse = (figures <= costs(point)).all(axis=1)
            own = (figures == costs(point)).all(axis=1)
            assert (point in best) != (no_worse & ~own).any()
        assert 0 < len(best) <= len(feasible)
    assert pareto_set([]) == ()
