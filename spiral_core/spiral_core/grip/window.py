# SPDX-License-Identifier: Apache-2.0
"""Closing on an object: the grip at one pressure, where it is wrapped, and where it is lost."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError, SolverError
from spiral_core.grip.setup import Closing, GripSetup, hanging_tube
from spiral_core.message import Message, Quantity
from spiral_core.numerics.tasks import Progress
from spiral_core.rod.contact.obstacles import seen_from
from spiral_core.rod.contact.solve import follow_contact
from spiral_core.rod.state import RodEvent, RodPath, RodState, RodStatus
from spiral_core.rod.types import Array
from spiral_core.rounding import rounded_down
from spiral_core.validation import require_positive
from spiral_core.wrap.wrap import WrapRegime

# The tip counts as touching within this fraction of the tube's outer radius, and the end as curled
# away where it bridges more than the second one: half a millimeter for the paper's tube.
TOUCH_GAP = 0.01
CURL_GAP = 0.1
# Of the tube, the part that has to touch before contact counts as something to lose.
FEWEST_TOUCHING = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class GripPoint:
    """A gripper on its object at one pressure.

    Args:
        pressure: gauge pressure [Pa].
        setup: the gripper and its object.
        state: the tube's shape, its contact forces and its certificate.
    """

    __repr__ = brief_repr

    pressure: float
    setup: GripSetup
    state: RodState

    @property
    def regime(self) -> WrapRegime:
        """How the tube lies on the object, from its contact."""
        if not self.is_wrapped:
            return WrapRegime.OVERHANG
        return WrapRegime.CURLING if self.is_curled else WrapRegime.PERFECT_WRAP

    @property
    def is_wrapped(self) -> bool:
        """Whether the tip touches, and more than a tenth of the tube with it."""
        return self.tip_gap <= TOUCH_GAP * self.outer_radius and self._wraps

    @property
    def is_curled(self) -> bool:
        """Whether the end bridges more than a curl's gap after its first touch."""
        return self._wraps and self.largest_gap > CURL_GAP * self.outer_radius

    @property
    def _wraps(self) -> bool:
        return wraps(self.state, self.outer_radius)

    @property
    def outer_radius(self) -> float:
        """Of the tube [m]."""
        return self.setup.gripper.tube.outer_radius

    @property
    def contact_length(self) -> float:
        """Length of tube that touches the object, its gap at most that of a touching tip [m]."""
        return float(self.state.lengths_within(TOUCH_GAP * self.outer_radius)[0].sum())

    @property
    def normal_force(self) -> float:
        """Sum of the normal forces on the object [N]."""
        return float(self.state.normal_forces.sum())

    @property
    def line_force(self) -> Array:
        """Normal force per length of tube at its nodes (n,) [N/m].

        Where the tube lifts off it presses with a point force, which an element spreads over its
        own length: compare resultants, or :attr:`contact_pressure`, not this peak.
        """
        values: Array = self.state.normal_forces[0] / self.state.node_lengths
        return values

    @property
    def contact_pressure(self) -> float:
        r"""Largest pressure of the tube on the object [Pa]: an estimate.

        .. math:: p = \sqrt{\frac{q E^*}{\pi r_o}}, \quad E^* = \frac{EI}{I (1 - \nu^2)}, \;
            \nu = 1/2

        Hertz's line contact of a solid elastomer cylinder of the tube's outer radius with a flat,
        hard surface; q is the largest line force, averaged over a length of two outer radii, which
        the tube's thickness spreads a point force over. A hollow tube flattens and presses less.
        EI is that of bending sideways, in which fibers take the least part.
        """
        tube = self.setup.gripper.tube
        forces = self.state.normal_forces[0]
        at = self.state.arc_lengths
        half = tube.outer_radius
        within = np.abs(at[:, None] - at[None, :]) <= half
        shared = np.maximum(within @ self.state.node_lengths, 2.0 * half)
        peak = float(np.max((within @ forces) / shared))
        modulus = self.setup.gripper.stiffness.sideways / tube.second_moment_of_area / 0.75
        return math.sqrt(max(peak, 0.0) * modulus / (math.pi * half))

    @property
    def turns(self) -> float:
        """Turns of the touching part about the object's axis."""
        touching = np.flatnonzero(self.state.touching[0])
        if touching.size < 2:
            return 0.0
        part = self.state.positions[touching[0] : touching[-1] + 1]
        x, y, _ = seen_from(self.setup.obstacle, part).T
        around = np.unwrap(np.arctan2(y, x))
        return float(abs(around[-1] - around[0])) / math.tau

    @property
    def tip_gap(self) -> float:
        """Distance between the tip's surface and the object's [m]."""
        return float(self.state.gaps[0, -1])

    @property
    def largest_gap(self) -> float:
        """Largest distance to the object between the first touch and the tip [m].

        Infinite where nothing touches.
        """
        touching = np.flatnonzero(self.state.touching[0])
        return float(self.state.gaps[0, touching[0] :].max()) if touching.size else math.inf

    @property
    def base_reaction(self) -> Array:
        """Force [N] and moment [N m] with which the mount holds the gripper (6,), base frame."""
        return self.state.base_reaction


