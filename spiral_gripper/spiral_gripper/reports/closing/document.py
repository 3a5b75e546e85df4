# SPDX-License-Identifier: Apache-2.0
"""A closing in real time as rows for people and as plain data for programs."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from spiral_core.errors import InvalidInputError, SolverError, SpiralError
from spiral_core.grip.closing import (
    BEYOND_WRAP,
    FRAMES,
    LONGEST_COURSE,
    ClosingSpread,
    PressureCourse,
    RateAdvice,
    TimedClosing,
    closing_frames,
    closing_spread,
    growing_advice,
    settling_after_move,
    slow_closing,
    vibrations,
)
from spiral_core.grip.holding import HoldingForce, Pull, holding_force
from spiral_core.grip.setup import lay_into_coil
from spiral_core.grip.window import GripPoint
from spiral_core.message import Message, Quantity
from spiral_core.rod.motion.inertia import Damping
from spiral_core.rod.motion.motion import Frame
from spiral_core.rounding import rounded_up
from spiral_core.wrap.gripper import Gripper
from spiral_gripper.files.shown import shown
from spiral_gripper.reports.fields import Field, Json, Progress, Rows, data
from spiral_gripper.reports.grip.rows import falls_by_choice

# Speed of an arm that stops before the approach [m/s].
MOVE = 0.25
# Pulls that are looked at, and what holds against them.
HELD = {Pull.AWAY: "holds away from the base", Pull.TOWARDS: "holds towards the base"}
# Rates that advice looks at, as times in which the pressure rises [s].
RISES = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)


@dataclass(frozen=True, slots=True)
class CloseQuestion:
    """What is asked of a gripper.

    Args:
        gripper: as it is mounted.
        radius: of a cylinder [m].
        rate: of the pressure [Pa/s].
        pressure: to close to [Pa]; None is a little beyond the perfect wrap.
        wait: at the pressure [s].
        friction: coefficient; None takes the gripper's or the default.
        damping: of the tube.
        advise: whether other rates are looked at too.
        spread: whether the closing is repeated although it is orderly.
    """

    gripper: Gripper
    radius: float
    rate: float
    pressure: float | None
    wait: float
    friction: float | None
    damping: Damping
    advise: bool
    spread: bool = False


@dataclass(frozen=True, slots=True)
class SolvedClose:
    """A question and its answer.

    Args:
        question: what was asked.
        pressure: closed to [Pa].
        closing: in time, as far as it was computed.
        forces: what holds then, for a complete closing; else empty.
        frequency: of the tube as it hangs, without pressure [Hz]; None if it is not known.
        settling: wait before it rests again after an arm's move [s]; None likewise.
        slow: what closing slowly ends with; None if it is not known.
        spread: of the figures over repeated closings; None if the closing is orderly and none was
            asked for, or it is not complete.
        advice: on the rate, where it was asked for; of the slowest rates after an interrupt.
        interrupted: whether something that was asked for was not computed.
    """

    question: CloseQuestion
    pressure: float
    closing: TimedClosing
    forces: tuple[HoldingForce, ...]
    frequency: float | None
    settling: float | None
    slow: GripPoint | None
    spread: ClosingSpread | None
    advice: RateAdvice | None
    interrupted: bool

    @property
    def orderly(self) -> bool:
        """Whether the closing is complete and ends like the slow one."""
        return self.closing.is_orderly(self.slow)

    @property
    def wraps_slowly(self) -> bool | None:
        """Whether the object is wrapped after closing slowly; None if that is not known."""
        return None if self.slow is None else self.slow.is_wrapped

    @property
    def complete(self) -> bool:
        """Whether all that was asked for was computed."""
        return self.closing.is_complete and not self.interrupted


def solve_close(question: CloseQuestion, progress: Progress | None = None) -> SolvedClose:
    """Return how a gripper closes; after an interrupt what was computed until then.

    Raises:
        InvalidInputError: a value is out of its range.
        NotGrippableError: no pressure coils the gripper to this radius.
    """
    setup = lay_into_coil(question.gripper, question.radius, friction=question.friction)
    pressure = question.pressure
    if pressure is None:
        wrapped = setup.tip_pressure or question.gripper.pressure_max
        pressure = min(BEYOND_WRAP * wrapped, question.gripper.pressure_max)
    slowest = pressure / max(LONGEST_COURSE - question.wait, 1.0)
    if not question.rate >= slowest:
        least = Quantity(slowest, "Pa/s", rounded_up)
        requirement = Message("at least {}; the grip of slower closings: grip", least)
        raise InvalidInputError("rate", question.rate, requirement, "Pa/s")
    course = PressureCourse.ramp(question.rate, pressure, question.wait)
    frames: list[Frame] = []
    forces: tuple[HoldingForce, ...] = ()
    spread: ClosingSpread | None = None
    advice: RateAdvice | None = None
    slow: GripPoint | None = None
    interrupted = False
    try:
        for frame in closing_frames(setup, course, damping=question.damping):
            frames.append(frame)
            if progress is not None:
                progress(len(frames), FRAMES)
        closing = TimedClosing(setup, course, tuple(frames))
        if closing.is_complete:
            forces = _forces(closing)
            with suppress(SpiralError):
                slow = slow_closing(setup, pressure)
        if closing.is_complete and (question.spread or not closing.is_orderly(slow)):
            spread = closing_spread(closing, damping=question.damping, progress=progress)
        if closing.is_complete and question.advise:
            rates = [pressure / rise for rise in RISES]
            for so_far in growing_advice(
                setup, pressure, rates, wait=question.wait, damping=question.damping,
                progress=progress,
            ):  # fmt: skip
                advice = so_far
    except KeyboardInterrupt:
        if not frames:
            raise
        interrupted = True
    frequency = settling = None
    with suppress(InvalidInputError, SolverError):  # free to turn, or not known
        settling = settling_after_move(question.gripper, 0.0, MOVE, damping=question.damping)
        (frequency,) = vibrations(question.gripper, 0.0, 1).frequencies.tolist()
    closing = TimedClosing(setup, course, tuple(frames))
    return SolvedClose(
        question, pressure, closing, forces, frequency, settling, slow, spread, advice,
        interrupted,
    )  # fmt: skip


def _forces(closing: TimedClosing) -> tuple[HoldingForce, ...]:
    """Return what holds after a closing, both ways; nothing if the tube was not seen to rest."""
    try:
        settled = closing.grip_at_rest()
    except SolverError:
        return ()
    return tuple(holding_force(settled, pull) for pull in HELD)


def _ended(solved: SolvedClose) -> Rows:
    """Return a row that says that something is missing; none where nothing is."""
    closing = solved.closing
    if not closing.is_complete:
        computed = f"{closing.frames[-1].time:.2f} s of {closing.course.duration:.2f} s"
        return [("NOT COMPLETE", f"computed {computed}")]
    return [("INTERRUPTED", "what was not computed is missing below")] if solved.interrupted else []


def _presses(solved: SolvedClose) -> str:
    # friction keeps what the closing left: up to 3 % of the normal force between two orderly ones
    force, spread = solved.closing.point.normal_force, solved.spread
    if spread is None:
        return shown(force, "N", 2)
    return _with_spread(force, spread.normal_force, _newtons)


def _held(solved: SolvedClose) -> Rows:
    """Return what holds both ways, with its spread where that is known."""
    known = {} if solved.spread is None else solved.spread.holding_forces
    rows = [
        (HELD[one.pull], _with_spread(one.force, known.get(one.pull), _newtons))
        for one in solved.forces
    ]
    if solved.spread is not None:
        more = solved.wraps_slowly and not solved.orderly
        why = "; a slow closing touches far more, so this one scatters" if more else ""
        rows.append(("in brackets", f"lowest and highest of four like closings{why}"))
    if solved.complete and not solved.forces:
        rows.append(("holds", "not known: the closed tube was not seen to rest"))
    return rows


def _advised(solved: SolvedClose) -> Rows:
    advice = solved.advice
    if advice is None:
        return []
    pairs = zip(advice.rates, advice.forces, strict=True)
    none = "none of these" if advice.rates else "no advice: closed slowly it is not wrapped or held"
    fastest = none if advice.fastest is None else shown(advice.fastest, "Pa/s")
    return [
        ("closed slowly it holds", _newtons(advice.slow)),
        *((f"  at {shown(rate, 'Pa/s')}", _newtons(force)) for rate, force in pairs),
        ("fastest that keeps 90 %", fastest),
    ]


def _advice(solved: SolvedClose) -> Json | None:
    advice = solved.advice
    if advice is None:
        return None
    return {
        "slow_holding_force": advice.slow,
        "rates": advice.rates,
        "holding_forces": advice.forces,
        "fastest_rate": advice.fastest,
    }


def _spread(solved: SolvedClose) -> Json | None:
    """Return lowest and highest figures; None where they are not known."""

    def known(bounds: tuple[float, float]) -> tuple[float, float] | None:
        return None if math.isnan(bounds[0]) else bounds

    spread = solved.spread
    if spread is None:
        return None
    return {
        "normal_force": known(spread.normal_force),
        "contact_fraction": known(spread.contact_fraction),
        "holding_forces": {p.name.lower(): known(b) for p, b in spread.holding_forces.items()},
    }


def _frames(solved: SolvedClose) -> list[Json]:
    closing = solved.closing
    return [
        {
            "time": frame.time,
            "pressure": closing.course.at(frame.time),
            "contact_fraction": fraction,
            "tip": frame.state.tip_position,
        }
        for frame, fraction in zip(closing.frames, closing.contact_fractions, strict=True)
    ]


def _between(solved: SolvedClose) -> float:
    """Return the time between two frames [s]."""
    return solved.closing.course.duration / (FRAMES - 1)


def _with_spread(
    value: float, bounds: tuple[float, float] | None, text: Callable[[float], str]
) -> str:
    """Return a figure and, where it is known, its range as text."""
    if bounds is None:
        return text(value)
    if math.isnan(bounds[0]):
        return f"{text(value)} (scatters: not every repeated closing was completed)"
    return f"{text(value)} ({text(bounds[0])} to {text(bounds[1])})"


def _newtons(force: float) -> str:
    return "not known" if math.isnan(force) else shown(force, "N", 3)


def _slowly(solved: SolvedClose) -> str | None:
    """Return that a slow closing wraps nothing at this pressure either; None if it does."""
    if not solved.complete or solved.wraps_slowly:
        return None
    if solved.slow is None:
        return "not seen to rest at this pressure"
    return "not wrapped at this pressure: it is too low, or too high"


def _seconds(time: float | None, within: float = 0.0, never: str = "not within this time") -> str:
    """Return a time that is known to ``within`` [s] as text."""
    if time is None:
        return never
    digits = 2 if within < 0.05 else 1 if within < 0.5 else 0
    return f"{time:.{digits}f} s"


CLOSE = (
    *data(gripper="question.gripper.name", object_radius="question.radius", rate="question.rate"),
    Field("pressure", "pressure", "pressure", lambda s: f"to {shown(s.pressure, 'Pa')}"),
    Field("friction", "friction coefficient", "closing.setup.obstacle.friction", "{:.3g}"),
    falls_by_choice("closing.setup"),
    Field("complete", "", "complete", _ended),
    Field("time_to_touch", "touches after", "closing.time_to_touch", lambda s: (
        _seconds(s.closing.time_to_touch)
    )),
    Field("time_to_wrap", "wrapped after", "closing.time_to_wrap", lambda s: (
        _seconds(s.closing.time_to_wrap, _between(s), "not wrapped")
    )),
    Field("settling_time", "at rest after", "closing.settling_time", lambda s: (
        _seconds(s.closing.settling_time, _between(s))
    )),
    Field("contact_fraction", "in contact", lambda s: s.closing.contact_fractions[-1], lambda s: (
        _with_spread(s.closing.contact_fractions[-1], s.spread and s.spread.contact_fraction,
                     lambda share: f"{100.0 * share:.0f} %")
    )),
    Field("turns", "turns", "closing.point.turns", "{:.2f}"),
    Field("normal_force", "presses with", "closing.point.normal_force", _presses),
    Field("holding_forces", "", lambda s: {o.pull.name.lower(): o.force for o in s.forces}, _held),
    *data(orderly="orderly", spread=_spread),
    Field("wraps_slowly", "closed slowly", "wraps_slowly", _slowly),
    Field("advice", "", _advice, _advised),
    Field("hanging_frequency", "hanging tube swings at", "frequency", lambda s: (
        "not known" if s.frequency is None else f"{s.frequency:.3g} Hz"
    )),
    Field("hanging_settling_time", lambda _: f"  rests after a stop from {shown(MOVE, 'm/s', 3)}",
          "settling", lambda s: "not known" if s.settling is None else (
        f"{s.settling:.1f} s" if math.isfinite(s.settling) else "never: nothing damps it"
    )),
    Field("frames", "", _frames),
)  # fmt: skip
