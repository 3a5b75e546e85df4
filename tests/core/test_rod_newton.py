# SPDX-License-Identifier: Apache-2.0
"""Assembly and elimination against dense algebra; every way in which a minimization can end."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from core import documented_energy as documented
from core.rod_cases import gripper_rod, straight_rod
from scipy.spatial.transform import Rotation

from spiral_core import Rod, RodLoad, RodStatus, Section
from spiral_core.rod import _newton as rod_newton
from spiral_core.rod._arrays import discretize
from spiral_core.rod._elimination import back_substitute, newton_pass, scales_of
from spiral_core.rod._newton import (
    CONVERGED,
    FOLD_LIMIT,
    ITERATION_LIMIT,
    LEFT_BRANCH,
    LINE_SEARCH_FAILED,
    NOT_FINITE,
    UNRESOLVED,
    UNSTABLE,
    minimize,
)
from spiral_core.rod._system import Ending, System
from spiral_core.rod._turns import turn_nodes
from spiral_core.rod.solve import STATUSES

pytestmark = pytest.mark.long

COUNT = 6
# A rod of order one (L = EI = 1), everything varying along it.
VARIED = Rod(
    1.0,
    Section.varying(lambda s: 1.0 + 0.3 * np.sin(3.0 * s), lambda s: 0.7 - 0.2 * s),
    rest_strain=lambda s: np.column_stack((np.cos(s), 0.3 * s, 2.0 + s * s)),
)
LOAD = RodLoad(
    distributed=lambda s: np.column_stack((1.0 + s, np.sin(s), -0.5 * s)),
    tip_force=(0.4, -0.7, 0.2),
)


def disturbed(count: int, size: float, seed: int = 2) -> np.ndarray:
    """Return random orientations, neighbors within ``size`` [rad] or so; the base is clamped."""
    rng = np.random.default_rng(seed)
    nodes = [Rotation.identity()]
    for _ in range(count):
        nodes.append(nodes[-1] * Rotation.from_rotvec(size * rng.normal(size=3)))
    return np.array([node.as_quat() for node in nodes])


def upright(count: int, critical: float) -> System:
    """Return a straight rod standing up, its length so many times Greenhill's."""
    length = critical * 7.837347 ** (1.0 / 3.0)
    rod = Rod(length, Section.inextensible(1.0, 0.7))
    return discretize(rod, RodLoad(distributed=(-1.0, 0.0, 0.0)), (count,))


def straight(count: int) -> np.ndarray:
    """Return the orientations of a straight rod."""
    q = np.zeros((count + 1, 4))
    q[:, 3] = 1.0
    return q


def energy_of_steps(system: System, q: np.ndarray):
    """Return the documented energy as a function of the free nodes' rotation vectors."""

    def energy(eta: np.ndarray) -> complex:
        nodes = [q[0].astype(eta.dtype)]
        nodes += [documented.turned(q[i + 1], eta[3 * i : 3 * i + 3]) for i in range(len(q) - 1)]
        return documented.rod(nodes, system)

    return energy


@cache
def documented_hessian() -> np.ndarray:
    """Return the documented energy's second derivative at a disturbed state of the varied rod."""
    energy = energy_of_steps(discretize(VARIED, LOAD, (COUNT,)), disturbed(COUNT, 0.1))
    return documented.hessian(energy, np.zeros(3 * COUNT))


