# SPDX-License-Identifier: Apache-2.0
"""Closing on an object at a pressure rate: contact over time, and the holding force at the end."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from numbers import Real

import numpy as np

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.actuator.fibers import FiberAngles, fiber_state
from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError, SolverError, SpiralError
from spiral_core.grip.holding import ROUNDING, HoldingForce, Pull, holding_force
from spiral_core.grip.setup import FREE_ELEMENTS, GripSetup, free_problem, hanging_tube
from spiral_core.grip.window import GripPoint
from spiral_core.message import Message, Quantity
from spiral_core.numerics.tasks import Progress
from spiral_core.rod.contact.problem import RodProblem
from spiral_core.rod.contact.solve import follow_contact, solve_contact
from spiral_core.rod.motion.frequencies import Modes, vibration_modes
from spiral_core.rod.motion.inertia import Damping, Inertia
from spiral_core.rod.motion.motion import EventKind, Frame, contact_fraction
from spiral_core.rod.motion.solve import DEFAULT_LONGEST_STEP, motion_frames
from spiral_core.rod.state import RodState, RodStatus
from spiral_core.rod.types import Array
from spiral_core.validation import (
    require_all,
    require_finite,
    require_in_range,
    require_kind,
    require_non_negative,
    require_positive,
)
from spiral_core.wrap.gripper import STANDARD_GRAVITY, Gripper


@dataclass(frozen=True, slots=True)
class PressureCourse:
    """Gauge pressure against time, linear between points.

    Args:
        times: increasing, from 0 [s].
        pressures: at these times, >= 0 [Pa].

    Raises:
        InvalidInputError: times and pressures do not match, or are out of their range.

    Example:
        >>> course = PressureCourse.ramp(rate=2e4, pressure=6e4, wait=1.0)
        >>> course.at(1.5), course.duration
        (30000.0, 4.0)
    """

    __repr__ = brief_repr

    times: tuple[float, ...]
    pressures: tuple[float, ...]

    def __post_init__(self) -> None:
        for field in ("times", "pressures"):
            require_all(field, getattr(self, field), (Real,), "numbers")
        times = [require_finite("times", time) for time in self.times]
        increasing = all(b > a for a, b in pairwise(times))
        if len(times) < 2 or times[0] != 0.0 or not increasing:
            raise InvalidInputError("times", self.times, "two or more increasing times from 0")
        if len(self.pressures) != len(times):
            raise InvalidInputError("pressures", self.pressures, "as many as times", "Pa")
        for pressure in self.pressures:
            require_non_negative("pressures", pressure)

    @property
    def duration(self) -> float:
        """The last time [s]."""
        return float(self.times[-1])

    def at(self, time: float) -> float:
        """Return the pressure at a time [s]; the ends' before and after them."""
        return float(np.interp(time, self.times, self.pressures))

    @classmethod
    def ramp(cls, rate: float, pressure: float, wait: float) -> PressureCourse:
        """Return a rise at a rate [Pa/s] to a pressure [Pa] that then stays for a while [s]."""
        end = require_positive("pressure", pressure) / require_positive("rate", rate)
        return cls((0.0, end, end + require_positive("wait", wait)), (0.0, pressure, pressure))


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


