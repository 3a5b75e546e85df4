# SPDX-License-Identifier: Apache-2.0
"""Small matrices and vectors, compiled: in numbered slots of a workspace, or one for each point."""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled

Array: TypeAlias = NDArray[np.float64]


@compiled
def rotation(q: Array, out: Array) -> None:
    """Write R(q)."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    out[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    out[0, 1] = 2.0 * (x * y - z * w)
    out[0, 2] = 2.0 * (x * z + y * w)
    out[1, 0] = 2.0 * (x * y + z * w)
    out[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    out[1, 2] = 2.0 * (y * z - x * w)
    out[2, 0] = 2.0 * (x * z - y * w)
    out[2, 1] = 2.0 * (y * z + x * w)
    out[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@compiled
def multiply(slots: Array, first: int, second: int, result: int) -> None:
    """Write the product of two slots into a third."""
    a, b, out = slots[first], slots[second], slots[result]
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@compiled
def skew(slots: Array, slot: int, vectors: Array, vector: int) -> None:
    """Write the matrix of a -> v x a."""
    out, v = slots[slot], vectors[vector]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i, i] = 0.0
        out[i, j] = -v[k]
        out[i, k] = v[j]


@compiled
def cross(vectors: Array, first: int, second: int, result: int) -> None:
    """Write the cross product of two vectors into a third."""
    a, b, out = vectors[first], vectors[second], vectors[result]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = a[j] * b[k] - a[k] * b[j]


@compiled
def transpose(slots: Array, slot: int, result: int) -> None:
    """Write the transpose of a slot into another."""
    for i in range(3):
        for j in range(3):
            slots[result, i, j] = slots[slot, j, i]


@compiled
def product(a: Array, b: Array, transposed: bool, out: Array) -> None:
    """Write a b, or a^T b, of (9, 9) matrices."""
    for i in range(9):
        for j in range(9):
            out[i, j] = 0.0
        for k in range(9):
            value = a[k, i] if transposed else a[i, k]
            if value != 0.0:
                for j in range(9):
                    out[i, j] += value * b[k, j]


@compiled
def in_space(turn: Array, normal: Array, bend: Array) -> tuple[Array, Array]:
    """Return gradients (n, 3) and Hessians (n, 3, 3) of a shape's frame in the base frame."""
    normals, bends = np.zeros_like(normal), np.zeros_like(bend)
    half = np.empty((3, 3))
    for e in range(len(normal)):
        for i in range(3):
            for k in range(3):
                half[i, k] = 0.0
                for m in range(3):
                    half[i, k] += turn[i, m] * bend[e, m, k]
                normals[e, i] += turn[i, k] * normal[e, k]
        for i in range(3):
            for k in range(3):
                for m in range(3):
                    bends[e, i, k] += half[i, m] * turn[k, m]
    return normals, bends


@compiled
def around_axis(points: Array, rho: Array, radial: Array, around: Array) -> None:
    """Write the distance (n,) from the z axis, e_rho (n, 3) and e_phi e_phi^T (n, 3, 3)."""
    for e in range(len(points)):
        rho[e] = math.hypot(points[e, 0], points[e, 1])
        x = points[e, 0] / rho[e] if rho[e] > 0.0 else 1.0
        y = points[e, 1] / rho[e] if rho[e] > 0.0 else 0.0
        radial[e, 0], radial[e, 1], radial[e, 2] = x, y, 0.0
        for i in range(3):
            for k in range(3):
                around[e, i, k] = 0.0
        around[e, 0, 0], around[e, 1, 1] = y * y, x * x
        around[e, 0, 1] = around[e, 1, 0] = -x * y
