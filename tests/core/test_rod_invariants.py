# SPDX-License-Identifier: Apache-2.0
"""Every rod of ``rod_cases``: against shooting, against the documented energy, and its images.

Nothing of the solver is used to judge it: the reference integrates Kirchhoff's equations
(``reference_shooting``), energy and derivatives are those of the documentation's formula
(``documented_energy``).
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from core import documented_energy as documented
from core.reference_shooting import integrated, shoot, shoot_from_rest
from core.rod_cases import (
    IMAGES,
    RODS,
    gripper_rod,
    random_direction,
    stiffness_at,
    vectors_at,
)
from numpy.linalg import norm
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from spiral_core import Clamped, RodElement, RodProblem, solve_rod

pytestmark = pytest.mark.long

COUNTS = (40, 80, 160)
TURNED = tuple(Rotation.from_rotvec((0.4, -0.7, 0.2)).as_quat().tolist())
INEXTENSIBLE = [name for name in RODS if "stretching" not in name]


@cache
def solved(name, elements, element=None):
    """Return the state of a named rod."""
    return solve_rod(RODS[name], elements=elements, element=element, estimate_error=True)


def pulled(case, by):
    """Return a rod with a little more force at its tip."""
    force = tuple(np.add(case.load.tip_force, by).tolist())
    return RodProblem(case.rod, replace(case.load, tip_force=force))


@pytest.mark.parametrize("name", RODS)
def test_order_is_four_and_the_estimate_is_honest(name):
    """In positions, orientations, moments and energy; the estimate within a factor of 2.5."""
    case = RODS[name]
    near = Rotation.from_quat(solved(name, 40).orientations[-1])
    tip = shoot(case, near * Rotation.from_rotvec((0.02, -0.01, 0.02)))
    rows = []
    for elements in COUNTS:
        state = solved(name, elements)
        s, h = state.arc_lengths, np.diff(state.arc_lengths).max()
        exact = integrated(case, tip, s)
        assert state.stable
        frames = Rotation.from_quat(state.orientations).as_matrix()
        off = norm(state.positions - exact.positions, axis=1).max()
        bent = np.abs(state.moments - exact.moments).max() / np.abs(exact.moments).max()
        rows.append((off / case.rod.length, np.abs(frames - exact.frames).max(), bent))
        assert 1.0 / 2.5 < state.discretization_error / off < 2.5
        assert_allclose(state.tangents, frames[:, :, 0], atol=1e-14)
        # The trapezoidal rule for a load that varies.
        assert_allclose(state.forces, exact.forces, atol=2.0 * h**3)
        if name in INEXTENSIBLE:
            inner = ~np.isclose(s, (*case.rod.breaks, -1.0)[0])
            strains = state.strains - vectors_at(case.rod.rest_strain, s)
            moments = documented.times(stiffness_at(case.rod.section, s), strains)
            assert_allclose(state.moments[inner], moments[inner], atol=1e-15)
    errors = np.array(rows)
    assert errors[0].max() < 2e-4
    assert errors[1, 0] < 1.2e-6
    # The rest is the next term of the error's expansion.
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders.min() > 3.6
    assert orders.max() < 4.6
    energies = np.diff([solved(name, 2 * elements).energy for elements in COUNTS])
    assert np.log2(energies[0] / energies[1]) == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize("name", INEXTENSIBLE[:-1])
def test_energy_balance_and_pivot_are_those_of_the_documented_energy(name):
    """On few elements, where its smallest terms count; the pivot is one of the whole Hessian."""
    case, count = RODS[name], 10
    state = solve_rod(case, elements=count)
    energy, q = documented.energy_of(case, count), np.array(state.orientations)

    def turning(eta):
        eta = np.pad(eta, [(0, 0)] * (eta.ndim - 1) + [(3, 0)])  # the base does not turn
        return energy(documented.turned(q, eta.reshape(*eta.shape[:-1], -1, 3)))

    at = np.zeros(3 * count)
    assert state.energy == pytest.approx(turning(at), rel=1e-12)
    sites = np.linspace(0.0, case.rod.length, 2 * count + 1)
    soft = np.linalg.inv(documented.mean(stiffness_at(case.rod.section, sites)))
    unit = 1.0 / soft[:, (1, 2), (1, 2)].max() / case.rod.length
    moments = documented.gradient(turning, at)
    moments[-3:] -= Rotation.from_quat(q[-1]).inv().apply(case.load.tip_moment)
    assert np.abs(moments).max() == pytest.approx(unit * state.residual, abs=1e-12 * unit)
    pivots = np.diag(np.linalg.cholesky(documented.hessian(turning, at))) ** 2
    assert pivots.min() == pytest.approx(unit * state.smallest_pivot, rel=1e-8)


@pytest.mark.parametrize("name", RODS)
def test_a_start_nearby_is_left_as_it_was_and_ends_where_the_path_does(name):
    """In one or a few of Newton's steps: the tangent, tip moment and all, is exact."""
    start = solve_rod(RODS[name], elements=10, estimate_error=False)
    before = start.orientations.copy()
    size, steps, residual = (3e-7, 1, 1e-8) if name in INEXTENSIBLE else (1e-6, 3, 1e-13)
    case = pulled(RODS[name], (size, -size, 0.5 * size))
    near = solve_rod(case, elements=10, start=start, estimate_error=False)
    assert 0 < near.iterations <= steps
    assert near.residual < residual
    assert_array_equal(start.orientations, before)
    count = 64 if name in INEXTENSIBLE else 40
    cold = solve_rod(case, elements=count)
    warm = solve_rod(case, elements=count, start=solved(name, 40))
    assert_allclose(warm.positions, cold.positions, atol=1e-8)


