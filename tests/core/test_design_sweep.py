# SPDX-License-Identifier: Apache-2.0
"""Sweeps: the same answers on any executor, the map's cells, the Pareto set's definition."""

import math
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from multiprocessing import get_context

import pytest
from core.design_cases import CATALOG, PAPER_EXAMPLE, angles, answered, designed

from spiral_core import (
    Constraint,
    InvalidInputError,
    feasibility_map,
    pareto_set,
    solve_points,
)

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
    design = designed(replace(WANTED, tubes=CATALOG[12:13]))
    same = points[14]  # 70 degrees
    assert same.candidate.fiber_angle_beta == design.actuator.fibers.beta
    assert same.feasible
    assert costs(same) == (design.smallest.pressure, design.smallest.strain, design.length)
    for point in points:
        # A placeholder of 0 m, +100 %, was the tightest constraint of nearly every design.
        assert point.binding.constraint is not Constraint.SMALLEST_RADIUS
        bounds = {margin.constraint: margin.value for margin in point.margins}
        assert bounds.get(Constraint.SMALLEST_RADIUS, 1.0) > 0.0


@contextmanager
def dask_cluster():
    """Yield a local Dask cluster as an executor."""
    from distributed import Client, LocalCluster

    local = partial(LocalCluster, n_workers=1, processes=False, dashboard_address=None)
    with local(threads_per_worker=2) as cluster, Client(cluster) as client:
        yield client.get_executor()


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
    ids=["threads", "processes", "dask"],
)
def test_any_executor_gives_the_same_answers(executor, points):
    calls = []
    with executor() as pool:
        progress = lambda *call: calls.append(call)  # noqa: E731
        there = solve_points(WANTED, WANTED.candidates()[:8], pool, progress)
    assert there == points[:8]
    assert calls == [(number, 8) for number in range(1, 9)]


def test_an_error_in_a_worker_is_raised_here():
    bad = replace(WANTED.candidates()[0], fiber_angle_beta=-0.5)
    wanted = replace(WANTED, fiber_angle_alpha=0.5)
    with ThreadPoolExecutor(2) as pool, pytest.raises(InvalidInputError):
        solve_points(wanted, [bad] * 5, pool)


def test_map_has_the_points_in_its_cells():
    betas, radii, calls = angles(60.0, 70.0), (3.96875e-3, 4.7625e-3, 6.35e-3), []
    progress = lambda *call: calls.append(call)  # noqa: E731
    result = feasibility_map(PAPER_EXAMPLE, betas, radii, 0.79375e-3, progress=progress)
    assert calls[-1] == (6, 6)
    assert (tuple(result.fiber_angles_beta), tuple(result.inner_radii)) == (betas, radii)
    # 60 degrees needs more object length than there is; 70 degrees of this tube is the example.
    assert result.binding[0] == (Constraint.OBJECT_LENGTH,) * 3
    assert (result.room[0] < 0.0).all()
    assert result.room.shape == (2, 3)
    assert result.room[1, 1] == pytest.approx(answered(PAPER_EXAMPLE).binding.relative)


@pytest.mark.parametrize(
    ("betas", "radii", "wall", "field"),
    [
        ((1.0, 1.2), (0.004, 0.005), 0.0, "wall_thickness"),
        ((2.0, 3.0), (0.004, 0.005), 1e-3, "beta"),
        ((1.2, 1.2), (0.004, 0.005), 1e-3, "fiber_angles_beta must be at least two"),
        ((1.0, 1.2), (0.005,), 1e-3, "inner_radii must be at least two"),
        ((1.0, 1.2), (0.004, math.nan), 1e-3, "inner_radii must be at least two"),
    ],
)
def test_map_refuses_bad_values(betas, radii, wall, field):
    with pytest.raises(InvalidInputError, match=field):
        feasibility_map(PAPER_EXAMPLE, betas, radii, wall)


def test_pareto_set_is_what_nothing_beats(points):
    feasible, best = [point for point in points if point.feasible], pareto_set(points)
    assert 0 < len(best) <= len(feasible) < len(points)
    for point in feasible:
        beaten = any(
            costs(other) != costs(point)
            and all(a <= b for a, b in zip(costs(other), costs(point), strict=True))
            for other in feasible
        )
        assert (point in best) is not beaten
    # What is worse in everything, and what is better in one figure only.
    good, exact = feasible[0], feasible[0].exact
    tube = replace(exact.gripper.tube, length=2.0 * exact.length)
    longer = replace(exact, gripper=replace(exact.gripper, tube=tube))
    worse, mixed = (
        replace(
            good,
            exact=replace(longer, smallest=replace(exact.smallest, stretch=1.9, pressure=pressure)),
        )
        for pressure in (2.0 * good.pressure, 0.5 * good.pressure)
    )
    assert pareto_set([worse, good, mixed]) == (mixed, good)
    assert pareto_set([]) == ()
