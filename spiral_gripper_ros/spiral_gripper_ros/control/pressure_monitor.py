# SPDX-License-Identifier: Apache-2.0
"""Comparison of the measured pressure with the commands: the faults of the regulator."""

from __future__ import annotations

import math
from collections import deque

from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.refusals import MUST_BE_GAUGE, cause
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal
from spiral_gripper_ros.control.timing import Silence

# Gauge pressures that exist [Pa]: from a perfect vacuum to ten times what a pneumatic supply has.
LOWEST_PRESSURE = -101325.0
HIGHEST_PRESSURE = 1.0e7
# Range of atmospheric pressure [Pa]: a vented sensor that reads this measures absolute pressure.
ATMOSPHERE = (6.0e4, 1.1e5)
# A verdict counts once all messages of this time agree [s]: several messages of the slowest usual
# sensor (20 Hz), and short compared with the time in which a leak releases an object.
PERSISTENCE = 0.2
# A pressure that is off the command is back once it is within this part of pressure_tolerance: at
# the boundary noise of a fifth of the tolerance does not make the fault come and go.
RETURN_BAND = 0.8
# The measured pressure is the mean of this time [s] and of at most so many messages.
SMOOTHING_TIME = 0.1
MOST_SAMPLES = 64
# The window is kept in so many parts: it reaches back too far by at most one of them and the time
# between two commands.
PARTS = 32


class CommandEnvelope:
    """Remembers which commands were in force during a window that ends now.

    Before the first command anything was in force, so the envelope is unbounded until the window
    is full.
    """

    def __init__(self) -> None:
        self._parts: deque[tuple[float, float, float]] = deque()  # start, lowest, highest

    def add(self, now: float, command: float, window: float) -> None:
        """Note a command [Pa] that is in force from ``now`` [s] on, for windows of that length."""
        if self._parts and now - self._parts[-1][0] <= window / PARTS:
            start, low, high = self._parts[-1]
            self._parts[-1] = (start, min(low, command), max(high, command))
        else:
            self._parts.append((now, command, command))
        self._drop(now - window)

    def bounds(self, now: float, window: float) -> tuple[float, float]:
        """Return the smallest and the largest command in force since ``now - window`` [Pa].

        Example:
            >>> envelope = CommandEnvelope()
            >>> for second, command in enumerate((0.0, 3.0e4, 5.0e4, 5.0e4)):
            ...     envelope.add(float(second), command, window=1.0)
            >>> envelope.bounds(3.0, window=1.0)
            (50000.0, 50000.0)
        """
        self._drop(now - window)
        if not self._parts or now - self._parts[0][0] < window:
            return -math.inf, math.inf
        return min(part[1] for part in self._parts), max(part[2] for part in self._parts)

    def _drop(self, oldest: float) -> None:
        """Drop the parts whose last command was replaced before the time ``oldest`` [s]."""
        while len(self._parts) > 1 and self._parts[1][0] <= oldest:
            self._parts.popleft()


