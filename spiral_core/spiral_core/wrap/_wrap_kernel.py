"""A shape and the cylinder it fits, in one compiled call: the step of a search for a wrap."""

import math

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import Array
from spiral_core.rod._continuation import Settled, settle_uniform
from spiral_core.rod._system import Vector
from spiral_core.wrap._coil_kernels import advancing_axis, angle_at_tip

NONE = (0.0, 0.0, 0.0)
# States that one guess of a shape goes through. A cubic is so near that one Newton step settles it.
STATES = 4


@compiled
def interpolated_orientations(places: Array, orientations: Array, place: float) -> Array:
    """Return orientations (N + 1, 4) from those at rising places, (m,) and (m, N + 1, 4).

    By Lagrange's polynomial through the quaternions next to the place: the states must follow each
    other without a snap.
    """
    m, n, _ = orientations.shape
    count = min(STATES, m)
    first = min(max(np.searchsorted(places, place) - count // 2, 0), m - count)
    q = np.zeros((n, 4))
    for i in range(first, first + count):
        weight = 1.0
        for j in range(first, first + count):
            if j != i:
                weight *= (place - places[j]) / (places[i] - places[j])
        for k in range(n):
            for c in range(4):
                q[k, c] += weight * orientations[i, k, c]
    for k in range(n):
        size = math.sqrt(q[k, 0] ** 2 + q[k, 1] ** 2 + q[k, 2] ** 2 + q[k, 3] ** 2)
        for c in range(4):
            q[k, c] /= size
    return q


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

    See :mod:`spiral_core.wrap.wrap`; ``FITTED`` for ``axis`` fits it to the coil's last turn.
    """
    torsion, _, curvature = rest
    turn_length = 2.0 * math.pi / math.hypot(curvature, torsion)
    h = length / (orientations.shape[0] - 1)
    axis = advancing_axis(orientations, strains, tip, h, turn_length, axis)
    sine = math.sin(angle_at_tip(orientations, axis))
    return sine * sine / curvature - outer_radius, axis


@compiled
def settle_on_object(
    q: Array,
    length: float,
    torsional: float,
    bending: float,
    rest: Vector,
    weight: Vector,
    axis: Vector,
    outer_radius: float,
) -> tuple[Settled, float, Vector]:
    """Settle a gripper's orientations q, in place; return the state, r_w [m] and the axis."""
    settled = settle_uniform(q, length, torsional, bending, rest, weight, NONE, NONE)
    tip = settled.positions[-1]
    radius, found = fitted_radius(q, settled.strains, tip, length, rest, axis, outer_radius)
    return settled, radius, found
