# SPDX-License-Identifier: Apache-2.0
"""The element's energy against its documented formula; its derivatives against the complex step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core import documented_energy as documented
from scipy.spatial.transform import Rotation

from spiral_core.rod import _element as rod_element
from spiral_core.rod._algebra import (
    inverse,
    quaternion_product,
    rotated,
    smallest_pivot_and_inverse,
    to_base,
    to_material,
)

# Rotation of the element [rad]: none at all, so little that series matter, and more than a rod's
# discretization ever uses.
ANGLES = (0.0, 1e-9, 1e-4, 0.2, 0.7, 1.5)
H = 0.13


def random_element(angle: float, seed: int, varying: bool = True) -> tuple[np.ndarray, ...]:
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


def kernel_inputs(q0: np.ndarray, q1: np.ndarray, n0: np.ndarray, n1: np.ndarray) -> tuple:
    """Return x, w, u, a0, a1 as the kernels compute them."""
    x, w, u = rod_element.element_frame(tuple(q0), tuple(q1), H)
    return x, w, u, to_material(tuple(q0), tuple(n0)), to_material(tuple(q1), tuple(n1))


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("varying", [False, True])
def test_energy_is_the_documented_one(angle: float, varying: bool) -> None:
    for seed in range(5):
        q0, q1, n0, n1, row = random_element(angle, seed, varying)
        _, _, u, a0, a1 = kernel_inputs(q0, q1, n0, n1)
        expected = documented.element(q0, q1, n0, n1, row, H)
        energy = rod_element.element_energy(u, a0, a1, rod_element.section_of(row), H)
        assert energy == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("varying", [False, True])
def test_gradient_and_hessian_are_those_of_the_energy(angle: float, varying: bool) -> None:
    for seed in range(3):
        q0, q1, n0, n1, row = random_element(angle, seed, varying)
        x, w, u, a0, a1 = kernel_inputs(q0, q1, n0, n1)
        section = rod_element.section_of(row)
        g0, g1, h00, h01, h11 = rod_element.element_derivatives(x, w, u, a0, a1, section, H)

        def energy(
            eta: np.ndarray,
            data: tuple[np.ndarray, ...] = (q0, q1, n0, n1, row),
        ) -> complex:
            start, end = (documented.turned(data[i], eta[3 * i : 3 * i + 3]) for i in (0, 1))
            return documented.element(start, end, data[2], data[3], data[4], H)

        gradient = documented.gradient(energy, np.zeros(6))
        scale = 1.0 / H
        np.testing.assert_allclose(np.array(g0 + g1), gradient, atol=1e-13 * scale, rtol=1e-12)
        block = [np.array(m).reshape(3, 3) for m in (h00, h01, h11)]
        assembled = np.block([[block[0], block[1]], [block[1].T, block[2]]])
        hessian = documented.hessian(energy, np.zeros(6))
        np.testing.assert_allclose(assembled, hessian, atol=1e-9 * scale)
        np.testing.assert_allclose(assembled, assembled.T, atol=1e-13 * scale)


def test_an_element_at_its_rest_strain_pushes_nothing() -> None:
    """Rest strain passed through the same series is the exact rest state of a finite rotation."""
    strain = np.array([-1.3, 0.4, 2.1])
    q0 = Rotation.random(random_state=7)
    q1 = q0 * Rotation.from_rotvec(H * strain)
    x, w, u = rod_element.element_frame(tuple(q0.as_quat()), tuple(q1.as_quat()), H)
    numbers = np.array([0.7, 1.1, 1.3, 0.6])
    row = np.concatenate((numbers, documented.section(numbers) @ np.array(u), np.zeros(7)))
    none = (0.0, 0.0, 0.0)
    section = rod_element.section_of(row)
    g0, g1, *_ = rod_element.element_derivatives(x, w, u, none, none, section, H)
    np.testing.assert_allclose(np.array(g0 + g1), 0.0, atol=1e-14)
    # The series of the strain differs from the rotation vector by its first term left out.
    left_out = 35.0 / 1152.0 * math.sin(0.5 * H * np.linalg.norm(strain)) ** 8
    assert 1.0 - np.linalg.norm(u) / np.linalg.norm(strain) == pytest.approx(left_out, rel=0.05)


@pytest.mark.parametrize("z", [0.0, 1e-8, 1e-3, 0.05, 0.2])
def test_strain_factor_is_the_series_of_arcsine(z: float) -> None:
    value, first, second = rod_element.strain_factor(z * z)
    exact = math.asin(z) / z if z > 0.0 else 1.0
    # The first term left out is 35/1152 z^8.
    assert abs(value - exact) <= 0.04 * z**8 + 1e-15
    step = 1e-30
    moved = complex(z * z, step)
    polynomial = 1.0 + moved / 6.0 + 3.0 * moved**2 / 40.0 + 5.0 * moved**3 / 112.0
    slope = 1.0 / 6.0 + 3.0 * moved / 20.0 + 15.0 * moved**2 / 112.0
    assert first == pytest.approx(polynomial.imag / step, rel=1e-13)
    assert second == pytest.approx(slope.imag / step, rel=1e-13)


def test_quaternions_turn_vectors_as_scipy_does() -> None:
    rng = np.random.default_rng(3)
    for seed in range(10):
        a, b = Rotation.random(2, random_state=seed)
        v = rng.normal(size=3)
        np.testing.assert_allclose(to_base(tuple(a.as_quat()), tuple(v)), a.apply(v), atol=1e-14)
        np.testing.assert_allclose(
            to_material(tuple(a.as_quat()), tuple(v)), a.inv().apply(v), atol=1e-14
        )
        both = Rotation.from_quat(quaternion_product(tuple(a.as_quat()), tuple(b.as_quat())))
        assert (both.inv() * a * b).magnitude() < 1e-14


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e-3, 0.7])
def test_nodes_turn_to_second_order_and_stay_unit(size: float) -> None:
    q = Rotation.random(random_state=5)
    eta = size * np.array([0.6, 0.0, -0.8])
    result = np.array(rotated(tuple(q.as_quat()), tuple(eta)))
    assert np.linalg.norm(result) == pytest.approx(1.0, abs=1e-15)
    left = Rotation.from_quat(result).inv() * q * Rotation.from_rotvec(eta)
    # 2 atan(size / 2) = size - size^3 / 12 + ...: the energy's Hessian sees no difference.
    assert left.magnitude() == pytest.approx(size - 2.0 * math.atan(0.5 * size), abs=1e-15)


def test_pivots_and_inverse_of_3x3_matrices() -> None:
    rng = np.random.default_rng(4)
    for _ in range(50):
        a = rng.normal(size=(3, 3))
        np.testing.assert_allclose(
            np.array(inverse(tuple(a.ravel()))).reshape(3, 3) @ a, np.eye(3), atol=1e-9
        )
        spd = a @ a.T + 0.1 * np.eye(3)
        pivot, inverted = smallest_pivot_and_inverse(tuple(spd.ravel()))
        assert pivot == pytest.approx((np.diag(np.linalg.cholesky(spd)) ** 2).min(), rel=1e-9)
        np.testing.assert_allclose(np.array(inverted).reshape(3, 3) @ spd, np.eye(3), atol=1e-11)


def test_a_pivot_is_positive_exactly_for_positive_definite_matrices() -> None:
    rng = np.random.default_rng(6)
    signs = set()
    for _ in range(200):
        a = rng.normal(size=(3, 3))
        symmetric = a + a.T + rng.uniform(-1.0, 5.0) * np.eye(3)
        definite = bool(np.linalg.eigvalsh(symmetric)[0] > 0.0)
        pivot, _ = smallest_pivot_and_inverse(tuple(symmetric.ravel()))
        assert bool(pivot > 0.0) is definite
        signs.add(definite)
    assert signs == {True, False}
