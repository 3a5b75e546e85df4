# SPDX-License-Identifier: Apache-2.0
"""The clock of the control logic, and the silence of what it hears."""

from __future__ import annotations

from spiral_core.validation import require_finite
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.refusals import TAKING_OVER, impossible_take_over

# Time-out of the watchdogs of the adapter and of the simulated regulator, unless set otherwise [s].
WATCHDOG_TIMEOUT = 0.5
# Longest time that one reading may add [s]: longer than any time-out, so that all of them act, and
# short enough that time is still told apart to a microsecond after ten thousand such leaps.
LONGEST_LEAP = 1.0e5
# Until a node that has just started finds a sensor, which may take so long on a busy machine [s]:
# 0 Pa before that would let go of an object.
LONGEST_DISCOVERY = 5.0
# Part of an allowed silence that one stall of the process counts as at most.
LONGEST_STEP = 0.25
# Measured pressures must agree for this time before one is taken over [s].
AGREEMENT_TIME = 0.2


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

    def change(self) -> None:
        """Read another clock from now on."""
        self._reading = None

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


class Silence:
    """When something was heard last, and how long not, as far as this process could have heard it.

    A stall of the process counts as at most a quarter of what is allowed, or as the time between
    two commands: what has come meanwhile is read before its loss is reported, even after several
    stalls in a row.

    Attributes:
        is_expected: whether it was ever heard, or is expected all the same.

    Example:
        >>> radius = Silence()
        >>> radius.hear(0.0)
        >>> radius.exceeds(1.3, longest=1.0), radius.exceeds(1.4, longest=1.0)
        (False, False)
        >>> radius.hear(2.0, age=-0.1)  # its stamp is a little ahead of this clock
        >>> radius.age(2.0)
        0.0
    """

    def __init__(self) -> None:
        self._heard_at: float | None = None
        self.is_expected = False
        self._lasts = self._counted_at = 0.0

    def age(self, now: float) -> float | None:
        """Return how old what was heard last is at a time [s]; None: nothing was."""
        return None if self._heard_at is None else now - self._heard_at

    def forget(self) -> None:
        """Expect nothing."""
        self._heard_at, self.is_expected = None, False

    def expect(self, now: float) -> None:
        """Expect it from a time [s] on, if it was never heard."""
        if self._heard_at is None:
            self.is_expected, self._lasts, self._counted_at = True, 0.0, now

    def hear(self, now: float, age: float = 0.0) -> None:
        """Note that something was heard at a time [s], as old as its stamp says [s]."""
        age, self.is_expected = max(age, 0.0), True
        self._heard_at, self._lasts, self._counted_at = now - age, age, now

    def exceeds(self, now: float, longest: float, period: float = 0.0) -> bool:
        """Let time pass until ``now`` [s]; return whether the silence is longer than allowed [s].

        What is not expected may be silent.

        Args:
            now: time [s], never decreasing.
            longest: silence that is allowed [s].
            period: time between two calls [s].
        """
        if not self.is_expected:
            return False
        step = max(now - self._counted_at, 0.0)
        self._lasts += min(step, max(LONGEST_STEP * longest, period))
        self._counted_at = now
        return self._lasts > longest


class TakeOver:
    """The wait for measured pressures that agree; meanwhile nothing is commanded.

    Attributes:
        waits: whether a pressure is still to be taken over.
        refusal: why nothing is taken over yet.
    """

    def __init__(self) -> None:
        self.waits = False
        self.refusal = TAKING_OVER
        self._silence = Silence()
        self._since: float | None = None
        self._held: float | None = None  # what was agreed [Pa]
        self._low = self._high = 0.0

    def start(self) -> None:
        """Wait from the next :meth:`check` on."""
        self.waits, self.refusal = True, TAKING_OVER
        self._since = self._held = None
        self._silence.forget()

    def hear(self, now: float, pressure: float, limits: Limits) -> None:
        """Note a possible measured gauge pressure [Pa] at a time [s].

        It is agreed once all of ``AGREEMENT_TIME`` are within ``pressure_tolerance`` of each other,
        if it may be commanded.
        """
        low, high = min(self._low, pressure), max(self._high, pressure)
        if self._since is None or high - low > limits.pressure_tolerance:
            self._since, low, high = now, pressure, pressure
        self._low, self._high = low, high
        self._held, self.refusal = None, TAKING_OVER
        if now - self._since >= AGREEMENT_TIME:
            refusal = impossible_take_over(pressure, limits)
            self._held = None if refusal else pressure
            self.refusal = refusal or TAKING_OVER

    def check(self, now: float, limits: Limits) -> float:
        """End the wait at a command, and return the pressure to take over [Pa].

        That is 0 while it waits, and where nothing is held: 0 Pa opens a latched watchdog. Without
        a pressure for ``measured_pressure_timeout``, and at least ``LONGEST_DISCOVERY``, the wait
        ends too. Once one was measured there is no time-out: something may be held.
        """
        if not self.waits:
            return 0.0
        if not self._silence.is_expected:
            self._silence.hear(now)
        longest = max(limits.measured_pressure_timeout, LONGEST_DISCOVERY)
        is_over = self._since is None and self._silence.exceeds(now, longest, limits.period)
        self.waits = self._held is None and not is_over
        return self._held or 0.0
