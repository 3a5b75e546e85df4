# SPDX-License-Identifier: Apache-2.0
"""Closing on an object: at which pressures it is wrapped, and when the grip is lost."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np

from spiral_core.errors import InvalidInputError, SolverError
from spiral_core.grip.hanging import hanging_tube
from spiral_core.grip.point import CURL_GAP, TOUCH_GAP, GripPoint, wraps
from spiral_core.grip.setup import Closing, GripSetup
from spiral_core.rod.contact.solve import follow_contact
from spiral_core.rod.contact.state import ContactPath, ContactStatus
from spiral_core.rod.types import Array
from spiral_core.validation import require_in_range

# Where the pressure stops on its way, as fractions of the tip criterion's; without one, and above
# the last of them, even steps.
BEFORE_WRAP = (0.3, 0.6, 0.75, 0.85, 0.9, 0.94)
STEP = 0.04
STEPS_OF_LIMIT = 32
# A tip that has not touched up to this many times the tip criterion's pressure never does: the coil
# is then thinner than the object and lies beside it, or on one side of it.
GIVE_UP = 1.6
# Pressures of the window are located to this fraction of themselves.
PRESSURE_TOLERANCE = 2e-3
# A loss with friction to this one: which increments fail next to it depends on the way there.
FRICTION_TOLERANCE = 5e-3
# Pressures up to which the coil's fall is followed, as fractions of the loss.
FALL_PRESSURES = (1.004, 1.01, 1.02)
# So often an onset is looked for by a line between two points, before it is bracketed by halves.
LINE_TRIES = 4
# A loss of more than this fraction of what touches is the loss of the grip.
LOST_FRACTION = 0.5

Progress = Callable[[int, int], None]


class WindowEnd(Enum):
    """What ends a rising pressure; the value says it in words."""

    LOST = "the wrapped coil loses stability"
    LIMIT = "the gripper's pressure limit"
    PASSED_BY = "the tip has not touched far above the tip criterion's pressure"
    SELF_CONTACT = "turns of the tube touch each other, which the model does not resist"
    NOT_FOLLOWED = "the tube finds no rest that could be certified"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class GripWindow:
    """What a rising pressure does to a gripper with an object in its way.

    Args:
        setup: the gripper and its object.
        points: the states met, by rising pressure; the last is the last that holds.
        onset_wrap: lowest pressure at which the tip touches the object, and more than a few nodes
            with it: the perfect wrap [Pa]; None if there is none.
        onset_curling: pressure above it at which the end bridges more than a tenth of the tube's
            outer radius [Pa]; None if it does not.
        loss: lowest pressure at which the wrapped coil has no stable shape next to the one it has
            and snaps: as a rule its end lets go [Pa]; None if it does not. :func:`follow_loss` has
            what remains.
        end: what ended the path.
    """

    setup: GripSetup
    points: tuple[GripPoint, ...]
    onset_wrap: float | None
    onset_curling: float | None
    loss: float | None
    end: WindowEnd

    def __repr__(self) -> str:
        wrap, curling, loss, tip = (
            "none" if value is None else f"{1e-3 * value:.2f} kPa"
            for value in (self.onset_wrap, self.onset_curling, self.loss, self.setup.tip_pressure)
        )
        return (
            f"GripWindow(wrapped from {wrap} (tip criterion: {tip}), curling from {curling}, "
            f"lost at {loss}; {self.setup.closing.value})"
        )

    @property
    def pressures(self) -> Array:
        """Pressures of the points (n,) [Pa]."""
        return np.array([point.pressure for point in self.points])

    @property
    def contact_lengths(self) -> Array:
        """Lengths in contact at the points (n,) [m]."""
        return np.array([point.contact_length for point in self.points])

    @property
    def normal_forces(self) -> Array:
        """Sums of the normal forces at the points (n,) [N]."""
        return np.array([point.normal_force for point in self.points])

    @property
    def top(self) -> float:
        """Highest pressure at which the grip was found to hold [Pa]."""
        return self.points[-1].pressure

    def at(self, pressure: float) -> GripPoint:
        """Return the grip at a pressure [Pa] of the path, closed from the point below it.

        Raises:
            InvalidInputError: the pressure lies outside of the path that was followed.
            SolverError: no certified state was found.
        """
        require_in_range("pressure", pressure, self.points[0].pressure, self.top)
        below = [point for point in self.points if point.pressure <= pressure][-1]
        if below.pressure == pressure:
            return below
        point, path = _raised(below, pressure)
        if point is None:
            last = path.events[-1].last if path.events else path.states[-1]
            raise SolverError(last.status, last.residual, last.iterations)
        return point


def follow_loss(window: GripWindow) -> GripPoint | None:
    """Return where the coil comes to rest after the loss of the grip: what remains of it.

    From the last stable state below the loss the pressure rises until the end has let go, by 2 % at
    most; the motion is overdamped. ``contact_length`` of the result is what stays in contact: with
    friction it may be most of the coil, or all of it where only a part near the base has snapped
    (``is_wrapped``). :func:`holding_force` of it is what still holds.

    Args:
        window: of a grip.

    Returns:
        The grip at rest, None where nothing was lost or the coil finds no rest.
    """
    if window.loss is None:
        return None
    point, limit = window.points[-1], window.setup.gripper.pressure_max
    for factor in FALL_PRESSURES:
        beyond = min(limit, factor * window.loss)
        if not beyond > point.pressure:
            break
        path = follow_contact(
            [window.setup.closing_problem(beyond)],
            start=point.state,
            smallest_increment=_finest(point, beyond),
        )
        if not path.states or path.states[-1].status is not ContactStatus.CONVERGED:
            return None
        point = GripPoint(beyond, window.setup, path.states[-1])
        if not point.is_wrapped:
            break
    return point


def grip_window(
    setup: GripSetup,
    pressures: Sequence[float] | Array | None = None,
    progress: Progress | None = None,
) -> GripWindow:
    """Return what a pressure that rises from nothing does, up to the gripper's limit or the loss.

    Args:
        setup: the gripper and its object.
        pressures: at which to look (n,) [Pa], increasing; None takes steps of a few percent. The
            window's pressures are located between them.
        progress: called with the number of steps done and the number there are, after each.

    Raises:
        InvalidInputError: pressures do not increase within (0, limit].
        NotGrippableError: the object lies in the way of the tube without pressure.
        SolverError: that tube has no certified shape.
    """
    points = [GripPoint(0.0, setup, hanging_tube(setup))]
    onset = curling = loss = None
    end = WindowEnd.LIMIT
    stations = _stations(setup, pressures)
    for count, pressure in enumerate(stations, start=1):
        here = points[-1]
        point, path = _raised(here, pressure, wrapped=onset is not None)
        loss = _lost_at(here, pressure, path)
        if loss is not None or point is None:
            end = WindowEnd.LOST if loss is not None else _why(path)
            break
        if onset is None and point.is_wrapped:
            onset = _located(here, point, _is_wrapped, _touch_missing)
        if onset is not None and curling is None and point.is_curled:
            curling = max(onset, _located(here, point, _is_curled, _curl_missing))
        points.append(point)
        if onset is None and pressures is None and _passed_by(point):
            end = WindowEnd.PASSED_BY
            break
        if progress is not None:
            progress(count, len(stations))
    return GripWindow(setup, tuple(points), onset, curling, loss, end)


def _stations(setup: GripSetup, pressures: Sequence[float] | Array | None) -> list[float]:
    """Return the pressures to stop at [Pa], increasing, checked."""
    limit = setup.gripper.pressure_max
    tip = setup.tip_pressure
    if pressures is not None:
        given = [float(pressure) for pressure in pressures]
        rises = all(b > a for a, b in pairwise([0.0, *given]))
        if not (given and rises and given[-1] <= limit):
            raise InvalidInputError("pressures", pressures, f"increasing in (0, {limit:.6g}] Pa")
        return given
    if tip is None:
        return list(np.linspace(0.0, limit, STEPS_OF_LIMIT + 1)[1:].tolist())
    rising = [fraction * tip for fraction in BEFORE_WRAP]
    rising += np.arange(BEFORE_WRAP[-1] * tip + STEP * tip, limit, STEP * tip).tolist()
    return [pressure for pressure in rising if pressure < limit] + [limit]


def _raised(
    point: GripPoint, pressure: float, *, wrapped: bool = False
) -> tuple[GripPoint | None, ContactPath]:
    """Raise the pressure from a point; None if the tube finds no rest there.

    Before the wrap the tube may snap onto the object, and is followed. Once wrapped, the end of the
    branch is the end of the grip.
    """
    problem = point.setup.closing_problem(pressure)
    path = (
        follow_contact(
            [problem],
            start=point.state,
            smallest_increment=_finest(point, pressure),
            stop_at_event=True,
        )
        if wrapped
        else follow_contact([problem], start=point.state)
    )
    if not path.states or path.states[-1].status is not ContactStatus.CONVERGED:
        return None, path
    return GripPoint(pressure, point.setup, path.states[-1]), path


def _finest(point: GripPoint, pressure: float) -> float:
    """Return the fraction of the way from a point to a pressure to which a loss is located."""
    rubs = point.setup.closing is Closing.SLOW and point.setup.obstacle.friction > 0.0
    tolerance = FRICTION_TOLERANCE if rubs else PRESSURE_TOLERANCE
    return min(1.0, 0.5 * tolerance * pressure / (pressure - point.pressure))


def _why(path: ContactPath) -> WindowEnd:
    """Return why a path could not be followed."""
    last = path.states[-1] if path.states else path.events[-1].last
    touches = last.status is ContactStatus.SELF_CONTACT
    return WindowEnd.SELF_CONTACT if touches else WindowEnd.NOT_FOLLOWED


def _lost_at(before: GripPoint, pressure: float, path: ContactPath) -> float | None:
    """Return the pressure at which an event on the way to another one lost the grip.

    An event whose motion was not followed counts as a loss.
    """
    for event in path.events:
        held = float(event.before.contact_lengths[0])
        moves_on = event.last.status is ContactStatus.NOT_HELD
        if wraps(event.before) and (moves_on or event.contact_lost > LOST_FRACTION * held):
            return before.pressure + event.position * (pressure - before.pressure)
    return None


def _passed_by(point: GripPoint) -> bool:
    """Return whether the pressure is so far above the tip criterion's that no wrap will follow."""
    tip = point.setup.tip_pressure
    return tip is not None and point.pressure >= GIVE_UP * tip


