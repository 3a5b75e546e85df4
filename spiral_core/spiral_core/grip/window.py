# SPDX-License-Identifier: Apache-2.0
"""Closing on an object: at which pressures it is wrapped, and when the grip is lost."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np

from spiral_core.errors import InvalidInputError, SolverError
from spiral_core.grip.hanging import hanging_tube
from spiral_core.grip.point import GripPoint
from spiral_core.grip.rise import (
    CURL,
    LIFT_OFF,
    WRAP,
    finest,
    located,
    lost_at,
    raised,
    wrapped_before_snap,
)
from spiral_core.grip.setup import GripSetup
from spiral_core.rod.contact.solve import follow_contact
from spiral_core.rod.state import RodPath, RodStatus
from spiral_core.rod.types import Array

# Where the pressure stops on its way, as fractions of the tip criterion's; without one, and above
# the last of them, even steps.
BEFORE_WRAP = (0.3, 0.6, 0.75, 0.85, 0.9, 0.94)
STEP = 0.04
STEPS_OF_LIMIT = 32
# A tip that has not touched up to this many times the tip criterion's pressure never does: the coil
# is then thinner than the object and lies beside it, or on one side of it.
GIVE_UP = 1.6
# Pressures up to which the coil's fall is followed, as fractions of the loss.
FALL_PRESSURES = (1.004, 1.01, 1.02)

Progress = Callable[[int, int], None]


class WindowEnd(Enum):
    """What ends a rising pressure; the value says it in words."""

    LOST = "the coil loses stability"
    LIMIT = "the gripper's pressure limit"
    PASSED_BY = "the coil is not wrapped far above the tip criterion's pressure"
    SELF_CONTACT = "turns of the tube touch each other, which the model does not resist"
    NOT_FOLLOWED = "the tube finds no rest that could be certified"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class GripWindow:
    """The result of closing a gripper on an object with rising pressure.

    Args:
        setup: the gripper and its object.
        points: the states met, by rising pressure; the last is the last that holds.
        onset_wrap: lowest pressure at which the tip touches the object, and more than a tenth of
            the tube with it: the perfect wrap [Pa]; None if there is none.
        onset_curling: pressure above it at which the end bridges more than a tenth of the tube's
            outer radius [Pa]; None if it does not. Where it does from the onset on, and the tip
            lifts off and touches again further up, the window is the one that begins there.
        loss: lowest pressure at which the wrapped coil has no stable shape next to the one it has
            and snaps: as a rule its end lets go [Pa]; None if it does not. :func:`follow_loss` has
            what remains.
        end: what ended the path.
        lift_off: lowest pressure above the wrap's onset at which the tip no longer touches, though
            nothing has snapped [Pa]; None if it does not. It may touch again further up.
    """

    setup: GripSetup
    points: tuple[GripPoint, ...]
    onset_wrap: float | None
    onset_curling: float | None
    loss: float | None
    end: WindowEnd
    lift_off: float | None = None

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
        if not self.points[0].pressure <= pressure <= self.top:
            end = self.end.value if self.loss is None else f"lost at {self.loss:.9g} Pa"
            reach = f"from 0 to {self.top:.9g} Pa, the last that was computed to hold ({end})"
            raise InvalidInputError("pressure", pressure, reach)
        below = [point for point in self.points if point.pressure <= pressure][-1]
        if below.pressure == pressure:
            return below
        point, path = raised(below, pressure)
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
            smallest_increment=finest(point, beyond),
        )
        if not path.states or path.states[-1].status is not RodStatus.CONVERGED:
            return None
        point = GripPoint(beyond, window.setup, path.states[-1])
        if not point.is_wrapped:
            break
    return point


def grip_window(
    setup: GripSetup,
    pressures: Sequence[float] | Array | None = None,
    progress: Progress | None = None,
    *,
    until_wrapped: bool = False,
) -> GripWindow:
    """Return what a pressure that rises from nothing does, up to the gripper's limit or the loss.

    Args:
        setup: the gripper and its object.
        pressures: at which to look (n,) [Pa], increasing; None takes steps of a few percent. The
            window's pressures are located between them.
        progress: called with the number of steps done and the number there are, after each.
        until_wrapped: whether to stop where the object is wrapped, for ``onset_wrap`` alone.

    Raises:
        InvalidInputError: pressures do not increase within (0, limit].
        NotGrippableError: the object lies in the way of the tube without pressure.
        SolverError: that tube has no certified shape.
    """
    points = [GripPoint(0.0, setup, hanging_tube(setup))]
    onset = curling = loss = lift_off = None
    end = WindowEnd.LIMIT
    stations = _stations(setup, pressures)
    for count, pressure in enumerate(stations, start=1):
        here = points[-1]
        point, path = raised(here, pressure, wrapped=onset is not None)
        snaps = wrapped_before_snap(here, pressure, path) if onset is None else None
        if snaps is not None:  # wrapped and lost again between two pressures
            onset = located(here, snaps, WRAP)
            if snaps.is_curled:
                curling = max(onset, located(here, snaps, CURL))
            points.append(snaps)
            here = snaps
            point, path = raised(here, pressure, wrapped=True)
        loss = lost_at(here, pressure, path, wrapped=onset is not None)
        if loss is not None or point is None:
            end = WindowEnd.LOST if loss is not None else _why(path)
            break
        curled_only = lift_off is not None and curling == onset
        if point.is_wrapped and (onset is None or curled_only):
            onset, curling, lift_off = located(here, point, WRAP), None, None
        if onset is not None and curling is None and point.is_curled:
            curling = max(onset, located(here, point, CURL))
        if onset is not None and lift_off is None and not point.is_wrapped:
            lift_off = max(onset, located(here, point, LIFT_OFF))
        points.append(point)
        if onset is None and pressures is None and _passed_by(point):
            end = WindowEnd.PASSED_BY
            break
        if progress is not None:
            progress(count, len(stations))
        if until_wrapped and onset is not None:
            break
    return GripWindow(setup, tuple(points), onset, curling, loss, end, lift_off)


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


def _why(path: RodPath) -> WindowEnd:
    """Return why a path could not be followed."""
    touches = path.self_contact is not None
    return WindowEnd.SELF_CONTACT if touches else WindowEnd.NOT_FOLLOWED


def _passed_by(point: GripPoint) -> bool:
    """Return whether the pressure is so far above the tip criterion's that no wrap will follow."""
    tip = point.setup.tip_pressure
    return tip is not None and point.pressure >= GIVE_UP * tip
