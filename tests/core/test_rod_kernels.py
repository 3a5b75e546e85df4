# SPDX-License-Identifier: Apache-2.0
"""Both elements' kernels against their documented energies, by differences and complex steps.

Private kernels, because nothing else shows a derivative: a wrong Hessian still converges, slowly,
to the right state, and its pivot is the certificate of stability that every answer carries.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from core import documented_energy as documented
from scipy.spatial.transform import Rotation

from spiral_core import Rod, RodLoad, Section
from spiral_core.rod import _element as rod_element
from spiral_core.rod._algebra import to_material, turned
from spiral_core.rod._mesh import discretize
from spiral_core.rod._newton import back_substitute, newton_pass, scales_of
from spiral_core.rod.contact._contact import empty
from spiral_core.rod.contact._element import Elements
from spiral_core.rod.contact._newton import assemble, no_elements

# Rotation of the element [rad]: none at all, so little that series matter, and more than a rod's
# discretization ever uses.
ANGLES = (0.0, 1e-9, 1e-4, 0.2, 0.7, 1.5)
H = 0.13


def random_element(angle: float, seed: int, varying: bool) -> tuple[np.ndarray, ...]:
    """Return q0, q1, n0, n1 and the element's row, of order one."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    first = Rotation.random(random_state=seed)
    second = first * Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    stiffness = rng.uniform(0.4, 2.0, 3)
    coupling = rng.uniform(-0.9, 0.9) * math.sqrt(stiffness[0] * stiffness[2])
    row = np.concatenate((stiffness, [coupling], rng.normal(size=3), rng.normal(size=7)))
    if not varying:
        row[7:] = 0.0
    return first.as_quat(), second.as_quat(), rng.normal(size=3), rng.normal(size=3), row


def section_of(row: np.ndarray) -> rod_element.Section:
    """Return the section of a row as the kernels take it."""
    slices = (slice(0, 4), slice(4, 7), slice(7, 11), slice(11, 14))
    return rod_element.section_at(rod_element.Elements(*(row[None, part] for part in slices)), 0)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("varying", [False, True])
def test_inextensible_element_has_the_documented_energy_and_its_derivatives(
    angle: float, varying: bool
) -> None:
    for seed in range(5):
        q0, q1, n0, n1, row = random_element(angle, seed, varying)
        x, w, u = rod_element.element_frame(tuple(q0), tuple(q1), H)
        ends = to_material(tuple(q0), tuple(n0)), to_material(tuple(q1), tuple(n1))
        section = section_of(row)
        expected = documented.element(q0, q1, n0, n1, row, H)
        energy = rod_element.element_energy(u, *ends, section, H)
        assert energy == pytest.approx(expected, rel=1e-13)
        g0, g1, h00, h01, h11 = rod_element.element_derivatives(x, w, u, *ends, section, H)

        def turning(
            eta: np.ndarray, data: tuple[np.ndarray, ...] = (q0, q1, n0, n1, row)
        ) -> complex:
            start, end = (documented.turned(data[i], eta[3 * i : 3 * i + 3]) for i in (0, 1))
            return documented.element(start, end, *data[2:], H)

        gradient = documented.gradient(turning, np.zeros(6))
        np.testing.assert_allclose(np.array(g0 + g1), gradient, atol=1e-13 / H, rtol=1e-12)
        block = [np.array(m).reshape(3, 3) for m in (h00, h01, h11)]
        assembled = np.block([[block[0], block[1]], [block[1].T, block[2]]])
        hessian = documented.hessian(turning, np.zeros(6))
        np.testing.assert_allclose(assembled, hessian, atol=1e-9 / H)
        np.testing.assert_allclose(assembled, assembled.T, atol=1e-13 / H)


# A rod of order one (L = EI = 1), everything varying along it, at a disturbed state.
COUNT = 4
VARIED = Rod(
    1.0,
    Section.varying(lambda s: 1.0 + 0.3 * np.sin(3.0 * s), lambda s: 0.7 - 0.2 * s),
    rest_strain=lambda s: np.column_stack((np.cos(s), 0.3 * s, 2.0 + s * s)),
)
LOAD = RodLoad(
    lambda s: np.column_stack((1.0 + s, np.sin(s), -0.5 * s)), tip_force=(0.4, -0.7, 0.2)
)
SYSTEM = discretize(VARIED, LOAD, (COUNT,))


def disturbed() -> np.ndarray:
    """Return random orientations, neighbors within 0.1 rad or so; the base is clamped."""
    rng = np.random.default_rng(2)
    nodes = [Rotation.identity()]
    for _ in range(COUNT):
        nodes.append(nodes[-1] * Rotation.from_rotvec(0.1 * rng.normal(size=3)))
    return np.array([node.as_quat() for node in nodes])


