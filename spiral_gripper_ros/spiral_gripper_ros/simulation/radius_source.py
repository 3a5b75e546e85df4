# SPDX-License-Identifier: Apache-2.0
"""The object's radius over time in the simulation: a recording or a simple profile.

A source gives the samples that an estimator takes, and the true radius. Time is counted from the
start of the simulation.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from statistics import median
from typing import Protocol

from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_in_range, require_positive
from spiral_gripper_ros.simulation.replay import RadiusSample

# More variation than this, as a part of the radius, would leave next to nothing of the object.
LARGEST_VARIATION = 0.9
# Rows per second of a recording, on average [Hz]: no camera has more, and without a bound a slip in
# the times could ask for any number of estimates in each step.
FASTEST_RECORDING = 1.0e4


class RadiusSource(Protocol):
    """What an estimator looks at."""

    def samples(self, start: float, end: float) -> list[float]:
        """Return the radii [m] that are looked at between two times [s], the first included."""
        ...

    def true_radius(self, time: float) -> float | None:
        """Return the object's radius [m] at a time [s]; None: there is no object."""
        ...


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


class RecordingSource:
    """A recorded stream of estimates, played in its own time.

    The object that is really there has the radius of the last estimate that is a positive number
    and that the recording does not call wrong: its label has no comma ("pipe", but not "pipe,
    outlier").

    Args:
        samples: the recording, in the order of their times.
        loop: whether it begins anew at its end; if not, the stream stops there.

    Raises:
        InvalidInputError: no sample of the recording tells what is really there, or they follow
            each other faster than ``FASTEST_RECORDING``.

    Example:
        >>> recording = [RadiusSample(0.0, 0.02, "pipe"), RadiusSample(0.1, math.nan, "pipe, dark")]
        >>> source = RecordingSource(recording, loop=True)
        >>> source.samples(0.0, 0.25), source.true_radius(0.15)
        ([0.02, nan, 0.02], 0.02)
    """

    def __init__(self, samples: Sequence[RadiusSample], loop: bool) -> None:
        start = samples[0].time
        self._times = [sample.time - start for sample in samples]
        self._radii = [sample.radius for sample in samples]
        good = [sample for sample in samples if _is_true(sample)]
        if not good:
            raise InvalidInputError(
                "recording", f"{len(samples)} rows", "rows whose radius is a positive number"
            )
        self._true_times = [sample.time - start for sample in good]
        self._true_radii = [sample.radius for sample in good]
        duration = self._times[-1] + _interval(self._times)
        if not duration >= len(samples) / FASTEST_RECORDING:
            raise InvalidInputError(
                "recording",
                f"{len(samples)} rows in {duration:.3g} s",
                f"at most {FASTEST_RECORDING:g} rows a second, on average",
            )
        self._duration = duration if loop else math.inf

    def samples(self, start: float, end: float) -> list[float]:
        """Return the estimates [m] between two times [s], the first included."""
        found: list[float] = []
        lap = start // self._duration if math.isfinite(self._duration) else 0.0
        origin = lap * self._duration if lap else 0.0
        while origin < end:
            first = bisect_left(self._times, start - origin)
            found += self._radii[first : bisect_left(self._times, end - origin)]
            origin += self._duration
        return found

    def true_radius(self, time: float) -> float:
        """Return the object's radius [m] at a time [s]."""
        within = math.fmod(time, self._duration)
        return self._true_radii[max(bisect_right(self._true_times, within) - 1, 0)]


class NoSource:
    """Nothing: estimates come from elsewhere, such as a real camera."""

    def samples(self, start: float, end: float) -> list[float]:
        """Return no radii."""
        del start, end
        return []

    def true_radius(self, time: float) -> None:
        """Return that there is no object."""
        del time


def _is_true(sample: RadiusSample) -> bool:
    """Return whether a sample tells the radius of the object that is really there."""
    return math.isfinite(sample.radius) and sample.radius > 0.0 and "," not in sample.label


def _interval(times: Sequence[float]) -> float:
    """Return the usual time [s] from one sample to the next: that from the last to the first."""
    gaps = [later - earlier for earlier, later in pairwise(times)]
    return median(gaps) if gaps else 1.0
