# SPDX-License-Identifier: Apache-2.0
"""Closing on an object at a pressure rate: contact over time, and the holding force at the end."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.actuator.fibers import FiberAngles, fiber_state
from spiral_core.brief import brief_repr
from spiral_core.closing.course import PressureCourse
from spiral_core.errors import InvalidInputError, SolverError, SpiralError
from spiral_core.grip.hanging import hanging_tube
from spiral_core.grip.holding import HoldingForce, Pull, holding_force
from spiral_core.grip.point import GripPoint
from spiral_core.grip.setup import GripSetup
from spiral_core.rod.contact.problem import RodProblem
from spiral_core.rod.contact.solve import follow_contact
from spiral_core.rod.motion.inertia import Damping, Inertia
from spiral_core.rod.motion.motion import EventKind, Frame, contact_fraction
from spiral_core.rod.motion.solve import DEFAULT_LONGEST_STEP, motion_frames
from spiral_core.rod.state import RodStatus
from spiral_core.validation import require_in_range, require_positive
from spiral_core.wrap.gripper import STANDARD_GRAVITY, Gripper

# Frames of a closing.
FRAMES = 120
# Pressure that a grip is closed to, over that of the perfect wrap, unless another one is asked for.
BEYOND_WRAP = 1.15
# Wrapped once this part of the final contact is there for good; settled once no node is faster
# than this fraction of the length per second for good.
WRAPPED, SETTLED = 0.9, 0.02
LEAST_WRAP = 0.5  # turns
# Orderly if so much of the contact of the slow closing is there.
ORDERLY = 0.9
# A closing is repeated on so many times the elements, and with the object this part of the length
# away; what is compared are pulls along the object.
FINER, PERTURBED = 1.5, 1e-9
ALONG = (Pull.AWAY, Pull.TOWARDS)
# In closings that take longer, inertia does not matter [s].
LONGEST_COURSE = 600.0
# Stations of the slow closing that a fast one is compared with.
SLOW_STATIONS = 40
KEEP = 0.9

Progress = Callable[[int, int], None]


def inertia_of(gripper: Gripper) -> Inertia:
    """Return the inertia of a gripper's tube with all that is wound on it.

    Raises:
        InvalidInputError: its weight is not known (zero).
    """
    mass = require_positive("weight_per_length", gripper.weight_per_length) / STANDARD_GRAVITY
    tube = gripper.tube
    return Inertia(mass, 0.25 * mass * (tube.outer_radius**2 + tube.inner_radius**2))


def enclosed_volume(gripper: Gripper, pressure: float) -> float:
    r"""Return the volume of air in a gripper [m^3] at a gauge pressure [Pa].

    .. math:: V = \pi r_i^2 L \lambda_1 \lambda_2^2

    with the stretches of the actuator model; the volume at rest where the model knows none, or
    has one family of fibers.
    """
    tube = gripper.tube
    rest = math.pi * tube.inner_radius**2 * tube.length
    stretch, actuation = gripper.unloaded_shape(pressure).stretch, gripper.actuation
    if stretch is None or not isinstance(actuation, FreeActuation):
        return rest
    fibers = actuation.actuator.fibers
    if not isinstance(fibers, FiberAngles):
        return rest
    return rest * stretch * fiber_state(fibers, stretch).hoop_stretch ** 2


@dataclass(frozen=True, slots=True, eq=False)
class TimedClosing:
    """A closing in time, as far as it was computed.

    Args:
        setup: the gripper and its object.
        course: the pressure that was asked for.
        frames: from the beginning on, at least one.
    """

    __repr__ = brief_repr

    setup: GripSetup
    course: PressureCourse
    frames: tuple[Frame, ...]

    @property
    def is_complete(self) -> bool:
        """Whether the whole course was computed."""
        return self.frames[-1].time >= self.course.duration

    @property
    def contact_fractions(self) -> tuple[float, ...]:
        """Part of the tube that touches the object, in each frame."""
        return tuple(contact_fraction(frame.state) for frame in self.frames)

    @property
    def time_to_touch(self) -> float | None:
        """When the tube first touches the object beyond its base [s]; None if it never does."""
        if self.contact_fractions[0] > 0.0:
            return self.frames[0].time
        events = (event for frame in self.frames for event in frame.events)
        return next((event.time for event in events if event.kind is EventKind.TOUCH), None)

    @property
    def time_to_wrap(self) -> float | None:
        """From when on 90 % of the final contact is there [s].

        None if the closing is not complete, or touches along less than half a turn in the end.
        """
        fractions, rod = self.contact_fractions, self.setup.gripper.tube
        turn = 2.0 * math.pi * (self.setup.obstacle.shape.feature_radius + rod.outer_radius)
        length = fractions[-1] * float(self.frames[-1].state.arc_lengths[-1])
        if not (self.is_complete and length >= LEAST_WRAP * turn):
            return None
        return self._since([c >= WRAPPED * fractions[-1] for c in fractions])

    @property
    def settling_time(self) -> float | None:
        """From when on the tube rests [s].

        The pressure and, to 90 %, the contact are then the final ones, and no node is faster than
        2 % of the length per second.
        """
        fractions, pressure = self.contact_fractions, self.course.pressures[-1]
        allowed = SETTLED * float(self.frames[0].state.arc_lengths[-1])
        rests = [
            bool(np.linalg.norm(frame.velocities, axis=1).max() <= allowed)
            and self.course.at(frame.time) == pressure
            and fraction >= WRAPPED * fractions[-1]
            for frame, fraction in zip(self.frames, fractions, strict=True)
        ]
        return self._since(rests)

    @property
    def point(self) -> GripPoint:
        """The grip at the end, where the tube may still move."""
        last = self.frames[-1]
        return GripPoint(self.course.at(last.time), self.setup, last.state)

    def grip_at_rest(self) -> GripPoint:
        """Return the grip once the tube rests, with the friction that the closing left.

        Raises:
            SolverError: it rests nowhere.
        """
        point = self.point
        path = follow_contact([self.setup.closing_problem(point.pressure)], start=point.state)
        last = path.states[-1] if path.states else path.events[-1].last
        if last.status is not RodStatus.CONVERGED:
            raise SolverError(last.status, last.residual, last.iterations)
        return GripPoint(point.pressure, self.setup, last)

    def holding_force(self, pull: Pull = Pull.AWAY) -> HoldingForce:
        """Return what then holds the object against being moved, slowly.

        Raises:
            SolverError: the closed tube rests nowhere.
        """
        return holding_force(self.grip_at_rest(), pull)

    def is_orderly(self) -> bool:
        """Return whether at least 90 % of the slow closing's contact is there in the end.

        If not, turns have met the object at wrong places or passed it, and what holds scatters, in
        a simulation as in experiments: see :func:`closing_spread`. A closing that is not complete,
        or whose slow one is not found, is not orderly.
        """
        if not self.is_complete:
            return False
        try:
            slow = slow_closing(self.setup, self.point.pressure)
        except SpiralError:
            return False
        return self.contact_fractions[-1] >= ORDERLY * contact_fraction(slow.state)

    def _since(self, good: list[bool]) -> float | None:
        """Return the time from which on every frame is good; None if the last one is not."""
        bad = [i for i, one in enumerate(good) if not one]
        first = bad[-1] + 1 if bad else 0
        return self.frames[first].time if first < len(good) else None


def closing_frames(
    setup: GripSetup,
    course: PressureCourse,
    *,
    damping: Damping | None = None,
    count: int = FRAMES,
    longest_step: float = DEFAULT_LONGEST_STEP,
) -> Iterator[Frame]:
    """Yield the frames of a gripper that closes on an object, as they are computed.

    The tube hangs at rest at first, at the course's first pressure, with the object in place.

    Args:
        setup: gripper, object, friction.
        course: the pressure in the tube.
        damping: None is that of a silicone tube in air.
        count: frames, even in time, at least two.
        longest_step: in time [s].

    Raises:
        InvalidInputError: the pressure leaves the gripper's range, or a value is not valid.
        NotGrippableError: the object lies in the way of the tube without pressure.
        SolverError: the hanging tube could not be certified.
    """
    require_in_range("pressures", max(course.pressures), 0.0, setup.gripper.pressure_max)
    require_in_range("count", count, 2, 100_000)
    if course.duration > LONGEST_COURSE:
        requirement = f"at most {LONGEST_COURSE:g} s; closing more slowly is slow_closing"
        raise InvalidInputError("course.duration", course.duration, requirement)

    posed = lru_cache(maxsize=1)(setup.closing_problem)

    def problem(time: float) -> RodProblem:
        return posed(course.at(time))

    return motion_frames(
        problem,
        inertia_of(setup.gripper),
        np.linspace(0.0, course.duration, count).tolist(),
        damping=damping,
        start=hanging_tube(setup),
        longest_step=longest_step,
    )


def close_on(
    setup: GripSetup,
    course: PressureCourse,
    *,
    damping: Damping | None = None,
    progress: Progress | None = None,
    longest_step: float = DEFAULT_LONGEST_STEP,
) -> TimedClosing:
    """Return a closing in time; see :func:`closing_frames`."""
    frames = []
    for frame in closing_frames(setup, course, damping=damping, longest_step=longest_step):
        frames.append(frame)
        if progress is not None:
            progress(len(frames), FRAMES)
    return TimedClosing(setup, course, tuple(frames))


@dataclass(frozen=True, slots=True)
class ClosingSpread:
    """Lowest and highest figure of a closing computed several times.

    NaN where one of the closings was not completed, or its tube was not seen to rest.

    Args:
        normal_force: sum of the normal forces on the object, at rest [N].
        contact_fraction: part of the tube that touches the object.
        holding_forces: against each pull [N].
    """

    normal_force: tuple[float, float]
    contact_fraction: tuple[float, float]
    holding_forces: Mapping[Pull, tuple[float, float]]


def closing_spread(
    closing: TimedClosing,
    *,
    damping: Damping | None = None,
    progress: Progress | None = None,
) -> ClosingSpread:
    """Return how far the figures of a closing scatter: what they are worth.

    It is computed again with the object 1e-9 of the tube's length farther along and back, and on
    1.5 times the elements in half the steps.

    Args:
        closing: a complete one.
        damping: that of the closing.
        progress: called with frames done and all.

    Raises:
        InvalidInputError: the closing is not complete.
    """
    if not closing.is_complete:
        raise InvalidInputError("closing", closing, "a complete one")
    setup = closing.setup
    x, y, z = (PERTURBED * setup.gripper.tube.length * setup.axis).tolist()
    along, back = (
        replace(setup, obstacle=setup.obstacle.moved(shift)) for shift in ((x, y, z), (-x, -y, -z))
    )
    finer = replace(setup, elements=math.ceil(FINER * setup.element_count))
    repeated = ((along, 1.0), (back, 1.0), (finer, 0.5))
    closings = [closing]
    for i, (other, step) in enumerate(repeated):

        def moved(frames: int, total: int, before: int = i) -> None:
            if progress is not None:
                progress(before * total + frames, len(repeated) * total)

        closings.append(
            close_on(
                other, closing.course, damping=damping, progress=moved,
                longest_step=step * DEFAULT_LONGEST_STEP,
            )
        )  # fmt: skip
    figures = np.array([_figures(one) for one in closings])
    low, high = figures.min(axis=0).tolist(), figures.max(axis=0).tolist()
    normal, contact, *held = zip(low, high, strict=True)
    return ClosingSpread(normal, contact, dict(zip(ALONG, held, strict=True)))


def _figures(closing: TimedClosing) -> list[float]:
    """Return normal force, part in contact and holding forces; NaN where they are not known."""
    try:
        if closing.is_complete:
            rest = closing.grip_at_rest()
            held = [holding_force(rest, pull).force for pull in ALONG]
            return [rest.normal_force, closing.contact_fractions[-1], *held]
    except SolverError:
        pass
    return [math.nan] * (2 + len(ALONG))


def slow_closing(setup: GripSetup, pressure: float) -> GripPoint:
    """Return the grip after closing so slowly that inertia does not matter.

    Raises:
        InvalidInputError: the closed gripper rests nowhere at this pressure.
        NotGrippableError: the object lies in the way of the tube without pressure.
        SolverError: the hanging tube could not be certified.
    """
    stations = [float(p) for p in np.linspace(0.0, pressure, SLOW_STATIONS + 1)[1:]]
    path = follow_contact([setup.closing_problem(p) for p in stations], start=hanging_tube(setup))
    if len(path.states) < len(stations):
        raise InvalidInputError("pressure", pressure, "one at which the closed gripper rests")
    return GripPoint(pressure, setup, path.states[-1])


@dataclass(frozen=True, slots=True, eq=False)
class RateAdvice:
    """The holding force after closing at several rates, compared with slow closing.

    Args:
        slow: holding force after closing slowly [N].
        rates: looked at, decreasing [Pa/s].
        forces: holding force after closing at each [N]; NaN where the closing was not completed,
            or the closed tube was not seen to rest.
        closings: at each.
        fastest: largest rate from which on downwards every one keeps 90 %; None if none does.
    """

    __repr__ = brief_repr

    slow: float
    rates: tuple[float, ...]
    forces: tuple[float, ...]
    closings: tuple[TimedClosing, ...]
    fastest: float | None


def advise_rate(
    setup: GripSetup,
    pressure: float,
    rates: Sequence[float],
    *,
    wait: float = 2.0,
    damping: Damping | None = None,
    progress: Progress | None = None,
) -> RateAdvice:
    """Return the fastest of some rates that keeps 90 % of the slowly closed grip.

    Args:
        setup: gripper, object, friction.
        pressure: to close to [Pa].
        rates: [Pa/s], any order.
        wait: at the pressure before the grip is judged [s].
        damping: None is that of a silicone tube in air.
        progress: called with frames done and all.
    """
    *_, advice = growing_advice(
        setup, pressure, rates, wait=wait, damping=damping, progress=progress
    )
    return advice


def growing_advice(
    setup: GripSetup,
    pressure: float,
    rates: Sequence[float],
    *,
    wait: float = 2.0,
    damping: Damping | None = None,
    progress: Progress | None = None,
) -> Iterator[RateAdvice]:
    """Yield :func:`advise_rate` of the slowest rate, the two slowest and so on, as they come."""
    rising = sorted(require_positive("rates", rate) for rate in rates)
    if not rising:
        raise InvalidInputError("rates", rates, "one or more rates")
    slow = holding_force(slow_closing(setup, pressure)).force
    done: list[tuple[float, float, TimedClosing]] = []
    fastest = None
    for i, rate in enumerate(rising):

        def moved(frames: int, total: int, before: int = i) -> None:
            if progress is not None:
                progress(before * total + frames, len(rising) * total)

        course = PressureCourse.ramp(rate, pressure, wait)
        closing = close_on(setup, course, damping=damping, progress=moved)
        done.insert(0, (rate, _held(closing), closing))
        if all(force >= KEEP * slow for _, force, _ in done):
            fastest = rate
        looked_at, forces, closings = zip(*done, strict=True)
        yield RateAdvice(slow, looked_at, forces, closings, fastest)


def _held(closing: TimedClosing) -> float:
    """Return what holds after a closing [N]; NaN where it, or the rest after it, is not known."""
    if not closing.is_complete:
        return math.nan
    try:
        return closing.holding_force().force
    except SolverError:
        return math.nan
