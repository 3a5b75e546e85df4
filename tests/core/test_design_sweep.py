# SPDX-License-Identifier: Apache-2.0
"""Sweeps: the same answers on any executor, the map's cells, the Pareto set's definition."""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from core.design_cases import CATALOG, PAPER_EXAMPLE

from spiral_core import (
    Constraint,
    InvalidInputError,
    design_gripper,
    feasibility_map,
    pareto_set,
    solve_points,
)
from spiral_core.design.evaluation import Evaluation

pytestmark = pytest.mark.long

WANTED = replace(PAPER_EXAMPLE, tubes=CATALOG[6:10])


@pytest.fixture(scope="module")
def points() -> tuple[Evaluation, ...]:
    """Return every candidate of four tubes, solved here."""
    return solve_points(WANTED, WANTED.candidates())


def costs(point: Evaluation) -> tuple[float, float, float]:
    assert point.pressure is not None
    assert point.strain is not None
    assert point.length is not None
    return point.pressure, point.strain, point.length


def test_points_come_in_order_with_their_figures(points: tuple[Evaluation, ...]) -> None:
    assert [point.candidate for point in points] == list(WANTED.candidates())
    report = design_gripper(replace(WANTED, tubes=CATALOG[9:10]), contact=False)
    (same,) = (
        p
        for p in points
        if p.candidate.tube is CATALOG[9]
        and p.candidate.fiber_angle_beta == pytest.approx(math.radians(70.0))
    )
    assert report.design is not None
    assert same.feasible
    assert costs(same) == (
        report.design.smallest.pressure,
        report.design.smallest.strain,
        report.design.length,
    )


@contextmanager
def threads() -> Iterator[Executor]:
    """Yield two threads."""
    with ThreadPoolExecutor(2) as executor:
        yield executor


@contextmanager
def processes() -> Iterator[Executor]:
    """Yield two processes that start afresh."""
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        yield executor


@contextmanager
def dask_cluster() -> Iterator[Executor]:
    """Yield a local Dask cluster as an executor."""
    from distributed import Client, LocalCluster

    with (
        LocalCluster(
            n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client.get_executor()


@pytest.mark.slow
# Dask's own teardown leaves closing connections to the garbage collector.
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::DeprecationWarning")
@pytest.mark.parametrize("executor", [threads, processes, dask_cluster])
def test_any_executor_gives_the_same_answers(executor: object) -> None:
    candidates = replace(WANTED, tubes=CATALOG[6:8]).candidates()
    calls: list[tuple[int, int]] = []
    with executor() as pool:  # type: ignore[operator]
        there = solve_points(WANTED, candidates, pool, lambda *call: calls.append(call))
    assert there == solve_points(WANTED, candidates)
    assert calls == [(number, 8) for number in range(1, 9)]


def test_an_error_in_a_worker_is_raised_here() -> None:
    bad = replace(WANTED.candidates()[0], fiber_angle_beta=-0.5)
    wanted = replace(WANTED, fiber_angle_alpha=0.5)
    with ThreadPoolExecutor(2) as pool, pytest.raises(InvalidInputError):
        solve_points(wanted, [bad] * 5, pool)


def test_map_has_the_points_in_its_cells() -> None:
    betas, radii = (math.radians(60.0), math.radians(70.0)), (3.96875e-3, 4.7625e-3, 6.35e-3)
    calls: list[tuple[int, int]] = []
    result = feasibility_map(
        PAPER_EXAMPLE, betas, radii, 0.79375e-3, progress=lambda *call: calls.append(call)
    )
    assert result.room.shape == (2, 3)
    assert calls[-1] == (6, 6)
    np.testing.assert_array_equal(result.fiber_angles_beta, betas)
    np.testing.assert_array_equal(result.inner_radii, radii)
    # 60 degrees needs more object length than there is; 70 degrees of this tube is the example.
    assert result.binding[0] == (Constraint.OBJECT_LENGTH,) * 3
    assert (result.room[0] < 0.0).all()
    assert result.room[1, 1] == pytest.approx(
        design_gripper(PAPER_EXAMPLE, contact=False).binding.relative
    )


def test_map_refuses_bad_values() -> None:
    with pytest.raises(InvalidInputError, match="wall_thickness"):
        feasibility_map(PAPER_EXAMPLE, (1.0, 1.2), (0.004, 0.005), 0.0)
    with pytest.raises(InvalidInputError, match="beta"):
        feasibility_map(PAPER_EXAMPLE, (2.0, 3.0), (0.004, 0.005), 1e-3)
    for radii in ((0.005,), (0.005, 0.004), (0.005, 0.005), (0.004, math.nan)):
        with pytest.raises(InvalidInputError, match="inner_radii must be at least two"):
            feasibility_map(PAPER_EXAMPLE, (1.0, 1.2), radii, 1e-3)
    with pytest.raises(InvalidInputError, match="fiber_angles_beta must be at least two"):
        feasibility_map(PAPER_EXAMPLE, (1.2, 1.2), (0.004, 0.005), 1e-3)


def test_a_coil_that_closes_before_the_actuator_ends_binds_nothing(
    points: tuple[Evaluation, ...],
) -> None:
    """A placeholder of 0 m, +100 %, was the tightest constraint of nearly every design."""
    for point in points:
        constraints = {margin.constraint for margin in point.margins}
        assert point.binding.constraint is not Constraint.SMALLEST_RADIUS
        assert Constraint.SMALLEST_RADIUS not in constraints or all(
            m.value > 0.0 for m in point.margins if m.constraint is Constraint.SMALLEST_RADIUS
        )


def test_pareto_set_is_what_nothing_beats(points: tuple[Evaluation, ...]) -> None:
    feasible = [point for point in points if point.feasible]
    best = pareto_set(points)
    assert 0 < len(best) <= len(feasible) < len(points)
    for point in feasible:
        beaten = any(
            costs(other) != costs(point)
            and all(a <= b for a, b in zip(costs(other), costs(point), strict=True))
            for other in feasible
        )
        assert (point in best) is not beaten
    assert [costs(p)[0] for p in best] == sorted(costs(p)[0] for p in best)


def test_pareto_set_drops_what_is_worse_in_everything(points: tuple[Evaluation, ...]) -> None:
    good = next(point for point in points if point.feasible)
    exact = good.exact
    assert exact is not None
    assert exact.smallest is not None
    strained = replace(exact.smallest, stretch=1.0 + 2.0 * exact.smallest.strain)
    pressure, tube = exact.smallest.pressure, exact.gripper.tube
    longer = replace(exact.gripper, tube=replace(tube, length=2.0 * tube.length))
    worse, mixed = (
        replace(good, exact=replace(exact, gripper=longer, smallest=smallest))
        for smallest in (
            replace(strained, pressure=2.0 * pressure),
            replace(strained, pressure=0.5 * pressure),
        )
    )
    assert pareto_set([worse, good, mixed]) == (mixed, good)
    assert pareto_set([]) == ()
