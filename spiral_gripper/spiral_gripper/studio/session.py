# SPDX-License-Identifier: Apache-2.0
"""The studio's computations: shapes at once, other answers in the background."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from spiral_core import (
    Grip,
    Gripper,
    PressureCourse,
    Profile,
    RodState,
    SpiralError,
    Wrap,
    WrapCurve,
    WrapRegime,
    close_on,
    grip_window,
    lay_into_coil,
    regime_chart,
    solve_grip,
    solve_rod,
)
from spiral_core.grip.closing import BEYOND_WRAP, TimedClosing
from spiral_core.grip.window import GripPoint, GripWindow
from spiral_core.rod.types import Array
from spiral_core.wrap.placement import ObjectPlacement, place_object
from spiral_gripper.files.description import GripperDescription
from spiral_gripper.studio.settings import DEFAULT_RATE, Settings, cone_ends, gripper_for

# At the pressure to which a gripper closes in real time [s].
WAIT = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """Results that take longer than a frame: the range of radii, and the wrap of one object.

    Args:
        settings: what it answers, whatever the pressure.
        curve: the gripper's wraps; None where it makes no coil.
        radii, pressures: (n,) the chart: rising radii [m] and the pressure that wraps each [Pa],
            NaN in a gap; empty where nothing is wrapped.
        wrap: the perfect wrap of the object; None where there is none.
        placement: where the object then lies.
        window: the shapes in contact, and the pressures that hold the object; None where that is
            not known yet, or not so.
        grip: what it holds at them; likewise.
        refusal: why there is no wrap, or the object is not held, where that is known.
    """

    settings: Settings
    curve: WrapCurve | None = None
    radii: Array = field(default_factory=lambda: np.empty(0))
    pressures: Array = field(default_factory=lambda: np.empty(0))
    wrap: Wrap | None = None
    placement: ObjectPlacement | None = None
    window: GripWindow | None = None
    grip: Grip | None = None
    refusal: str = ""

    @property
    def is_complete(self) -> bool:
        """Whether nothing more is being computed."""
        return self.grip is not None or self.refusal != ""

    def contact_at(self, pressure: float) -> GripPoint | None:
        """Return the solved contact next to a pressure [Pa]; None where there is none."""
        if self.window is None or not 0.0 <= pressure <= self.window.top:
            return None
        # Half-way between two, as the wrap's own pressure is, rounding must not choose.
        return min(self.window.points, key=lambda point: abs(point.pressure - 1.000001 * pressure))

    def object_place(self) -> ObjectPlacement | None:
        """Return where the object lies: where contact was solved with it, once it was."""
        if self.window is None or self.placement is None:
            return self.placement
        setup = self.window.setup
        x, y, z = setup.axis.tolist()
        return replace(self.placement, center=setup.obstacle.position, axis=(x, y, z))

    def regime(self, pressure: float) -> WrapRegime | None:
        """Return how a pressure [Pa] holds the object; None where it is not grippable."""
        if self.curve is None or self.wrap is None:
            return None
        return self.curve.regime(pressure, self.settings.object_radius)


class _StaleError(Exception):
    """The result being computed is no longer needed."""


class Session:
    """One gripper under the controls' settings.

    The shape at a pressure follows within a frame. Answers are computed by one thread in the
    background, the newest settings first.

    Args:
        description: the gripper's file.
        settings: to start with.
        on_answer: called with each answer, from the background thread.
    """

    def __init__(
        self,
        description: GripperDescription,
        settings: Settings,
        on_answer: Callable[[Answer], None],
    ) -> None:
        self.description = description
        self.settings = settings
        self.gripper = gripper_for(description, settings)
        self.answer: Answer | None = None
        self._on_answer = on_answer
        self._closed = False
        self._state: RodState | None = None
        self._background = ThreadPoolExecutor(1, thread_name_prefix="studio")
        self._pending: Future[None] | None = None
        self._asked_since = 0.0
        self._closing: tuple[Settings | None, TimedClosing | None] = None, None
        self._ask()

    def update(self, settings: Settings) -> None:
        """Take new settings; where they cannot be, the old ones stay.

        Raises:
            SpiralError: there is no such gripper; says why.
        """
        if _asked_of(settings) != _asked_of(self.settings):
            self.gripper = gripper_for(self.description, settings)
            self._state = None
            self.settings = settings
            self._ask()
        most = self.gripper.pressure_max
        self.settings = replace(settings, pressure=min(settings.pressure, most))

    def shape(self) -> RodState:
        """Return the free shape at the pressure that is set, certified.

        Raises:
            SolverError: no stable shape was found.
        """
        shape = self.gripper.unloaded_shape(self.settings.pressure)
        rod, load = self.gripper.rod(shape), self.gripper.load(shape)
        self._state = solve_rod(rod, load, start=self._state, estimate_error=False)
        return self._state

    def contact(self) -> GripPoint | None:
        """Return the solved contact next to the pressure that is set, where one is known."""
        known = self.known  # asked once: the background may give another answer in between
        return None if known is None else known.contact_at(self.settings.pressure)

    def shown(self) -> RodState:
        """Return the shape to show: in contact where that is known, else the free coil."""
        point = self.contact()
        return self.shape() if point is None else point.state

    @property
    def known(self) -> Answer | None:
        """The answer to the settings, whatever the pressure; None where there is none yet."""
        answer = self.answer
        same = answer is not None and answer.settings == _asked_of(self.settings)
        return answer if same else None

    @property
    def waited(self) -> float | None:
        """Time since the settings were asked about [s]; None where everything is answered."""
        known = self.known
        complete = known is not None and known.is_complete
        return None if complete else time.monotonic() - self._asked_since

    @property
    def closing(self) -> TimedClosing | None:
        """The closing in real time of the settings, whatever the pressure, if it was computed."""
        settings, closing = self._closing
        return closing if settings == replace(self.settings, pressure=0.0) else None

    def close_in_time(self, progress: Callable[[int, int], None]) -> TimedClosing | None:
        """Return the closing of the gripper on its object; None without contact yet.

        The pressure rises at the rate that is set, to a little beyond the perfect wrap.

        Args:
            progress: called with the frames done and those there are; what it raises ends the
                computation.

        Raises:
            SpiralError: the closing cannot be computed.
        """
        answer, asked = self.known, replace(self.settings, pressure=0.0)
        if answer is None or answer.window is None or answer.wrap is None:
            return None
        if self.closing is None:
            end = min(BEYOND_WRAP * answer.wrap.pressure, self.gripper.pressure_max)
            course = PressureCourse.ramp(asked.rate, end, WAIT)
            self._closing = asked, close_on(answer.window.setup, course, progress=progress)
        return self._closing[1]

    def close(self) -> None:
        """End the background's work; what is under way is dropped."""
        self._closed = True
        self._background.shutdown(wait=False, cancel_futures=True)

    def _ask(self) -> None:
        """Have the settings answered, in place of what waits to be."""
        if self._pending is not None:
            self._pending.cancel()
        self._asked_since = time.monotonic()
        asked, gripper = _asked_of(self.settings), self.gripper
        self._pending = self._background.submit(self._reply, asked, gripper)

    def _reply(self, asked: Settings, gripper: Gripper) -> None:
        """Compute an answer in the background, part by part, while it is asked for."""

        def give(answer: Answer) -> Answer:
            self.answer = answer
            self._on_answer(answer)
            return answer

        def go_on(done: int, total: int) -> None:
            del done, total
            if self._closed or asked != _asked_of(self.settings):
                raise _StaleError

        answer = give(answer_for(asked, gripper))
        if answer.wrap is None or answer.curve is None:
            return
        try:
            shape = object_shape(asked, answer.wrap.object_length_needed or 0.0)
            setup = lay_into_coil(gripper, asked.object_radius, shape=shape, curve=answer.curve)
            window = grip_window(setup, progress=go_on)
            answer = give(replace(answer, window=window))
            give(replace(answer, grip=solve_grip(setup, window=window, progress=go_on)))
        except SpiralError as error:
            give(replace(answer, refusal=str(error)))
        except _StaleError:
            return


def answer_for(settings: Settings, gripper: Gripper) -> Answer:
    """Return what a gripper wraps, and how it wraps the object that is set."""
    answer = Answer(settings)
    try:
        curve = WrapCurve(gripper)
        chart = regime_chart(curve, curve.radius_min, curve.radius_max)
        answer = Answer(settings, curve, chart.radius[::-1], chart.tip[::-1])
        wrap = curve.wrap_for_radius(settings.object_radius)
        return replace(answer, wrap=wrap, placement=place_object(wrap))
    except SpiralError as error:
        return replace(answer, refusal=str(error))


def object_shape(settings: Settings, length: float) -> Profile | None:
    """Return the shape of a tapered object that a coil of this length [m] lies on, or beyond.

    None for a cylinder.
    """
    if settings.taper == 0.0:
        return None
    radius = settings.object_radius
    heights = np.linspace(*cone_ends(radius, settings.taper, length + 10.0 * radius), 5)
    radii = radius + math.tan(settings.taper) * heights
    return Profile(tuple(heights.tolist()), tuple(radii.tolist()))


def _asked_of(settings: Settings) -> Settings:
    """Return the settings that answers depend on, whatever pressure and rate."""
    return replace(settings, pressure=0.0, rate=DEFAULT_RATE)