class PressureMonitor:
    """Compares measured pressures with the commands, and reports a fault while it persists.

    The mean of the last messages is compared with the commands of the last
    ``pressure_settle_time``, from the smallest to the largest, each widened by
    ``pressure_tolerance``: a ramp and a regulator that lags are no fault. A verdict must have
    persisted for ``PERSISTENCE``, and a pressure that was off the command must come back to within
    ``RETURN_BAND`` of the tolerance, so that neither noise nor a value at the boundary makes the
    fault chatter. Messages are compared, on arrival, with the commands of that time.

    Attributes:
        fault: what is wrong now; ``Reason.NONE`` if nothing is, or nothing was ever measured.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Reset: no measured pressure is known, and none is expected."""
        self._envelope = CommandEnvelope()
        self._samples: deque[tuple[float, float]] = deque(maxlen=MOST_SAMPLES)
        self.fault = NOT_REFUSED
        self._silence, self._interval = Silence(), 0.0
        self._verdict: Reason | None = None
        self._verdict_since = 0.0
        self._invalid_since: float | None = None
        self._last_invalid = NOT_REFUSED

    @property
    def is_expected(self) -> bool:
        """Whether a pressure has been measured since activation, believed or not."""
        return self._silence.is_expected

    def commanded(self, now: float, pressure: float, limits: Limits) -> None:
        """Note the command [Pa] that is in force from ``now`` [s] on."""
        self._envelope.add(now, pressure, limits.pressure_settle_time)

    def offer(self, now: float, pressure: float, limits: Limits) -> Refusal | None:
        """Judge a measured pressure.

        Args:
            now: time [s], never decreasing.
            pressure: measured gauge pressure [Pa]; anything a float can be.
            limits: tolerance, settling time and time-out.

        Returns:
            Why the message is dropped, or None if it is believed.
        """
        refusal = impossible_pressure(pressure)
        if refusal:
            if not self.is_expected:
                self._silence.hear(now)
            self._note_invalid(now, refusal)
            return refusal
        self._silence.hear(now)
        self._invalid_since, self._last_invalid = None, NOT_REFUSED
        self._interval = self.age(now) or 0.0
        self._samples.append((now, pressure))
        while self._samples[0][0] < now - SMOOTHING_TIME:
            self._samples.popleft()
        if self.measured is not None:  # it is the mean of at least this one
            self._compare(now, self.measured, limits)
        return None

    def check(self, now: float, limits: Limits) -> None:
        """Advance to the time ``now`` [s], and report missing messages as a fault."""
        if self._silence.exceeds(now, limits.measured_pressure_timeout, limits.period):
            if self.fault.reason is not Reason.PRESSURE_LOST:
                self.fault = Refusal(
                    Reason.PRESSURE_LOST,
                    "no usable measured_pressure for more than "
                    f"{limits.measured_pressure_timeout:.3g} s (measured_pressure.timeout)"
                    f"{cause(self._last_invalid)}",
                )
            self._samples.clear()
            self._verdict = None

    @property
    def measured(self) -> float | None:
        """The smoothed pressure [Pa], or None if none is believed."""
        if not self._samples:
            return None
        return math.fsum(pressure for _, pressure in self._samples) / len(self._samples)

    def age(self, now: float) -> float | None:
        """Return the time since the newest message that is believed [s], or None."""
        return now - self._samples[-1][0] if self._samples else None

    def misses(self, now: float, longest: float) -> bool:
        """Return whether no message has come for this time [s], though the last came sooner."""
        age = self.age(now)
        return age is not None and age > max(longest, 1.5 * self._interval)

    def _note_invalid(self, now: float, refusal: Refusal) -> None:
        self._last_invalid = refusal
        if self._invalid_since is None:
            self._invalid_since = now
        if now - self._invalid_since >= PERSISTENCE:
            self._verdict = None
            if self.fault.reason is not Reason.PRESSURE_LOST:
                self.fault = refusal

    def _compare(self, now: float, pressure: float, limits: Limits) -> None:
        """Compare the pressure [Pa] with the commands, and change the fault if it persists."""
        low, high = self._envelope.bounds(now, limits.pressure_settle_time)
        is_off = self.fault.reason in (Reason.PRESSURE_LOW, Reason.PRESSURE_HIGH)
        part = RETURN_BAND if is_off else 1.0
        refusal = _difference(pressure, low, high, limits.pressure_tolerance, part)
        if refusal.reason is not self._verdict:
            self._verdict, self._verdict_since = refusal.reason, now
        persists = now - self._verdict_since >= PERSISTENCE
        if persists and self.fault.reason is not refusal.reason:
            self.fault = refusal


def impossible_pressure(pressure: float) -> Refusal | None:
    """Return why no gauge pressure [Pa] could be this, or None.

    Example:
        >>> impossible_pressure(float("nan")).text
        'measured_pressure must be a gauge pressure from -101325 to 1e+07 Pa, got nan Pa'
    """
    if LOWEST_PRESSURE <= pressure <= HIGHEST_PRESSURE:
        return None
    return Refusal(
        Reason.PRESSURE_INVALID,
        f"measured_pressure must be a gauge pressure from {LOWEST_PRESSURE:g} to "
        f"{HIGHEST_PRESSURE:g} Pa, got {pressure:.6g} Pa",
    )


def _difference(pressure: float, low: float, high: float, tolerance: float, part: float) -> Refusal:
    """Return the fault of a pressure compared with the commands from ``low`` to ``high``, all [Pa].

    ``part`` is the fraction of the tolerance that is allowed.
    """
    allowed = f"(pressure.tolerance {tolerance:.6g} Pa)"
    if pressure < low - part * tolerance:
        return Refusal(
            Reason.PRESSURE_LOW,
            f"measured_pressure {pressure:.6g} Pa stays below the command of at least {low:.6g} Pa "
            f"{allowed}: leak, weak supply or stuck valve",
        )
    if pressure > high + part * tolerance:
        looks_absolute = high == 0.0 and ATMOSPHERE[0] <= pressure <= ATMOSPHERE[1]
        absolute = f"it looks like an absolute pressure: {MUST_BE_GAUGE}"
        return Refusal(
            Reason.PRESSURE_HIGH,
            f"measured_pressure {pressure:.6g} Pa stays above the command of at most {high:.6g} Pa "
            f"{allowed}: {absolute if looks_absolute else 'it does not vent'}",
        )
    return NOT_REFUSED
