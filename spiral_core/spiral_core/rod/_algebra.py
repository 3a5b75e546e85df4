# SPDX-License-Identifier: Apache-2.0
"""3-vectors and 3x3 matrices as plain tuples, for the compiled rod kernels.

A tuple lives in registers, an array on the heap: inside a loop over rod elements that is a factor
of ten. Matrices are row-major 9-tuples. Nothing here is specific to rods.
"""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import inlined

Array: TypeAlias = NDArray[np.float64]
Vec: TypeAlias = tuple[float, float, float]
Mat: TypeAlias = tuple[float, float, float, float, float, float, float, float, float]
Quat: TypeAlias = tuple[float, float, float, float]

TANGENT = (1.0, 0.0, 0.0)


@inlined
def dot(a: Vec, b: Vec) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a: Vec, b: Vec) -> Vec:
    """Return a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@inlined
def add(a: Vec, b: Vec) -> Vec:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@inlined
def scale(c: float, a: Vec) -> Vec:
    """Return c a."""
    return (c * a[0], c * a[1], c * a[2])


@inlined
def matvec(m: Mat, v: Vec) -> Vec:
    """Return m v."""
    return (
        m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
        m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
        m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
    )


@inlined
def matvec_t(m: Mat, v: Vec) -> Vec:
    """Return m^T v."""
    return (
        m[0] * v[0] + m[3] * v[1] + m[6] * v[2],
        m[1] * v[0] + m[4] * v[1] + m[7] * v[2],
        m[2] * v[0] + m[5] * v[1] + m[8] * v[2],
    )


@inlined
def matmul(a: Mat, b: Mat) -> Mat:
    """Return a b."""
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6],
        a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8],
        a[3] * b[0] + a[4] * b[3] + a[5] * b[6],
        a[3] * b[1] + a[4] * b[4] + a[5] * b[7],
        a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6],
        a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )


@inlined
def transpose(a: Mat) -> Mat:
    """Return a^T."""
    return (a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8])


@inlined
def matmul_t(a: Mat, b: Mat) -> Mat:
    """Return a^T b."""
    return matmul(transpose(a), b)


@inlined
def matadd(a: Mat, b: Mat) -> Mat:
    """Return a + b."""
    return (
        a[0] + b[0],
        a[1] + b[1],
        a[2] + b[2],
        a[3] + b[3],
        a[4] + b[4],
        a[5] + b[5],
        a[6] + b[6],
        a[7] + b[7],
        a[8] + b[8],
    )


@inlined
def matscale(c: float, a: Mat) -> Mat:
    """Return c a."""
    return (
        c * a[0],
        c * a[1],
        c * a[2],
        c * a[3],
        c * a[4],
        c * a[5],
        c * a[6],
        c * a[7],
        c * a[8],
    )


@inlined
def outer(a: Vec, b: Vec) -> Mat:
    """Return a b^T."""
    return (
        a[0] * b[0],
        a[0] * b[1],
        a[0] * b[2],
        a[1] * b[0],
        a[1] * b[1],
        a[1] * b[2],
        a[2] * b[0],
        a[2] * b[1],
        a[2] * b[2],
    )


@inlined
def skew(a: Vec) -> Mat:
    """Return the matrix of v -> a x v."""
    return (0.0, -a[2], a[1], a[2], 0.0, -a[0], -a[1], a[0], 0.0)


@inlined
def matmul_skew(m: Mat, a: Vec) -> Mat:
    """Return m [a], with [a] the matrix of v -> a x v."""
    return (
        m[1] * a[2] - m[2] * a[1],
        m[2] * a[0] - m[0] * a[2],
        m[0] * a[1] - m[1] * a[0],
        m[4] * a[2] - m[5] * a[1],
        m[5] * a[0] - m[3] * a[2],
        m[3] * a[1] - m[4] * a[0],
        m[7] * a[2] - m[8] * a[1],
        m[8] * a[0] - m[6] * a[2],
        m[6] * a[1] - m[7] * a[0],
    )


@inlined
def skew_matmul(a: Vec, m: Mat) -> Mat:
    """Return [a] m, with [a] the matrix of v -> a x v."""
    return (
        a[1] * m[6] - a[2] * m[3],
        a[1] * m[7] - a[2] * m[4],
        a[1] * m[8] - a[2] * m[5],
        a[2] * m[0] - a[0] * m[6],
        a[2] * m[1] - a[0] * m[7],
        a[2] * m[2] - a[0] * m[8],
        a[0] * m[3] - a[1] * m[0],
        a[0] * m[4] - a[1] * m[1],
        a[0] * m[5] - a[1] * m[2],
    )


@inlined
def diagonal(a: float, b: float, c: float) -> Mat:
    """Return diag(a, b, c)."""
    return (a, 0.0, 0.0, 0.0, b, 0.0, 0.0, 0.0, c)


@inlined
def inverse(m: Mat) -> Mat:
    """Return m^-1 by cofactors (the caller has checked that m is far from singular)."""
    c0 = m[4] * m[8] - m[5] * m[7]
    c1 = m[5] * m[6] - m[3] * m[8]
    c2 = m[3] * m[7] - m[4] * m[6]
    d = 1.0 / (m[0] * c0 + m[1] * c1 + m[2] * c2)
    return (
        d * c0,
        d * (m[2] * m[7] - m[1] * m[8]),
        d * (m[1] * m[5] - m[2] * m[4]),
        d * c1,
        d * (m[0] * m[8] - m[2] * m[6]),
        d * (m[2] * m[3] - m[0] * m[5]),
        d * c2,
        d * (m[1] * m[6] - m[0] * m[7]),
        d * (m[0] * m[4] - m[1] * m[3]),
    )


@inlined
def smallest_pivot_and_inverse(m: Mat) -> tuple[float, Mat]:
    """Return the smallest Cholesky pivot of a symmetric m, and m^-1, from its upper triangle.

    Pivots are ratios of leading minors. Once one is not positive the later ones mean nothing: it is
    returned, and the inverse with it must not be used.
    """
    minor = m[0] * m[4] - m[1] * m[1]
    c0 = m[4] * m[8] - m[5] * m[5]
    c1 = m[2] * m[5] - m[1] * m[8]
    c2 = m[1] * m[5] - m[2] * m[4]
    determinant = m[0] * c0 + m[1] * c1 + m[2] * c2
    d = 1.0 / determinant
    a, b, c = d * c0, d * c1, d * c2
    e, f = d * (m[0] * m[8] - m[2] * m[2]), d * (m[1] * m[2] - m[0] * m[5])
    inverse_m = (a, b, c, b, e, f, c, f, d * minor)
    if not m[0] > 0.0:
        return m[0], inverse_m
    second = minor / m[0]
    if not second > 0.0:
        return second, inverse_m
    return min(m[0], second, determinant / minor), inverse_m


@inlined
def quaternion_product(a: Quat, b: Quat) -> Quat:
    """Return the product a b of scalar-last quaternions."""
    return (
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
        a[3] * b[1] + a[1] * b[3] + a[2] * b[0] - a[0] * b[2],
        a[3] * b[2] + a[2] * b[3] + a[0] * b[1] - a[1] * b[0],
        a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
    )


@inlined
def to_material(q: Quat, v: Vec) -> Vec:
    """Return R(q)^T v: a vector of the base frame seen from the material frame."""
    axis = (q[0], q[1], q[2])
    t = scale(-2.0, cross(axis, v))
    return add(v, add(scale(q[3], t), scale(-1.0, cross(axis, t))))


@inlined
def to_base(q: Quat, v: Vec) -> Vec:
    """Return R(q) v: a vector of the material frame seen from the base frame."""
    axis = (q[0], q[1], q[2])
    t = scale(2.0, cross(axis, v))
    return add(v, add(scale(q[3], t), cross(axis, t)))


@inlined
def rotated(q: Quat, rotation: Vec) -> Quat:
    """Return q turned by a rotation vector [rad] in its frame: unit, exact to second order."""
    half = (0.5 * rotation[0], 0.5 * rotation[1], 0.5 * rotation[2], 1.0)
    p = quaternion_product(q, half)
    c = 1.0 / math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3])
    return (c * p[0], c * p[1], c * p[2], c * p[3])


@inlined
def vector_at(rows: Array, i: int) -> Vec:
    """Return row i of an (n, 3) array as a tuple."""
    return (rows[i, 0], rows[i, 1], rows[i, 2])


@inlined
def quaternion_at(rows: Array, i: int) -> Quat:
    """Return row i of an (n, 4) array as a tuple."""
    return (rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3])


@inlined
def largest_component(a: Vec) -> float:
    """Return the largest absolute component of a."""
    return max(abs(a[0]), abs(a[1]), abs(a[2]))
