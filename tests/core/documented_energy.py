# SPDX-License-Identifier: Apache-2.0
"""The rod's energy as ``docs/derivations/rod.md`` writes it, in plain numpy.

Every operation is analytic, so that the complex step gives derivatives to rounding: scalar products
are sums of products, and nothing is conjugated.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from core.rod_cases import stiffness_at, vectors_at
from numpy.typing import NDArray

from spiral_core import RodProblem

Complex = NDArray[Any]  # float64 or complex128
TANGENT = np.array([1.0, 0.0, 0.0])
BACK = np.array([-1.0, -1.0, -1.0, 1.0])


def product(a: Complex, b: Complex) -> Complex:
    """Return the products (n, 4) of scalar-last quaternions."""
    vector = a[:, 3:] * b[:, :3] + b[:, 3:] * a[:, :3] + np.cross(a[:, :3], b[:, :3])
    scalar = a[:, 3:] * b[:, 3:] - np.sum(a[:, :3] * b[:, :3], axis=1, keepdims=True)
    return np.hstack((vector, scalar))


def turned(q: Complex, eta: Complex) -> Complex:
    """Return q exp(eta / 2), exact to second order."""
    turn = np.hstack((0.5 * eta, np.ones((len(eta), 1))))
    return product(q, turn / np.sqrt(np.sum(turn * turn, axis=1, keepdims=True)))


def seen(q: Complex, v: Complex) -> Complex:
    """Return R(q)^T v."""
    return product(product(q * BACK, np.hstack((v, np.zeros((len(v), 1))))), q)[:, :3]


def series(square: Complex) -> Complex:
    """Return the series of asin(z) / z to z^6."""
    return 1.0 + square / 6.0 + 3.0 * square**2 / 40.0 + 5.0 * square**3 / 112.0


def mean(samples: Complex) -> Complex:
    """Return Simpson's means over the elements, of samples at nodes and midpoints."""
    return (samples[:-2:2] + 4.0 * samples[1:-1:2] + samples[2::2]) / 6.0


def times(k: Complex, u: Complex) -> Complex:
    return np.einsum("nij,nj->ni", k, u)


def energy_of(case: RodProblem, count: int) -> Callable[[Complex], Any]:
    """Return the energy of a rod without breaks on so many elements, of its orientations.

    Of an element it is W = h (u.Ku/2 - c.u) + h^2/12 u.(t x D) - h^3/24 G.K^-1 G.
    """
    sites = np.linspace(0.0, case.rod.length, 2 * count + 1)
    h = case.rod.length / count
    k = stiffness_at(case.rod.section, sites)
    strain = vectors_at(case.rod.rest_strain, sites)
    half = 0.5 * h * np.linalg.norm(strain, axis=1, keepdims=True)
    strain = strain * series(np.sin(half) ** 2) * np.sinc(half / np.pi)
    c, weight = times(k, strain), vectors_at(case.load.distributed, sites)
    rest_energy = 0.5 * h * np.sum(mean(c * strain))
    beyond = np.cumsum(h * mean(weight)[::-1], axis=0)[::-1]
    n = case.load.tip_force + np.vstack((beyond, np.zeros(3)))
    dk, dc = np.diff(k[::2], axis=0) / h, np.diff(c[::2], axis=0) / h
    k, c, weight = mean(k), mean(c), weight[::2]

    def energy(q: Complex) -> Any:
        x = product(q[:-1] * BACK, q[1:])[:, :3]
        u = 2.0 / h * x * series(np.sum(x * x, axis=1, keepdims=True))
        a, pull = seen(q, n), seen(q, weight)[:, 0]
        bent = times(k, u) - c
        middle = 0.5 * (a[:-1] + a[1:])
        g = times(dk, u) - dc + np.cross(u, bent) + np.cross(TANGENT, middle)
        elastic = 0.5 * h * np.sum(u * (bent - c))
        lean = h**2 / 12.0 * np.sum(u * np.cross(TANGENT, np.diff(a, axis=0)))
        relaxed = h**3 / 24.0 * np.sum(g * np.linalg.solve(k, g[:, :, None])[:, :, 0])
        loads = h * np.sum(middle[:, 0]) + h**2 / 12.0 * np.sum(np.diff(pull))
        return rest_energy + elastic + lean - relaxed - loads

    return energy


def gradient(function: Callable[[Complex], Any], at: Complex) -> Complex:
    """Return the gradient of a function by the complex step: exact to rounding."""
    return np.array([np.imag(function(at + 1e-30j * e)) / 1e-30 for e in np.eye(len(at))])


def hessian(function: Callable[[Complex], Any], at: Complex) -> Complex:
    """Return the Hessian: differences (error 1e-10 or so) of exact gradients."""
    d = 1e-5
    near = [gradient(function, at + e) - gradient(function, at - e) for e in d * np.eye(len(at))]
    return np.array(near) / (2.0 * d)
