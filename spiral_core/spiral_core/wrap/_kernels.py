# SPDX-License-Identifier: Apache-2.0
"""A shape as a coil, and the cylinder it fits (compiled)."""

import math

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    TANGENT,
    Array,
    Mat,
    Vec,
    add,
    cross,
    diagonal,
    dot,
    matadd,
    matmul,
    matscale,
    outer,
    put_vector,
    quaternion_at,
    scale,
    subtract,
    to_base,
    vector_at,
)
from spiral_core.rod.types import Vector

# Squarings that leave the largest eigenvalue of a matrix alone; far fewer where it stands apart.
SQUARINGS, ALONE = 40, 1e-15
# Tangents taken from the last turn to fit its axis; more change the axis by less than the rod's own
# error.
AXIS_SAMPLES = 33
# An element whose ends are both this far from where turns stop to count (in the sine to the axis)
# does not come near it; one that may is looked at in parts.
CLEAR_SINE = 0.25
PARTS = 8
# In place of a given axis: fit it.
FITTED = (0.0, 0.0, 0.0)


@compiled
def tangent_at(orientations: Array, i: int) -> Vec:
    """Return the unit tangent of node i in the base frame."""
    return to_base(quaternion_at(orientations, i), TANGENT)


@compiled
def tangent_between(orientations: Array, strains: Array, h: float, i: int, f: float) -> Vec:
    """Return the tangent at the fraction f of element i, by cubic Hermite interpolation.

    With the slope t' = R (u x e_x) it is right to the order of the rod itself, and smooth in the
    shape.
    """
    q0, q1 = quaternion_at(orientations, i), quaternion_at(orientations, i + 1)
    slope0 = to_base(q0, cross(vector_at(strains, i), TANGENT))
    slope1 = to_base(q1, cross(vector_at(strains, i + 1), TANGENT))
    g = 1.0 - f
    ends = add(
        scale((1.0 + 2.0 * f) * g * g, to_base(q0, TANGENT)),
        scale((3.0 - 2.0 * f) * f * f, to_base(q1, TANGENT)),
    )
    return add(ends, scale(h * f * g, add(scale(g, slope0), scale(-f, slope1))))


@compiled
def tangent_covariance(orientations: Array, strains: Array, h: float, window: float) -> Mat:
    """Return the covariance of tangents, evenly sampled over the last ``window`` [m]."""
    n = orientations.shape[0] - 1
    mean = (0.0, 0.0, 0.0)
    tangents = np.empty((AXIS_SAMPLES, 3))
    for j in range(AXIS_SAMPLES):
        place = (n * h - window + window * j / (AXIS_SAMPLES - 1)) / h
        i = max(0, min(n - 1, int(place)))
        t = tangent_between(orientations, strains, h, i, place - i)
        mean = add(mean, scale(1.0 / AXIS_SAMPLES, t))
        put_vector(tangents[j], 0, t)
    covariance = diagonal(0.0, 0.0, 0.0)
    for j in range(AXIS_SAMPLES):
        apart = subtract(vector_at(tangents, j), mean)
        covariance = matadd(covariance, outer(apart, apart))
    return covariance


@compiled
def least_direction(m: Mat) -> Vec:
    """Return the unit eigenvector of the smallest eigenvalue of a symmetric matrix; of 0 any.

    The adjugate has the same eigenvectors, and there its largest eigenvalue: squared again and
    again, it keeps that one alone.
    """
    m = (cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]))
    trace = m[0][0] + m[1][1] + m[2][2]
    if not trace > 0.0:
        return TANGENT
    for _ in range(SQUARINGS):
        m = matscale(1.0 / trace, m)
        m = matmul(m, m)
        trace = m[0][0] + m[1][1] + m[2][2]
        if trace >= 1.0 - ALONE:
            break
    longest = m[0]
    for row in (m[1], m[2]):
        if dot(row, row) > dot(longest, longest):
            longest = row
    return scale(1.0 / math.sqrt(dot(longest, longest)), longest)


