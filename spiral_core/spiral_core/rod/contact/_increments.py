# SPDX-License-Identifier: Apache-2.0
"""From one problem to the next in increments that the rod can follow, and what to do at a fold."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from spiral_core.rod._algebra import matrices, turn_between, turned
from spiral_core.rod.contact._contact import Anchors, Iterate, Reach, carried, distances
from spiral_core.rod.contact._mesh import Arrays, between, last_slip
from spiral_core.rod.contact._newton import CONVERGED, Newton, Solution
from spiral_core.rod.contact.obstacles import passes_through, seen_from
from spiral_core.rod.types import Array

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


def gaps_at(here: Point) -> list[Array]:
    """Return the gaps of the nodes to each obstacle (N + 1,) [m]."""
    if here.solution.contacts:
        return [contact.gap for contact in here.solution.contacts]
    arrays = here.arrays
    return [distances(obstacle, here.x.p, arrays.radius)[0] for obstacle in arrays.obstacles]


def largest_moves(here: Point) -> Array:
    """Return how far each node may move in an increment (N + 1,) [m].

    A node that is farther from an obstacle than that cannot change sides of it.
    """
    arrays = here.arrays
    moves = np.full(arrays.count + 1, LARGEST_MOVE * arrays.length)
    for obstacle, gap in zip(arrays.obstacles, gaps_at(here), strict=True):
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
    pairs = zip(here.arrays.obstacles, arrays.obstacles, strict=True)
    for (old, new), gap in zip(pairs, gaps_at(here), strict=True):
        seen = moves
        if (old.position, old.orientation) != (new.position, new.orientation):
            seen = seen_from(new, positions) - seen_from(old, here.x.p)
            seen = np.sqrt(np.sum(seen * seen, axis=1))
        arc = LARGEST_ARC * (old.shape.feature_radius + arrays.radius)
        fraction = max(fraction, float(np.max(seen / np.maximum(arc, gap))))
        if passes_through(old, new, here.x.p, positions):
            fraction = max(fraction, THROUGH)
    return fraction


def attempt(
    here: Point, arrays: Arrays, guess: Iterate, drag: float = 0.0
) -> tuple[Iterate, Anchors, Solution, float]:
    """Solve ``arrays`` from a guess, friction measured from ``here``.

    Returns also the largest move of a node, as a fraction of what it may.
    """
    slip = last_slip(arrays)
    anchors = carried(
        here.x, here.anchors, here.arrays.obstacles, arrays.obstacles, arrays.lever, slip
    )
    resistance = Drag(drag, here.x.copy(), arrays.step) if drag else None
    newton = Newton(arrays, guess, anchors, resistance)
    limits = largest_moves(here)
    solution = newton.run(LARGEST_MOVE * arrays.length, Reach(here.x.p, TOO_FAR * limits))
    return guess, anchors, solution, moved_fraction(here, arrays, guess.p)


def advance(
    start: Point,
    end: Arrays,
    sizes: tuple[float, float],
    first: Arrays,
    before: Point | None = None,
) -> Iterator[Point | int]:
    """Follow the branch from ``start``, on the way from ``first`` to ``end``; yield its points.

    Yields the passes spent in vain, and ends, where the branch ends. ``sizes`` are the smallest and
    the largest increment. With friction the states depend on the increments, so these follow from
    states alone: neither the passes of an iteration nor where a failed one stopped, which rounding
    changes, decides the next. ``before`` is a point passed earlier, to extrapolate from.
    """
    here = start
    smallest, largest = sizes
    step = first_increment(before, here, smallest, largest)
    spent = 0
    while here.at < 1.0:
        at = min(1.0, here.at + step) if here.at + step < 1.0 - 1e-12 else 1.0
        arrays = between(first, end, at)
        x, anchors, solution, move = attempt(here, arrays, extrapolated(before, here, at))
        spent += solution.passes
        if solution.outcome == CONVERGED and move <= 1.0:
            before, here = here, Point(at, arrays, x, anchors, solution, spent)
            yield here
            spent = 0
            step = min(largest, step * min(GROWTH, 0.7 / max(move, 1e-9)))
            step = max(step, smallest)
        elif step > smallest or before is not None:
            before = None  # the next attempt goes without extrapolation
            step = max(smallest, 0.5 * step)
        else:
            yield spent
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
    parts = [
        (last.elements.stiffness - first.elements.stiffness) / bending,
        (last.elements.compliance - first.elements.compliance) / bending,
        (last.elements.rest - first.elements.rest) * (length / bending),
        (last.elements.rest_slope - first.elements.rest_slope) * (length / bending),
        (last.elements.half_load - first.elements.half_load) / force,
        (last.nodal - first.nodal) / np.repeat((force * length, force), 3),
        (last.end_positions - first.end_positions) / length,
        last.end_orientations - first.end_orientations,
    ]
    for a, b in zip(first.obstacles, last.obstacles, strict=True):
        parts.append((np.array(b.position) - np.array(a.position)) / length)
        parts.append(
            np.array((*b.orientation, b.friction)) - np.array((*a.orientation, a.friction))
        )
    return np.concatenate([part.ravel() for part in parts])


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


def release(here: Point, arrays: Arrays) -> tuple[Point, bool, list[Array]]:
    """Let the rod go from a shape that need not be near a state; returns as :func:`slide`."""
    x, anchors, solution, move = attempt(here, arrays, here.x.copy())
    if solution.outcome == CONVERGED and move <= 0.5:
        there = Point(here.at, arrays, x, anchors, solution, solution.passes)
        return there, True, [here.x.p, x.p]
    return slide(here, arrays, solution.passes)


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
        x, anchors, solution, move = attempt(here, arrays, here.x.copy(), drag)
        spent += solution.passes
        if solution.outcome != CONVERGED or move > 1.0:
            drag *= DRAG_RISES
            if drag > 1e8 * unit:
                break
            continue
        here = Point(here.at, arrays, x, anchors, solution)
        trail.append(x.p)
        if np.abs(x.p - trail[0]).max() > LOST * arrays.length:
            break
        if reach < math.inf and moved_fraction(start, arrays, x.p) > reach:
            break
        if move < 0.3:
            drag *= DRAG_FALLS
        rests = rests + 1 if move < 0.02 else 0
        if rests >= 2 or drag < 1e-8 * unit:
            x, anchors, solution, move = attempt(here, arrays, here.x.copy())
            spent += solution.passes
            if solution.outcome == CONVERGED and move <= 0.5:
                trail.append(x.p)
                return Point(here.at, arrays, x, anchors, solution, spent), True, trail
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
    x, _, solution, _ = attempt(here, here.arrays, here.x.copy())
    return replace(here, x=x, solution=solution)


def beyond(here: Point, end: Arrays, first: Arrays, smallest: float) -> tuple[float, Arrays]:
    """Return the problem just beyond the end of a branch."""
    at = min(1.0, here.at + smallest)
    return at, between(first, end, at)