def inertia_of(gripper: Gripper, length: float | None = None) -> Inertia:
    """Return the inertia of a gripper's tube with all that is wound on it.

    Args:
        gripper: whose mass stays when it stretches.
        length: of the backbone [m]; None: unstretched.

    Raises:
        InvalidInputError: its weight is not known (zero).
    """
    mass = require_positive("weight_per_length", gripper.weight_per_length) / STANDARD_GRAVITY
    tube = gripper.tube
    mass *= tube.length / (length or tube.length)
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

    def is_orderly(self, slow: GripPoint | None) -> bool:
        """Return whether at least 90 % of the slow closing's contact is there in the end.

        If not, turns have met the object at wrong places or passed it, and what holds scatters, in
        a simulation as in experiments: see :func:`closing_spread`. A closing that is not complete,
        or whose slow one is not known, is not orderly.

        Args:
            slow: what :func:`slow_closing` to the same pressure ends with; None if it is not known.
        """
        if slow is None or not self.is_complete:
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
    longest_step: float = DEFAULT_LONGEST_STEP,
) -> Iterator[Frame]:
    """Yield 120 frames, even in time, of a gripper that closes on an object, as they are computed.

    The tube hangs at rest at first, at the course's first pressure, with the object in place.

    Args:
        setup: gripper, object, friction.
        course: the pressure in the tube.
        damping: None is that of a silicone tube in air.
        longest_step: in time [s].

    Raises:
        InvalidInputError: the pressure leaves the gripper's range, or a value is not valid.
        NotGrippableError: the object lies in the way of the tube without pressure.
        SolverError: the hanging tube could not be certified.
    """
    require_in_range("pressures", max(course.pressures), 0.0, setup.gripper.pressure_max, "Pa")
    if course.duration > LONGEST_COURSE:
        most = Quantity(LONGEST_COURSE, "s")
        requirement = Message("at most {}; closing more slowly is slow_closing", most)
        raise InvalidInputError("course.duration", course.duration, requirement, "s")

    posed, first = lru_cache(maxsize=1)(setup.closing_problem), course.pressures[0]

    def problem(time: float) -> RodProblem:
        return posed(course.at(time))

    return motion_frames(
        problem,
        inertia_of(setup.gripper),
        np.linspace(0.0, course.duration, FRAMES).tolist(),
        damping=damping,
        start=slow_closing(setup, first).state if first > 0.0 else hanging_tube(setup),
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
        normal_force: sum of the normal forces on the object, in the end [N].
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
    shift = np.array((PERTURBED * setup.gripper.tube.length, 0.0, 0.0, 0.0, 0.0))
    along, back = setup.moved(shift), setup.moved(-shift)
    finer = replace(setup, elements=math.ceil(FINER * setup.element_count))
    repeated = ((along, 1.0), (back, 1.0), (finer, 0.5))
    closings = [closing]
    for i, (other, step) in enumerate(repeated):
        closings.append(
            close_on(
                other,
                closing.course,
                damping=damping,
                progress=_part(progress, i, len(repeated)),
                longest_step=step * DEFAULT_LONGEST_STEP,
            )
        )
    figures = np.array([_figures(one) for one in closings])
    low, high = figures.min(axis=0).tolist(), figures.max(axis=0).tolist()
    normal, contact, *held = zip(low, high, strict=True)
    return ClosingSpread(normal, contact, dict(zip(ALONG, held, strict=True)))


def _part(progress: Progress | None, number: int, count: int) -> Progress:
    """Return the progress of one of several closings, from that of all."""

    def part(frames: int, total: int) -> None:
        if progress is not None:
            progress(number * total + frames, count * total)

    return part


def _figures(closing: TimedClosing) -> list[float]:
    """Return normal force, part in contact and holding forces; NaN where they are not known."""
    try:
        if closing.is_complete:
            rest = closing.grip_at_rest()
            held = [holding_force(rest, pull).force for pull in ALONG]
            return [closing.point.normal_force, closing.contact_fractions[-1], *held]
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
    rests = len(path.states) == len(stations) and path.states[-1].stable
    if not rests:
        requirement = "one at which the closed gripper rests"
        raise InvalidInputError("pressure", pressure, requirement, "Pa")
    return GripPoint(pressure, setup, path.states[-1])


@dataclass(frozen=True, slots=True, eq=False)
class RateAdvice:
    """The holding force after closing at several rates, compared with slow closing.

    Args:
        slow: holding force after closing slowly [N]; NaN where it is not known.
        rates: looked at, decreasing [Pa/s]; none where the object is then not wrapped or held.
        forces: holding force after closing at each [N]; NaN where the closing was not completed,
            or the closed tube was not seen to rest.
        fastest: largest rate from which on downwards every one keeps 90 %; None if none does.
    """

    __repr__ = brief_repr

    slow: float
    rates: tuple[float, ...]
    forces: tuple[float, ...]
    fastest: float | None


def growing_advice(
    setup: GripSetup,
    pressure: float,
    rates: Sequence[float],
    *,
    wait: float = 2.0,
    damping: Damping | None = None,
    progress: Progress | None = None,
) -> Iterator[RateAdvice]:
    """Yield the fastest of some rates that keeps 90 % of the slowly closed grip, rate by rate.

    First of the slowest rate alone, then of the two slowest and so on, as they are computed. Of no
    rate where an object is not wrapped or held even after closing slowly.

    Args:
        setup: gripper, object, friction.
        pressure: to close to [Pa].
        rates: [Pa/s], any order.
        wait: at the pressure before the grip is judged [s].
        damping: None is that of a silicone tube in air.
        progress: called with frames done and all.

    Raises:
        InvalidInputError: a value is out of its range.
    """
    rising = sorted(require_positive("rates", rate) for rate in rates)
    if not rising:
        raise InvalidInputError("rates", rates, "one or more rates")
    require_in_range("pressure", pressure, 0.0, setup.gripper.pressure_max, "Pa")
    slow, wrapped = math.nan, False
    with suppress(SpiralError):  # it is not seen to rest
        closed = slow_closing(setup, pressure)
        slow, wrapped = holding_force(closed).force, closed.is_wrapped
    if not (wrapped and slow > ROUNDING):
        yield RateAdvice(slow, (), (), None)
        return
    done: list[tuple[float, float]] = []
    fastest = None
    for i, rate in enumerate(rising):
        course, part = PressureCourse.ramp(rate, pressure, wait), _part(progress, i, len(rising))
        closing = close_on(setup, course, damping=damping, progress=part)
        done.insert(0, (rate, _held(closing)))
        if all(force >= KEEP * slow for _, force in done):
            fastest = rate
        looked_at, forces = zip(*done, strict=True)
        yield RateAdvice(slow, looked_at, forces, fastest)


def _held(closing: TimedClosing) -> float:
    """Return what holds after a closing [N]; NaN where it, or the rest after it, is not known."""
    if not closing.is_complete:
        return math.nan
    try:
        return closing.holding_force().force
    except SolverError:
        return math.nan


# Modes that are looked at: both planes of the three slowest vibrations.
MODES = 6
# Pressures on a ramp between which the tube's velocities are taken.
STATIONS = 5
TINY = 1e-300


def vibrations(gripper: Gripper, pressure: float, count: int = MODES) -> Modes:
    """Return the slowest vibrations of a free gripper at a pressure [Pa].

    Raises:
        InvalidInputError: the pressure is out of range, the weight not known, or the tube, next to
            upright, free to turn.
        SolverError: the tube has no certified shape there.
    """
    return _modes(gripper, _free(gripper, pressure), count)[1]


def settling_after_ramp(
    gripper: Gripper,
    pressure: float,
    rate: float,
    *,
    grip: GripPoint | None = None,
    damping: Damping | None = None,
) -> float:
    """Return how long a tube swings on after its pressure has risen from zero at a rate.

    The swing is as large as the fastest quarter of the ramp leaves it.

    Args:
        gripper: as it is mounted.
        pressure: where the ramp ends [Pa].
        rate: of the ramp [Pa/s], > 0.
        grip: at this pressure, on an object; None is the free tube.
        damping: None is that of a silicone tube in air.

    Returns:
        Until no node is faster than 2 % of the length per second [s]; 0 where none is; infinite
        where nothing damps it.

    Raises:
        InvalidInputError: a value is out of range, the weight not known, or the tube, next to
            upright, free to turn.
        SolverError: the tube has no certified shape at this pressure.
    """
    require_positive("rate", rate)
    require_in_range("pressure", pressure, 0.0, gripper.pressure_max, "Pa")
    count = FREE_ELEMENTS if grip is None else len(grip.state.positions) - 1
    states = [_free(gripper, 0.0, count)]
    for station in np.linspace(0.0, pressure, STATIONS)[1:]:
        states.append(_free(gripper, float(station), count, states[-1]))
    positions = np.array([state.positions for state in states])
    # a ramp from 0 to 0 has no parts that move
    parts = np.diff(positions, axis=0) * (rate * (STATIONS - 1) / max(pressure, TINY))
    closed = states[-1] if grip is None else grip.state
    return _settled(gripper, closed, parts, math.inf, damping)


def settling_after_move(
    gripper: Gripper, pressure: float, speed: float, *, damping: Damping | None = None
) -> float:
    """Return how long a tube swings on after its base has stopped from a speed.

    Args:
        gripper: as it is mounted.
        pressure: in the tube [Pa].
        speed: of the base before it stopped at once [m/s], >= 0, in whatever direction makes it
            longest.
        damping: None is that of a silicone tube in air.

    Returns:
        As :func:`settling_after_ramp`.

    Raises:
        InvalidInputError: a value is out of range, the weight not known, or the tube, next to
            upright, free to turn.
        SolverError: the tube has no certified shape at this pressure.
    """
    require_non_negative("speed", speed)
    state = _free(gripper, pressure)
    velocities = speed * np.repeat(np.eye(3)[:, None, :], len(state.positions), axis=1)
    return _settled(gripper, state, velocities, 2.0, damping)


def _free(
    gripper: Gripper,
    pressure: float,
    elements: int = FREE_ELEMENTS,
    start: RodState | None = None,
) -> RodState:
    """Return the tube's state at a pressure, without an object."""
    return solve_contact(free_problem(gripper, pressure), elements=elements, start=start)


def _modes(gripper: Gripper, state: RodState, count: int) -> tuple[Inertia, Modes]:
    """Return inertia and slowest vibrations of a gripper's tube about a state."""
    inertia = inertia_of(gripper, state.arc_lengths[-1])
    try:
        return inertia, vibration_modes(state, inertia, count)
    except InvalidInputError as error:
        if error.field != "state":
            raise
        requirement = "one that holds the tube on one side: next to upright it turns freely"
        raise InvalidInputError("gravity", gripper.gravity, requirement, "m/s^2") from error


def _settled(
    gripper: Gripper, state: RodState, velocities: Array, order: float, damping: Damping | None
) -> float:
    """Return the longest time of all modes.

    Args:
        gripper: as it is mounted.
        state: about which it swings.
        velocities: that it may have (k, n, 3) [m/s].
        order: of the norm over them: 2 where they may add up, infinite where they do not.
        damping: of the tube.
    """
    inertia, modes = _modes(gripper, state, MODES)
    weights = inertia.mass * state.node_lengths[:, None]
    slow = SETTLED * float(state.arc_lengths[-1])
    longest = 0.0
    for shape, swing in zip(modes.shapes, modes.swings, strict=True):
        omega = 2.0 * math.pi * swing.frequency
        parts = np.sum(weights * shape * velocities, axis=(1, 2))
        speed = float(np.linalg.norm(parts, order) / np.sum(weights * shape * shape))
        if speed > slow:
            time = swing.settling_time(damping or Damping(), speed / omega, slow / omega)
            longest = max(longest, time)
    return longest


# Reference conditions of ISO 6358 (ISO 8778): 100 kPa, 20 degC, 65 % humidity.
REFERENCE_PRESSURE, REFERENCE_DENSITY = 1e5, 1.185
ATMOSPHERE = 101_325.0
# Pressures in between at which the flow is looked at.
SAMPLES = 400

Volume = Callable[[float], float]


@dataclass(frozen=True, slots=True)
class Orifice:
    """A valve, a fitting or a line in the terms of ISO 6358.

    Args:
        conductance: sonic conductance C [m^3/(s Pa)], > 0; data sheets give dm^3/(s bar),
            1 dm^3/(s bar) = 1e-8 m^3/(s Pa).
        critical_ratio: b, from 0 to below 1; 0.2 to 0.5 for valves.

    Raises:
        InvalidInputError: a value is out of its range.

    Example:
        Choked from 300 kPa into the atmosphere, in grams per second:

        >>> round(1e3 * Orifice(1e-9).mass_flow(3e5, 101325.0), 3)
        0.355
    """

    conductance: float
    critical_ratio: float = 0.3

    def __post_init__(self) -> None:
        require_positive("conductance", self.conductance)
        if not require_in_range("critical_ratio", self.critical_ratio, 0.0, 1.0) < 1.0:
            raise InvalidInputError("critical_ratio", self.critical_ratio, "below 1")

    def mass_flow(self, upstream: float, downstream: float) -> float:
        """Return the mass flow [kg/s] between two absolute pressures [Pa]; negative backwards."""
        high, low = (
            require_positive("upstream", upstream),
            require_positive("downstream", downstream),
        )
        sign = 1.0
        if low > high:
            high, low, sign = low, high, -1.0
        over = max(0.0, (low / high - self.critical_ratio) / (1.0 - self.critical_ratio))
        share = math.sqrt(max(0.0, 1.0 - over * over))
        return sign * self.conductance * REFERENCE_DENSITY * high * share


def orifices_in_series(first: Orifice, second: Orifice) -> Orifice:
    r"""Return one orifice for two after each other, :math:`C^{-3} = C_1^{-3} + C_2^{-3}`.

    The approximation of ISO 6358-3's users for lines of components; b is the mean of both, weighted
    with the third powers of their resistance.

    Example:
        >>> round(orifices_in_series(Orifice(1e-9), Orifice(1e-9)).conductance * 1e9, 3)
        0.794
    """
    a, b = first.conductance**-3, second.conductance**-3
    ratio = (a * first.critical_ratio + b * second.critical_ratio) / (a + b)
    return Orifice((a + b) ** (-1.0 / 3.0), ratio)


@dataclass(frozen=True, slots=True)
class Supply:
    """What an actuator is filled from and vented to, through one orifice.

    Args:
        orifice: of regulator and line together.
        pressure: gauge pressure of the supply [Pa], > 0.
        dead_volume: of the line and fittings behind the valve [m^3], >= 0.

    Raises:
        InvalidInputError: a value is of another kind or out of its range.
    """

    orifice: Orifice
    pressure: float
    dead_volume: float = 0.0

    def __post_init__(self) -> None:
        require_kind("orifice", self.orifice, Orifice)
        require_positive("pressure", self.pressure)
        require_non_negative("dead_volume", self.dead_volume)

    def time_to_fill(self, volume: Volume, start: float, end: float) -> float:
        """Return the time [s] in which the fully open valve takes the pressure up, or down.

        Args:
            volume: enclosed volume [m^3] of the actuator at a gauge pressure [Pa].
            start: gauge pressure [Pa].
            end: gauge pressure [Pa]; below ``start`` the tube is vented to the atmosphere.

        Returns:
            Infinite where the supply's pressure, or the atmosphere's, stops short of ``end``.
        """
        first = require_non_negative("start", start)
        last = require_non_negative("end", end)
        if first == last:
            return 0.0
        # Denser towards the end, where the flow may die.
        share = 1.0 - (1.0 - np.linspace(0.0, 1.0, SAMPLES)) ** 2
        pressures: Array = first + (last - first) * share
        inverse = np.empty(SAMPLES)
        for i, pressure in enumerate(pressures):
            rate = self.rates(volume, float(pressure), max(first, last))[0 if last >= first else 1]
            inverse[i] = 1.0 / rate if rate > 0.0 else math.inf
        if not np.all(np.isfinite(inverse[:-1])):
            return math.inf
        # At an end where the flow dies as a root, the mean of the inverse is twice the last known.
        if not math.isfinite(inverse[-1]):
            inverse[-1] = 3.0 * inverse[-2]
        steps = 0.5 * (inverse[1:] + inverse[:-1]) * np.abs(np.diff(pressures))
        return float(np.sum(steps))

    def rates(self, volume: Volume, pressure: float, top: float = math.inf) -> tuple[float, float]:
        """Return how fast a gauge pressure rises and falls with the valve fully open [Pa/s].

        The volume is asked for up to a pressure ``top`` [Pa].
        """
        step = max(10.0, 1e-4 * pressure)
        low, high = max(0.0, pressure - step), min(pressure + step, top)
        stored = [
            (gauge + ATMOSPHERE) * (require_positive("volume", volume(gauge)) + self.dead_volume)
            for gauge in (low, high)
        ]
        slope = require_positive("volume", (stored[1] - stored[0]) / (high - low))
        slope *= REFERENCE_DENSITY / REFERENCE_PRESSURE  # d(mass)/d(pressure) [kg/Pa]
        inside = pressure + ATMOSPHERE
        fill = self.orifice.mass_flow(self.pressure + ATMOSPHERE, inside)
        vent = self.orifice.mass_flow(inside, ATMOSPHERE)
        return fill / slope, vent / slope
