# SPDX-License-Identifier: Apache-2.0
"""3-vectors, 3x3 matrices and quaternions, scalar last: one at a time, and arrays of them.

One at a time they are plain tuples, for the compiled rod kernels: a tuple lives in registers, an
array on the heap, which inside a loop over rod elements is a factor of ten. A matrix is its three
rows. Nothing here is specific to rods.
"""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled, inlined

Array: TypeAlias = NDArray[np.float64]
Vec: TypeAlias = tuple[float, float, float]
Mat: TypeAlias = tuple[Vec, Vec, Vec]
Quat: TypeAlias = tuple[float, float, float, float]

TANGENT = (1.0, 0.0, 0.0)


@inlined
def dot(a: Vec, b: Vec) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def norm(a: Vec) -> float:
    """Return the length of a."""
    return math.sqrt(dot(a, a))


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
def largest_component(a: Vec) -> float:
    """Return the largest absolute component of a."""
    return max(abs(a[0]), abs(a[1]), abs(a[2]))


@inlined
def diagonal(a: float, b: float, c: float) -> Mat:
    """Return diag(a, b, c)."""
    return ((a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c))


@inlined
def outer(a: Vec, b: Vec) -> Mat:
    """Return a b^T."""
    return (scale(a[0], b), scale(a[1], b), scale(a[2], b))


@inlined
def skew(a: Vec) -> Mat:
    """Return the matrix [a] of v -> a x v."""
    return ((0.0, -a[2], a[1]), (a[2], 0.0, -a[0]), (-a[1], a[0], 0.0))


@inlined
def transpose(m: Mat) -> Mat:
    """Return m^T."""
    a, b, c = m
    return ((a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2]))


@inlined
def matadd(a: Mat, b: Mat) -> Mat:
    """Return a + b."""
    return (add(a[0], b[0]), add(a[1], b[1]), add(a[2], b[2]))


@inlined
def matsubtract(a: Mat, b: Mat) -> Mat:
    """Return a - b."""
    return (subtract(a[0], b[0]), subtract(a[1], b[1]), subtract(a[2], b[2]))


@inlined
def matscale(c: float, m: Mat) -> Mat:
    """Return c m."""
    return (scale(c, m[0]), scale(c, m[1]), scale(c, m[2]))


@inlined
def with_transpose(m: Mat) -> Mat:
    """Return m + m^T."""
    return matadd(m, transpose(m))


@inlined
def matvec(m: Mat, v: Vec) -> Vec:
    """Return m v."""
    return (dot(m[0], v), dot(m[1], v), dot(m[2], v))


@inlined
def matvec_t(m: Mat, v: Vec) -> Vec:
    """Return m^T v."""
    return matvec(transpose(m), v)


@inlined
def matmul(a: Mat, b: Mat) -> Mat:
    """Return a b."""
    columns = transpose(b)
    return (matvec(columns, a[0]), matvec(columns, a[1]), matvec(columns, a[2]))


@inlined
def matmul_t(a: Mat, b: Mat) -> Mat:
    """Return a^T b."""
    return matmul(transpose(a), b)


@inlined
def matmul_skew(m: Mat, a: Vec) -> Mat:
    """Return m [a]."""
    return (cross(m[0], a), cross(m[1], a), cross(m[2], a))


@inlined
def skew_matmul(a: Vec, m: Mat) -> Mat:
    """Return [a] m."""
    x, y, z = transpose(m)
    return transpose((cross(a, x), cross(a, y), cross(a, z)))


@inlined
def inverse(m: Mat) -> Mat:
    """Return m^-1 by cofactors (the caller has checked that m is far from singular)."""
    x, y, z = cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])
    return matscale(1.0 / dot(m[0], x), transpose((x, y, z)))


@inlined
def smallest_pivot_and_inverse(m: Mat) -> tuple[float, Mat]:
    """Return the smallest Cholesky pivot of a symmetric m, and m^-1.

    Pivots are ratios of leading minors. Once one is not positive the later ones mean nothing: it is
    returned, and the inverse with it must not be used.
    """
    x, y, z = cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])
    determinant = dot(m[0], x)
    soft = matscale(1.0 / determinant, (x, (x[1], y[1], y[2]), (x[2], y[2], z[2])))
    first, second = m[0][0], z[2] / m[0][0]
    if not first > 0.0:
        return first, soft
    if not second > 0.0:
        return second, soft
    return min(first, second, determinant / z[2]), soft


