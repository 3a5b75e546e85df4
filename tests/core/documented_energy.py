# SPDX-License-Identifier: Apache-2.0
"""The rod's energy as ``docs/derivations/rod.md`` writes it, in plain numpy.

Every operation is analytic, so that the complex step gives derivatives to rounding: scalar products
are sums of products, and nothing is conjugated. Of (..., n, 3 or 4) all (...) are treated at once.
"""

import numpy as np
from core.rod_cases import stiffness_at, vectors_at

TANGENT = np.array([1.0, 0.0, 0.0])
BACK = np.array([-1.0, -1.0, -1.0, 1.0])


def dot(a, b):
    return np.sum(a * b, axis=-1, keepdims=True)


def product(a, b):
    """Return the products of scalar-last quaternions."""
    u, s, v, t = a[..., :3], a[..., 3:], b[..., :3], b[..., 3:]
    return np.concatenate((s * v + t * u + np.cross(u, v), s * t - dot(u, v)), axis=-1)


def turned(q, eta):
    """Return q exp(eta / 2), exact to second order."""
    turn = np.concatenate((0.5 * eta, np.ones_like(eta[..., :1])), axis=-1)
    return product(q, turn / np.sqrt(dot(turn, turn)))


def seen(q, v):
    """Return R(q)^T v."""
    return product(product(q * BACK, np.pad(v, ((0, 0), (0, 1)))), q)[..., :3]


def series(square):
    """Return the series of asin(z) / z to z^6."""
    return 1.0 + square / 6.0 + 3.0 * square**2 / 40.0 + 5.0 * square**3 / 112.0


def mean(samples):
    """Return Simpson's means over the elements, of samples at nodes and midpoints."""
    return (samples[:-2:2] + 4.0 * samples[1:-1:2] + samples[2::2]) / 6.0


def times(k, u):
    return np.einsum("nij,...nj->...ni", k, u)


def energy_of(case, count):
    """Return the energy of a rod's orientations on so many elements, and these' compliance.

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
    soft = np.linalg.inv(k)

    def energy(q):
        x = product(q[..., :-1, :] * BACK, q[..., 1:, :])[..., :3]
        u = 2.0 / h * x * series(dot(x, x))
        a = seen(q, n)
        bent = times(k, u) - c
        middle = 0.5 * (a[..., :-1, :] + a[..., 1:, :])
        g = times(dk, u) - dc + np.cross(u, bent) + np.cross(TANGENT, middle)
        elastic = 0.5 * h * dot(u, bent - c)
        lean = h**2 / 12.0 * dot(u, np.cross(TANGENT, np.diff(a, axis=-2)))
        relaxed = h**3 / 24.0 * dot(g, times(soft, g))
        loads = h * middle + h**2 / 12.0 * np.diff(seen(q, weight), axis=-2)
        return rest_energy + np.sum(elastic + lean - relaxed - loads[..., :1], axis=(-1, -2))

    return energy, soft


def gradient(function, at):
    """Return the gradient of a function by the complex step: exact to rounding."""
    return np.imag(function(at + 1e-30j * np.eye(len(at)))) / 1e-30