def _is_wrapped(point: GripPoint) -> bool:
    return point.is_wrapped


def _is_curled(point: GripPoint) -> bool:
    return point.is_wrapped and point.is_curled


def _touch_missing(point: GripPoint) -> float:
    """Return how far the tip is from touching [m]."""
    return point.tip_gap - TOUCH_GAP * point.outer_radius


def _curl_missing(point: GripPoint) -> float:
    """Return how much less the end bridges than counts as curled [m]."""
    return CURL_GAP * point.outer_radius - point.largest_gap


def _located(
    low: GripPoint,
    high: GripPoint,
    happened: Callable[[GripPoint], bool],
    missing: Callable[[GripPoint], float],
) -> float:
    """Return the pressure between two points from which on something has happened [Pa].

    Looked for where a line through what is missing at both ends says, in the second half of the
    tries in the middle; what is missing is infinite, or of the wrong sign, where no such line is.
    """
    tries = 0
    while high.pressure - low.pressure > PRESSURE_TOLERANCE * high.pressure:
        span = high.pressure - low.pressure
        before, after = missing(low), missing(high)
        fraction = 0.5
        if tries < LINE_TRIES and math.isfinite(before) and before > 0.0 >= after > -math.inf:
            # A little beyond the line, so that both ends close in.
            margin = 0.4 * PRESSURE_TOLERANCE * high.pressure / span
            fraction = before / (before - after)
            fraction = min(max(fraction + (margin if tries % 2 == 0 else -margin), 0.1), 0.9)
        middle, _ = _raised(low, low.pressure + fraction * span)
        if middle is None:
            break
        low, high = (low, middle) if happened(middle) else (middle, high)
        tries += 1
    return high.pressure
