# SPDX-License-Identifier: Apache-2.0
"""Following a branch of stable states: folds found and counted, unstable states left."""

from __future__ import annotations

import numpy as np
import pytest
from core.rod_cases import gripper_rod
from scipy.spatial.transform import Rotation

from spiral_core import Rod, RodLoad, Section, solve_rod
from spiral_core.rod._arrays import discretize
from spiral_core.rod._continuation import (
    LARGEST_TURN,
    MAX_FOLDS,
    SMALLEST_STEP,
    follow_branch,
    follow_loading,
    follow_over_folds,
    minimize_to_stable,
    solve_from,
    solve_system,
)
from spiral_core.rod._newton import CONVERGED, FOLD_LIMIT, LEFT_BRANCH, UNSTABLE, minimize
from spiral_core.rod._shape import shape_from_orientations
from spiral_core.rod._system import Ending, blended, without_rest_strain
from spiral_core.rod._turns import largest_turn, resample

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
    return discretize(SNAPPING.rod, SNAPPING.load, (90,))


def test_an_unstable_state_is_left_for_a_lower_one() -> None:
    """A rod standing up straight past its critical length: stationary, and not an answer."""
    rod = Rod(2.5, Section.inextensible(1.0, 0.7))
    system = discretize(rod, RodLoad(distributed=(-1.0, 0.0, 0.0)), (40,))
    upright = minimize(straight(40), system, Ending(1.0, 0, False)).energy
    q = straight(40)
    assert minimize(q, system, Ending(1e-8, 50, False)).outcome == UNSTABLE
    found = minimize_to_stable(q, system, 1e-8)
    assert found.outcome == CONVERGED
    assert found.pivot > 0.0
    assert found.residual <= 1e-8
    assert found.energy < upright - 1e-3
    again = straight(40)
    minimize_to_stable(again, system, 1e-8)
    np.testing.assert_array_equal(q, again)


def test_a_stable_state_is_not_kicked() -> None:
    case = gripper_rod()
    system = discretize(case.rod, case.load, (40,))
    q, folds, found = follow_loading(system, 1e-12)
    before = q.copy()
    assert (folds, found.outcome) == (0, CONVERGED)
    assert minimize_to_stable(q, system, 1e-10).iterations == 0
    np.testing.assert_array_equal(q, before)


def test_a_blend_is_the_rod_of_blended_properties() -> None:
    """Lengths differ: loads at the nodes, rest energy and strains must be the blended rod's own."""
    first, second = (
        Rod(0.3, Section.inextensible(3e-4, 2e-4), rest_strain=(-5.0, 2.0, 10.0)),
        Rod(0.5, Section.inextensible(4e-4, 1e-4), rest_strain=(3.0, 0.0, 20.0)),
    )
    loads = RodLoad((0.2, 0.1, 0.0)), RodLoad((0.0, -0.3, 0.1), (0.1, 0.2, 0.3), (1e-3, 0.0, 0.0))
    a, b = discretize(first, loads[0], (24,)), discretize(second, loads[1], (24,))
    moment = 0.75 * 3e-4 * np.array([2.0 / 3.0 * -5.0, 2.0, 10.0]) + 0.25 * 4e-4 * np.array(
        [0.25 * 3.0, 0.0, 20.0]
    )
    stiffness = np.array([0.75 * 2e-4 + 0.25 * 1e-4, *2 * [0.75 * 3e-4 + 0.25 * 4e-4]])
    rest = tuple((moment / stiffness).tolist())
    rod = Rod(
        0.35, Section.inextensible(float(stiffness[1]), float(stiffness[0])), rest_strain=rest
    )
    load = RodLoad((0.15, 0.0, 0.025), (0.025, 0.05, 0.075), (2.5e-4, 0.0, 0.0))
    mixed, meant = blended(a, b, 0.25), discretize(rod, load, (24,))
    for name in ("steps", "distributed", "tip_moment", "sections"):
        np.testing.assert_allclose(
            getattr(mixed, name), getattr(meant, name), rtol=1e-13, atol=1e-15
        )
    # The force is blended; that of the blended weight on the blended length differs.
    forces = 0.75 * a.force + 0.25 * b.force
    np.testing.assert_allclose(mixed.force, forces, rtol=1e-13)
    # Rest strain passes through the elements' series: alike to (h |u*|)^2 / 24.
    np.testing.assert_allclose(mixed.elements, meant.elements, rtol=5e-3)
    assert mixed.rest_energy == pytest.approx(meant.rest_energy, rel=1e-2)
    same = blended(a, a, 0.3)
    assert same.rest_energy == pytest.approx(a.rest_energy, rel=1e-13)


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
    system = snapping()
    start = without_rest_strain(system, 1.0)
    q = straight(90)
    assert minimize_to_stable(q, start, 1e-8).outcome == CONVERGED
    at, found = follow_branch(q, start, system, 0.0, 1e-8)
    assert found.outcome == LEFT_BRANCH
    assert 0.0 < at < 1.0
    beyond = blended(start, system, at + SMALLEST_STEP)
    held = minimize(q.copy(), beyond, Ending(1.0, 0, False)).energy
    before = q.copy()
    found = minimize_to_stable(q, beyond, 1e-8)
    assert found.outcome == CONVERGED
    assert found.energy < held
    assert largest_turn(q, before) > 0.0
    moved = [shape_from_orientations(x, beyond)[0] for x in (before, q)]
    assert np.linalg.norm(moved[1][-1] - moved[0][-1]) > 0.01 * SNAPPING.rod.length