@cache
def documented_derivatives() -> tuple[float, np.ndarray, np.ndarray]:
    """Return the documented energy, its gradient and its Hessian at the disturbed state."""
    q, at = disturbed(), np.zeros(3 * COUNT)

    def energy(eta: np.ndarray) -> complex:
        steps = eta.reshape(COUNT, 3)
        nodes = [documented.turned(a, e) for a, e in zip(q[1:], steps, strict=True)]
        return documented.rod([q[0].astype(eta.dtype), *nodes], SYSTEM)

    return energy(at), documented.gradient(energy, at), documented.hessian(energy, at)


@pytest.mark.parametrize("shift", [5.0, 0.5, -1.0])
def test_a_pass_is_newtons_step_on_the_documented_energy(shift: float) -> None:
    """Elimination against dense algebra: what it leaves out of the Hessian is zero."""
    expected, gradient, hessian = documented_derivatives()
    hessian = hessian + shift * np.eye(3 * COUNT)
    gains, offsets, step = np.empty((COUNT - 1, 9)), np.empty((COUNT, 3)), np.empty((COUNT, 3))
    energy, residual, decrement, pivot, neutral = newton_pass(
        disturbed(), SYSTEM, shift, scales_of(SYSTEM), gains, offsets
    )
    assert neutral == 0
    assert energy == pytest.approx(expected, rel=1e-12)
    assert residual == pytest.approx(np.abs(gradient).max(), rel=1e-11)
    assert (pivot > 0.0) is bool(np.linalg.eigvalsh(hessian)[0] > 0.0) is (shift > 0.0)
    if shift < 0.0:
        return
    largest = back_substitute(gains, offsets, step)
    newton = -np.linalg.solve(hessian, gradient)
    np.testing.assert_allclose(step.ravel(), newton, rtol=1e-8, atol=1e-10)
    assert decrement == pytest.approx(-gradient @ newton, rel=1e-8)
    smallest = (np.diag(np.linalg.cholesky(hessian)) ** 2).min()
    assert pivot == pytest.approx(smallest, rel=1e-8)
    rotations = np.abs(np.diff(np.vstack((np.zeros(3), step)), axis=0)).max()
    assert largest == pytest.approx(max(np.abs(step).max(), 2.0 * rotations), rel=1e-12)


def evaluate(change, ends, n, elements):
    """Return energy, gradient and Hessian of a mixed element, its nodes and its force changed."""
    x = empty(1, 0, turned(ends, change[:6].reshape(2, 3)), np.zeros((2, 3)))
    x.n[0] = n + change[6:]
    found = no_elements(1)
    return assemble(x, elements, found), found.gradients[0], found.hessians[0]


@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_mixed_elements_gradient_and_hessian_are_those_of_its_energy(seed, coupled):
    random = np.random.default_rng(seed)
    q0 = random.normal(size=4)
    q0 /= np.linalg.norm(q0)
    ends = np.vstack((q0, turned(q0[None], random.normal(size=(1, 3)) * 0.4)))
    root = random.normal(size=(3, 3))
    stiffness = root @ root.T + np.eye(3)
    parts = {
        "stiffness": stiffness,
        "stiffness_slope": (root + root.T) * 0.3,
        "flexibility": np.linalg.inv(stiffness),
        "compliance": 0.1 * root.T @ root,
        "coupling": coupled * 0.3 * random.normal(size=(3, 3)),
        "rest": random.normal(size=3),
        "rest_slope": random.normal(size=3),
        "rest_stretch": coupled * 0.3 * random.normal(size=3),
        "half_load": random.normal(size=3),
    }
    elements = Elements(np.array([0.7]), **{name: part[None] for name, part in parts.items()})
    n = random.normal(size=3)

    def energy(change: np.ndarray) -> float:
        return evaluate(change, ends, n, elements)[0]

    _, gradient, hessian = evaluate(np.zeros(9), ends, n, elements)
    unit = 1e-5 * np.eye(9)
    differences = [(energy(e) - energy(-e)) / 2e-5 for e in unit]
    np.testing.assert_allclose(gradient, differences, atol=1e-8)  # of the differences
    # The gradient turns with its node: compare the symmetric part by energy differences.
    unit = 2e-4 * np.eye(9)
    for i, k in np.ndindex(9, 9):
        a, b = unit[i], unit[k]
        second = (energy(a + b) - energy(a - b) - energy(b - a) + energy(-a - b)) / 1.6e-7
        assert hessian[i, k] == pytest.approx(second, abs=2e-6)
