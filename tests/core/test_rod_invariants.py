# SPDX-License-Identifier: Apache-2.0
"""Every rod of ``rod_cases``: against shooting from the tip, in balance, and its images.

Nothing of the solver is used to judge it: the reference integrates Kirchhoff's equations
(``reference_shooting``), balance is summed up from positions, forces and moments.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from core.reference_shooting import Rods, Shapes, continue_from_rest, shoot
from core.rod_cases import IMAGES, RODS, Case, gripper_rod, random_direction, stiffness_at
from scipy.spatial.transform import Rotation

from spiral_core import RodElement, RodState, solve_rod

pytestmark = pytest.mark.long

SITES = np.array([0.0, 0.5, 1.0])
COUNTS = (40, 80, 160)


def as_rods(cases: list[Case]) -> Rods:
    """Return rods as the reference wants them."""
    lengths = np.array([case.rod.length for case in cases])

    def profile(given: list, sample):
        if not any(map(callable, given)):
            return np.concatenate([sample(each, np.zeros(1)) for each in given])
        return lambda x: np.concatenate(
            [
                sample(each, np.array([x * length]))
                for each, length in zip(given, lengths, strict=True)
            ]
        )

    def vectors(given, sites: np.ndarray) -> np.ndarray:
        return given(sites) if callable(given) else np.tile(given, (len(sites), 1))

    return Rods(
        lengths,
        profile([case.rod.section for case in cases], stiffness_at),
        profile([case.rod.rest_strain for case in cases], vectors),
        profile([case.load.distributed for case in cases], vectors),
        np.array([case.load.tip_force for case in cases]),
        np.array([case.load.tip_moment for case in cases]),
        tuple(at / cases[0].rod.length for at in cases[0].rod.breaks),
    )


@cache
def solved(name: str, elements: int, estimate: bool = True) -> RodState:
    """Return the state of a named rod."""
    case = RODS[name]
    return solve_rod(case.rod, case.load, elements=elements, estimate_error=estimate)


@cache
def reference(name: str) -> Shapes:
    """Return the reference's shape of a named rod, near the solver's: of several, that one."""
    near = Rotation.from_quat(solved(name, 40).orientations[-1:])
    guess = near * Rotation.from_rotvec([0.02, -0.01, 0.02])
    shape = shoot(as_rods([RODS[name]]), guess.as_quat(), SITES)
    assert shape.miss.max() < 1e-9
    return shape


def distance(state: RodState, shape: Shapes, row: int = 0) -> float:
    """Return the largest distance of middle and tip from the reference, over the length."""
    middle = len(state.positions) // 2
    miss = state.positions[[middle, -1]] - shape.positions[row, 1:]
    return float(np.linalg.norm(miss, axis=1).max() / state.arc_lengths[-1])


@pytest.mark.parametrize("name", [name for name in RODS if name != "two tubes"])
def test_order_is_four_and_the_estimate_is_honest(name: str) -> None:
    """In positions, orientations, moments and energy; the estimate within a factor of 2.5."""
    shape, length = reference(name), RODS[name].rod.length
    rows = []
    for elements in COUNTS:
        state = solved(name, elements)
        assert state.stable
        ends = [0, elements // 2, elements]
        assert state.arc_lengths[ends] == pytest.approx(SITES * length)
        sign = np.sign(np.sum(state.orientations[ends] * shape.orientations[0], axis=1))
        off = distance(state, shape)
        rows.append(
            [
                off,
                np.abs(sign[:, None] * state.orientations[ends] - shape.orientations[0]).max(),
                np.abs(state.moments[ends] - shape.moments[0]).max() / np.abs(shape.moments).max(),
            ]
        )
        assert 1.0 / 2.5 < state.discretization_error / (length * off) < 2.5, elements
    errors = np.array(rows)
    assert errors[0].max() < 2e-4
    assert errors[1, 0] < 1.2e-6
    orders = np.log2(errors[:-1] / errors[1:])
    # The rest is the next term of the error's expansion.
    assert orders.min() > 3.6
    assert orders.max() < 4.6
    energies = np.diff([solved(name, 2 * elements, False).energy for elements in COUNTS])
    assert np.log2(energies[0] / energies[1]) == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize("name", RODS)
def test_forces_and_moments_balance_at_every_node(name: str) -> None:
    """m + p x n falls by the moment of the weight, and n by the weight, to fourth order."""
    case, errors = RODS[name], []
    for elements in COUNTS[:2]:
        state = solved(name, elements)
        s, p, n = state.arc_lengths, state.positions, state.forces
        w = case.load.distributed
        w = w(s) if callable(w) else np.tile(w, (len(s), 1))
        h = np.diff(s)[:, None]
        # Euler-Maclaurin in each piece, so that the quadrature is of fourth order too.
        parts = np.empty((elements, 3))
        ends = [0, *np.flatnonzero(np.isclose(s, [*case.rod.breaks, -1.0][0])), elements]
        for a, b in pairwise(ends):
            piece = slice(a, b + 1)
            moment = np.cross(p, w)[piece]
            slope = np.gradient(moment, s[piece], axis=0, edge_order=2)
            parts[a:b] = h[a:b] * 0.5 * (moment[:-1] + moment[1:])
            parts[a:b] += h[a:b] ** 2 / 12.0 * (slope[:-1] - slope[1:])
        beyond = np.vstack((np.cumsum(parts[::-1], axis=0)[::-1], np.zeros(3)))
        total = Rotation.from_quat(state.orientations).apply(np.array(state.moments)) + np.cross(
            p, n
        )
        miss = total - total[-1] - beyond
        errors.append(np.abs(miss).max() / np.abs(state.moments).max())
        np.testing.assert_allclose(total[-1] - np.cross(p, n)[-1], case.load.tip_moment, atol=1e-11)
        np.testing.assert_allclose(n[-1], case.load.tip_force, atol=1e-15)
        # The trapezoidal rule for a load that varies.
        np.testing.assert_allclose(
            n[:-1] - n[1:], 0.5 * h * (w[:-1] + w[1:]), atol=2.0 * h.max() ** 3
        )
        np.testing.assert_allclose(
            state.tangents,
            Rotation.from_quat(state.orientations).apply([1.0, 0.0, 0.0]),
            atol=1e-14,
        )
    assert errors[0] < 2e-4
    assert errors[1] < max(errors[0] / 8.0, 1e-11)


@pytest.mark.parametrize("name", RODS)
def test_the_tip_is_the_energys_derivative_by_the_force(name: str) -> None:
    """Castigliano: at equilibrium dE/dF = -p(L). A moment fixed in space has no potential."""
    case, d = RODS[name], 2e-5
    case = Case(case.rod, replace(case.load, tip_moment=(0.0, 0.0, 0.0)))
    start = solve_rod(case.rod, case.load, elements=96, estimate_error=False)
    derivative = np.empty(3)
    for k in range(3):
        energies = []
        for sign in (-1.0, 1.0):
            force = np.array(case.load.tip_force) + sign * d * np.eye(3)[k]
            load = replace(case.load, tip_force=tuple(force.tolist()))
            near = solve_rod(case.rod, load, elements=96, start=start, estimate_error=False)
            energies.append(near.energy)
        derivative[k] = (energies[1] - energies[0]) / (2.0 * d)
    # Differences of a minimum, d^2 times the third derivative; and the scheme's own error.
    assert np.linalg.norm(derivative + start.tip_position) < 5e-6 * case.rod.length


@pytest.mark.parametrize("image", IMAGES)
@pytest.mark.parametrize("name", RODS)
def test_the_image_of_a_rod_has_the_image_of_its_shape(name: str, image: str) -> None:
    """A rolled section that bends unequally is one of the mixed element: it must agree."""
    by, plain = IMAGES[image], solved(name, 80)
    case = by.of(RODS[name])
    state = solve_rod(case.rod, case.load, elements=80, start=None)
    alike = state.element is plain.element
    off = 1e-9 if alike and plain.element is RodElement.INEXTENSIBLE else 2e-6
    length = case.rod.length
    expected = by.scale * plain.positions @ by.turn.T
    np.testing.assert_allclose(state.positions, expected, atol=off * length)
    moments = by.stiffer / by.scale * plain.moments @ by.axial.T
    np.testing.assert_allclose(state.moments, moments, atol=5.0 * off * np.abs(moments).max())
    assert state.energy == pytest.approx(by.stiffer / by.scale * plain.energy, rel=10.0 * off)
    if "rolled" not in image:  # a pivot is of the frame
        assert state.smallest_pivot == pytest.approx(plain.smallest_pivot, rel=1e-5)


@pytest.mark.parametrize("name", RODS)
def test_strains_are_those_of_the_moments(name: str) -> None:
    case, state = RODS[name], solved(name, 40)
    if state.element is RodElement.MIXED:
        assert state.strains.shape == (0, 3)
        return
    s = state.arc_lengths
    inner = ~np.isclose(s, [*case.rod.breaks, -1.0][0])
    rest = case.rod.rest_strain
    rest = rest(s) if callable(rest) else np.array(rest)
    expected = np.einsum("nij,nj->ni", stiffness_at(case.rod.section, s), state.strains - rest)
    np.testing.assert_allclose(state.moments[inner], expected[inner], atol=1e-15)


def random_rods(
    count: int,
    seed: int,
    curvatures: tuple[float, float],
    lengths: tuple[float, float],
    moduli: tuple[float, float],
) -> list[Case]:
    """Return gripper-sized rods on tilted mounts."""
    rng = np.random.default_rng(seed)
    return [
        gripper_rod(
            curvature=(curvature := rng.uniform(*curvatures)),
            length=rng.uniform(*lengths),
            modulus=rng.uniform(*moduli),
            torsion=rng.uniform(-0.9, 0.9) * curvature,
            gravity=random_direction(rng),
        )
        for _ in range(count)
    ]


def test_forty_random_rods_agree_with_shooting() -> None:
    """The requirement is 1e-3 of the length; the elements are chosen for about 1e-5 of it."""
    cases = random_rods(40, 11, (5.0, 60.0), (0.15, 1.0), (0.6e6, 3.0e6))
    states = [solve_rod(case.rod, case.load) for case in cases]
    assert all(state.stable for state in states)
    shapes = shoot(as_rods(cases), np.array([s.orientations[-1] for s in states]), SITES)
    # Where the weight presses a long rod together the base reacts a million times to its tip, so
    # that the integrator's 1e-13 leaves 2e-10 or so.
    assert shapes.miss.max() < 1e-8
    errors = np.array([distance(state, shapes, i) for i, state in enumerate(states)])
    # Measured: 2.9e-5 at worst, at one of the smallest numbers of elements, and 2e-6 at the median.
    assert errors.max() < 5e-5
    assert np.median(errors) < 5e-6
    estimates = np.array([s.discretization_error / s.arc_lengths[-1] for s in states])
    # Honest: a factor of 3 where errors cross zero between the sites that are compared.
    assert (estimates / errors).min() > 1.0 / 3.0
    moments = [
        np.abs(s.moments[0] - shapes.moments[i, 0]).max() / np.abs(shapes.moments[i]).max()
        for i, s in enumerate(states)
    ]
    # Moments follow from the curvature's error, ten times the position's.
    assert max(moments) < 2e-4


def test_shooting_on_its_own_finds_the_same() -> None:
    """The reference continued from the unloaded helix, knowing nothing of the solver's answer."""
    cases = random_rods(12, 12, (5.0, 40.0), (0.15, 0.4), (1.0e6, 3.0e6))
    shapes = continue_from_rest(as_rods(cases), steps=5, sites=SITES)
    assert shapes.miss.max() < 1e-8
    for i, case in enumerate(cases):
        state = solve_rod(case.rod, case.load)
        assert state.stable
        assert distance(state, shapes, i) < 5e-5  # the elements are chosen for 1e-5