def wraps(state: RodState, outer_radius: float) -> bool:
    """Return whether more than a tenth of the tube touches: contact that can be lost.

    Counted is what lies within a touching tip's gap, from the first node that bears a force to the
    last. Where tube and object only cross this is short; and the nodes that bear a force are now
    more and now less where the tube lies on the object lightly.
    """
    bearing = np.flatnonzero(state.touching[0])
    if bearing.size < 2:
        return False
    near = state.lengths_within(TOUCH_GAP * outer_radius)[0, bearing[0] : bearing[-1]]
    return float(near.sum()) > FEWEST_TOUCHING * float(state.arc_lengths[-1])


# Pressures of the window are located to this fraction of themselves.
PRESSURE_TOLERANCE = 2e-3
# Where windows are compared, to this one.
DIFFERENCE_TOLERANCE = 1e-5
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
            lost = wraps(event.before, before.outer_radius) and lets_go
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


def located(
    low: GripPoint, high: GripPoint, mark: Mark, tolerance: float = PRESSURE_TOLERANCE
) -> float:
    """Return the pressure between two points from which on something has happened [Pa].

    Looked for where a line through what is missing at both ends says, in the second half of the
    tries in the middle; what is missing is infinite, or of the wrong sign, where no such line is.
    """
    tries = 0
    while high.pressure - low.pressure > tolerance * high.pressure:
        span = high.pressure - low.pressure
        before, after = mark.missing(low), mark.missing(high)
        fraction = 0.5
        if tries < LINE_TRIES and math.isfinite(before) and before > 0.0 >= after > -math.inf:
            # A little beyond the line, so that both ends close in.
            margin = 0.4 * tolerance * high.pressure / span
            fraction = before / (before - after)
            fraction = min(max(fraction + (margin if tries % 2 == 0 else -margin), 0.1), 0.9)
        middle, _ = raised(low, low.pressure + fraction * span)
        if middle is None:
            break
        low, high = (low, middle) if mark.happened(middle) else (middle, high)
        tries += 1
    return high.pressure


UNCURL = Mark(
    lambda point: point.is_wrapped and not point.is_curled,
    lambda point: point.largest_gap - CURL_GAP * point.outer_radius,
)


# Where the pressure stops on its way, as fractions of the tip criterion's; without one, and above
# the last of them, even steps.
BEFORE_WRAP = (0.3, 0.6, 0.75, 0.85, 0.9, 0.94)
STEP = 0.04
STEPS_OF_LIMIT = 32
# A tip that has not touched up to this many times the tip criterion's pressure never does: the coil
# is then thinner than the object and lies beside it, or on one side of it.
GIVE_UP = 1.6
# A recommended pressure stays below the loss by this part of it.
LOSS_MARGIN = 0.1
# Pressures up to which the coil's fall is followed, as fractions of the loss.
FALL_PRESSURES = (1.004, 1.01, 1.02)

# To see what a grip depends on, the object is moved by this part of the tube's length.
NUDGE = 1e-6


class WindowEnd(Enum):
    """What ends a rising pressure; the value says it in words."""

    LOST = "the coil loses stability"
    LIMIT = "the gripper's pressure limit"
    PASSED_BY = "the coil is not wrapped above the tip criterion's pressure"
    SELF_CONTACT = "turns of the tube touch each other, which the model does not resist"
    NOT_FOLLOWED = "the tube finds no rest that could be certified"