def test_a_pass_is_newtons_step_on_the_documented_energy() -> None:
    system = discretize(VARIED, LOAD, (COUNT,))
    q = disturbed(COUNT, 0.1)
    shift = 5.0
    gains, offsets = np.empty((COUNT - 1, 9)), np.empty((COUNT, 3))
    energy, residual, decrement, pivot, neutral = newton_pass(
        q, system, shift, scales_of(system), gains, offsets
    )
    assert neutral == 0
    step = np.empty((COUNT, 3))
    largest = back_substitute(gains, offsets, step)
    function = energy_of_steps(system, q)
    at = np.zeros(3 * COUNT)
    gradient = documented.gradient(function, at)
    hessian = documented_hessian() + shift * np.eye(3 * COUNT)
    newton = -np.linalg.solve(hessian, gradient)
    assert energy == pytest.approx(function(at), rel=1e-12)
    assert residual == pytest.approx(np.abs(gradient).max(), rel=1e-11)
    np.testing.assert_allclose(step.ravel(), newton, rtol=1e-8, atol=1e-10)
    assert decrement == pytest.approx(-gradient @ newton, rel=1e-8)
    assert pivot == pytest.approx((np.diag(np.linalg.cholesky(hessian)) ** 2).min(), rel=1e-8)
    rotations = np.abs(np.diff(np.vstack((np.zeros(3), step)), axis=0)).max()
    assert largest == pytest.approx(max(np.abs(step).max(), 2.0 * rotations), rel=1e-12)


def test_the_hessian_couples_only_neighbors() -> None:
    """What the elimination leaves out is zero."""
    blocks = np.abs(documented_hessian()).reshape(COUNT, 3, COUNT, 3).max(axis=(1, 3))
    far = np.abs(np.subtract.outer(np.arange(COUNT), np.arange(COUNT))) > 1
    assert blocks[far].max() < 1e-9 < blocks[~far].min()


@pytest.mark.parametrize("moment", [(0.0, 0.0, 0.0), (0.8, -0.5, 1.1)])
def test_convergence_is_quadratic(moment: tuple[float, float, float]) -> None:
    """From 1e-3 rad away, the residual squares: the tangent, tip moment and all, is exact."""
    system = discretize(VARIED, replace(LOAD, tip_moment=moment), (40,))
    q = straight(40)
    assert minimize(q, system, Ending(1e-12, 100, False)).outcome == CONVERGED
    step = 1e-3 * np.random.default_rng(1).normal(size=(40, 3)).cumsum(axis=0) / 6.0
    near = np.empty_like(q)
    turn_nodes(q, step, 1.0, near)
    residuals = []
    for _ in range(3):
        residuals.append(minimize(near, system, Ending(0.0, 0, False)).residual)
        assert minimize(near, system, Ending(1e-14, 1, False)).outcome in (
            CONVERGED,
            ITERATION_LIMIT,
        )
    # The first step's constant is measured; the rounding of a moment here is 1e-13.
    assert residuals[1] < 0.2 * residuals[0] ** 1.5
    assert residuals[2] < 1e-9
    assert residuals[2] < max(1e-3 * residuals[1], 1e-12)


def test_turning_leaves_the_clamp_alone() -> None:
    q = disturbed(COUNT, 0.3)
    turned = np.empty_like(q)
    step = np.random.default_rng(8).normal(size=(COUNT, 3))
    turn_nodes(q, step, 0.25, turned)
    np.testing.assert_array_equal(turned[0], q[0])
    np.testing.assert_allclose(np.linalg.norm(turned, axis=1), 1.0, rtol=1e-15)
    moved = (Rotation.from_quat(q[1:]).inv() * Rotation.from_quat(turned[1:])).as_rotvec()
    # 2 atan(|eta| / 2) about the axis of eta.
    size = np.linalg.norm(0.25 * step, axis=1)[:, None]
    np.testing.assert_allclose(moved, 2.0 * np.arctan(0.5 * size) * step * 0.25 / size, atol=1e-13)


def test_too_few_iterations_are_said_to_be() -> None:
    system = discretize(VARIED, LOAD, (20,))
    found = minimize(straight(20), system, Ending(1e-10, 2, False))
    assert (found.outcome, found.iterations) == (ITERATION_LIMIT, 2)
    assert found.residual > 1e-10


