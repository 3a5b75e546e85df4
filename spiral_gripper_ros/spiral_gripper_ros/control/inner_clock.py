# SPDX-License-Identifier: Apache-2.0
"""The time that the control logic lives in: that of any clock, without its leaps."""

from __future__ import annotations

from spiral_core.validation import require_finite

# Longest time that one reading may add [s]: longer than any time-out, so that all of them act, and
# short enough that time is still told apart to a microsecond after ten thousand such leaps.
LONGEST_LEAP = 1.0e5


class InnerClock:
    """Never runs backwards: while the clock it is read from does, no time passes.

    Example:
        >>> clock = InnerClock()
        >>> [clock.advance(reading) for reading in (100.0, 100.5, 20.0, 21.0)]
        [0.0, 0.5, 0.5, 1.5]
    """

    def __init__(self) -> None:
        self.now = 0.0
        self._reading: float | None = None

    def advance(self, reading: float) -> float:
        """Move on to what the outer clock reads [s] and return the inner time [s].

        Raises:
            InvalidInputError: the reading is not a finite number.
        """
        reading = require_finite("now", reading)
        if self._reading is not None:
            self.now += min(max(reading - self._reading, 0.0), LONGEST_LEAP)
        self._reading = reading
        return self.now