@dataclass(frozen=True, slots=True, eq=False)
class GripWindow:
    """The result of closing a gripper on an object with rising pressure.

    Args:
        setup: the gripper and its object.
        points: the states met, by rising pressure; the last is the last that holds.
        onset_wrap: lowest pressure at which the tip touches the object, and more than a tenth of
            the tube with it: the perfect wrap [Pa]; None if there is none.
        onset_curling: pressure above it at which the end bridges more than a tenth of the tube's
            outer radius [Pa]; None if it does not. Where it does from the onset on, and no longer
            further up, or the tip lifts off and touches again, the window begins there.
        loss: lowest pressure at which the wrapped coil has no stable shape next to the one it has
            and snaps: as a rule its end lets go [Pa]; None if it does not. :func:`follow_loss` has
            what remains.
        end: what ended the path.
        lift_off: lowest pressure above the wrap's onset at which the tip no longer touches, though
            nothing has snapped [Pa]; None if it does not. It may touch again further up.
        loss_above: of a grip that holds up to the gripper's limit, the loss above that, where its
            margin reaches below the limit [Pa]; None if there is none, or it was not looked for.
    """

    __repr__ = brief_repr

    setup: GripSetup
    points: tuple[GripPoint, ...]
    onset_wrap: float | None
    onset_curling: float | None
    loss: float | None
    end: WindowEnd
    lift_off: float | None = None
    loss_above: float | None = None

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

    @property
    def is_cut_short(self) -> bool:
        """Whether higher pressures were not looked at."""
        return self.end is WindowEnd.LIMIT and self.top < self.setup.gripper.pressure_max

    def at(self, pressure: float) -> GripPoint:
        """Return the grip at a pressure [Pa] of the path, closed from the point below it.

        Raises:
            InvalidInputError: the pressure lies outside of the path that was followed.
            SolverError: no certified state was found.
        """
        if not self.points[0].pressure <= pressure <= self.top:
            end = self.end.value
            if self.loss is not None:
                end = Message("lost at {}", Quantity(self.loss, "Pa"))
            top = Quantity(self.top, "Pa", rounded_down)
            reach = Message("from 0 to {}, the last that was computed to hold ({})", top, end)
            raise InvalidInputError("pressure", pressure, reach, "Pa")
        below = [point for point in self.points if point.pressure <= pressure][-1]
        if below.pressure == pressure:
            return below
        point, path = raised(below, pressure)
        if point is None:
            last = path.events[-1].last if path.events else path.states[-1]
            raise SolverError(last.status, last.residual, last.iterations)
        return point


def sharp_onset(window: GripWindow) -> float:
    """Return the onset of a wrap to :data:`DIFFERENCE_TOLERANCE` of itself [Pa].

    For differences of windows: that of two onsets to :data:`PRESSURE_TOLERANCE` says nothing where
    their setups are alike.

    Raises:
        InvalidInputError: the window has none.
    """
    if window.onset_wrap is None:
        raise InvalidInputError("window", window, "one with an onset of the wrap")
    above = int(np.searchsorted(window.pressures, window.onset_wrap))
    low, high = window.points[above - 1 : above + 1]
    mark = UNCURL if WRAP.happened(low) else WRAP
    return located(low, high, mark, DIFFERENCE_TOLERANCE)


