# SPDX-License-Identifier: Apache-2.0
"""The clock of the control logic, and the time-outs of client, gravity and take-over."""

from __future__ import annotations

from spiral_core.validation import require_finite
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.pressure_monitor import LONGEST_STEP
from spiral_gripper_ros.control.refusals import lost_client, stale_gravity
from spiral_gripper_ros.control.states import NOT_REFUSED, Refusal

# Longest time that one reading may add [s]: longer than any time-out, so that all of them act, and
# short enough that time is still told apart to a microsecond after ten thousand such leaps.
LONGEST_LEAP = 1.0e5
# Until a node that has just started finds a sensor, which may take so long on a busy machine [s]:
# 0 Pa before that would let go of an object.
LONGEST_DISCOVERY = 5.0


class MonotonicClock:
    """A clock that never runs backwards: while the clock that it reads does, no time passes.

    Example:
        >>> clock = MonotonicClock()
        >>> [clock.advance(reading) for reading in (100.0, 100.5, 20.0, 21.0)]
        [0.0, 0.5, 0.5, 1.5]
    """

    def __init__(self) -> None:
        self.now = 0.0
        self._reading: float | None = None

    def advance(self, reading: float) -> float:
        """Take a reading of the other clock [s] and return the time of this one [s].

        Raises:
            InvalidInputError: the reading is not a finite number.
        """
        reading = require_finite("now", reading)
        if self._reading is not None:
            self.now += min(max(reading - self._reading, 0.0), LONGEST_LEAP)
        self._reading = reading
        return self.now


class SilenceWatch:
    """The times of the last keep-alive and the last gravity message."""

    def __init__(self) -> None:
        self._client_at = 0.0
        self._gravity_at: float | None = None

    def forget_gravity(self) -> None:
        """Expect no gravity: it is that of the parameter."""
        self._gravity_at = None

    def hear_client(self, now: float) -> None:
        """Note a sign of life of the client at a time [s], or that none is needed."""
        self._client_at = now

    def hear_gravity(self, now: float) -> None:
        """Note that a usable gravity was heard at a time [s]."""
        self._gravity_at = now

    def client_fault(self, now: float, limits: Limits) -> Refusal:
        """Return that the client is lost; ``Reason.NONE`` if it is not, or none is expected."""
        is_lost = 0.0 < limits.keep_alive_timeout < now - self._client_at
        return lost_client(limits) if is_lost else NOT_REFUSED

    def gravity_age(self, now: float) -> float | None:
        """Return the time since the newest gravity [s], or None if none was heard."""
        return None if self._gravity_at is None else now - self._gravity_at

    def gravity_fault(self, now: float, limits: Limits) -> Refusal:
        """Return that gravity is stale; ``Reason.NONE`` if it is not."""
        age = self.gravity_age(now)
        is_stale = age is not None and 0.0 < limits.gravity_timeout < age
        return stale_gravity(age, limits) if is_stale and age is not None else NOT_REFUSED


class TakeOver:
    """The wait for a measured pressure to take over; meanwhile nothing is commanded."""

    def __init__(self) -> None:
        self.waits = False
        self._silence = 0.0
        self._checked_at: float | None = None

    def start(self) -> None:
        """Wait from the next :meth:`check` on."""
        self.waits, self._silence, self._checked_at = True, 0.0, None

    def end(self) -> None:
        """Wait no longer."""
        self.waits = False

    def check(self, now: float, limits: Limits) -> None:
        """Give up at a time [s] once no pressure has come for long enough.

        That is ``measured_pressure_timeout``, and at least ``LONGEST_DISCOVERY``. A stall of this
        process counts in part only, as in the pressure's monitor: it may have held up a message.
        """
        longest = max(limits.measured_pressure_timeout, LONGEST_DISCOVERY)
        if self._checked_at is not None:
            step = max(now - self._checked_at, 0.0)
            self._silence += min(step, LONGEST_STEP * longest)
        self._checked_at = now
        self.waits = self.waits and self._silence <= longest
