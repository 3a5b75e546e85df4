# SPDX-License-Identifier: Apache-2.0
"""One step in time: generalized-alpha where the rod is free, implicit Euler where it touches.

Both are a minimization: of the energy plus an inertia that is quadratic about a target. Derived in
``docs/derivations/motion.md``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spiral_core.rod._algebra import composed, matrices, turned
from spiral_core.rod.contact._contact import Iterate, carried, distances
from spiral_core.rod.contact._continuation import Point, largest_moves, moved_fraction
from spiral_core.rod.contact._mesh import Arrays, node_lengths
from spiral_core.rod.contact._newton import Newton, Solution
from spiral_core.rod.contact.obstacles import Obstacle, in_base_frame, seen_from
from spiral_core.rod.motion._terms import (
    StepTerms,
    coordinates,
    drag_factor,
    stiffened,
    strains,
)
from spiral_core.rod.motion.inertia import Damping
from spiral_core.rod.types import Array

# Spectral radius at infinite frequency of the generalized-alpha method (Chung, Hulbert, J. Appl.
# Mech. 60, 1993); with constraints of positions it stays of second order (Arnold, Bruels,
# Multibody Syst. Dyn. 18, 2007).
SPECTRAL_RADIUS = 0.8
ALPHA_M = (2.0 * SPECTRAL_RADIUS - 1.0) / (SPECTRAL_RADIUS + 1.0)
ALPHA_F = SPECTRAL_RADIUS / (SPECTRAL_RADIUS + 1.0)
GAMMA = 0.5 + ALPHA_F - ALPHA_M
BETA = 0.25 * (1.0 + ALPHA_F - ALPHA_M) ** 2
# Imbalance at which a step is solved, and, where impacts of many nodes let the iteration come no
# nearer, accepted: fractions of the scales of static forces and lengths.
TOLERANCE, ACCEPTED = 1e-7, 1e-4


class Course(NamedTuple):
    """Quantities in time, with the first and the second derivative that the method uses."""

    value: Array
    rate: Array
    mean: Array


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """A rod at a time, and what the next step needs of its past.

    Args:
        time: [s].
        point: the unknowns, the problem and the evidence.
        y: coordinates (N + 1, 9).
        last: their accelerations (N + 1, 9) [1/s^2].
        strain: what the elements' material remembers (N, 6); only where it is damped.
        touches: which nodes touch an obstacle (N + 1,).
        started: whether accelerations are known.
    """

    time: float
    point: Point
    y: Course
    last: Array
    strain: Course
    touches: NDArray[np.bool_]
    started: bool = True


def at_rest(time: float, point: Point) -> Moment:
    """Return a rod that begins to move from rest."""
    point = replace(point, x=point.x.copy())
    _release(point.x, point.solution)
    y, strain = coordinates(point.x), strains(point.x, point.arrays, point.arrays)
    zero, none = np.zeros_like(y), np.zeros_like(strain)
    courses = Course(y, zero, zero), zero, Course(strain, none, none)
    return Moment(time, point, *courses, np.any(point.x.normal > 0.0, axis=0), started=False)


def _release(x: Iterate, solution: Solution) -> None:
    """Take the forces from nodes that do not touch: an interior point leaves each node a little."""
    x.normal[~solution.contacts.active] = 0.0
    x.friction[~solution.contacts.active] = 0.0


def advanced(
    here: Moment, arrays: Arrays, duration: float, inertia: Array, damping: Damping
) -> tuple[Moment | None, float]:
    """Take a step to the problem that ``arrays`` states.

    ``inertia`` is that of its coordinates. Returns the rod after it, or None if the step was not
    solved or a node moved too far; and the estimated error of the positions in this step [m].
    """
    smooth = ~here.touches & here.started
    target, scale = _target(here, duration, smooth)
    back, past = _backward(here.y, duration, smooth[:, None])
    guess = _predicted(here, arrays, duration)
    solved = arrays
    if damping.retardation_time > 0.0:
        both = (smooth[:-1] & smooth[1:])[:, None]
        between, past_strain = _backward(here.strain, duration, both)
        solved = stiffened(arrays, damping.retardation_time / between, past_strain)
    moved, resisted = inertia / scale, inertia * (damping.drag_rate / back)
    weight = moved + resisted
    drag = _air(here, arrays, duration, damping.air) / back[:, :, None]
    terms = StepTerms(weight, (moved * target + resisted * past) / weight, drag, past[:, :3])
    point = _solve(here.point, solved, guess, terms)
    if point is None:
        return None, np.inf
    after = _after(here, point, arrays, duration, smooth, target, scale)
    return after, _error(here, after, duration, smooth)


def _target(
    here: Moment, duration: float, smooth: NDArray[np.bool_]
) -> tuple[Array, NDArray[np.float64]]:
    """Return where the nodes would be without forces, and time squared per acceleration."""
    h = duration
    gain = BETA * h * h / (1.0 - ALPHA_M)
    y, rate, mean = here.y
    euler = y + h * rate
    alpha = euler + h * h * (0.5 - BETA) * mean
    alpha += gain * (ALPHA_F * here.last - ALPHA_M * mean)
    chosen = smooth[:, None]
    scale = np.where(chosen, gain * (1.0 - ALPHA_F), h * h)
    return np.where(chosen, alpha, euler), scale


def _backward(before: Course, duration: float, smooth: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return b (n, 1) and z such that (value - z) / b is the rate at the end of the step."""
    h, (value, rate, mean) = duration, before
    back = BETA * h / GAMMA
    newmark = value + (h - back) * rate + h * ((0.5 - BETA) * h - (1.0 - GAMMA) * back) * mean
    return np.where(smooth, back, h), np.where(smooth, newmark, value)


