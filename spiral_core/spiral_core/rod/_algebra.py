# SPDX-License-Identifier: Apache-2.0
"""3-vectors, 3x3 matrices and quaternions, scalar last: one at a time, and arrays of them.

One at a time they are plain tuples, for the compiled rod kernels: a tuple lives in registers, an
array on the heap, which inside a loop over rod elements is a factor of ten. Matrices are row-major
9-tuples. Nothing here is specific to rods.
"""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled, inlined

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
def subtract(a: Vec, b: Vec) -> Vec:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


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
def matsubtract(a: Mat, b: Mat) -> Mat:
    """Return a - b."""
    return (
        a[0] - b[0],
        a[1] - b[1],
        a[2] - b[2],
        a[3] - b[3],
        a[4] - b[4],
        a[5] - b[5],
        a[6] - b[6],
        a[7] - b[7],
        a[8] - b[8],
    )


@inlined
def with_transpose(a: Mat) -> Mat:
    """Return a + a^T."""
    x, y, z = a[1] + a[3], a[2] + a[6], a[5] + a[7]
    return (a[0] + a[0], x, y, x, a[4] + a[4], z, y, z, a[8] + a[8])


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
def normalized(q: Quat) -> Quat:
    """Return q as a unit quaternion."""
    c = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return (c * q[0], c * q[1], c * q[2], c * q[3])


@inlined
def rotated(q: Quat, rotation: Vec) -> Quat:
    """Return q turned by a rotation vector [rad] in its frame: unit, exact to second order."""
    half = (0.5 * rotation[0], 0.5 * rotation[1], 0.5 * rotation[2], 1.0)
    return normalized(quaternion_product(q, half))


@inlined
def to_material_matrix(q: Quat) -> Mat:
    """Return R(q)^T, which :func:`to_material` multiplies by."""
    x, y, z, w = q
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y + z * w),
        2.0 * (x * z - y * w),
        2.0 * (x * y - z * w),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z + x * w),
        2.0 * (x * z + y * w),
        2.0 * (y * z - x * w),
        1.0 - 2.0 * (x * x + y * y),
    )


@inlined
def vector_at(rows: Array, i: int) -> Vec:
    """Return row i of an (n, 3) array as a tuple."""
    return (rows[i, 0], rows[i, 1], rows[i, 2])


@inlined
def block_at(array: Array, i: int, k: int) -> Mat:
    """Return the 3x3 block of an array (n, n') that begins in row i and column k."""
    a, b, c = array[i], array[i + 1], array[i + 2]
    return (a[k], a[k + 1], a[k + 2], b[k], b[k + 1], b[k + 2], c[k], c[k + 1], c[k + 2])


@inlined
def matrix_at(blocks: Array, i: int) -> Mat:
    """Return block i of an (n, 3, 3) array as a tuple."""
    return block_at(blocks[i], 0, 0)


@inlined
def put_vector(out: Array, i: int, a: Vec) -> None:
    """Write a into an array (n,), from its entry i on."""
    out[i], out[i + 1], out[i + 2] = a


@inlined
def add_vector(out: Array, i: int, a: Vec) -> None:
    """Add a to an array (n,), from its entry i on."""
    for k in range(3):
        out[i + k] += a[k]


@inlined
def put_matrix(out: Array, i: int, k: int, m: Mat) -> None:
    """Write m into an array (n, n'), from its row i and column k on."""
    out[i, k], out[i, k + 1], out[i, k + 2] = m[0], m[1], m[2]
    out[i + 1, k], out[i + 1, k + 1], out[i + 1, k + 2] = m[3], m[4], m[5]
    out[i + 2, k], out[i + 2, k + 1], out[i + 2, k + 2] = m[6], m[7], m[8]


@inlined
def add_matrix(out: Array, i: int, k: int, m: Mat) -> None:
    """Add m to an array (n, n'), from its row i and column k on."""
    for row in range(3):
        for column in range(3):
            out[i + row, k + column] += m[3 * row + column]


@inlined
def quaternion_at(rows: Array, i: int) -> Quat:
    """Return row i of an (n, 4) array as a tuple."""
    return (rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3])


@inlined
def largest_component(a: Vec) -> float:
    """Return the largest absolute component of a."""
    return max(abs(a[0]), abs(a[1]), abs(a[2]))


@compiled
def matrices(q: Array) -> Array:
    """Return the rotation matrices R (n, 3, 3) of quaternions (n, 4)."""
    out = np.empty((len(q), 3, 3))
    for i in range(len(q)):
        put_matrix(out[i], 0, 0, transpose(to_material_matrix(quaternion_at(q, i))))
    return out


