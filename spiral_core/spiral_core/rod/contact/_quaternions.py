# SPDX-License-Identifier: Apache-2.0
"""Unit quaternions, scalar last, as arrays (n, 4)."""

from __future__ import annotations

import math

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod.contact._slots import rotation
from spiral_core.rod.types import Array


@compiled
def matrices(q: Array) -> Array:
    """Return the rotation matrices (n, 3, 3)."""
    out = np.empty((len(q), 3, 3))
    for i in range(len(q)):
        rotation(q[i], out[i])
    return out


def product(a: Array, b: Array) -> Array:
    """Return the products a b, row by row."""
    out = np.empty_like(a)
    out[:, 0] = a[:, 3] * b[:, 0] + a[:, 0] * b[:, 3] + a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1]
    out[:, 1] = a[:, 3] * b[:, 1] + a[:, 1] * b[:, 3] + a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2]
    out[:, 2] = a[:, 3] * b[:, 2] + a[:, 2] * b[:, 3] + a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    out[:, 3] = a[:, 3] * b[:, 3] - a[:, 0] * b[:, 0] - a[:, 1] * b[:, 1] - a[:, 2] * b[:, 2]
    return out


def turned(q: Array, rotation: Array) -> Array:
    """Return q turned by rotation vectors (n, 3) [rad] in their frames: exact to second order."""
    out = q.copy()
    turn_nodes(out, 0.5 * rotation)
    return out


@compiled
def turn_nodes(q: Array, half: Array) -> None:
    """Turn quaternions (n, 4) in place by the products with (half, 1), normalized."""
    for i in range(len(q)):
        x, y, z, w = q[i, 0], q[i, 1], q[i, 2], q[i, 3]
        a, b, c = half[i, 0], half[i, 1], half[i, 2]
        q[i, 0] = x + w * a + y * c - z * b
        q[i, 1] = y + w * b + z * a - x * c
        q[i, 2] = z + w * c + x * b - y * a
        q[i, 3] = w - x * a - y * b - z * c
        size = math.sqrt(q[i, 0] ** 2 + q[i, 1] ** 2 + q[i, 2] ** 2 + q[i, 3] ** 2)
        for k in range(4):
            q[i, k] /= size


def turn_between(first: Array, second: Array) -> Array:
    """Return r (n, 3) with ``turned(first, r)`` equal to ``second``: 2 tan of half the angle."""
    inverse = first * np.array((-1.0, -1.0, -1.0, 1.0))
    between = product(inverse, second)
    vector: Array = 2.0 * between[:, :3] / between[:, 3:]
    return vector


def blended(first: Array, second: Array, at: float) -> Array:
    """Return quaternions at the fraction ``at`` of the way, normalized; for small turns."""
    sign = np.where(np.sum(first * second, axis=1) < 0.0, -1.0, 1.0)[:, None]
    mean = (1.0 - at) * first + at * sign * second
    mean /= np.sqrt(np.sum(mean * mean, axis=1))[:, None]
    return mean


def skews(v: Array) -> Array:
    """Return the matrices (n, 3, 3) of a -> v x a."""
    out = np.zeros((len(v), 3, 3))
    out[:, 0, 1] = -v[:, 2]
    out[:, 0, 2] = v[:, 1]
    out[:, 1, 0] = v[:, 2]
    out[:, 1, 2] = -v[:, 0]
    out[:, 2, 0] = -v[:, 1]
    out[:, 2, 1] = v[:, 0]
    return out
