# SPDX-License-Identifier: Apache-2.0
"""The pressure over time, linear between points."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_finite, require_non_negative, require_positive


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
        times = [require_finite("times", time) for time in self.times]
        increasing = all(b > a for a, b in pairwise(times))
        if len(times) < 2 or times[0] != 0.0 or not increasing:
            raise InvalidInputError("times", self.times, "two or more increasing times from 0")
        if len(self.pressures) != len(times):
            raise InvalidInputError("pressures", self.pressures, "as many as times")
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

    @classmethod
    def overshoot(cls, rate: float, pressure: float, wait: float, over: float) -> PressureCourse:
        """Return a ramp that goes beyond by a factor, over > 1, for half of the wait."""
        if not require_finite("over", over) > 1.0:
            raise InvalidInputError("over", over, "more than 1")
        first = cls.ramp(rate, over * pressure, 0.5 * wait)
        down = first.duration + (over - 1.0) * pressure / rate
        times = (*first.times, down, down + 0.5 * wait)
        return cls(times, (*first.pressures, pressure, pressure))

    @classmethod
    def squeezed_twice(
        cls, rate: float, pressure: float, wait: float, down: float = 0.7
    ) -> PressureCourse:
        """Return a ramp, a fall to a fraction of its pressure, and a second rise."""
        if not 0.0 < require_finite("down", down) < 1.0:
            raise InvalidInputError("down", down, "between 0 and 1")
        first = cls.ramp(rate, pressure, 0.5 * wait)
        change = (1.0 - down) * pressure / rate
        low, high = first.duration + change, first.duration + 2.0 * change
        return cls(
            (*first.times, low, high, high + 0.5 * wait),
            (*first.pressures, down * pressure, pressure, pressure),
        )
