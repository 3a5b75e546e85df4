# SPDX-License-Identifier: Apache-2.0
"""Simulated time: it follows the machine's clock or /clock, or the simulator publishes /clock."""

from __future__ import annotations

from typing import Final

from spiral_gripper_ros.control.timing import MonotonicClock

# Of the simulation [s]: short against every time constant that is usual.
STEP: Final = 0.01
# At most so much time passes in one step [s]: a machine that holds the simulator up must not look
# like a sender that has fallen silent.
LONGEST_STEP: Final = 0.25
_NANOSECONDS: Final = 1_000_000_000
# Sums of periods miss a step by their rounding [s], which must not cost a whole step.
_EARLY: Final = 1e-9


class Pacing:
    """The time of the simulation, which only goes forward.

    Args:
        publishes_clock: whether it is the source of time: each step is then ``STEP`` long, whatever
            the machine's clock says, so that runs repeat exactly. If not, time passes as it does on
            the clock that :meth:`step` is given.

    Example:
        >>> pacing = Pacing(publishes_clock=True)
        >>> pacing.step(reading=123.4), pacing.step(reading=123.4), pacing.now
        (0.01, 0.01, 0.02)
    """

    def __init__(self, publishes_clock: bool) -> None:
        self._publishes_clock = publishes_clock
        self._clock = MonotonicClock()
        self._steps = 0
        self._now = 0.0

    @property
    def now(self) -> float:
        """Time since the start of the simulation [s]."""
        return self.nanoseconds / _NANOSECONDS if self._publishes_clock else self._now

    @property
    def nanoseconds(self) -> int:
        """The time that it publishes [ns]."""
        return self._steps * round(STEP * _NANOSECONDS)

    def step(self, reading: float) -> float:
        """Let time pass; return how much it was [s].

        Args:
            reading: of the clock that it follows if it is not the source [s].
        """
        if self._publishes_clock:
            self._steps += 1
            return STEP
        before = self._clock.now
        passed = min(self._clock.advance(reading) - before, LONGEST_STEP)
        self._now += passed
        return passed


class RateGate:
    """Says when something that is done with a rate is due.

    Example:
        >>> gate = RateGate()
        >>> [gate.due(now, rate=2.0) for now in (0.0, 0.1, 0.5, 0.9, 1.0)]
        [True, False, True, False, True]
    """

    def __init__(self) -> None:
        self._next = 0.0

    def due(self, now: float, rate: float) -> bool:
        """Return whether it is due at a time [s], for a rate [Hz] > 0; then it is done."""
        if now < self._next - _EARLY:
            return False
        period = 1.0 / rate
        # In step with what went before, but what was missed during a pause is not made up.
        self._next = period + (self._next if now - self._next < period else now)
        return True