@compiled
def turn_nodes(q: Array, step: Array, fraction: float, turned: Array) -> None:
    """Write into ``turned`` the quaternions q (n, 4), the last m turned by ``fraction`` of a step.

    The step's rows (m, k) begin with rotation vectors in the frames that they turn [rad]; what lies
    before those m is held.
    """
    held = len(q) - len(step)
    for i in range(len(q)):
        r = quaternion_at(q, i)
        if i >= held:
            r = rotated(r, scale(fraction, vector_at(step, i - held)))
        for k in range(4):
            turned[i, k] = r[k]


@compiled
def copy_nodes(q: Array, to: Array) -> None:
    """Write the orientations q into another array."""
    for i in range(q.shape[0]):
        for k in range(4):
            to[i, k] = q[i, k]


@compiled
def largest_turn(q: Array, previous: Array) -> float:
    """Return the largest angle [rad] by which a node turned relative to the node before it."""
    largest = 0.0
    for i in range(q.shape[0] - 1):
        a = quaternion_at(previous, i)
        b = quaternion_at(previous, i + 1)
        c = quaternion_at(q, i)
        d = quaternion_at(q, i + 1)
        before = quaternion_product((-a[0], -a[1], -a[2], a[3]), b)
        after = quaternion_product((-c[0], -c[1], -c[2], c[3]), d)
        change = quaternion_product((-before[0], -before[1], -before[2], before[3]), after)
        axis = (change[0], change[1], change[2])
        largest = max(largest, 2.0 * math.asin(min(1.0, math.sqrt(dot(axis, axis)))))
    return largest


@compiled
def resample(q: Array, steps: Array, new_steps: Array) -> Array:
    """Return the rod that q samples on other elements, by geodesics.

    Lengths of elements (n,) and (m,) are compared as fractions of their sums.
    """
    old, new = 0.0, 0.0
    for i in range(steps.shape[0]):
        old += steps[i]
    for j in range(new_steps.shape[0]):
        new += new_steps[j]
    fine = np.empty((new_steps.shape[0] + 1, 4))
    i, begin, place = 0, 0.0, 0.0
    for j in range(fine.shape[0]):
        while place > begin + steps[i] and i < steps.shape[0] - 1:
            begin += steps[i]
            i += 1
        q0 = quaternion_at(q, i)
        x0, x1, x2, w = quaternion_product((-q0[0], -q0[1], -q0[2], q0[3]), quaternion_at(q, i + 1))
        sine = math.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
        angle = (place - begin) / steps[i] * math.atan2(sine, w)
        # `rotated` turns by 2 atan(|half|): give it the tangent of the half angle.
        factor = 2.0 * math.tan(angle) / sine if sine > 0.0 else 0.0
        r = rotated(q0, scale(factor, (x0, x1, x2)))
        for k in range(4):
            fine[j, k] = r[k]
        if j < new_steps.shape[0]:
            place += old / new * new_steps[j]
    return fine


def turned(q: Array, rotation: Array) -> Array:
    """Return q turned by rotation vectors (n, 3) [rad] in their frames: exact to second order."""
    out = np.empty_like(q)
    turn_nodes(q, rotation, 1.0, out)
    return out


@compiled
def composed(a: Array, b: Array) -> Array:
    """Return the products a b of quaternions, row by row."""
    out = np.empty_like(a)
    for i in range(len(a)):
        product = quaternion_product(quaternion_at(a, i), quaternion_at(b, i))
        for k in range(4):
            out[i, k] = product[k]
    return out


def turn_between(first: Array, second: Array) -> Array:
    """Return r (n, 3) with ``turned(first, r)`` equal to ``second``: 2 tan of half the angle."""
    inverse = first * np.array((-1.0, -1.0, -1.0, 1.0))
    between = composed(inverse, second)
    vector: Array = 2.0 * between[:, :3] / between[:, 3:]
    return vector


def quaternions_between(first: Array, second: Array, at: float) -> Array:
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


@compiled
def in_space(turn: Array, vectors: Array, blocks: Array) -> tuple[Array, Array]:
    """Return R v and R M R^T for vectors (n, 3), matrices (n, 3, 3) and one R (3, 3)."""
    turned_vectors, turned_blocks = np.empty_like(vectors), np.empty_like(blocks)
    back = transpose(matrix_at(turn.reshape(1, 3, 3), 0))
    for e in range(len(vectors)):
        put_vector(turned_vectors[e], 0, matvec_t(back, vector_at(vectors, e)))
        block = matmul_t(back, matmul(matrix_at(blocks, e), back))
        put_matrix(turned_blocks[e], 0, 0, block)
    return turned_vectors, turned_blocks


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