@pytest.mark.parametrize("name", ["coupled", "stretching"])
def test_arrays_of_a_state_are_its_own(name):
    """They may be turned and changed: neither a new solve nor what goes on knows of it."""
    problem, fields = RODS[name], ("arc_lengths", "positions", "orientations", "moments")
    one = solve_rod(problem.rod, problem.load, elements=20)
    Rotation.from_euler("x", 1.0).apply(one.positions)  # scipy refuses arrays that are read-only
    before = [getattr(one, field).copy() for field in fields]
    for field in (*fields, "tip_reaction"):
        getattr(one, field)[:] = 7.0
    # The fast element goes on from what a state shows.
    start = one if one.element is RodElement.MIXED else None
    again = solve_rod(problem.rod, problem.load, elements=20, start=start)
    for field, expected in zip(fields, before, strict=True):
        assert_allclose(getattr(again, field), expected, atol=1e-9)
    assert np.abs(again.tip_reaction).max() < 1e-9


@pytest.mark.parametrize("name", RODS)
def test_the_tip_is_the_energys_derivative_by_the_force(name):
    """Castigliano: at equilibrium dE/dF = -p(L). A moment fixed in space has no potential."""
    case = RodProblem(RODS[name].rod, replace(RODS[name].load, tip_moment=(0.0, 0.0, 0.0)))
    start = solve_rod(case, elements=96, estimate_error=False)
    by = 2e-5 * np.array((1.0, -2.0, 2.0)) / 3.0
    energies = []
    for sign in (-1.0, 1.0):
        near = pulled(case, tuple((sign * by).tolist()))
        energies.append(solve_rod(near, elements=96, start=start).energy)
    # Differences of a minimum, d^2 times the third derivative; and the scheme's own error.
    off = (np.diff(energies)[0] + 2.0 * by @ start.tip_position) / 4e-5
    assert abs(off) < 5e-6 * case.rod.length


# The mixed element, of which a rolled one is, is of second order in a load that varies.
PAIRS = [
    (name, image) for name in RODS for image in IMAGES if (name, image[:4]) != ("varied", "roll")
]


@pytest.mark.parametrize(("name", "image"), PAIRS)
def test_the_image_of_a_rod_has_the_image_of_its_shape(name, image):
    """A rolled section that bends unequally is one of the mixed element: it must agree."""
    by, plain = IMAGES[image], solved(name, 80)
    case = by.of(RODS[name])
    state = solve_rod(case, elements=80)
    alike = state.element is plain.element
    off = 1e-9 if alike and plain.element is RodElement.INEXTENSIBLE else 2e-6
    expected = by.scale * plain.positions @ by.turn.T
    assert_allclose(state.positions, expected, atol=off * case.rod.length)
    moments = by.stiffer / by.scale * plain.moments @ by.axial.T
    assert_allclose(state.moments, moments, atol=5.0 * off * np.abs(moments).max())
    assert state.energy == pytest.approx(by.stiffer / by.scale * plain.energy, rel=10.0 * off)
    if "rolled" not in image:  # a pivot is of the frame
        assert state.smallest_pivot == pytest.approx(plain.smallest_pivot, rel=1e-5)


