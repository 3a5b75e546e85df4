"""Following a branch of stable states: folds found and counted, unstable states left."""

from __future__ import annotations

import numpy as np
import pytest
from core.rod_cases import gripper_rod
from scipy.spatial.transform import Rotation

from spiral_core import Rod, RodLoad, RodStatus, SolverError, solve_rod
from spiral_core.rod._arrays import discretize
from spiral_core.rod._continuation import (
    LARGEST_TURN,
    SMALLEST_STEP,
    advance,
    blend,
    descend,
    follow,
    largest_turn,
    resample,
    settle,
    snap,
    walk,
    walk_and_refine,
)
from spiral_core.rod._newton import CONVERGED, LEFT_BRANCH, UNSTABLE, energy_and_imbalance, minimize
from spiral_core.rod._shape import shape_from_orientations

# A rod mounted sideways and up, found among random ones: on its way it snaps, once.
SNAPPING = gripper_rod(
    length=0.55,
    modulus=1.244e6,
    curvature=38.94,
    torsion=6.46,
    gravity=(0.544, -0.393, -0.741),
)


def straight(count: int) -> np.ndarray:
    """Return the orientations of a straight rod."""
    q = np.zeros((count + 1, 4))
    q[:, 3] = 1.0
    return q


def snapping():
    """Return a rod that snaps while its rest curvature grows, on few elements."""
    return discretize(SNAPPING.rod, SNAPPING.load, 90)


def test_an_unstable_state_is_left_for_a_lower_one() -> None:
    """A rod standing up straight past its critical length: stationary, and not an answer."""
    rod = Rod(2.5, bending_stiffness=1.0, torsional_stiffness=0.7)
    system = discretize(rod, RodLoad(distributed=(-1.0, 0.0, 0.0)), 40).system
    upright = energy_and_imbalance(straight(40), system)[0]
    q = straight(40)
    assert minimize(q, system, 1e-8, 50, False)[0] == UNSTABLE
    outcome, _, energy, residual, pivot = descend(q, system, 1e-8)
    assert outcome == CONVERGED
    assert pivot > 0.0
    assert residual <= 1e-8
    assert energy < upright - 1e-3
    again = straight(40)
    descend(again, system, 1e-8)
    np.testing.assert_array_equal(q, again)


def test_a_stable_state_is_not_kicked() -> None:
    case = gripper_rod()
    system = discretize(case.rod, case.load, 40).system
    q, folds, solution = walk(system, 1e-12)
    before = q.copy()
    assert (folds, solution[0]) == (0, CONVERGED)
    assert descend(q, system, 1e-10)[1] == 0
    np.testing.assert_array_equal(q, before)


def test_blend_is_linear_in_everything() -> None:
    first, second = gripper_rod(), gripper_rod(tip_force=(0.1, 0.2, 0.3), tip_moment=(1e-3, 0, 0))
    a = discretize(first.rod, first.load, 8).system
    b = discretize(second.rod, second.load, 8).system
    mixed = blend(a, b, 0.25)
    for x, y, z in zip(a[:4], b[:4], mixed[:4], strict=True):
        np.testing.assert_allclose(z, 0.75 * x + 0.25 * y, rtol=1e-14, atol=1e-300)


def test_largest_turn_is_measured_between_neighbors() -> None:
    rng = np.random.default_rng(2)
    before = Rotation.from_rotvec(0.3 * rng.normal(size=(9, 3)).cumsum(axis=0))
    after = Rotation.from_rotvec(0.3 * rng.normal(size=(9, 3)).cumsum(axis=0))
    a, b = before[:-1].inv() * before[1:], after[:-1].inv() * after[1:]
    expected = (a.inv() * b).magnitude().max()
    assert largest_turn(after.as_quat(), before.as_quat()) == pytest.approx(expected, rel=1e-7)
    # A whole rod turned as a body has not bent.
    moved = Rotation.from_rotvec([0.0, 2.0, 1.0]) * before
    assert largest_turn(moved.as_quat(), before.as_quat()) < 1e-7  # asin near 1: half the digits


