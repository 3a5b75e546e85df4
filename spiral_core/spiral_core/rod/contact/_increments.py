# SPDX-License-Identifier: Apache-2.0
"""From one problem to the next in increments that the rod can follow, and what to do at a fold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from spiral_core.rod.contact._contact import Anchors, Iterate, carried, distances
from spiral_core.rod.contact._mesh import Arrays, between
from spiral_core.rod.contact._newton import CONVERGED, Drag, Newton, Solution, last_slip
from spiral_core.rod.contact._quaternions import turn_between, turned
from spiral_core.rod.types import Array

# In one increment a node moves by at most this fraction of an obstacle's arc, or its distance from
# it, so that it cannot change sides; and of the rod's length, so that a jump is seen as one.
LARGEST_ARC = 0.5
LARGEST_MOVE = 0.1
# Increments grow up to this many times where they are easy.
GROWTH = 1.6
EASY_PASSES = 14
# The branch has ended where no increment longer than this succeeds.
SMALLEST_INCREMENT = 1.0 / 4096.0
# Steps of the motion after a fold, how their drag changes, and after how many lengths of the rod
# it is lost.
SLIDE_STEPS = 600
DRAG_FALLS = 0.4
DRAG_RISES = 5.0
LOST = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """A state on a path.

    Args:
        at: fraction of the way between two problems.
        arrays: the problem there.
        x: the unknowns.
        anchors: of friction.
        solution: the evidence.
    """

    at: float
    arrays: Arrays
    x: Iterate
    anchors: Anchors
    solution: Solution


def largest_moves(here: Point) -> Array:
    """Return how far each node may move in an increment (N + 1,) [m].

    A node that is farther from an obstacle than that cannot change sides of it.
    """
    arrays = here.arrays
    moves = np.full(arrays.count + 1, LARGEST_MOVE * arrays.length)
    for obstacle in arrays.obstacles:
        arc = LARGEST_ARC * (obstacle.shape.feature_radius + arrays.radius)
        gap, _, _ = distances(obstacle, here.x.p, arrays.radius)
        moves = np.minimum(moves, np.maximum(arc, gap))
    return moves


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
    newton = Newton(arrays, guess, anchors, Drag(drag, here.x.copy()) if drag else None)
    solution = newton.run(LARGEST_MOVE * arrays.length)
    moves = np.sqrt(np.sum((guess.p - here.x.p) ** 2, axis=1))
    return guess, anchors, solution, float(np.max(moves / largest_moves(here)))


def advance(
    start: Point, end: Arrays, largest: float, first: Arrays, before: Point | None = None
) -> Iterator[Point | None]:
    """Follow the branch from ``start``, on the way from ``first`` to ``end``; yield its points.

    Yields None, and ends, where the branch ends. ``before`` is a point passed earlier, to
    extrapolate from.
    """
    here = start
    step = largest
    while here.at < 1.0:
        at = min(1.0, here.at + step) if here.at + step < 1.0 - 1e-12 else 1.0
        arrays = between(first, end, at)
        x, anchors, solution, move = attempt(here, arrays, extrapolated(before, here, at))
        if solution.outcome == CONVERGED and move <= 1.0:
            before, here = here, Point(at, arrays, x, anchors, solution)
            yield here
            growth = GROWTH if solution.passes <= EASY_PASSES else 1.0
            step = min(largest, step * min(growth, 0.7 / max(move, 1e-9)))
            step = max(step, SMALLEST_INCREMENT)
        elif before is not None:  # once more without extrapolation
            before = None
        elif step > SMALLEST_INCREMENT:
            step = max(SMALLEST_INCREMENT, step * min(0.5, 0.6 / max(move, 1e-9)))
        else:
            yield None
            return


def extrapolated(before: Point | None, here: Point, at: float) -> Iterate:
    """Return the state expected at ``at`` from the last two."""
    x = here.x.copy()
    if before is None or not here.at > before.at:
        return x
    ratio = min(2.0, (at - here.at) / (here.at - before.at))
    x.q[:] = turned(x.q, ratio * turn_between(before.x.q, here.x.q))
    x.p += ratio * (here.x.p - before.x.p)
    x.n += ratio * (here.x.n - before.x.n)
    grown = here.x.normal + ratio * (here.x.normal - before.x.normal)
    kept = np.maximum(grown, 0.1 * here.x.normal)
    x.normal[:] = np.where(here.x.normal > 0.0, kept, here.x.normal)
    x.friction += ratio * (here.x.friction - before.x.friction)
    return x


def slide(here: Point, arrays: Arrays) -> tuple[Point, bool, list[Array]]:
    """Let the rod move, overdamped, under ``arrays`` until it rests.

    Each step minimizes energy plus drag (a step of the implicit Euler method), short enough that
    no node changes sides of an obstacle. Returns where it is in the end, whether it rests there,
    and the positions (N + 1, 3) that it passed.
    """
    unit = arrays.force_scale / arrays.length
    drag = 1e-2 * unit
    trail = [here.x.p]
    rests = 0
    for _ in range(SLIDE_STEPS):
        x, anchors, solution, move = attempt(here, arrays, here.x.copy(), drag)
        if solution.outcome != CONVERGED or move > 1.0:
            drag *= DRAG_RISES
            if drag > 1e8 * unit:
                return here, False, trail
            continue
        here = Point(here.at, arrays, x, anchors, solution)
        trail.append(x.p)
        if np.abs(x.p - trail[0]).max() > LOST * arrays.length:
            return here, False, trail
        if move < 0.3:
            drag *= DRAG_FALLS
        rests = rests + 1 if move < 0.02 else 0
        if rests >= 2 or drag < 1e-8 * unit:
            x, anchors, solution, move = attempt(here, arrays, here.x.copy())
            if solution.outcome == CONVERGED and move <= 0.5:
                trail.append(x.p)
                return Point(here.at, arrays, x, anchors, solution), True, trail
            rests = 0
    return here, False, trail


def beyond(here: Point, end: Arrays, first: Arrays) -> tuple[float, Arrays]:
    """Return the problem just beyond the end of a branch."""
    at = min(1.0, here.at + SMALLEST_INCREMENT)
    return at, between(first, end, at)


def empty(count: int, obstacles: int, q: Array, p: Array) -> Iterate:
    """Return an iterate without forces."""
    return Iterate(
        q=q,
        p=p,
        n=np.zeros((count, 3)),
        normal=np.zeros((obstacles, count + 1)),
        slack=np.ones((obstacles, count + 1)),
        friction=np.zeros((obstacles, count + 1, 3)),
    )