def _stepped(before: Course, value: Array, duration: float, smooth: NDArray[np.bool_]) -> Course:
    """Return quantities with these values at the end of a step."""
    back, past = _backward(before, duration, smooth)
    change = (value - before.value) / duration - before.rate
    newmark = (change / duration - (0.5 - BETA) * before.mean) / BETA
    return Course(value, (value - past) / back, np.where(smooth, newmark, change / duration))


def _predicted(here: Moment, arrays: Arrays, duration: float) -> Iterate:
    """Return the state expected at the end of the step."""
    x = _taken_along(here.point, arrays)
    still, (_, rate, mean) = here.touches[:, None], here.y
    x.p[:] += np.where(still, 0.0, duration * (rate + 0.5 * duration * mean)[:, :3])
    spin = _spin(here)
    x.q[:] = turned(x.q, np.where(still, 0.0, duration * spin))
    return x


def _taken_along(here: Point, arrays: Arrays) -> Iterate:
    """Return a state whose nodes that touch have moved with their obstacle."""
    x = here.x.copy()
    for j, (old, new) in enumerate(zip(here.arrays.obstacles, arrays.obstacles, strict=True)):
        if (old.position, old.orientation) == (new.position, new.orientation):
            continue
        hit = x.normal[j] > 0.0
        x.p[hit] = in_base_frame(new, seen_from(old, x.p[hit]))
        back = np.array([old.orientation]) * (-1.0, -1.0, -1.0, 1.0)
        turn = composed(np.array([new.orientation]), back)
        x.q[hit] = composed(np.repeat(turn, np.count_nonzero(hit), axis=0), x.q[hit])
    return x


def _spin(here: Moment) -> Array:
    """Return the angular velocities in the material frame (N + 1, 3) [rad/s]."""
    turn = matrices(here.point.x.q)
    second = np.einsum("nji,nj->ni", turn, here.y.rate[:, 3:6])
    third = np.einsum("nji,nj->ni", turn, here.y.rate[:, 6:9])
    # d_2' = w x d_2 = (-w_z, 0, w_x), d_3' = w x d_3 = (w_y, -w_x, 0)
    return np.column_stack((0.5 * (second[:, 2] - third[:, 1]), third[:, 0], -second[:, 0]))