def test_a_snap_is_counted_and_releases_energy() -> None:
    arrays = snapping()
    system, tolerance = arrays.system, 1e-8 * arrays.moment_scale
    bent = list(system)
    bent[3] = system[3].copy()
    bent[3][:, 2:5] = 0.0
    start = tuple(bent)
    q = straight(arrays.count)
    assert descend(q, start, tolerance)[0] == CONVERGED
    at, solution = advance(q, start, system, 0.0, tolerance)
    assert solution[0] == LEFT_BRANCH
    assert 0.0 < at < 1.0
    beyond = blend(start, system, at + SMALLEST_STEP)
    held = energy_and_imbalance(q, beyond)[0]
    before = q.copy()
    joined, solution = snap(q, start, system, at, tolerance)
    assert solution[0] == CONVERGED
    assert joined == pytest.approx(at + SMALLEST_STEP, abs=1e-12)
    assert solution[2] < held
    assert largest_turn(q, before) > 0.0
    moved = [
        shape_from_orientations(x, arrays.force, arrays.distributed, arrays.elements, arrays.step)[
            0
        ]
        for x in (before, q)
    ]
    assert np.linalg.norm(moved[1][-1] - moved[0][-1]) > 0.01 * SNAPPING.rod.length


def test_the_count_of_folds_reaches_the_state() -> None:
    arrays = snapping()
    _, folds, solution = walk(arrays.system, 1e-8 * arrays.moment_scale)
    assert solution[0] == CONVERGED
    assert folds == 1
    state = solve_rod(SNAPPING.rod, SNAPPING.load)
    assert state.stable
    assert state.folds == 1
    assert solve_rod(SNAPPING.rod, SNAPPING.load, start=state).folds == 0
    assert solve_rod(gripper_rod().rod, gripper_rod().load).folds == 0


def test_following_there_and_back_ends_where_it_began() -> None:
    case = gripper_rod()
    arrays = discretize(case.rod, case.load, 40)
    other = gripper_rod(curvature=30.0, gravity=(0.8, 0.6, 0.0))
    away = discretize(other.rod, other.load, 40).system
    tolerance = 1e-10 * arrays.moment_scale
    q, _, _ = walk(arrays.system, tolerance)
    start = q.copy()
    folds, solution = follow(q, arrays.system, away, tolerance)
    assert (folds, solution[0]) == (0, CONVERGED)
    assert np.abs(q - start).max() > 0.1
    assert follow(q, away, arrays.system, tolerance)[0] == 0
    # The residual's tolerance, 1e-10 EI/L, times the rod's compliance.
    np.testing.assert_allclose(q, start, atol=1e-9)


def test_settling_counts_leaving_the_branch() -> None:
    rod = Rod(2.5, bending_stiffness=1.0, torsional_stiffness=0.7)
    system = discretize(rod, RodLoad(distributed=(-1.0, 0.0, 0.0)), 40).system
    q = straight(40)
    folds, solution = settle(q, system, 1e-8)
    assert (folds, solution[0]) == (1, CONVERGED)
    assert settle(q, system, 1e-8)[0] == 0


def test_refining_finds_what_the_fine_walk_finds() -> None:
    case = gripper_rod(length=0.5, curvature=31.0, torsion=-21.0)
    coarse, fine = (discretize(case.rod, case.load, n) for n in (24, 72))
    tolerance = 1e-9 * fine.moment_scale
    q, folds, solution = walk_and_refine(coarse.system, fine.system, tolerance)
    slow, slow_folds, _ = walk(fine.system, tolerance)
    assert (solution[0], folds) == (CONVERGED, slow_folds)
    np.testing.assert_allclose(q, slow, atol=1e-8)  # the residual's tolerance


@pytest.mark.parametrize("count", [5, 24, 100])
@pytest.mark.parametrize("strain", [(0.0, 0.0, 0.0), (-3.0, 0.4, 9.0)])
def test_resampling_a_uniform_rotation_is_exact(
    count: int, strain: tuple[float, float, float]
) -> None:
    def nodes(n: int) -> Rotation:
        return Rotation.from_rotvec(np.linspace(0.0, 1.0, n + 1)[:, None] * np.array(strain))

    finer = Rotation.from_quat(resample(nodes(24).as_quat(), count))
    assert (finer.inv() * nodes(count)).magnitude().max() < 1e-13


def test_a_path_of_endless_snaps_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """The kernels' LEFT_BRANCH becomes an error with its figures."""
    from spiral_core.rod import solve as rod_statics

    case = gripper_rod()
    state = solve_rod(case.rod, case.load)

    def endless(*_: object) -> tuple[object, ...]:
        return state.orientations, 33, (LEFT_BRANCH, 17, 0.0, 1e-3, -1.0)

    monkeypatch.setattr(rod_statics, "walk_and_refine", endless)
    with pytest.raises(SolverError) as caught:
        solve_rod(case.rod, case.load)
    assert caught.value.status is RodStatus.LEFT_BRANCH
    assert caught.value.iterations == 17
    assert caught.value.residual > 0.0
    assert LARGEST_TURN > 0.0