def follow_loss(window: GripWindow) -> GripPoint | None:
    """Return where the coil comes to rest after the loss of the grip: what remains of it.

    From the last stable state below the loss the pressure rises until the end has let go, by 2 % at
    most; the motion is overdamped. ``contact_length`` of the result is what stays in contact: with
    friction it may be most of the coil, or all of it where only a part near the base has snapped
    (``is_wrapped``). :func:`~spiral_core.grip.holding.holding_force` of it is what still holds.

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
    give_up: float | None = None,
) -> GripWindow:
    """Return what a pressure that rises from nothing does, up to the gripper's limit or the loss.

    Args:
        setup: the gripper and its object.
        pressures: at which to look (n,) [Pa], increasing; None takes steps of a few percent. The
            window's pressures are located between them.
        progress: called with the number of steps done and the number there are, after each.
        until_wrapped: whether to stop where the object is wrapped, and the end does not curl, for
            ``onset_wrap`` alone.
        give_up: pressure from which on a tube that is not wrapped is given up, as a multiple of the
            tip criterion's; None is 1.6 or, with ``pressures``, never.

    Raises:
        InvalidInputError: pressures do not increase within (0, limit]; ``give_up`` is not positive.
        NotGrippableError: the object lies in the way of the tube without pressure.
        SolverError: that tube has no certified shape.
    """
    points = [GripPoint(0.0, setup, hanging_tube(setup))]
    wrapped, loss, end = False, None, WindowEnd.LIMIT
    stations = _stations(setup, pressures)
    if give_up is None:
        give_up = GIVE_UP if pressures is None else math.inf
    else:
        require_positive("give_up", give_up)
    for count, pressure in enumerate(stations, start=1):
        here = points[-1]
        point, path = raised(here, pressure, wrapped=wrapped)
        snaps = None if wrapped else wrapped_before_snap(here, pressure, path)
        if snaps is not None:  # wrapped and lost again between two pressures
            points.append(snaps)
            here, wrapped = snaps, True
            point, path = raised(here, pressure, wrapped=True)
        loss = lost_at(here, pressure, path, wrapped=wrapped)
        if loss is not None or point is None:
            touches = path.self_contact is not None
            end = WindowEnd.SELF_CONTACT if touches else WindowEnd.NOT_FOLLOWED
            end = end if loss is None else WindowEnd.LOST
            break
        points.append(point)
        wrapped = wrapped or point.is_wrapped
        passed = setup.tip_pressure is not None and pressure >= give_up * setup.tip_pressure
        if passed and not wrapped:
            end = WindowEnd.PASSED_BY
            break
        if progress is not None:
            progress(count, len(stations))
        if until_wrapped and point.is_wrapped and not point.is_curled:
            break
    above = None
    if end is WindowEnd.LIMIT and wrapped and pressures is None and not until_wrapped:
        above = _loss_above(points[-1])
    onset, curling, lift_off = _marks(points)
    return GripWindow(setup, tuple(points), onset, curling, loss, end, lift_off, above)


def _marks(points: Sequence[GripPoint]) -> tuple[float | None, float | None, float | None]:
    """Return onsets of the wrap and of curling, and where the tip lifts off, between points [Pa].

    An end that curls from the onset on is no wrap yet, if it no longer does further up.
    """
    onset = curling = lift_off = None
    for here, point in pairwise(points):
        curled_only = (
            onset is not None
            and curling is not None
            and curling <= (1.0 + PRESSURE_TOLERANCE) * onset
        )
        again = curled_only and (lift_off is not None or not point.is_curled)
        if point.is_wrapped and (onset is None or again):
            mark = UNCURL if again and lift_off is None else WRAP
            onset, curling, lift_off = located(here, point, mark), None, None
        if onset is None:
            continue
        if curling is None and point.is_curled:
            curling = max(onset, located(here, point, CURL))
        if lift_off is None and not point.is_wrapped:
            lift_off = max(onset, located(here, point, LIFT_OFF))
    return onset, curling, lift_off


def _loss_above(point: GripPoint) -> float | None:
    """Return the loss above the gripper's limit [Pa] whose margin reaches below that, if any."""
    gripper = point.setup.gripper
    highest = min(point.pressure / (1.0 - LOSS_MARGIN), gripper.actuation.pressure_limit)
    if not (highest > point.pressure and point.is_wrapped):
        return None
    setup = replace(point.setup, gripper=replace(gripper, pressure_max=highest))
    here = GripPoint(point.pressure, setup, point.state)
    _, path = raised(here, highest, wrapped=True)
    return lost_at(here, highest, path, wrapped=True)


def nudged_windows(setup: GripSetup) -> tuple[GripWindow, GripWindow]:
    """Return the windows with the object a little nearer to the base and a little farther.

    It is moved by a millionth of the tube's length: what the windows do not share depends on what
    no experiment can set.

    Raises:
        NotGrippableError: see :func:`grip_window`.
        SolverError: likewise.
    """
    away = np.array((0.0, NUDGE * setup.gripper.tube.length, 0.0, 0.0, 0.0))
    return grip_window(setup.moved(-away)), grip_window(setup.moved(away))


def _stations(setup: GripSetup, pressures: Sequence[float] | Array | None) -> list[float]:
    """Return the pressures to stop at [Pa], increasing, checked."""
    limit = setup.gripper.pressure_max
    tip = setup.tip_pressure
    if pressures is not None:
        given = [float(pressure) for pressure in pressures]
        rises = all(b > a for a, b in pairwise([0.0, *given]))
        if not (given and rises and given[-1] <= limit):
            requirement = Message(
                "increasing, above 0 and up to {}", Quantity(limit, "Pa", rounded_down)
            )
            raise InvalidInputError("pressures", tuple(given), requirement, "Pa")
        return given
    if tip is None:
        return list(np.linspace(0.0, limit, STEPS_OF_LIMIT + 1)[1:].tolist())
    rising = [fraction * tip for fraction in BEFORE_WRAP]
    rising += np.arange(BEFORE_WRAP[-1] * tip + STEP * tip, limit, STEP * tip).tolist()
    return [pressure for pressure in rising if pressure < limit] + [limit]
