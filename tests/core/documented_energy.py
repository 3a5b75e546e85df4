# SPDX-License-Identifier: Apache-2.0
"""The rod's energy as ``docs/derivations/rod.md`` writes it, in plain numpy.

Every operation is analytic, so that the complex step gives derivatives to rounding: scalar products
are sums of products, and nothing is conjugated.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spiral_core.rod._system import System

Complex = NDArray[Any]  # float64 or complex128
TANGENT = np.array([1.0, 0.0, 0.0])
STEP = 1e-30


def product(a: Complex, b: Complex) -> Complex:
    """Return the product of scalar-last quaternions."""
    vector = a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3])
    result: Complex = np.append(vector, a[3] * b[3] - np.sum(a[:3] * b[:3]))
    return result


def conjugate(a: Complex) -> Complex:
    """Return the conjugate quaternion (not the complex conjugate)."""
    result: Complex = a * np.array([-1.0, -1.0, -1.0, 1.0])
    return result


def turned(q: Complex, eta: Complex) -> Complex:
    """Return q exp(eta / 2), for small eta: the exponential's series to the ninth power."""
    square = np.sum(eta * eta) / 4.0
    cosine = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0))
    sinc = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0))
    return product(q, np.append(0.5 * sinc * eta, cosine))


def seen(q: Complex, v: Complex) -> Complex:
    """Return R(q)^T v."""
    return product(product(conjugate(q), np.append(v, 0.0)), q)[:3]


def strain(q0: Complex, q1: Complex, h: float) -> Complex:
    """Return u = 2 f(x.x) x / h with f the series of asin(z) / z to z^6."""
    x = product(conjugate(q0), q1)[:3]
    s = np.sum(x * x)
    u: Complex = 2.0 * (1.0 + s / 6.0 + 3.0 * s**2 / 40.0 + 5.0 * s**3 / 112.0) * x / h
    return u


def section(numbers: Complex) -> Complex:
    """Return K of an element's row: twist, bending about y and z, and the coupling."""
    twist, y, z, coupling = numbers
    return np.array([[twist, 0.0, coupling], [0.0, y, 0.0], [coupling, 0.0, z]])


def element(q0: Complex, q1: Complex, n0: Complex, n1: Complex, row: Complex, h: float) -> Any:
    """Return W = h (u.Ku/2 - c.u) + h^2/12 u.(t x D) - h^3/24 G.K^-1 G."""
    k, c = section(row[:4]), row[4:7]
    dk, dc = section(row[7:11]), row[11:14]
    u = strain(q0, q1, h)
    a0, a1 = seen(q0, n0), seen(q1, n1)
    g = dk @ u - dc + np.cross(u, k @ u - c) + np.cross(TANGENT, 0.5 * (a0 + a1))
    elastic = h * np.sum(0.5 * u * (k @ u) - c * u)
    lean = h**2 / 12.0 * np.sum(u * np.cross(TANGENT, a1 - a0))
    return elastic + lean - h**3 / 24.0 * np.sum(g * np.linalg.solve(k, g))


def rod(q: Complex, system: System) -> Any:
    """Return the sum of the elements' energies and their shares of the load's, and the rest's."""
    total: Any = system.rest_energy
    n, e = system.force, system.elements
    rows = np.hstack((e.stiffness, e.rest, e.stiffness_slope, e.rest_slope))
    for i, h in enumerate(system.steps):
        total += element(q[i], q[i + 1], n[i], n[i + 1], rows[i], h)
        ends = ((q[i], n[i], -system.load_start[i]), (q[i + 1], n[i + 1], system.load_end[i]))
        for node, force, load in ends:
            total -= seen(node, h / 2.0 * force + h**2 / 12.0 * load)[0]
    return total


def gradient(function: Callable[[Complex], Any], at: Complex) -> Complex:
    """Return the gradient of a function by the complex step: exact to rounding."""
    result = np.empty(len(at))
    for i in range(len(at)):
        moved = at.astype(complex)
        moved[i] += 1j * STEP
        result[i] = np.imag(function(moved)) / STEP
    return result


def hessian(function: Callable[[Complex], Any], at: Complex) -> Complex:
    """Return the Hessian: fourth-order differences (error 1e-12 or so) of exact gradients."""
    d = 1e-3
    rows = []
    for i in range(len(at)):
        e = np.zeros(len(at))
        e[i] = d
        near = gradient(function, at + e) - gradient(function, at - e)
        far = gradient(function, at + 2.0 * e) - gradient(function, at - 2.0 * e)
        rows.append((8.0 * near - far) / (12.0 * d))
    return np.array(rows)