@inlined
def quaternion_product(a: Quat, b: Quat) -> Quat:
    """Return the product a b of scalar-last quaternions."""
    u, v = (a[0], a[1], a[2]), (b[0], b[1], b[2])
    x, y, z = add(add(scale(a[3], v), scale(b[3], u)), cross(u, v))
    return (x, y, z, a[3] * b[3] - dot(u, v))


@inlined
def seen_turn(a: Quat, b: Quat) -> Quat:
    """Return the turn from a to b as seen in the frame of a: conj(a) b."""
    return quaternion_product((-a[0], -a[1], -a[2], a[3]), b)


@inlined
def to_base(q: Quat, v: Vec) -> Vec:
    """Return R(q) v: a vector of the material frame seen from the base frame."""
    axis = (q[0], q[1], q[2])
    t = scale(2.0, cross(axis, v))
    return add(v, add(scale(q[3], t), cross(axis, t)))


@inlined
def to_material(q: Quat, v: Vec) -> Vec:
    """Return R(q)^T v: a vector of the base frame seen from the material frame."""
    return to_base((-q[0], -q[1], -q[2], q[3]), v)


@inlined
def to_material_matrix(q: Quat) -> Mat:
    """Return R(q)^T, which :func:`to_material` multiplies by."""
    x, y, z, w = q
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)),
        (2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)),
        (2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)),
    )


@inlined
def normalized(q: Quat) -> Quat:
    """Return q as a unit quaternion."""
    c = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return (c * q[0], c * q[1], c * q[2], c * q[3])


@inlined
def rotated(q: Quat, rotation: Vec) -> Quat:
    """Return q turned by a rotation vector [rad] in its frame: unit, exact to second order."""
    x, y, z = scale(0.5, rotation)
    return normalized(quaternion_product(q, (x, y, z, 1.0)))


@inlined
def vector_from(row: Array, k: int) -> Vec:
    """Return the three entries of an array (n,) from k on."""
    return (row[k], row[k + 1], row[k + 2])


@inlined
def vector_at(rows: Array, i: int) -> Vec:
    """Return row i of an (n, 3) array."""
    return (rows[i, 0], rows[i, 1], rows[i, 2])


@inlined
def quaternion_at(rows: Array, i: int) -> Quat:
    """Return row i of an (n, 4) array."""
    return (rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3])


@inlined
def block_at(array: Array, i: int, k: int) -> Mat:
    """Return the 3x3 block of an array (n, n') that begins in row i and column k."""
    return (vector_from(array[i], k), vector_from(array[i + 1], k), vector_from(array[i + 2], k))


@inlined
def matrix_at(blocks: Array, i: int) -> Mat:
    """Return block i of an (n, 3, 3) array."""
    return block_at(blocks[i], 0, 0)


@inlined
def put_vector(out: Array, i: int, a: tuple[float, ...]) -> None:
    """Write a vector or a quaternion into an array (n,), from its entry i on."""
    for k in range(len(a)):
        out[i + k] = a[k]


@inlined
def add_vector(out: Array, i: int, a: Vec) -> None:
    """Add a to an array (n,), from its entry i on."""
    for k in range(3):
        out[i + k] += a[k]


@inlined
def put_matrix(out: Array, i: int, k: int, m: Mat) -> None:
    """Write m into an array (n, n'), from its row i and column k on."""
    put_vector(out[i], k, m[0])
    put_vector(out[i + 1], k, m[1])
    put_vector(out[i + 2], k, m[2])


@inlined
def add_matrix(out: Array, i: int, k: int, m: Mat) -> None:
    """Add m to an array (n, n'), from its row i and column k on."""
    add_vector(out[i], k, m[0])
    add_vector(out[i + 1], k, m[1])
    add_vector(out[i + 2], k, m[2])


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
        put_vector(turned[i], 0, r)


@compiled
def copy_nodes(q: Array, to: Array) -> None:
    """Write the orientations q into another array."""
    for i in range(len(q)):
        put_vector(to[i], 0, quaternion_at(q, i))


@compiled
def largest_turn(q: Array, previous: Array) -> float:
    """Return the largest angle [rad] by which a node turned relative to the node before it."""
    largest = 0.0
    for i in range(len(q) - 1):
        before = seen_turn(quaternion_at(previous, i), quaternion_at(previous, i + 1))
        after = seen_turn(quaternion_at(q, i), quaternion_at(q, i + 1))
        x, y, z, _ = seen_turn(before, after)
        largest = max(largest, 2.0 * math.asin(min(1.0, norm((x, y, z)))))
    return largest


