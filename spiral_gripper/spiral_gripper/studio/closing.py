# SPDX-License-Identifier: Apache-2.0
"""The closing in real time: computed on request, kept while the settings stay the same."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from spiral_core import PressureCourse, close_on
from spiral_core.grip.closing import BEYOND_WRAP, FRAMES, TimedClosing
from spiral_core.rod.motion.motion import Frame
from spiral_gripper.studio.session import Session
from spiral_gripper.studio.settings import Settings

# At the pressure, after it has been reached [s].
WAIT = 1.0


class StoppedError(Exception):
    """The computation of the closing was canceled."""


class Closings:
    """The last closing that was computed, for the settings that it belongs to."""

    def __init__(self) -> None:
        self._settings: Settings | None = None
        self._closing: TimedClosing | None = None

    def known(self, session: Session) -> TimedClosing | None:
        """Return the closing of a session's settings, if it was computed."""
        return self._closing if _asked_of(session) == self._settings else None

    def of(self, session: Session, moved: Callable[[float], None]) -> TimedClosing | None:
        """Return the closing of a session's gripper on its object; None without contact yet.

        The pressure rises at the rate that is set, to a little beyond the perfect wrap.

        Args:
            session: the gripper and its object.
            moved: called with the share that is computed; what it raises ends the computation.

        Raises:
            SpiralError: the closing cannot be computed.
        """
        answer = session.known
        if answer is None or answer.window is None or answer.wrap is None:
            return None
        if self.known(session) is None:
            asked = _asked_of(session)
            end = min(BEYOND_WRAP * answer.wrap.pressure, session.gripper.pressure_max)
            course, setup = PressureCourse.ramp(asked.rate, end, WAIT), answer.window.setup
            self._closing = close_on(setup, course, progress=lambda done, _: moved(done / FRAMES))
            self._settings = asked
        return self._closing


def in_time(frames: Sequence[Frame], tolerance: float) -> Iterator[Frame]:
    """Yield frames at their times; skip those that are late by more than ``tolerance`` [s]."""
    start = time.monotonic()
    for frame in frames:
        early = start + frame.time - time.monotonic()
        if early >= -tolerance or frame is frames[-1]:
            time.sleep(max(0.0, early))
            yield frame


def _asked_of(session: Session) -> Settings:
    """Return the settings that a closing depends on: all but the pressure."""
    return replace(session.settings, pressure=0.0)
