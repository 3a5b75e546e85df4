# SPDX-License-Identifier: Apache-2.0
"""Every rod of ``rod_cases``: against shooting, against the documented energy, and its images.

Nothing of the solver is used to judge it: the reference integrates Kirchhoff's equations
(``reference_shooting``), energy and derivatives are those of the documentation's formula
(``documented_energy``).
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from core import documented_energy as documented
from core.contact_paths import agree
from core.recorded import recorded
from core.reference_shooting import integrated, shoot
from core.rod_cases import (
    IMAGES,
    RODS,
    drawn,
    image,
    stiffness_at,
    vectors_at,
)
from numpy.linalg import norm
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from spiral_core import Clamped, RodElement, RodLoad, RodProblem, solve_rod

pytestmark = pytest.mark.long

COUNTS = (40, 80, 160)
TURNED = tuple(Rotation.from_rotvec((0.4, -0.7, 0.2)).as_quat().tolist())
INEXTENSIBLE = [name for name in RODS if "stretching" not in name]


@cache
def solved(name, elements, element=None):
    """Return the state of a named rod."""
    return solve_rod(RODS[name], elements=elements, element=element, estimate_error=True)


def loaded(case, by, moment=0.0):
    """Return a rod with more force at its tip, and so much of its tip's moment."""
    load = case.load
    more = replace(
        load, tip_force=np.add(load.tip_force, by), tip_moment=np.multiply(moment, load.tip_moment)
    )
    return RodProblem(case.rod, more)


@pytest.mark.parametrize("name", RODS)
def test_order_is_four_and_the_estimate_is_honest(name):
    """In positions, orientations, moments and energy; the estimate within a factor of 2.5."""
    case = RODS[name]
    near = Rotation.from_quat(solved(name, 40).orientations[-1])
    tip, errors = shoot(case, near * Rotation.from_rotvec((0.02, -0.01, 0.02))), []
    for elements in COUNTS:
        state = solved(name, elements)
        s, frames = state.arc_lengths, Rotation.from_quat(state.orientations).as_matrix()
        positions, turned, moments, forces = integrated(case, tip, s)
        off = norm(state.positions - positions, axis=1).max()
        bent = np.abs(state.moments - moments).max() / np.abs(moments).max()
        errors.append((off / case.rod.length, np.abs(frames - turned).max(), bent))
        assert 1.0 / 2.5 < state.discretization_error / off < 2.5
        # The trapezoidal rule for a load that varies.
        assert_allclose(state.forces, forces, atol=2.0 * np.diff(s).max() ** 3)
        if name in INEXTENSIBLE:
            inner = ~np.isclose(s, (*case.rod.breaks, -1.0)[0])
            strains = state.strains - vectors_at(case.rod.rest_strain, s)
            bent = documented.times(stiffness_at(case.rod.section, s), strains)
            assert_allclose(state.moments[inner], bent[inner], atol=1e-15)
    recorded(f"rods/{name}", [state.tip_position, state.energy, state.discretization_error])
    assert max(errors[0]) < 2e-4
    assert errors[1][0] < 1.2e-6
    # The rest is the next term of the error's expansion.
    assert_allclose(-np.diff(np.log2(errors), axis=0), 4.1, rtol=0.0, atol=0.5)
    energies = np.diff([solved(name, 2 * elements).energy for elements in COUNTS])
    assert np.log2(energies[0] / energies[1]) == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize("name", INEXTENSIBLE[:-1])
def test_energy_balance_and_pivot_are_those_of_the_documented_energy(name):
    """On few elements, where its smallest terms count; the pivot is one of the whole Hessian."""
    case, at = RODS[name], np.zeros(30)
    state = solve_rod(case, elements=10)
    energy, soft = documented.energy_of(case, 10)

    def turning(eta):
        eta = np.insert(eta, [0, 0, 0], 0.0, axis=-1)  # the base does not turn
        return energy(documented.turned(state.orientations, eta.reshape(*eta.shape[:-1], -1, 3)))

    assert state.energy == pytest.approx(turning(at), rel=1e-12)
    unit = 1.0 / soft[:, (1, 2), (1, 2)].max() / case.rod.length
    moments = documented.gradient(turning, at)
    moments[-3:] -= Rotation.from_quat(state.orientations[-1]).inv().apply(case.load.tip_moment)
    assert np.abs(moments).max() == pytest.approx(unit * state.residual, abs=1e-12 * unit)
    # The Hessian by differences (error 1e-10 or so) of exact gradients.
    near = 1e-5 * np.eye(30)
    ahead, behind = ([documented.gradient(turning, e) for e in way] for way in (near, -near))
    pivots = np.diag(np.linalg.cholesky(np.subtract(ahead, behind) / 2e-5)) ** 2
    assert pivots.min() == pytest.approx(unit * state.smallest_pivot, rel=1e-8)


@pytest.mark.parametrize("name", RODS)
def test_a_start_nearby_is_left_as_it_was_and_ends_where_the_path_does(name):
    """In one or a few of Newton's steps: the tangent, tip moment and all, is exact."""
    start = solve_rod(RODS[name], elements=10, estimate_error=False)
    before = start.orientations.copy()
    size, steps, residual = (3e-7, 1, 1e-8) if name in INEXTENSIBLE else (1e-6, 3, 1e-13)
    case = loaded(RODS[name], np.array((size, -size, 0.5 * size)), 1.0)
    near = solve_rod(case, elements=10, start=start, estimate_error=False)
    assert 0 < near.iterations <= steps
    assert near.residual < residual
    assert_array_equal(start.orientations, before)
    count = 64 if name in INEXTENSIBLE else 40
    cold, warm = (solve_rod(case, elements=count, start=s) for s in (None, solved(name, 40)))
    kept = replace(cold, orientations=np.float32(2.0 * cold.orientations))  # as files may keep it
    for other in (warm, solve_rod(case, elements=count, start=kept)):
        assert_allclose(other.positions, cold.positions, atol=1e-8)