def test_the_count_of_folds_reaches_the_state() -> None:
    _, folds, found = follow_loading(snapping(), 1e-8)
    assert found.outcome == CONVERGED
    assert folds == 1
    state = solve_rod(SNAPPING.rod, SNAPPING.load)
    assert state.stable
    assert state.folds == 1
    assert solve_rod(SNAPPING.rod, SNAPPING.load, start=state).folds == 0
    assert solve_rod(gripper_rod().rod, gripper_rod().load).folds == 0


def test_following_there_and_back_ends_where_it_began() -> None:
    case = gripper_rod()
    here = discretize(case.rod, case.load, (40,))
    other = gripper_rod(curvature=30.0, gravity=(0.8, 0.6, 0.0))
    away = discretize(other.rod, other.load, (40,))
    q, _, _ = follow_loading(here, 1e-10)
    start = q.copy()
    folds, found = follow_over_folds(q, here, away, 0.0, 1e-10)
    assert (folds, found.outcome) == (0, CONVERGED)
    assert np.abs(q - start).max() > 0.1
    assert follow_over_folds(q, away, here, 0.0, 1e-10)[0] == 0
    # The residual's tolerance, 1e-10 EI/L, times the rod's compliance.
    np.testing.assert_allclose(q, start, atol=1e-9)


def test_settling_counts_leaving_the_branch() -> None:
    rod = Rod(2.5, Section.inextensible(1.0, 0.7))
    system = discretize(rod, RodLoad(distributed=(-1.0, 0.0, 0.0)), (40,))
    q = straight(40)
    folds, found = solve_from(q, system, 1e-8)
    assert (folds, found.outcome) == (1, CONVERGED)
    assert solve_from(q, system, 1e-8)[0] == 0


def test_refining_finds_what_the_fine_walk_finds() -> None:
    case = gripper_rod(length=0.5, curvature=31.0, torsion=-21.0)
    coarse, fine = (discretize(case.rod, case.load, (n,)) for n in (24, 72))
    q = np.empty((73, 4))
    refined = solve_system(q, coarse, fine, False)
    slow, slow_folds, _ = follow_loading(fine, 1e-9)
    assert (refined.solution.outcome, refined.folds) == (CONVERGED, slow_folds)
    np.testing.assert_allclose(q, slow, atol=1e-7)  # the residual's tolerance


@pytest.mark.parametrize("count", [5, 24, 100])
@pytest.mark.parametrize("strain", [(0.0, 0.0, 0.0), (-3.0, 0.4, 9.0)])
def test_resampling_a_uniform_rotation_is_exact(
    count: int, strain: tuple[float, float, float]
) -> None:
    def nodes(n: int) -> Rotation:
        return Rotation.from_rotvec(np.linspace(0.0, 1.0, n + 1)[:, None] * np.array(strain))

    steps = np.full(24, 1.0 / 24), np.full(count, 2.0 / count)
    finer = Rotation.from_quat(resample(nodes(24).as_quat(), *steps))
    assert (finer.inv() * nodes(count)).magnitude().max() < 1e-13


def test_a_path_of_too_many_snaps_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reaching the cap on folds is not the end of a branch; run as plain Python."""
    from spiral_core.rod import _continuation as continuation

    system = discretize(gripper_rod().rod, gripper_rod().load, (24,))
    q = straight(24)
    resting = minimize_to_stable(q, system, 1e-8)
    ended = resting._replace(outcome=LEFT_BRANCH)
    monkeypatch.setattr(continuation, "follow_branch", lambda *_: (0.5, ended))
    folds, found = follow_over_folds.py_func(q, system, system, 0.0, 1e-8)
    assert (folds, found.outcome) == (MAX_FOLDS, FOLD_LIMIT)
    assert LARGEST_TURN > 0.0