@pytest.mark.parametrize("name", INEXTENSIBLE[:-1])
def test_both_elements_agree_and_go_on_from_each_other(name):
    """From a base elsewhere too, or one whose quaternion has the other sign."""
    case, fast = RODS[name], solved(name, 80)
    slow = solved(name, 80, RodElement.MIXED)
    off = 2e-6 * case.rod.length
    back = solve_rod(case, elements=80, start=fast, element=RodElement.MIXED)
    assert_allclose(back.positions, slow.positions, atol=1e-3 * off)
    assert_allclose(slow.positions, fast.positions, atol=off)
    for field in ("forces", "moments", "base_reaction"):
        one, other = getattr(fast, field), getattr(slow, field)
        assert_allclose(other, one, atol=5e-6 * np.abs(one).max())
    for base in (Clamped((0.1, 0.0, 0.2), TURNED), Clamped(orientation=(0.0, 0.0, 0.0, -1.0))):
        load = replace(case.load, tip_moment=(0.0, 0.0, 0.0))
        elsewhere = solve_rod(case.rod, load, elements=80, base=base)
        again = solve_rod(case, elements=80, start=elsewhere)
        assert_allclose(again.positions, fast.positions, atol=1e-9)
    same = solve_rod(case.rod, case.load, elements=80, base=base, start=slow)
    assert_allclose(same.positions, slow.positions, atol=1e-3 * off)


def random_rods(count, seed, curviest, longest, softest):
    """Return gripper-sized rods on tilted mounts."""
    rng = np.random.default_rng(seed)
    cases = []
    for _ in range(count):
        curvature, length = rng.uniform(5.0, curviest), rng.uniform(0.15, longest)
        modulus, torsion = rng.uniform(softest, 3.0e6), rng.uniform(-0.9, 0.9) * curvature
        cases.append(gripper_rod(length, modulus, curvature, torsion, random_direction(rng)))
    return cases


def test_twenty_random_rods_agree_with_shooting():
    """The requirement is 1e-3 of the length; the elements are chosen for about 1e-5 of it."""
    rows = []
    for case in random_rods(20, 11, 60.0, 1.0, 0.6e6):
        state = solve_rod(case)
        assert state.stable
        exact = integrated(
            case, shoot(case, Rotation.from_quat(state.orientations[-1])), np.zeros(0)
        )
        off = float(norm(state.tip_position - exact.positions[-1]))
        bent = np.abs(state.moments[0] - exact.moments[0]).max() / np.abs(exact.moments).max()
        turned = case.rod.length * math.hypot(*case.rod.rest_strain) / 0.25
        count = len(state.positions) - 1
        rows.append((off / case.rod.length, state.discretization_error / off, bent, count / turned))
    errors, estimates, moments, counts = np.transpose(rows)
    # Measured: 2.9e-5 at worst, at one of the smallest numbers of elements, and 2e-6 at the median.
    assert errors.max() < 5e-5
    assert np.median(errors) < 5e-6
    assert estimates.min() > 1.0 / 3.0
    # Moments follow from the curvature's error, ten times the position's.
    assert moments.max() < 2e-4
    assert 1.0 <= np.median(counts) < 1.1


def test_shooting_on_its_own_finds_the_same():
    """The reference continued from the unloaded helix, knowing nothing of the solver's answer."""
    for case in random_rods(3, 12, 40.0, 0.4, 1.0e6):
        exact = integrated(case, shoot_from_rest(case, steps=3), np.zeros(0)).positions[-1]
        state = solve_rod(case)
        assert state.stable
        # The elements are chosen for 1e-5.
        assert norm(state.tip_position - exact) < 5e-5 * case.rod.length
