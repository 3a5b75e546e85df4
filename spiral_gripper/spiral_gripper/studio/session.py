# SPDX-License-Identifier: Apache-2.0
"""The studio's computations: shapes at once, other answers in the background."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from spiral_core import (
    Grip,
    Gripper,
    Profile,
    RodState,
    SpiralError,
    Wrap,
    WrapCurve,
    WrapRegime,
    grip_window,
    lay_into_coil,
    solve_grip,
    solve_rod,
)
from spiral_core.grip.window import GripPoint, GripWindow
from spiral_core.rod.types import Array
from spiral_core.wrap.placement import ObjectPlacement, place_object
from spiral_gripper.files.description import GripperDescription
from spiral_gripper.studio.settings import DEFAULT_RATE, Settings, gripper_for

# Pressures at which the chart is drawn.
CHART_POINTS = 61


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """Results that take longer than a frame: the range of radii, and the wrap of one object.

    Args:
        settings: what it answers, whatever the pressure.
        pressures, radii: (n,) the chart: rising radii [m] and the pressure that wraps each [Pa],
            NaN in a gap; empty where nothing is wrapped.
        wrap: the perfect wrap of the object; None where there is none.
        placement: where the object then lies.
        refusal: why there is no wrap.
        curve: the gripper's wraps; None where it makes no coil.
        window: the shapes in contact, and the pressures that hold the object; None where that is
            not known yet, or not so.
        grip: what it holds at them; likewise.
        no_grip: why the object is not held, where that is known.
    """

    settings: Settings
    pressures: Array
    radii: Array
    wrap: Wrap | None
    placement: ObjectPlacement | None
    refusal: str
    curve: WrapCurve | None
    window: GripWindow | None = None
    grip: Grip | None = None
    no_grip: str = ""

    @property
    def is_complete(self) -> bool:
        """Whether nothing more is being computed."""
        return self.wrap is None or self.grip is not None or self.no_grip != ""

    def contact_at(self, pressure: float) -> GripPoint | None:
        """Return the solved contact next to a pressure [Pa]; None where there is none."""
        if self.window is None or not 0.0 <= pressure <= self.window.top:
            return None
        return min(self.window.points, key=lambda point: abs(point.pressure - pressure))

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
    background, the newest settings first; an answer is current while :meth:`current` says so.

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
    def current(self) -> bool:
        """Whether :attr:`answer` belongs to the settings, whatever the pressure."""
        return self.known is not None

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
            give(replace(answer, no_grip=str(error)))
        except _StaleError:
            return


def answer_for(settings: Settings, gripper: Gripper) -> Answer:
    """Return what a gripper wraps, and how it wraps the object that is set."""
    empty = np.empty(0)
    try:
        curve = WrapCurve(gripper)
    except SpiralError as error:
        return Answer(settings, empty, empty, None, None, str(error), None)
    radii = np.linspace(curve.radius_min, curve.radius_max, CHART_POINTS)
    pressures = np.full(CHART_POINTS, np.nan)
    for index, radius in enumerate(radii.tolist()):
        with suppress(SpiralError):
            pressures[index] = curve.pressure_from_radius(radius)
    try:
        wrap = curve.wrap_for_radius(settings.object_radius)
    except SpiralError as error:
        return Answer(settings, pressures, radii, None, None, str(error), curve)
    return Answer(settings, pressures, radii, wrap, place_object(wrap), "", curve)


def object_shape(settings: Settings, length: float) -> Profile | None:
    """Return the shape of a tapered object that a coil of this length [m] lies on, or beyond.

    None for a cylinder. A cone ends where only a fifth of its radius is left.
    """
    if settings.taper == 0.0:
        return None
    radius, slope = settings.object_radius, math.tan(settings.taper)
    reach, apex = length + 10.0 * radius, -0.8 * radius / slope
    low, high = (max(-reach, apex), reach) if slope > 0.0 else (-reach, min(reach, apex))
    heights = np.linspace(low, high, 5)
    return Profile(tuple(heights.tolist()), tuple((radius + slope * heights).tolist()))


def _asked_of(settings: Settings) -> Settings:
    """Return the settings that answers depend on, whatever pressure and rate."""
    return replace(settings, pressure=0.0, rate=DEFAULT_RATE)
