"""Tangents along a rod, the axis that fits them, and what they are to one (compiled)."""

import math

import numpy as np

from spiral_core.numerics.kernel import compiled, inlined
from spiral_core.rod._algebra import (
    TANGENT,
    Array,
    Vec,
    add,
    cross,
    dot,
    quaternion_at,
    scale,
    to_base,
    vector_at,
)

# Jacobi's method squares the rotations that are left with every sweep: three or four sweeps reach
# rounding, and the off-diagonal counts as zero at this fraction of the trace.
SWEEPS = 12
DIAGONAL = 1e-17
# Tangents taken from the last turn to fit its axis; more change the axis by less than the rod's own
# error.
AXIS_SAMPLES = 33
# In place of a given axis: fit it.
FITTED = (0.0, 0.0, 0.0)


@inlined
def tangent_at(orientations: Array, i: int) -> Vec:
    """Return the unit tangent of node i in the base frame."""
    return to_base(quaternion_at(orientations, i), TANGENT)


@compiled
def tangent_covariance(orientations: Array, strains: Array, h: float, window: float) -> Array:
    """Return the covariance (3, 3) of the tangents over the last ``window`` [m] of a rod.

    The tangents are sampled evenly, between nodes by cubic Hermite interpolation with the slope
    t' = R (u x e_x): right to the order of the rod itself, and a smooth function of the shape.
    """
    n = orientations.shape[0] - 1
    mean = (0.0, 0.0, 0.0)
    tangents = np.empty((AXIS_SAMPLES, 3))
    for j in range(AXIS_SAMPLES):
        place = (n * h - window + window * j / (AXIS_SAMPLES - 1)) / h
        i = max(0, min(n - 1, int(place)))
        f = place - i
        q0, q1 = quaternion_at(orientations, i), quaternion_at(orientations, i + 1)
        slope0 = to_base(q0, cross(vector_at(strains, i), TANGENT))
        slope1 = to_base(q1, cross(vector_at(strains, i + 1), TANGENT))
        g = 1.0 - f
        ends = add(
            scale((1.0 + 2.0 * f) * g * g, to_base(q0, TANGENT)),
            scale((3.0 - 2.0 * f) * f * f, to_base(q1, TANGENT)),
        )
        t = add(ends, scale(h * f * g, add(scale(g, slope0), scale(-f, slope1))))
        mean = add(mean, scale(1.0 / AXIS_SAMPLES, t))
        for k in range(3):
            tangents[j, k] = t[k]
    covariance = np.zeros((3, 3))
    for j in range(AXIS_SAMPLES):
        for k in range(3):
            for m in range(3):
                covariance[k, m] += (tangents[j, k] - mean[k]) * (tangents[j, m] - mean[m])
    return covariance


@compiled
def rotate_to_zero(a: Array, v: Array, p: int, q: int) -> None:
    """Turn the coordinates p < q so that the symmetric a (3, 3) has a[p, q] = 0, and v along."""
    if a[p, q] == 0.0:
        return
    half = 0.5 * (a[q, q] - a[p, p]) / a[p, q]
    tangent = math.copysign(1.0, half) / (abs(half) + math.sqrt(half * half + 1.0))
    cosine = 1.0 / math.sqrt(tangent * tangent + 1.0)
    sine = tangent * cosine
    for k in range(3):
        x, y = a[k, p], a[k, q]
        a[k, p], a[k, q] = cosine * x - sine * y, sine * x + cosine * y
    for k in range(3):
        x, y = a[p, k], a[q, k]
        a[p, k], a[q, k] = cosine * x - sine * y, sine * x + cosine * y
        x, y = v[k, p], v[k, q]
        v[k, p], v[k, q] = cosine * x - sine * y, sine * x + cosine * y
    a[p, q] = a[q, p] = 0.0


@compiled
def least_direction(symmetric: Array) -> Vec:
    """Return the unit eigenvector of the smallest eigenvalue of a symmetric (3, 3) matrix.

    By Jacobi's rotations: as accurate as LAPACK, without its cost for so small a matrix.
    """
    a = symmetric.copy()
    v = np.eye(3)
    negligible = DIAGONAL * (abs(a[0, 0]) + abs(a[1, 1]) + abs(a[2, 2]))
    for _ in range(SWEEPS):
        if max(abs(a[0, 1]), abs(a[0, 2]), abs(a[1, 2])) <= negligible:
            break
        for p in range(2):
            for q in range(p + 1, 3):
                rotate_to_zero(a, v, p, q)
    least = 0
    for k in range(1, 3):
        if a[k, k] < a[least, least]:
            least = k
    return (v[0, least], v[1, least], v[2, least])


@compiled
def advancing_axis(
    orientations: Array, strains: Array, tip: Array, h: float, turn_length: float, axis: Vec
) -> Vec:
    """Return a coil's axis (:func:`spiral_core.wrap.coil.coil_axis`); nodes are ``h`` [m] apart."""
    if axis == FITTED:
        window = min(turn_length, h * (orientations.shape[0] - 1))
        axis = least_direction(tangent_covariance(orientations, strains, h, window))
    if axis[0] * tip[0] + axis[1] * tip[1] + axis[2] * tip[2] < 0.0:
        return (-axis[0], -axis[1], -axis[2])
    return axis


@compiled
def angle_at_tip(orientations: Array, axis: Vec) -> float:
    """Return the angle between the tip's tangent and a unit axis [rad]."""
    along = dot(axis, tangent_at(orientations, orientations.shape[0] - 1))
    return math.acos(min(1.0, max(-1.0, along)))


@inlined
def counted_share(before: float, after: float) -> float:
    """Return which share of an element is positive when its ends are ``before`` and ``after``."""
    if before >= 0.0 and after >= 0.0:
        return 1.0
    if before < 0.0 and after < 0.0:
        return 0.0
    return max(before, after) / abs(after - before)


@compiled
def turns_about(orientations: Array, axis: Vec, least_sine: float) -> Array:
    """Return the turns of the tangent about an axis up to each node (n,), right-handed positive.

    Where the tangent is within asin(``least_sine``) of the axis its azimuth is not counted.
    """
    n = orientations.shape[0]
    turns = np.zeros(n)
    tangent = tangent_at(orientations, 0)
    before = add(tangent, scale(-dot(tangent, axis), axis))
    excess_before = math.sqrt(dot(before, before)) - least_sine
    for i in range(1, n):
        tangent = tangent_at(orientations, i)
        after = add(tangent, scale(-dot(tangent, axis), axis))
        excess = math.sqrt(dot(after, after)) - least_sine
        angle = math.atan2(dot(axis, cross(before, after)), dot(before, after))
        share = counted_share(excess_before, excess)
        turns[i] = turns[i - 1] + share * angle / (2.0 * math.pi)
        before, excess_before = after, excess
    return turns
