# SPDX-License-Identifier: Apache-2.0
"""Where a solve begins: the straight rod, a given centerline, or a state on longer elements."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    TANGENT,
    cross,
    dot,
    matrices,
    normalized,
    quaternion_product,
    quaternions_between,
    to_base,
    vector_at,
)
from spiral_core.rod.contact._contact import Iterate, carried, empty
from spiral_core.rod.contact._increments import Point
from spiral_core.rod.contact._mesh import Arrays
from spiral_core.rod.contact._newton import UNSTABLE, Solution
from spiral_core.rod.contact.problem import Clamped, Free, Guided, RodProblem
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Array

# Loads bend a rod to no side if what is across it, of them all, is at most this fraction.
NO_SIDE = 1e-6
# Then it is bent by this angle while they come on [rad]: by its rest strain, or towards its y axis.
TRACE = 1e-2
TOWARDS_Y = (0.0, 0.0, 1.0)


def straight(problem: RodProblem, arrays: Arrays) -> tuple[Iterate, Arrays]:
    """Return the straight unloaded rod, and its problem: no loads, no rest strain."""
    base, tip = problem.base, problem.tip
    if isinstance(base, Free):
        origin, along = _from_tip(problem)
    else:
        origin = np.asarray(base.position, dtype=np.float64)
        along = None
        if not isinstance(tip, Free):
            span = np.asarray(tip.position, dtype=np.float64) - origin
            along = span / max(float(np.linalg.norm(span)), 1e-300)
    held = base.orientation if isinstance(base, (Clamped, Guided)) else None
    if held is not None:
        q = np.asarray(held, dtype=np.float64)
        along = matrices(q[None])[0][:, 0]
    else:
        along = np.array((1.0, 0.0, 0.0)) if along is None else along
        q = turn_to(along)
    count = arrays.count
    points = origin + arrays.arc_lengths[:, None] * along
    x = empty(count, len(arrays.obstacles), np.tile(q, (count + 1, 1)), points)
    none, orientations = np.zeros((count, 3)), arrays.end_orientations.copy()
    positions = arrays.end_positions.copy()
    if not isinstance(tip, Free):
        positions[1] = points[-1]
        orientations[1] = q
    first = replace(
        arrays,
        elements=arrays.elements._replace(
            rest=none, rest_slope=none, rest_stretch=none, half_load=none
        ),
        nodal=np.zeros_like(arrays.nodal),
        end_orientations=orientations,
        end_positions=positions,
        rest_energy=0.0,
    )
    return x, first


def loaded(arrays: Arrays, first: Arrays, x: Iterate) -> Arrays:
    """Return the problem with its loads and no rest strain, to go by from the straight rod.

    A column that its loads bend to no side has a trace of the rest strain, or without one bends
    towards the y axis of its sections: that decides to which side it buckles, not rounding.
    """
    elements = first.elements._replace(half_load=arrays.elements.half_load)
    if _is_column(arrays, x):
        rest = arrays.elements.rest
        moment = rest if rest.any() else np.tile(TOWARDS_Y, (arrays.count, 1))
        scale = arrays.bending / arrays.length / np.sqrt(np.sum(moment**2, axis=1)).max()
        elements = elements._replace(rest=TRACE * scale * moment)
    return replace(arrays, elements=elements, rest_energy=first.rest_energy)


def _is_column(arrays: Arrays, straight: Iterate) -> bool:
    """Return whether loads compress the straight rod and bend it to no side; its tip is free."""
    if not arrays.end_free[1].any(axis=1).all():
        return False
    along = matrices(straight.q[:1])[0][:, 0]
    forces = arrays.nodal[:, 3:].copy()
    forces[1:] += arrays.elements.half_load
    forces[:-1] += arrays.elements.half_load
    axial = forces @ along
    sideways = np.abs(forces - np.outer(axial, along)).sum()
    sideways += np.abs(arrays.nodal[:, :3]).sum() / arrays.length
    compressed = float(np.cumsum(axial[::-1]).min()) < 0.0
    return compressed and float(sideways) <= NO_SIDE * float(np.abs(axial).sum())


def _from_tip(problem: RodProblem) -> tuple[Array, Array]:
    """Return where a rod held by its tip alone begins, and along what it runs."""
    tip = problem.tip
    if isinstance(tip, Free):
        return np.zeros(3), np.array((1.0, 0.0, 0.0))
    along = np.array((1.0, 0.0, 0.0))
    if isinstance(tip, (Clamped, Guided)) and tip.orientation is not None:
        along = matrices(np.array([tip.orientation], dtype=np.float64))[0][:, 0]
    return np.asarray(tip.position, dtype=np.float64) - problem.rod.length * along, along


def from_shape(problem: RodProblem, arrays: Arrays, start: RodState | Array) -> Iterate:
    """Return a rod in the shape of a centerline or, on as many nodes, of a state."""
    if not isinstance(start, RodState):
        return from_centerline(problem, arrays, np.asarray(start, dtype=np.float64))
    x = from_centerline(problem, arrays, start.positions.copy())
    if start.orientations.shape == x.q.shape:
        x.q[:] = start.orientations
    return x


def from_centerline(problem: RodProblem, arrays: Arrays, points: Array) -> Iterate:
    """Return a rod along a centerline, with the least twist that starts from the base's frame.

    As many points as nodes are the nodes, stretched as they are; others are a curve along which
    the rod lies evenly.

    Raises:
        InvalidInputError: the centerline is not two or more different finite points.
    """
    requirement = "a centerline of two or more different finite points (n, 3)"
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
        raise InvalidInputError("start", points, requirement)
    legs = np.sqrt(np.sum(np.diff(points, axis=0) ** 2, axis=1))
    if not np.all(np.isfinite(points)) or not np.all(legs > 0.0):
        raise InvalidInputError("start", points, requirement)
    p = points.copy()
    if len(points) != arrays.count + 1:
        along = np.concatenate(([0.0], np.cumsum(legs)))
        sites = arrays.arc_lengths * along[-1] / arrays.length
        p = np.column_stack([np.interp(sites, along, c) for c in points.T])
    chords = np.diff(p, axis=0)
    chords /= np.sqrt(np.sum(chords**2, axis=1))[:, None]
    tangents = np.vstack((chords[:1], chords[:-1] + chords[1:], chords[-1:]))
    tangents /= np.sqrt(np.sum(tangents**2, axis=1))[:, None]
    base = problem.base
    held = base.orientation if isinstance(base, (Clamped, Guided)) else None
    frame = turn_to(tangents[0]) if held is None else np.asarray(held, dtype=np.float64)
    q = np.vstack((frame, _carried(frame, tangents[1:])))
    return empty(arrays.count, len(arrays.obstacles), q, p)


def unsolved(arrays: Arrays, x: Iterate) -> Point:
    """Return a point whose equilibrium has not been looked for."""
    anchors = carried(x, None, arrays.obstacles, arrays.obstacles, arrays.lever, 0.0)
    nothing = Solution(
        UNSTABLE, 0, math.nan, math.inf, math.nan, np.zeros((arrays.count + 1, 6)),
        np.zeros((arrays.count + 1, 3)), (),
    )  # fmt: skip
    return Point(0.0, arrays, x, anchors, nothing)


def halved(here: Point, arrays: Arrays) -> Iterate:
    """Return a frictionless state's unknowns on elements half as long, those of ``arrays``."""
    old, half, count = here.x, here.arrays.elements.half_load, arrays.count
    x = empty(count, len(arrays.obstacles), np.empty((count + 1, 4)), np.empty((count + 1, 3)))
    x.q[::2], x.p[::2] = old.q, old.p
    x.q[1::2] = quaternions_between(old.q[:-1], old.q[1:], 0.5)
    legs = np.sqrt(np.sum(np.diff(old.p, axis=0) ** 2, axis=1))[:, None]
    tangents = matrices(old.q)[:, :, 0]
    x.p[1::2] = 0.5 * (old.p[:-1] + old.p[1:]) + 0.125 * legs * (tangents[:-1] - tangents[1:])
    x.n[::2], x.n[1::2] = old.n + 0.5 * half, old.n - 0.5 * half
    x.normal[:, ::2] = 0.5 * old.normal
    x.normal[:, 1::2] = 0.25 * (old.normal[:, :-1] + old.normal[:, 1:])
    return x


def turn_to(direction: Array) -> Array:
    """Return the smallest turn (4,) that takes e_x to a unit vector."""
    turn: Array = _carried(np.array((0.0, 0.0, 0.0, 1.0)), direction[None])[0]
    return turn


@compiled
def _carried(first: Array, directions: Array) -> Array:
    """Return quaternions (n, 4), each the last one, at first ``first``, turned the smallest way.

    That takes its x axis to the next of the unit vectors ``directions`` (n, 3).
    """
    q = np.empty((len(directions), 4))
    here = (first[0], first[1], first[2], first[3])
    for e in range(len(directions)):
        tangent, direction = to_base(here, TANGENT), vector_at(directions, e)
        x, y, z = cross(tangent, direction)
        w = 1.0 + dot(tangent, direction)
        if w < 1e-9:  # opposite: half a turn about an axis across, the section's own
            x, y, z = to_base(here, (0.0, 1.0, 0.0))
            w = 0.0
        here = normalized(quaternion_product((x, y, z, w), here))
        for i in range(4):
            q[e, i] = here[i]
    return q
