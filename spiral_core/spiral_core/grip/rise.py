# SPDX-License-Identifier: Apache-2.0
"""Raising the pressure from one grip to the next, and locating what happens between the two."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from spiral_core.grip.point import CURL_GAP, TOUCH_GAP, GripPoint, wraps
from spiral_core.grip.setup import Closing
from spiral_core.rod.contact.solve import follow_contact
from spiral_core.rod.state import RodEvent, RodPath, RodStatus
from spiral_core.rod.types import Array

# Pressures of the window are located to this fraction of themselves.
PRESSURE_TOLERANCE = 2e-3
# A loss with friction to this one: which increments fail next to it depends on the way there.
FRICTION_TOLERANCE = 5e-3
# So often an onset is looked for by a line between two points, before it is bracketed by halves.
LINE_TRIES = 4
# A loss of more than this fraction of what touches is the loss of the grip.
LOST_FRACTION = 0.5
# Between two problems the rod's rest shape changes straight, with the pressure it does not: in one
# step the pressure rises by at most this fraction of the tip criterion's, or of the limit.
WIDEST_STEP = 0.15


def raised(
    point: GripPoint, pressure: float, *, wrapped: bool = False
) -> tuple[GripPoint | None, RodPath]:
    """Raise the pressure from a point; None if the tube finds no rest there.

    Before the wrap the tube may snap onto the object, and is followed. Once wrapped, the end of the
    branch is the end of the grip.
    """
    problems = [point.setup.closing_problem(each) for each in _way(point, pressure)[1:].tolist()]
    path = (
        follow_contact(
            problems,
            start=point.state,
            smallest_increment=finest(point, pressure),
            stop_at_event=True,
        )
        if wrapped
        else follow_contact(problems, start=point.state)
    )
    missing = len(path.states) < len(problems)
    if missing or path.states[-1].status is not RodStatus.CONVERGED:
        return None, path
    return GripPoint(pressure, point.setup, path.states[-1]), path


def _way(point: GripPoint, pressure: float) -> Array:
    """Return the pressures to go by from a point to a pressure, both included (n,) [Pa]."""
    setup = point.setup
    widest = WIDEST_STEP * (setup.tip_pressure or setup.gripper.pressure_max)
    steps = max(1, math.ceil((pressure - point.pressure) / widest))
    return np.linspace(point.pressure, pressure, steps + 1)


def _pressure_at(before: GripPoint, pressure: float, event: RodEvent) -> float:
    """Return the pressure of an event on the way from a point to a pressure [Pa]."""
    way = _way(before, pressure)
    return float(np.interp(event.position, np.arange(len(way)), way))


def finest(point: GripPoint, pressure: float) -> float:
    """Return the fraction of a step from a point to a pressure to which a loss is located."""
    rubs = point.setup.closing is Closing.SLOW and point.setup.obstacle.friction > 0.0
    tolerance = FRICTION_TOLERANCE if rubs else PRESSURE_TOLERANCE
    steps = len(_way(point, pressure)) - 1
    return min(1.0, 0.5 * tolerance * pressure * steps / (pressure - point.pressure))


def wrapped_before_snap(before: GripPoint, pressure: float, path: RodPath) -> GripPoint | None:
    """Return the grip next to the first event on the way to a pressure, if the coil is wrapped."""
    if not path.events:
        return None
    event = path.events[0]
    there = _pressure_at(before, pressure, event)
    point = GripPoint(there, before.setup, event.before)
    return point if there > before.pressure and point.is_wrapped else None


def lost_at(before: GripPoint, pressure: float, path: RodPath, *, wrapped: bool) -> float | None:
    """Return the pressure at which an event on the way to another one lost the grip.

    Of a wrapped coil every snap counts, but not a place where the tube neither moves nor rests.
    """
    for event in path.events:
        lost = event.after is None
        if not wrapped:
            held = float(event.before.contact_lengths[0])
            moves_on = event.last.status is RodStatus.NOT_HELD
            lets_go = moves_on or event.contact_lost > LOST_FRACTION * held
            lost = wraps(event.before) and lets_go
        if lost:
            return _pressure_at(before, pressure, event)
    return None


@dataclass(frozen=True, slots=True)
class Mark:
    """Something that happens while the pressure rises.

    Args:
        happened: whether it has, at a point.
        missing: what is missing until it does [m], to interpolate; not above zero once it has.
    """

    happened: Callable[[GripPoint], bool]
    missing: Callable[[GripPoint], float]


def _touch_missing(point: GripPoint) -> float:
    """Return how far the tip is from touching [m]."""
    return point.tip_gap - TOUCH_GAP * point.outer_radius


WRAP = Mark(lambda point: point.is_wrapped, _touch_missing)
LIFT_OFF = Mark(lambda point: not point.is_wrapped, lambda point: -_touch_missing(point))
CURL = Mark(
    lambda point: point.is_wrapped and point.is_curled,
    lambda point: CURL_GAP * point.outer_radius - point.largest_gap,
)


def located(low: GripPoint, high: GripPoint, mark: Mark) -> float:
    """Return the pressure between two points from which on something has happened [Pa].

    Looked for where a line through what is missing at both ends says, in the second half of the
    tries in the middle; what is missing is infinite, or of the wrong sign, where no such line is.
    """
    tries = 0
    while high.pressure - low.pressure > PRESSURE_TOLERANCE * high.pressure:
        span = high.pressure - low.pressure
        before, after = mark.missing(low), mark.missing(high)
        fraction = 0.5
        if tries < LINE_TRIES and math.isfinite(before) and before > 0.0 >= after > -math.inf:
            # A little beyond the line, so that both ends close in.
            margin = 0.4 * PRESSURE_TOLERANCE * high.pressure / span
            fraction = before / (before - after)
            fraction = min(max(fraction + (margin if tries % 2 == 0 else -margin), 0.1), 0.9)
        middle, _ = raised(low, low.pressure + fraction * span)
        if middle is None:
            break
        low, high = (low, middle) if mark.happened(middle) else (middle, high)
        tries += 1
    return high.pressure