@pytest.mark.parametrize("name", ["coupled", "stretching"])
def test_arrays_of_a_state_are_its_own(name):
    """They may be turned and changed: neither a new solve nor what goes on knows of it."""
    fields = ("arc_lengths", "positions", "orientations", "moments", "tip_reaction")
    one, other = (solve_rod(RODS[name], elements=20) for _ in range(2))
    Rotation.from_euler("x", 1.0).apply(one.positions)  # scipy refuses arrays that are read-only
    for field in fields:
        getattr(one, field)[:] = 7.0
    # The fast element goes on from what a state shows.
    start = one if one.element is RodElement.MIXED else None
    again = solve_rod(RODS[name], elements=20, start=start)
    for field in fields:
        assert_allclose(getattr(again, field), getattr(other, field), atol=1e-9)


@pytest.mark.parametrize("name", RODS)
def test_the_tip_is_the_energys_derivative_by_the_force(name):
    """Castigliano: at equilibrium dE/dF = -p(L). A moment fixed in space has no potential."""
    start = solve_rod(loaded(RODS[name], 0.0), elements=96, estimate_error=False)
    by = 2e-5 * np.array((1.0, -2.0, 2.0)) / 3.0
    less, more = (
        solve_rod(loaded(RODS[name], one), elements=96, start=start).energy for one in (-by, by)
    )
    # Differences of a minimum, d^2 times the third derivative; and the scheme's own error.
    off = (more - less + 2.0 * by @ start.tip_position) / 4e-5
    assert abs(off) < 5e-6 * RODS[name].rod.length


@pytest.mark.parametrize("name", [name for name in RODS if name != "varied"])
@pytest.mark.parametrize("kind", IMAGES)
def test_the_image_of_a_rod_has_the_image_of_its_shape(name, kind):
    """A rolled section that bends unequally is one of the mixed element: it must agree."""
    (turn, size), plain = (*IMAGES[kind], 1.0)[:2], solved(name, 80)
    case = image(RODS[name], *IMAGES[kind])
    state = solve_rod(case, elements=80)
    alike = state.element is plain.element
    off = 1e-9 if alike and plain.element is RodElement.INEXTENSIBLE else 2e-6
    agree(state.positions, size * plain.positions @ turn.T, off)
    agree(state.moments, size**3 * np.linalg.det(turn) * plain.moments @ turn.T, 5.0 * off)
    assert state.energy == pytest.approx(size**3 * plain.energy, rel=10.0 * off)
    if "rolled" not in kind:  # a pivot is of the frame
        assert state.smallest_pivot == pytest.approx(plain.smallest_pivot, rel=1e-5)


@pytest.mark.parametrize("name", INEXTENSIBLE[:-1])
def test_both_elements_agree_and_go_on_from_each_other(name):
    """From a base elsewhere too, or one whose quaternion has the other sign."""
    case, fast = RODS[name], solved(name, 80)
    slow = solved(name, 80, RodElement.MIXED)
    back = solve_rod(case, elements=80, start=fast, element=RodElement.MIXED)
    agree(back.positions, slow.positions, 2e-9)
    agree(slow.positions, fast.positions, 3e-6)
    for field in ("forces", "moments", "base_reaction"):
        agree(getattr(slow, field), getattr(fast, field), 5e-6)
    for base in (Clamped((0.1, 0.0, 0.2), TURNED), Clamped(orientation=(0.0, 0.0, 0.0, -1.0))):
        elsewhere = solve_rod(replace(loaded(case, 0.0), base=base), elements=80)
        agree(solve_rod(case, elements=80, start=elsewhere).positions, fast.positions, 1e-8)
    same = solve_rod(replace(case, base=base), elements=80, start=slow)
    agree(same.positions, slow.positions, 2e-9)


def test_twenty_random_rods_agree_with_shooting():
    """The requirement is 1e-3 of the length; the elements are chosen for about 1e-5 of it."""
    rng, rows = np.random.default_rng(11), []
    for _ in range(20):
        case = drawn(rng, (5.0, 0.15, 0.6e6, -0.9), (60.0, 1.0, 3.0e6, 0.9))
        state, length = solve_rod(case), case.rod.length
        tip = shoot(case, Rotation.from_quat(state.orientations[-1]))
        positions, _, moments, _ = integrated(case, tip)
        off = norm(state.tip_position - positions[-1])
        bent = np.abs(state.moments[0] - moments[0]).max() / np.abs(moments).max()
        count = len(state.positions) - 1
        turned = length * norm(case.rod.rest_strain) / 0.25
        rows.append((off / length, state.discretization_error / off, bent, count / turned))
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
    rng = np.random.default_rng(12)
    for _ in range(3):
        case = drawn(rng, (5.0, 0.15, 1.0e6, -0.9), (40.0, 0.4, 3.0e6, 0.9))
        tip = Rotation.from_rotvec(np.multiply(case.rod.length, case.rod.rest_strain))
        for part in (1, 2, 3):
            tip = shoot(
                replace(case, load=RodLoad(np.multiply(part / 3.0, case.load.distributed))), tip
            )
        # The elements are chosen for 1e-5.
        off = norm(solve_rod(case).tip_position - integrated(case, tip)[0][-1])
        assert off < 5e-5 * case.rod.length
