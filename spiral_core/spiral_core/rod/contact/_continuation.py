# SPDX-License-Identifier: Apache-2.0
"""Where a solve begins, and how it goes on from one problem to the next in increments.

It begins from the straight rod, a given centerline, or a state on longer elements; increments are
such that the rod can follow; at a fold it moves, overdamped, to where it rests.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    TANGENT,
    cross,
    dot,
    matrices,
    normalized,
    put_vector,
    quaternion_at,
    quaternion_product,
    quaternions_between,
    subtract,
    to_base,
    turn_between,
    turned,
    vector_at,
)
from spiral_core.rod._newton import CONVERGED, UNSTABLE
from spiral_core.rod.contact._contact import TINY, Anchors, Iterate, carried, contacts_at, empty
from spiral_core.rod.contact._mesh import Arrays, between
from spiral_core.rod.contact._newton import Newton, Solution
from spiral_core.rod.contact.obstacles import Quaternion, passes_through, seen_from
from spiral_core.rod.contact.problem import Free, RodProblem
from spiral_core.rod.types import ZERO, Array

# In one increment a node moves by at most this fraction of an obstacle's arc, or its distance from
# it, so that it cannot change sides; and of the rod's length, so that a jump is seen as one.
LARGEST_ARC = 0.5
LARGEST_MOVE = 0.1
THROUGH = 2.0  # where an element passed through an obstacle
# An iteration on whose way a node is so many times as far is given up.
TOO_FAR = 3.0
# Increments grow up to this many times from one to the next.
GROWTH = 1.6
# Two changes are proportional up to this fraction.
ALIKE = 0.05
# The branch has ended where no increment longer than this succeeds, if nothing else is asked for.
SMALLEST_INCREMENT = 1.0 / 4096.0
# A rod that comes to rest after no more than this fraction of what a node may move in an increment
# rests where it was: an increment failed, with friction as a rule, but nothing has snapped.
NEXT_TO = 0.1
# Steps of the motion after a fold, how their drag changes, and after how many lengths of the rod
# it is lost.
SLIDE_STEPS = 600
DRAG_FALLS = 0.4
DRAG_RISES = 5.0
LOST = 2.0
# Where a rod on a saddle is pushed to: towards the inside of its rest curvature and along it, or in
# the frame of its sections without one; and by how much of its length: twice as far each time that
# it comes to rest there again, since what drives it off is within the tolerance.
INWARDS, ALONG = 0.8, 0.6
LEAST_ASIDE, LARGEST_ASIDE = 1e-7, 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """A state on a path.

    Args:
        at: fraction of the way between two problems.
        arrays: the problem there.
        x: the unknowns.
        anchors: of friction.
        solution: the evidence.
        spent: passes since the point before, those of failed attempts included.
    """

    at: float
    arrays: Arrays
    x: Iterate
    anchors: Anchors
    solution: Solution
    spent: int = 0

    @property
    def solved(self) -> bool:
        """Whether it is a state."""
        return self.solution.outcome == CONVERGED


@dataclass(frozen=True, slots=True, eq=False)
class Drag:
    """Resistance to leaving a state: a step of the overdamped motion away from it.

    Args:
        weight: per node, against displacement [N/m].
        rest: the state.
        arm: length by which rotations count as displacements [m].
    """

    weight: float
    rest: Iterate
    arm: float

    def add(self, x: Iterate, gradient: Array, tangent: Array) -> None:
        """Add gradient and Hessian at x."""
        turning, every = self.weight * self.arm**2, np.arange(6)
        gradient[:, :3] += turning * turn_between(self.rest.q, x.q)
        gradient[:, 3:] += self.weight * (x.p - self.rest.p)
        tangent[:, every[:3], every[:3]] += turning
        tangent[:, every[3:], every[3:]] += self.weight


def largest_moves(here: Point) -> Array:
    """Return how far each node may move in an increment (N + 1,) [m].

    A node that is farther from an obstacle than that cannot change sides of it.
    """
    arrays = here.arrays
    moves = np.full(arrays.count + 1, LARGEST_MOVE * arrays.length)
    for obstacle, gap in zip(arrays.obstacles, here.solution.contacts.gap, strict=True):
        arc = LARGEST_ARC * (obstacle.shape.feature_radius + arrays.radius)
        moves = np.minimum(moves, np.maximum(arc, gap))
    return moves


def moved_fraction(here: Point, arrays: Arrays, positions: Array) -> float:
    """Return the largest move of a node as a fraction of what it may, up to a problem and a place.

    A node may not change sides of an obstacle: its move is seen from the obstacle, wherever that
    goes meanwhile. Nor may an element: its nodes then went too far.
    """
    moves = np.sqrt(np.sum((positions - here.x.p) ** 2, axis=1))
    fraction = float(moves.max()) / (LARGEST_MOVE * arrays.length)
    gaps = here.solution.contacts.gap
    for old, new, gap in zip(here.arrays.obstacles, arrays.obstacles, gaps, strict=True):
        start, end = seen_from(old, here.x.p), seen_from(new, positions)
        seen = np.sqrt(np.sum((end - start) ** 2, axis=1))
        arc = LARGEST_ARC * (old.shape.feature_radius + arrays.radius)
        fraction = max(fraction, float(np.max(seen / np.maximum(arc, gap))))
        if passes_through(old, start, end):
            fraction = max(fraction, THROUGH)
    return fraction


@compiled
def strays(start: Array, squares: Array, positions: Array) -> bool:
    """Return whether a point (n, 3) is farther from its start than given by squares (n,)."""
    for e in range(len(start)):
        away = subtract(vector_at(positions, e), vector_at(start, e))
        if dot(away, away) > squares[e]:
            return True
    return False


def attempt(
    here: Point, arrays: Arrays, guess: Iterate | None = None, drag: float = 0.0
) -> tuple[Point, float]:
    """Solve ``arrays`` from a guess, or as the rod is, friction measured from ``here``.

    Returns also the largest move of a node, as a fraction of what it may.
    """
    x = here.x.copy() if guess is None else guess
    anchors = carried(here.x, here.anchors, here.arrays, arrays)
    resistance = Drag(drag, here.x, arrays.step) if drag else None
    newton = Newton(arrays, x, anchors, resistance)
    limits = (TOO_FAR * largest_moves(here)) ** 2
    solution = newton.run(LARGEST_MOVE * arrays.length, partial(strays, here.x.p, limits))
    return Point(here.at, arrays, x, anchors, solution), moved_fraction(here, arrays, x.p)


def advance(
    start: Point,
    end: Arrays,
    sizes: tuple[float, float],
    first: Arrays,
    before: Point | None = None,
) -> Iterator[Point]:
    """Follow the branch from ``start``, on the way from ``first`` to ``end``; yield its points.

    Yields the last one again, with the passes spent in vain, where the branch ends. ``sizes`` are
    the smallest and the largest increment. With friction the states depend on the increments, so
    these follow from states alone: neither the passes of an iteration nor where a failed one
    stopped, which rounding changes, decides the next. ``before`` is a point passed earlier, to
    extrapolate from.
    """
    here = start
    smallest, largest = sizes
    step = first_increment(before, here, smallest, largest)
    spent = 0
    while here.at < 1.0:
        at = min(1.0, here.at + step) if here.at + step < 1.0 - 1e-12 else 1.0
        there, move = attempt(here, between(first, end, at), extrapolated(before, here, at))
        spent += there.solution.passes
        if there.solved and move <= 1.0:
            before, here = here, replace(there, at=at, spent=spent)
            yield here
            spent = 0
            step = min(largest, step * min(GROWTH, 0.7 / max(move, 1e-9)))
            step = max(step, smallest)
        elif step > smallest or before is not None:
            before = None  # the next attempt goes without extrapolation
            step = max(smallest, 0.5 * step)
        else:
            yield replace(here, spent=spent)
            return


def first_increment(before: Point | None, here: Point, smallest: float, largest: float) -> float:
    """Return the increment that moves the rod as far as it may if it goes on as it came."""
    if before is None or not here.at > before.at:
        return largest
    move = moved_fraction(before, here.arrays, here.x.p) / (here.at - before.at)
    return min(largest, max(smallest, 0.7 / max(move, 1e-9)))


def continued(before: Point | None, here: Point, end: Arrays) -> Point | None:
    """Return ``before``, its place counted as if it lay on the way from ``here`` to ``end``.

    None unless this way leads on in the direction of the last one: the same quantities change, in
    the same proportions.
    """
    if before is None:
        return None
    last, now = _change(before.arrays, here.arrays), _change(here.arrays, end)
    square = float(last @ last)
    ratio = float(last @ now) / square if square > 0.0 else 0.0
    if not ratio > 0.0 or not np.abs(now - ratio * last).max() <= ALIKE * np.abs(now).max():
        return None
    return replace(before, at=here.at - 1.0 / ratio)


def _change(first: Arrays, last: Arrays) -> Array:
    """Return how much the quantities differ that a way may change, each in a scale of its own."""
    bending, length = first.bending, first.length
    force = bending / length**2

    def quantities(arrays: Arrays) -> Array:
        elements = arrays.elements
        parts = [
            elements.stiffness / bending,
            elements.compliance / bending,
            elements.rest * (length / bending),
            elements.rest_slope * (length / bending),
            elements.half_load / force,
            arrays.nodal / np.repeat((force * length, force), 3),
            arrays.end_positions / length,
            arrays.end_orientations,
        ]
        for obstacle in arrays.obstacles:
            place = np.array(obstacle.position) / length
            parts += [place, np.array((*obstacle.orientation, obstacle.friction))]
        return np.concatenate([part.ravel() for part in parts])

    return quantities(last) - quantities(first)


def extrapolated(before: Point | None, here: Point, at: float) -> Iterate:
    """Return the state expected at ``at`` from the last two."""
    x = here.x.copy()
    if before is None or not here.at > before.at:
        return x
    ratio = min(2.0, (at - here.at) / (here.at - before.at))
    x.q[:] = turned(x.q, ratio * turn_between(before.x.q, here.x.q))
    x.p[:] += ratio * (here.x.p - before.x.p)
    x.n[:] += ratio * (here.x.n - before.x.n)
    grown = here.x.normal + ratio * (here.x.normal - before.x.normal)
    kept = np.maximum(grown, 0.1 * here.x.normal)
    x.normal[:] = np.where(here.x.normal > 0.0, kept, here.x.normal)
    x.friction[:] += ratio * (here.x.friction - before.x.friction)
    return x


def release(here: Point) -> tuple[Point, bool, list[Array]]:
    """Let the rod go from a shape that need not be near a state; returns as :func:`slide`."""
    there, move = attempt(here, here.arrays)
    spent = there.solution.passes
    if there.solved and move <= 0.5:
        return replace(there, spent=spent), True, [here.x.p, there.x.p]
    return slide(here, here.arrays, spent)


def slide(
    here: Point, arrays: Arrays, spent: int = 0, reach: float = math.inf
) -> tuple[Point, bool, list[Array]]:
    """Let the rod move, overdamped, under ``arrays`` until it rests.

    Each step minimizes energy plus drag (a step of the implicit Euler method), short enough that
    no node changes sides of an obstacle. Returns where it is in the end, whether it rests there,
    and the positions (N + 1, 3) that it passed. ``spent`` are passes to count with its own; the
    motion is followed no further than ``reach``, a fraction of what a node may move.
    """
    unit = arrays.force_scale / arrays.length
    drag = unit
    start = here
    trail = [here.x.p]
    rests, aside = 0, LEAST_ASIDE
    for _ in range(SLIDE_STEPS):
        there, move = attempt(here, arrays, drag=drag)
        spent += there.solution.passes
        if not there.solved or move > 1.0:
            drag *= DRAG_RISES
            if drag > 1e8 * unit:
                break
            continue
        here = there
        trail.append(here.x.p)
        if np.abs(here.x.p - trail[0]).max() > LOST * arrays.length:
            break
        if reach < math.inf and moved_fraction(start, arrays, here.x.p) > reach:
            break
        if move < 0.3:
            drag *= DRAG_FALLS
        rests = rests + 1 if move < 0.02 else 0
        if rests >= 2 or drag < 1e-8 * unit:
            there, move = attempt(here, arrays)
            spent += there.solution.passes
            if there.solved and move <= 0.5:
                trail.append(there.x.p)
                return replace(there, spent=spent), True, trail
            rests = 0
            here = replace(here, x=pushed_aside(here, aside))
            aside = min(2.0 * aside, LARGEST_ASIDE)
    return replace(here, spent=spent), False, trail


def pushed_aside(here: Point, fraction: float) -> Iterate:
    """Return the rod moved by a fraction of its length: off a saddle, where it cannot rest."""
    x, s = here.x.copy(), here.arrays.arc_lengths / here.arrays.length
    x.p[:] += (
        fraction
        * here.arrays.length
        * (s * (1.6 - s))[:, None]
        * (matrices(x.q) @ push_direction(here.arrays))
    )
    return x


def push_direction(arrays: Arrays) -> Array:
    """Return the direction (3,) in which a rod is pushed off a saddle, in the sections' frame.

    It is made of the rest moment, so that a mirrored rod is pushed to the mirrored side.
    """
    twist, *bending = arrays.elements.rest.mean(axis=0).tolist()
    size = math.hypot(*bending)
    if not size > 0.0:
        return np.array((0.0, INWARDS, ALONG))
    second, third = bending[0] / size, bending[1] / size
    along = ALONG if twist >= -1e-9 * size else -ALONG
    return np.array((0.0, INWARDS * third + along * second, -INWARDS * second + along * third))


def tried(here: Point) -> Point:
    """Return the point with the evidence of one more try, if it has none, for a report."""
    if math.isfinite(here.solution.residual):
        return here
    return replace(attempt(here, here.arrays)[0], spent=here.spent)


# Loads bend a rod to no side if what is across it, of them all, is at most this fraction.
NO_SIDE = 1e-6
# Then it is bent by this angle while they come on [rad]: by its rest strain, or towards its y axis.
TRACE = 1e-2
TOWARDS_Y = (0.0, 0.0, 1.0)


def straight(problem: RodProblem, arrays: Arrays) -> tuple[Iterate, Arrays]:
    """Return the straight unloaded rod, and its problem: no loads, no rest strain."""
    base, tip = problem.base, problem.tip
    begin, end = getattr(base, "position", None), getattr(tip, "position", None)
    turn, last = getattr(base, "orientation", None), getattr(tip, "orientation", None)
    along = np.array(TANGENT)
    if turn is not None:
        along = _axis_of(turn)
    elif begin is not None and end is not None:
        span = np.asarray(end, dtype=np.float64) - begin
        along = span / max(float(np.linalg.norm(span)), TINY)
    elif begin is None and last is not None:
        along = _axis_of(last)
    if begin is None:
        begin = ZERO if end is None else np.asarray(end) - problem.rod.length * along
    origin = np.asarray(begin, dtype=np.float64)
    q = turn_to(along) if turn is None else np.asarray(turn, dtype=np.float64)
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
    )
    return x, first


def legs(arrays: Arrays, straight: Iterate) -> Array | None:
    """Return two legs (3, 3) [m] as long as the rod, from where one end is held to the other.

    A straight rod cannot get shorter: pushed together along itself it finds no way. None where it
    need not.
    """
    begin, end = arrays.end_positions
    span = end - begin
    rise = arrays.length**2 - float(span @ span)
    if arrays.end_free[:, 3:, 3:].any() or not rise > 0.0:
        return None
    aside = matrices(straight.q[:1])[0] @ push_direction(arrays)
    aside -= (aside @ span) / max(float(span @ span), TINY) * span
    aside *= 0.5 * math.sqrt(rise) / max(float(np.linalg.norm(aside)), TINY)
    return np.array((begin, 0.5 * (begin + end) + aside, end))


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
    return replace(arrays, elements=elements)


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


def _axis_of(orientation: Quaternion) -> Array:
    """Return the x axis (3,) of a section so turned."""
    axis: Array = matrices(np.array([orientation]))[0][:, 0]
    return axis


def from_centerline(problem: RodProblem, arrays: Arrays, points: Array) -> Iterate:
    """Return a rod along a centerline, with the least twist that starts from the base's frame.

    As many points as nodes are the nodes, stretched as they are; others are a curve along which
    the rod lies evenly.
    """
    p = points
    if len(points) != arrays.count + 1:
        legs = np.sqrt(np.sum(np.diff(points, axis=0) ** 2, axis=1))
        along = np.concatenate(([0.0], np.cumsum(legs)))
        sites = arrays.arc_lengths * along[-1] / arrays.length
        p = np.column_stack([np.interp(sites, along, c) for c in points.T])
    chords = _directions(np.diff(p, axis=0))
    tangents = _directions(np.vstack((chords[:1], chords[:-1] + chords[1:], chords[-1:])))
    held = getattr(problem.base, "orientation", None)
    frame = turn_to(tangents[0]) if held is None else np.asarray(held, dtype=np.float64)
    q = np.vstack((frame, _carried(frame, tangents[1:])))
    return empty(arrays.count, len(arrays.obstacles), q, p)


def _directions(vectors: Array) -> Array:
    """Return vectors (n, 3) at length one; none where a centerline turns back."""
    sizes = np.sqrt(np.sum(vectors**2, axis=1))
    directions: Array = vectors / np.maximum(sizes, TINY)[:, None]
    return directions


def unsolved(arrays: Arrays, x: Iterate) -> Point:
    """Return a point whose equilibrium has not been looked for."""
    anchors = carried(x, None, arrays, arrays)
    nodes = arrays.count + 1
    contacts = contacts_at(x, arrays, np.ones(nodes, dtype=np.bool_))
    imbalance, moments = np.zeros((nodes, 6)), np.zeros((nodes, 3))
    nothing = Solution(UNSTABLE, 0, math.nan, math.inf, math.nan, imbalance, moments, contacts)
    return Point(0.0, arrays, x, anchors, nothing)


def halved(here: Point, arrays: Arrays) -> Iterate:
    """Return a frictionless state's unknowns on elements half as long, those of ``arrays``."""
    old, half, count = here.x, here.arrays.elements.half_load, arrays.count
    x = empty(count, len(arrays.obstacles), np.empty((count + 1, 4)), np.empty((count + 1, 3)))
    x.q[::2], x.p[::2] = old.q, old.p
    x.q[1::2] = quaternions_between(old.q[:-1], old.q[1:], 0.5)
    x.p[1::2] = 0.5 * (old.p[:-1] + old.p[1:])
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
    here = quaternion_at(first.reshape(1, 4), 0)
    for e in range(len(directions)):
        tangent, direction = to_base(here, TANGENT), vector_at(directions, e)
        x, y, z = cross(tangent, direction)
        w = 1.0 + dot(tangent, direction)
        if w < 1e-9:  # opposite: half a turn about an axis across, the section's own
            x, y, z = to_base(here, (0.0, 1.0, 0.0))
            w = 0.0
        here = normalized(quaternion_product((x, y, z, w), here))
        put_vector(q[e], 0, here)
    return q
