# SPDX-License-Identifier: Apache-2.0
"""The loops over nodes and elements of one step in time, compiled."""

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    Array,
    Mat,
    add,
    cross,
    dot,
    matvec,
    matvec_t,
    quaternion_at,
    scale,
    to_material,
    vector_at,
)


@compiled
def _matrix(block: Array) -> Mat:
    """Return a (3, 3) array as a tuple."""
    return (
        block[0, 0], block[0, 1], block[0, 2],
        block[1, 0], block[1, 1], block[1, 2],
        block[2, 0], block[2, 1], block[2, 2],
    )  # fmt: skip


@compiled
def add_step_terms(
    q: Array,
    p: Array,
    weight: Array,
    target: Array,
    drag: Array,
    rest: Array,
    gradient: Array,
    tangent: Array,
) -> None:
    """Add a step's inertia and drag to gradient (n, 6) and Hessian (n, 6, 6) of every node.

    Args:
        q: (n, 4) orientations.
        p: (n, 3) positions [m].
        weight: (n, 9), as the next three that of ``StepTerms``.
        target: (n, 9).
        drag: (n, 3, 3).
        rest: (n, 3).
        gradient: by rotations in the material frame and displacements; added to.
        tangent: likewise.
    """
    for n in range(p.shape[0]):
        for i in range(3):
            gradient[n, 3 + i] += weight[n, i] * (p[n, i] - target[n, i])
            tangent[n, 3 + i, 3 + i] += weight[n, i]
            for k in range(3):
                gradient[n, 3 + i] += drag[n, i, k] * (p[n, k] - rest[n, k])
                tangent[n, 3 + i, 3 + k] += drag[n, i, k]
        turn = quaternion_at(q, n)
        for axis in range(1, 3):
            first = 3 * axis
            kept = (target[n, first], target[n, first + 1], target[n, first + 2])
            seen = scale(weight[n, first], to_material(turn, kept))
            ahead, behind = (axis + 1) % 3, (axis + 2) % 3
            # e x b, the unit vector e along the axis
            gradient[n, ahead] += seen[behind]
            gradient[n, behind] -= seen[ahead]
            for i in range(3):
                tangent[n, i, i] += seen[axis]
                tangent[n, axis, i] -= 0.5 * seen[i]
                tangent[n, i, axis] -= 0.5 * seen[i]


@compiled
def remembered_strains(
    q: Array, n: Array, half: Array, steps: Array, own: Array, elastic: Array
) -> Array:
    """Return the strains that each element's material remembers (N, 6) [1/m, 1/m^2].

    Args:
        q: (N + 1, 4) orientations.
        n: (N, 3) mean forces [N].
        half: (N, 3) half the load of each element [N].
        steps: (N,) lengths [m].
        own: (N, 7, 3, 3) elements, with their damping.
        elastic: the same without.
    """
    out = np.empty((steps.shape[0], 6))
    for e in range(steps.shape[0]):
        a, b = quaternion_at(q, e), quaternion_at(q, e + 1)
        v, u = (a[0], a[1], a[2]), (b[0], b[1], b[2])
        turn = add(scale(a[3], u), add(scale(-b[3], v), scale(-1.0, cross(v, u))))
        s = dot(turn, turn)
        factor = 1.0 + s * (1.0 / 6.0 + s * (3.0 / 40.0 + s * (5.0 / 112.0)))
        strain = scale(2.0 * factor / steps[e], turn)
        block = own[e]
        rest = scale(-1.0, vector_at(block[4], 0))
        moment = add(matvec(_matrix(block[0]), strain), rest)
        change = add(matvec(_matrix(block[1]), strain), scale(-1.0, vector_at(block[4], 1)))
        change = add(change, cross(strain, moment))
        for end in range(2):
            sign = 1.0 - 2.0 * end
            load = add(vector_at(n, e), scale(sign, vector_at(half, e)))
            inner = to_material(quaternion_at(q, e + end), load)
            stretch = add(matvec(_matrix(block[3]), inner), (1.0, 0.0, 0.0))
            change = add(change, scale(0.5, cross(stretch, inner)))
        slope = matvec(_matrix(block[2]), change)
        # what the elastic element would remember: I + [c] x has a closed inverse
        stiffness, rate = _matrix(elastic[e, 0]), _matrix(elastic[e, 1])
        flexible = _matrix(elastic[e, 2])
        small = steps[e] * steps[e] / 12.0
        known = add(matvec(stiffness, cross(slope, strain)), matvec_t(rate, slope))
        known, c = scale(small, known), scale(small, slope)
        solved = add(known, add(scale(-1.0, cross(c, known)), scale(dot(c, known), c)))
        solved = scale(1.0 / (1.0 + dot(c, c)), solved)
        less = matvec(flexible, solved)
        turning = matvec(flexible, add(cross(strain, solved), matvec(rate, less)))
        for i in range(3):
            out[e, i] = strain[i] - less[i]
            out[e, 3 + i] = slope[i] - turning[i]
    return out