@compiled
def resample(q: Array, steps: Array, new_steps: Array) -> Array:
    """Return the rod that q samples on other elements, by geodesics.

    Lengths of elements (n,) and (m,) are compared as fractions of their sums.
    """
    old, new = 0.0, 0.0
    for step in steps:
        old += step
    for step in new_steps:
        new += step
    fine = np.empty((len(new_steps) + 1, 4))
    i, begin, place = 0, 0.0, 0.0
    for j in range(len(fine)):
        while place > begin + steps[i] and i < len(steps) - 1:
            begin += steps[i]
            i += 1
        q0 = quaternion_at(q, i)
        x, y, z, w = seen_turn(q0, quaternion_at(q, i + 1))
        sine = norm((x, y, z))
        angle = (place - begin) / steps[i] * math.atan2(sine, w)
        # `rotated` turns by 2 atan(|half|): give it the tangent of the half angle.
        factor = 2.0 * math.tan(angle) / sine if sine > 0.0 else 0.0
        put_vector(fine[j], 0, rotated(q0, scale(factor, (x, y, z))))
        if j < len(new_steps):
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
        put_vector(out[i], 0, quaternion_product(quaternion_at(a, i), quaternion_at(b, i)))
    return out


def turn_between(first: Array, second: Array) -> Array:
    """Return r (n, 3) with ``turned(first, r)`` equal to ``second``: 2 tan of half the angle."""
    between = composed(first * np.array((-1.0, -1.0, -1.0, 1.0)), second)
    vector: Array = 2.0 * between[:, :3] / between[:, 3:]
    return vector


def quaternions_between(first: Array, second: Array, at: float) -> Array:
    """Return quaternions at the fraction ``at`` of the shorter turn between, normalized."""
    cosine = np.sum(first * second, axis=1)[:, None]
    turn = np.arccos(np.minimum(np.abs(cosine), 1.0)) / math.pi
    ahead = np.where(cosine < 0.0, -at, at) * np.sinc(at * turn)
    mean: Array = (1.0 - at) * np.sinc((1.0 - at) * turn) * first + ahead * second
    mean /= np.sqrt(np.sum(mean * mean, axis=1))[:, None]
    return mean


def skews(v: Array) -> Array:
    """Return the matrices (n, 3, 3) of a -> v x a."""
    found: Array = np.einsum("ni,ijk->njk", v, SKEWS)
    return found


SKEWS = np.cross(np.eye(3), np.eye(3)[:, None])


@compiled
def in_space(turn: Array, vectors: Array, blocks: Array) -> tuple[Array, Array]:
    """Return R v and R M R^T for vectors (n, 3), symmetric M (n, 3, 3) and one R (3, 3)."""
    frame, turned, bent = block_at(turn, 0, 0), np.empty(vectors.shape), np.empty(blocks.shape)
    for e in range(len(vectors)):
        put_vector(turned[e], 0, matvec(frame, vector_at(vectors, e)))
        half = matmul(frame, matrix_at(blocks, e))
        put_matrix(bent[e], 0, 0, matmul(half, transpose(frame)))
    return turned, bent


@compiled
def around_axis(points: Array) -> tuple[Array, Array, Array]:
    """Return the distance (n,) from the z axis, e_rho (n, 3) and e_phi e_phi^T (n, 3, 3)."""
    rho, radial, around = (
        np.empty(len(points)),
        np.empty(points.shape),
        np.empty((len(points), 3, 3)),
    )
    for e in range(len(points)):
        x, y, _ = vector_at(points, e)
        rho[e] = math.hypot(x, y)
        x, y = (x / rho[e], y / rho[e]) if rho[e] > 0.0 else (1.0, 0.0)
        put_vector(radial[e], 0, (x, y, 0.0))
        put_matrix(around[e], 0, 0, outer((-y, x, 0.0), (-y, x, 0.0)))
    return rho, radial, around


@compiled
def from_cone(points: Array, radius: float, slope: float) -> tuple[Array, Array, Array]:
    """Return the distance (n,) from a cone about z, its gradient (n, 3) and Hessian (n, 3, 3)."""
    gap, normals, bends = around_axis(points)
    c = 1.0 / math.hypot(1.0, slope)
    for e in range(len(points)):
        bend = c / max(gap[e], 1e-9 * radius)
        put_matrix(bends[e], 0, 0, matscale(bend, matrix_at(bends, e)))
        gap[e] = c * (gap[e] - radius - slope * points[e, 2])
        put_vector(normals[e], 0, (c * normals[e, 0], c * normals[e, 1], -c * slope))
    return gap, normals, bends
