# SPDX-License-Identifier: Apache-2.0
"""Unit quaternions, scalar last, as arrays (n, 4)."""

from __future__ import annotations

import numpy as np

from spiral_core.rod.types import Array


def matrices(q: Array) -> Array:
    """Return the rotation matrices (n, 3, 3)."""
    x, y, z, w = q.T
    out = np.empty((len(q), 3, 3))
    out[:, 0, 0] = 1.0 - 2.0 * (y * y + z * z)
    out[:, 0, 1] = 2.0 * (x * y - z * w)
    out[:, 0, 2] = 2.0 * (x * z + y * w)
    out[:, 1, 0] = 2.0 * (x * y + z * w)
    out[:, 1, 1] = 1.0 - 2.0 * (x * x + z * z)
    out[:, 1, 2] = 2.0 * (y * z - x * w)
    out[:, 2, 0] = 2.0 * (x * z - y * w)
    out[:, 2, 1] = 2.0 * (y * z + x * w)
    out[:, 2, 2] = 1.0 - 2.0 * (x * x + y * y)
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
    half = np.ones_like(q)
    half[:, :3] = 0.5 * rotation
    out = product(q, half)
    out /= np.sqrt(np.sum(out * out, axis=1))[:, None]
    return out


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