@compiled
def angle_at_tip(orientations: Array, axis: Vec) -> float:
    """Return the angle between the tip's tangent and a unit axis [rad]."""
    along = dot(axis, tangent_at(orientations, orientations.shape[0] - 1))
    return math.acos(min(1.0, max(-1.0, along)))


@compiled
def counted_share(before: float, after: float) -> float:
    """Return which share of an element is positive when its ends are ``before`` and ``after``."""
    if before >= 0.0 and after >= 0.0:
        return 1.0
    if before < 0.0 and after < 0.0:
        return 0.0
    return max(before, after) / abs(after - before)


@compiled
def across(axis: Vec, v: Vec) -> Vec:
    """Return the part of a vector across a unit axis."""
    return add(v, scale(-dot(v, axis), axis))


@compiled
def turns_about(
    orientations: Array, strains: Array, h: float, axis: Vec, least_sine: float
) -> Array:
    """Return the turns of the tangent about an axis up to each node (n,), right-handed positive.

    Where the tangent is within asin(``least_sine``) of the axis its azimuth is not counted. Next to
    that limit an element is counted in :data:`PARTS`.
    """
    n = orientations.shape[0]
    turns = np.zeros(n)
    before = across(axis, tangent_at(orientations, 0))
    excess_before = math.sqrt(dot(before, before)) - least_sine
    for i in range(1, n):
        end = across(axis, tangent_at(orientations, i))
        excess_end = math.sqrt(dot(end, end)) - least_sine
        parts = 1 if min(excess_before, excess_end) > CLEAR_SINE else PARTS
        turns[i] = turns[i - 1]
        for part in range(1, parts + 1):
            after, excess = end, excess_end
            if part < parts:
                inside = tangent_between(orientations, strains, h, i - 1, part / parts)
                after = across(axis, inside)
                excess = math.sqrt(dot(after, after)) - least_sine
            angle = math.atan2(dot(axis, cross(before, after)), dot(before, after))
            turns[i] += counted_share(excess_before, excess) * angle / (2.0 * math.pi)
            before, excess_before = after, excess
    return turns


@compiled
def lagrange_weights(nodes: Array, place: float, most: int) -> tuple[int, Array]:
    """Return the first of the rising nodes next to a place, and their weights in a polynomial."""
    count = min(most, len(nodes))
    first = int(np.searchsorted(nodes, place)) - count // 2
    first = min(max(first, 0), len(nodes) - count)
    weights = np.ones(count)
    for i in range(count):
        for j in range(count):
            if j != i:
                apart = nodes[first + i] - nodes[first + j]
                weights[i] *= (place - nodes[first + j]) / apart
    return first, weights


@compiled
def fitted_radius(
    orientations: Array,
    strains: Array,
    tip: Array,
    length: float,
    rest: Vector,
    axis: Vector,
    outer_radius: float,
) -> tuple[float, Vector]:
    """Return r_w [m] of a shape with some rest strain, and the object's axis (unit vector).

    See :mod:`spiral_core.wrap.wrap`. The axis points the way the coil advances from base to tip. A
    given one keeps its direction; ``FITTED`` fits it to the coil's end: the direction in which the
    tangents of the last turn vary least, the eigenvector of the smallest eigenvalue of their
    covariance. For a helix that is exactly its axis. A rod that does not bend fits no cylinder:
    infinite.
    """
    torsion, _, curvature = rest
    h = length / (orientations.shape[0] - 1)
    rate = math.hypot(curvature, torsion)
    if axis == FITTED:
        window = min(2.0 * math.pi / rate, length) if rate > 0.0 else length
        axis = least_direction(tangent_covariance(orientations, strains, h, window))
    if dot(axis, (tip[0], tip[1], tip[2])) < 0.0:
        axis = scale(-1.0, axis)
    sine = math.sin(angle_at_tip(orientations, axis))
    if not curvature > 0.0:
        return math.inf, axis
    return sine * sine / curvature - outer_radius, axis
