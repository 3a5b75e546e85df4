# SPDX-License-Identifier: Apache-2.0
"""Turning a rod's nodes, measuring their turns, and sampling them anew (compiled)."""

import math

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    TANGENT,
    Array,
    dot,
    quaternion_at,
    quaternion_product,
    rotated,
    scale,
    to_base,
)
from spiral_core.rod._element import section_of
from spiral_core.rod._system import System


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
def turn_about_base_axis(q: Array, system: System) -> float:
    """Turn the bent rod q, in place, about the base's axis to where its energy is least.

    A bent isotropic rod under an axial load may point anywhere; rest strain and a tilt of the load,
    however small, choose. In a turn by phi the energy is E(phi) = E + B cos phi + C sin phi, but
    for the small terms of an element's supplement. Returns phi [rad].
    """
    n = system.elements.shape[0]
    cosine, sine = 0.0, 0.0
    for i in range(n):
        h, rest = system.steps[i], section_of(system.elements[i]).rest
        a, b = quaternion_at(q, i), quaternion_at(q, i + 1)
        _, y, z, _ = quaternion_product((-a[0], -a[1], -a[2], a[3]), b)
        t = to_base(b, TANGENT)
        cosine -= 2.0 * (rest[1] * y + rest[2] * z)
        sine -= 2.0 * (rest[2] * y - rest[1] * z)
        if i == n - 1:
            h *= 0.5
        cosine -= h * (system.force[i + 1, 1] * t[1] + system.force[i + 1, 2] * t[2])
        sine -= h * (system.force[i + 1, 2] * t[1] - system.force[i + 1, 1] * t[2])
    if cosine == 0.0 and sine == 0.0:
        return 0.0
    angle = math.atan2(-sine, -cosine)
    s, c = math.sin(0.5 * angle), math.cos(0.5 * angle)
    for i in range(n + 1):
        p = quaternion_product((s, 0.0, 0.0, c), quaternion_at(q, i))
        r = quaternion_product(p, (-s, 0.0, 0.0, c))
        for k in range(4):
            q[i, k] = r[k]
    return angle


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
