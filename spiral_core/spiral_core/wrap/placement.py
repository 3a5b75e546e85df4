# SPDX-License-Identifier: Apache-2.0
"""The place of the object: the cylinder that fits a wrap's coil best, and the gap that remains."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from spiral_core.rod._algebra import matrices
from spiral_core.rod.types import Array, Vector
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import Wrap

# The search for the axis ends when a step is this fraction of the contact radius; it halves its
# error several times over with each step and needs fewer than ten.
FIT_TOLERANCE = 1e-9
FIT_STEPS = 50
# Between the base and an object that the coil would put inside of it [outer radii of the tube].
CLEARANCE = 0.02


@dataclass(frozen=True, slots=True)
class ObjectPlacement:
    """A cylinder in the gripper's base frame.

    Args:
        center: middle of the part of its axis that the coil covers [m].
        axis: unit vector along it, the way the coil advances.
        radius: of the object [m].
        length: of the part that the coil covers [m].
        largest_gap: largest distance between the tube of the required turns and the object's
            surface, outside or inside of it [m]. The coil is the free one: contact, which would
            close such gaps, is not modeled.
    """

    center: Vector
    axis: Vector
    radius: float
    length: float
    largest_gap: float


def coil_place(wrap: Wrap, gripper: Gripper) -> ObjectPlacement:
    """Return where a grip lays the object of a wrap.

    Args:
        wrap: about the axis that fits the coil.
        gripper: that makes it, with the object's direction, if that is known.
    """
    if gripper.object_axis is not None:  # turned the way the coil advances
        sign = 1.0 if float(np.dot(gripper.object_axis, wrap.axis)) >= 0.0 else -1.0
        x, y, z = (sign * component for component in gripper.object_axis)
        wrap = replace(wrap, axis=(x, y, z))
    placement = place_object(wrap)
    center, axis = np.asarray(placement.center), np.asarray(placement.axis)
    across = center - (center @ axis) * axis
    distance = float(np.linalg.norm(across))
    needed = placement.radius + (1.0 + CLEARANCE) * wrap.outer_radius
    if 0.0 < distance < needed:  # moved square to its axis until the base lies outside
        center = center + (needed / distance - 1.0) * across
    x, y, z = center.tolist()
    return replace(placement, center=(x, y, z))


def place_object(wrap: Wrap) -> ObjectPlacement:
    r"""Return the place of the object that a wrap fits best.

    The direction of its axis is the coil's. Its place is where the last turns touch it best: the
    c that minimizes

    .. math:: \sum_i (|q_i - c| - r_w - r_o)^2

    over the nodes of the required turns, seen along the axis as :math:`q_i`. For a helix that is
    its own axis; a heavy tube is not quite one, and its nodes then miss the surface by the fit's
    residual.

    Args:
        wrap: the perfect wrap. The fit uses at most one of its required turns, which is the window
            that gave a fitted axis its direction.
    """
    radius, outer_radius = wrap.object_radius, wrap.outer_radius
    axis = np.asarray(wrap.axis)
    plane = np.linalg.svd(axis[None, :])[2][1:]  # two unit vectors across the axis, as rows
    # The tip carries no moment: it curves towards its material y axis with the free curvature.
    normal = matrices(wrap.state.orientations[-1:])[0, :, 1]
    normal -= (normal @ axis) * axis
    size, contact_radius = float(np.linalg.norm(normal)), radius + outer_radius
    start = wrap.state.positions[-1] + (contact_radius / size if size else 0.0) * normal
    nodes = touching_nodes(wrap, min(wrap.turns_required, 1.0))
    center = _fitted_center(nodes @ plane.T, start @ plane.T, contact_radius)
    touching = touching_nodes(wrap, wrap.turns_required)
    covered = touching @ axis
    low, high = float(covered.min()) - outer_radius, float(covered.max()) + outer_radius
    place = center @ plane
    x, y, z = (place + 0.5 * (low + high) * axis).tolist()
    distances = distances_from_axis(touching, place, axis)
    gap = float(np.abs(distances - radius - outer_radius).max())
    return ObjectPlacement((x, y, z), wrap.axis, radius, high - low, gap)


def touching_nodes(wrap: Wrap, turns: float) -> Array:
    """Return the positions of the nodes of the last ``turns`` turns (n, 3) [m]; the tip's at least.

    All of them where there are fewer.
    """
    coil = wrap.coil
    positions: Array = wrap.state.positions[coil.turns >= coil.total_turns - turns]
    return positions


def distances_from_axis(positions: Array, center: Array | Vector, axis: Array | Vector) -> Array:
    """Return the distances (n,) of positions (n, 3) from a line through ``center`` [m]."""
    distances: Array = np.linalg.norm(
        np.cross(positions - np.asarray(center), np.asarray(axis)), axis=1
    )
    return distances


def misplacement(
    point: Array | Vector, axis: Array | Vector, center: Array | Vector, frame: Array
) -> Array:
    r"""Return how far an object is from its place: two shifts [m] and two tilts [rad] (4,).

    With the axes a of the place and d of the object, on the side of a, the shifts are those of the
    point in which the object's axis crosses the plane through the place's center square to a; the
    tilts are those of the smallest turn from a to d,

    .. math:: x = p + d\,\frac{(c - p) \cdot a}{d \cdot a}, \quad
        \theta = \frac{a \times d}{|a \times d|} \arccos(a \cdot d)

    A cylinder has neither a shift along its axis nor a turn about it.

    Args:
        point: any of the object's axis [m].
        axis: its direction, a unit vector in either sense.
        center: of the place [m].
        frame: unit rows (3, 3): along the place's axis, and the two directions of shifts and tilts.

    Example:
        >>> misplacement((0.1, 0.003, 0.5), (0.0, 0.0, 1.0), (0.1, 0.0, 0.0), np.eye(3)[[2, 0, 1]])
        array([0.   , 0.003, 0.   , 0.   ])
    """
    along, across = frame[0], frame[1:]
    direction = np.asarray(axis) * (1.0 if float(np.dot(axis, along)) >= 0.0 else -1.0)
    offset, cosine = np.asarray(point) - np.asarray(center), float(direction @ along)
    # Square to the place's axis it never crosses the plane: as far away as can be told.
    shift = offset - direction * float(offset @ along) / max(cosine, np.finfo(float).eps)
    turn = np.cross(along, direction)
    sine = float(np.linalg.norm(turn))
    tilt = turn * (math.atan2(sine, cosine) / sine if sine else 0.0)
    found: Array = np.concatenate((across @ shift, across @ tilt))
    return found


def _fitted_center(points: Array, start: Array, contact_radius: float) -> Array:
    """Return the center [m] (2,) of the circle of a given radius that fits points (n, 2) best."""
    center = start
    for _ in range(FIT_STEPS):
        offsets = points - center
        distances = np.linalg.norm(offsets, axis=1)
        directions = offsets / np.maximum(distances, np.finfo(float).tiny)[:, None]
        step = np.linalg.lstsq(directions, distances - contact_radius, rcond=None)[0]
        center = center + step
        if float(np.linalg.norm(step)) <= FIT_TOLERANCE * contact_radius:
            break
    return center