@pytest.mark.parametrize("bad", [np.nan, 1e308])
def test_numbers_that_are_not_finite_are_noticed(bad: float) -> None:
    system = discretize(straight_rod(), RodLoad(tip_force=(0.0, 1.0, 0.0)), (20,))
    spoiled = system._replace(force=system.force * bad)
    outcome = minimize(straight(20), spoiled, Ending(1e-8, 50, False)).outcome
    assert outcome == NOT_FINITE


def test_a_moment_that_no_energy_balances_fails_the_line_search() -> None:
    """A tolerance far below rounding leaves nothing to lower."""
    system = discretize(VARIED, replace(LOAD, tip_moment=(0.8, -0.5, 1.1)), (20,))
    found = minimize(straight(20), system, Ending(0.0, 200, False))
    assert found.outcome == LINE_SEARCH_FAILED
    assert found.residual < 1e-11
    assert found.pivot > 0.0


@pytest.mark.parametrize(("critical", "stable"), [(0.99, True), (1.01, False)])
def test_the_certificate_refuses_the_straight_state_past_buckling(
    critical: float, stable: bool
) -> None:
    system = upright(24, critical)
    q = straight(24)
    found = minimize(q, system, Ending(1e-8, 50, False))
    assert found.outcome == (CONVERGED if stable else UNSTABLE)
    assert (found.pivot > 0.0) is stable
    assert found.residual < 1e-8
    np.testing.assert_array_equal(q, straight(24))
    strict = minimize(q, system, Ending(1e-8, 50, True)).outcome
    assert strict == (CONVERGED if stable else LEFT_BRANCH)


def test_the_smallest_eigenvalue_changes_sign_with_the_pivot() -> None:
    """The certificate says what a dense eigenvalue solver says."""
    seen = set()
    count = 4
    for critical in (0.97, 1.03):
        system = upright(count, critical)
        hessian = documented.hessian(energy_of_steps(system, straight(count)), np.zeros(3 * count))
        gains, offsets = np.empty((count - 1, 9)), np.empty((count, 3))
        pivot = newton_pass(straight(count), system, 0.0, scales_of(system), gains, offsets).pivot
        definite = bool(np.linalg.eigvalsh(hessian)[0] > 0.0)
        assert (pivot > 0.0) is definite
        seen.add(definite)
    assert seen == {True, False}


def test_energy_never_rises_on_the_way_down() -> None:
    """From a crumpled start the Hessian is indefinite; shift and line search still lower it."""
    case = gripper_rod()
    system = discretize(case.rod, case.load, (40,))
    q = disturbed(40, 0.6, seed=5)
    energies = [minimize(q, system, Ending(0.0, 0, False)).energy]
    strict = minimize(q.copy(), system, Ending(1e-8, 50, True)).outcome
    assert strict == LEFT_BRANCH
    outcome = ITERATION_LIMIT
    while outcome == ITERATION_LIMIT and len(energies) < 300:
        found = minimize(q, system, Ending(1e-8, 1, False))
        outcome = found.outcome
        energies.append(found.energy)
    assert outcome == CONVERGED
    assert np.diff(energies).max() < rod_newton.ENERGY_NOISE * scales_of(system).moment


def test_every_outcome_has_a_status_with_advice() -> None:
    outcomes = [
        CONVERGED,
        ITERATION_LIMIT,
        LINE_SEARCH_FAILED,
        NOT_FINITE,
        UNSTABLE,
        LEFT_BRANCH,
        FOLD_LIMIT,
        UNRESOLVED,
    ]
    assert sorted(outcomes) == list(range(len(STATUSES)))
    assert len({STATUSES[outcome] for outcome in outcomes}) == len(STATUSES)
    assert [STATUSES[o].name for o in outcomes] == [
        "CONVERGED",
        "ITERATION_LIMIT",
        "LINE_SEARCH_FAILED",
        "NOT_FINITE",
        "UNSTABLE",
        "LEFT_BRANCH",
        "FOLD_LIMIT",
        "UNRESOLVED",
    ]
    assert len({status.value for status in RodStatus}) == len(RodStatus)
