# SPDX-License-Identifier: Apache-2.0
"""The object's radius over time in the simulation, counted from its start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from spiral_core.validation import require_in_range, require_positive

# More variation than this, as a part of the radius, would leave next to nothing of the object.
LARGEST_VARIATION = 0.9


class Shape(Enum):
    """How the radius goes over time."""

    CONSTANT = "constant"
    STEP = "step"  # radius, and radius + variation, half a period each
    SINE = "sine"  # radius + variation * sin(2 pi t / period)


@dataclass(frozen=True, slots=True)
class ProfileSource:
    """An object whose radius follows a simple function of time, looked at with a fixed rate.

    Args:
        shape: which function.
        radius: [m], > 0.
        variation: height of the step or amplitude of the sine, as a part of ``radius``, from -0.9
            to 0.9.
        period: of step and sine [s], > 0.
        rate: looks per second [Hz], > 0.

    Raises:
        InvalidInputError: a value is out of its range.

    Example:
        >>> source = ProfileSource(Shape.STEP, radius=0.02, variation=0.5, period=2.0, rate=1.0)
        >>> source.samples(0.0, 4.0)
        [0.02, 0.03, 0.02, 0.03]
    """

    shape: Shape
    radius: float
    variation: float
    period: float
    rate: float

    def __post_init__(self) -> None:
        for field in ("radius", "period", "rate"):
            require_positive(field, getattr(self, field))
        require_in_range("variation", self.variation, -LARGEST_VARIATION, LARGEST_VARIATION)

    def samples(self, start: float, end: float) -> list[float]:
        """Return the radii [m] that are looked at between two times [s], the first included."""
        first, last = math.ceil(start * self.rate), math.ceil(end * self.rate)
        return [self.true_radius(number / self.rate) for number in range(first, last)]

    def true_radius(self, time: float) -> float:
        """Return the object's radius [m] at a time [s]."""
        phase = math.fmod(time, self.period) / self.period
        if self.shape is Shape.STEP:
            return self.radius * (1.0 + (self.variation if phase >= 0.5 else 0.0))
        if self.shape is Shape.SINE:
            return self.radius * (1.0 + self.variation * math.sin(2.0 * math.pi * phase))
        return self.radius
