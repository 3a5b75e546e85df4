# SPDX-License-Identifier: Apache-2.0
"""The mixed element: its derivatives against differences of its energy, and against the rod's."""

import numpy as np
import pytest

from spiral_core import Clamped, Rod, RodLoad, RodProblem, Section, solve_rod
from spiral_core.rod.contact._algebra import SLOTS, VECTORS, matrices, turned
from spiral_core.rod.contact._element import element
from spiral_core.rod.contact.solve import solve_contact

REST = (-13.5, 0.0, 21.0)


def _evaluate(change, ends, n, half, own):
    room = np.zeros((SLOTS, 3, 3)), np.zeros((VECTORS, 3)), np.zeros((3, 9, 9))
    g, hess = np.zeros(9), np.zeros((9, 9))
    q0, q1 = (
        turned(q[None], e[None])[0] for q, e in zip(ends, (change[:3], change[3:6]), strict=True)
    )
    return element(q0, q1, n + change[6:], half, own, *room, g, hess), g, hess


@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_gradient_and_hessian_are_those_of_the_energy(seed, coupled):
    random = np.random.default_rng(seed)
    q0 = random.normal(size=4)
    q0 /= np.linalg.norm(q0)
    ends = q0, turned(q0[None], random.normal(size=(1, 3)) * 0.4)[0]
    own = np.zeros((7, 3, 3))
    root = random.normal(size=(3, 3))
    own[0] = root @ root.T + np.eye(3)
    own[2] = np.linalg.inv(own[0])
    own[1] = (root + root.T) * 0.3
    own[3] = 0.1 * root.T @ root
    own[4, 0], own[4, 1], own[4, 2, 0] = random.normal(size=3), random.normal(size=3), 0.7
    if coupled:
        own[5], own[6, 0] = 0.3 * random.normal(size=(3, 3)), 0.3 * random.normal(size=3)
    n, half = random.normal(size=3), random.normal(size=3)
    _, gradient, hessian = _evaluate(np.zeros(9), ends, n, half, own)
    step = 1e-5
    unit = step * np.eye(9)
    values = [
        [_evaluate(s * unit[i], ends, n, half, own)[0] for s in (1.0, -1.0)] for i in range(9)
    ]
    differences = np.array([(a - b) / (2.0 * step) for a, b in values])
    np.testing.assert_allclose(gradient, differences, atol=1e-8)  # of the differences
    # The gradient turns with its node: compare the symmetric part by energy differences.
    step = 2e-4
    for i in range(9):
        for k in range(9):
            e = [
                _evaluate(step * (a * np.eye(9)[i] + b * np.eye(9)[k]), ends, n, half, own)[0]
                for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1))
            ]
            second = (e[0] - e[1] - e[2] + e[3]) / (4.0 * step * step)
            assert hessian[i, k] == pytest.approx(second, abs=2e-6)


@pytest.mark.parametrize("elements", [30, 90, 180])
def test_without_contact_it_is_the_rod_of_the_other_solver(elements):
    load = RodLoad(distributed=(0.24, 0.1, 0.0), tip_force=(0.01, 0.02, 0.0))
    free = solve_rod(
        Rod(0.36, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=REST), load, elements=elements
    )
    rod = Rod(0.36, Section((1.7e-4, 2.5e-4, 2.5e-4)), rest_strain=REST)
    state = solve_contact(RodProblem(rod, load), elements=elements)
    np.testing.assert_allclose(state.orientations, free.orientations, atol=1e-8)
    np.testing.assert_allclose(state.forces, free.forces, atol=1e-8 * np.abs(free.forces).max())
    np.testing.assert_allclose(state.moments, free.moments, atol=1e-8 * np.abs(free.moments).max())
    # Positions are the same to the discretization's error: the chord of an element is integrated
    # by another rule of fourth order.
    apart = np.abs(state.positions - free.positions).max() / 0.36
    assert apart <= 1.5 * (30 / elements) ** 4 * 6e-6


def test_moved_and_turned_base_moves_and_turns_the_rod():
    rod = Rod(0.36, Section((1.7e-4, 2.5e-4, 3.0e-4)), rest_strain=REST)
    plain = solve_contact(RodProblem(rod, RodLoad((0.0, 0.2, 0.1))), elements=60)
    turn = np.array((0.5, -0.5, 0.5, 0.5))
    matrix = matrices(turn[None])[0]
    load = tuple(matrix @ (0.0, 0.2, 0.1))
    base = Clamped((0.1, -0.2, 0.3), tuple(turn))
    moved = solve_contact(RodProblem(rod, RodLoad(load), base=base), elements=60)
    expected = plain.positions @ matrix.T + (0.1, -0.2, 0.3)
    np.testing.assert_allclose(moved.positions, expected, atol=1e-9)