def _air(here: Moment, arrays: Arrays, duration: float, air: float) -> Array:
    """Return force over velocity of the air on each node (N + 1, 3, 3) [N s/m]."""
    if not air > 0.0:
        return np.zeros((len(here.last), 3, 3))
    along = matrices(here.point.x.q)[:, :, 0]
    across = np.eye(3) - along[:, :, None] * along[:, None, :]
    velocity = here.y.rate[:, :3] + duration * here.y.mean[:, :3]
    speed = np.sqrt(np.sum(np.einsum("nij,nj->ni", across, velocity) ** 2, axis=1))
    factor = drag_factor(speed, 2.0 * arrays.radius, air) * node_lengths(arrays.arc_lengths)
    drag: Array = factor[:, None, None] * across
    return drag


def _solve(here: Point, arrays: Arrays, guess: Iterate, terms: StepTerms) -> Point | None:
    """Minimize; from where the rod is if not from the guess. None if neither works."""
    anchors = carried(here.x, here.anchors, here.arrays, arrays)
    largest = float(largest_moves(here).max())
    for x in (guess, _taken_along(here, arrays)):
        newton = Newton(arrays, x, anchors, terms, tolerance=TOLERANCE, rounded=0.0)
        solution = newton.run(largest)
        near = solution.pivot > 0.0 and solution.residual < ACCEPTED
        if near and moved_fraction(here, arrays, x.p) <= 1.0:
            _release(x, solution)
            return Point(here.at, arrays, x, anchors, solution)
    return None


def _after(
    here: Moment,
    point: Point,
    arrays: Arrays,
    duration: float,
    smooth: NDArray[np.bool_],
    target: Array,
    scale: NDArray[np.float64],
) -> Moment:
    """Return the rates at the end of a step; contact takes the velocity at which nodes met it."""
    value, touches = coordinates(point.x), np.any(point.x.normal > 0.0, axis=0)
    chosen = smooth & ~touches
    y, last = _stepped(here.y, value, duration, chosen[:, None]), (value - target) / scale
    struck = touches & ~here.touches
    if struck.any():
        _stop(y.rate, struck, here.point.arrays.obstacles, arrays, point.x, duration)
    y.mean[touches] = last[touches] = 0.0
    strain = here.strain
    if point.arrays is not arrays:  # stiffened: the material remembers
        both = (chosen[:-1] & chosen[1:])[:, None]
        strain = _stepped(strain, strains(point.x, point.arrays, arrays), duration, both)
    point = replace(point, at=here.time + duration, arrays=arrays)
    return Moment(here.time + duration, point, y, last, strain, touches)


def _stop(
    rate: Array,
    struck: NDArray[np.bool_],
    before: tuple[Obstacle, ...],
    arrays: Arrays,
    x: Iterate,
    duration: float,
) -> None:
    """Give nodes that have met an obstacle its velocity across the surface: no rebound."""
    for j, (old, new) in enumerate(zip(before, arrays.obstacles, strict=True)):
        hit = np.nonzero(struck & (x.normal[j] > 0.0))[0]
        _, normal, _ = distances(new, x.p[hit], arrays.radius)
        surface = (x.p[hit] - in_base_frame(old, seen_from(new, x.p[hit]))) / duration
        excess = np.sum((rate[hit, :3] - surface) * normal, axis=1)
        rate[hit, :3] -= excess[:, None] * normal


def _error(here: Moment, after: Moment, duration: float, smooth: NDArray[np.bool_]) -> float:
    """Return the estimated error of the positions [m]; impacts are not judged."""
    jump = np.abs(after.y.mean - here.y.mean)[:, :3]
    free = smooth & ~after.touches
    error = abs(BETA - 1.0 / 6.0) * duration**2 * jump[free].max(initial=0.0)
    return float(error)
