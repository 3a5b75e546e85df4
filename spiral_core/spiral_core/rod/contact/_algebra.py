# SPDX-License-Identifier: Apache-2.0
"""Small matrices, vectors and unit quaternions, scalar last.

The element's matrices and vectors are in numbered slots of a workspace; others are one for each
point, quaternions (n, 4).
"""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled

Array: TypeAlias = NDArray[np.float64]


def numbers(first: int, end: int) -> tuple[int, ...]:
    """Return integers of numpy: numba compiles a kernel once for them, but for each of Python's."""
    return tuple(np.arange(first, end))


# Slots of the 3x3 workspace. K, K', K^-1 and C are copied there; [v] means v -> a of a x v.
SLOTS = 59
K, SLOPE, INVERSE, C, R0, R1, P = numbers(0, 7)
SKEW_U, SKEW_M, SKEW_Y, SKEW_A0, SKEW_A1, SKEW_V0, SKEW_V1 = numbers(7, 14)
J, JT, JP, JPJ, KY, CY, CU = numbers(14, 21)
A0, A1, A0T, A1T, JA0, JA1, AP0, AP1, A00, A01, A11 = numbers(21, 32)
X, X0, X1, X0T, X1T, F, FX, T, TX0, TX1, X00, X01, X11 = numbers(32, 45)
SKEW_B, CB, ACB, SKEW_E = numbers(45, 49)
# Of the coupling: B, and its products.
COUPLING, UB, BU, BA0, BA1, BY, YB, SKEW_Z, BB0, BB1 = numbers(49, SLOTS)
# Whether a product takes its first matrix as it is.
PLAIN, TRANSPOSED = numbers(0, 2)
# Slots of the vectors.
VECTORS = 24
U, M, LOAD0, LOAD1, STRAIN0, STRAIN1, CROSS0, CROSS1, G, Y = numbers(0, 10)
B0, B1, EU, E0, E1, TURN0, TURN1, XV, GX, REST, RATE = numbers(10, 21)
TANGENT, Z, PULL = numbers(21, VECTORS)


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
def product(a: Array, b: Array, transposed: int, out: Array) -> None:
    """Write a b, or a^T b, of (9, 9) matrices."""
    for i in range(9):
        for j in range(9):
            out[i, j] = 0.0
        for k in range(9):
            value = a[i, k] if transposed == PLAIN else a[k, i]
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
def around_axis(points: Array) -> tuple[Array, Array, Array]:
    """Return the distance (n,) from the z axis, e_rho (n, 3) and e_phi e_phi^T (n, 3, 3)."""
    count = len(points)
    rho, radial, around = np.empty(count), np.empty((count, 3)), np.zeros((count, 3, 3))
    for e in range(count):
        rho[e] = math.hypot(points[e, 0], points[e, 1])
        x = points[e, 0] / rho[e] if rho[e] > 0.0 else 1.0
        y = points[e, 1] / rho[e] if rho[e] > 0.0 else 0.0
        radial[e, 0], radial[e, 1], radial[e, 2] = x, y, 0.0
        around[e, 0, 0], around[e, 1, 1] = y * y, x * x
        around[e, 0, 1] = around[e, 1, 0] = -x * y
    return rho, radial, around


@compiled
def matrices(q: Array) -> Array:
    """Return the rotation matrices (n, 3, 3)."""
    out = np.empty((len(q), 3, 3))
    for i in range(len(q)):
        rotation(q[i], out[i])
    return out


def composed(a: Array, b: Array) -> Array:
    """Return the products a b of quaternions, row by row."""
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
    between = composed(inverse, second)
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


def free_between(first: Array, last: Array, at: float) -> Array:
    """Return the free motions of an end of one kind; the line of a guided one turns."""
    if np.array_equal(first, last) or round(np.trace(first)) != round(np.trace(last)):
        return last
    lines = [free[3:, np.argmax(np.diag(free)[3:]) + 3] for free in (first, last)]
    lines = [line / np.sqrt(line @ line) for line in lines]
    line = (1.0 - at) * lines[0] + at * (lines[1] if lines[0] @ lines[1] >= 0.0 else -lines[1])
    free = last.copy()
    free[3:, 3:] = np.outer(line, line) / (line @ line)
    return free


def total_force(half: Array, nodal: Array) -> float:
    """Return the sum of the sizes of all loads on elements and nodes [N]."""
    parts = (np.sqrt(np.sum(force * force, axis=1)) for force in (2.0 * half, nodal[:, 3:]))
    return float(sum(np.sum(part) for part in parts))


def node_lengths(arc_lengths: Array) -> Array:
    """Return the length that each node stands for (N + 1,) [m]."""
    steps = np.diff(arc_lengths)
    lengths: Array = 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))
    return lengths
