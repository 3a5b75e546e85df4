# SPDX-License-Identifier: Apache-2.0
r"""A simulated object, whose radius goes over time, and its estimator, with errors.

.. math:: \hat r = r + b + \sigma n \pm o

with the bias :math:`b`, noise of standard deviation :math:`\sigma`, and now and then an outlier of
size :math:`o`, a NaN, or no estimate at all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from spiral_gripper_ros.parameters.spec import Parameters, choice, parameter

# After a longer pause of the simulation [s] what was due meanwhile is lost, as a stopped camera's
# images are.
LONGEST_BACKLOG = 1.0
# More variation than this, as a part of the radius, would leave next to nothing of the object.
LARGEST_VARIATION = 0.9


class Profile(Enum):
    """The object's radius over time."""

    CONSTANT = "constant"
    STEP = "step"  # radius, and radius + variation, half a period each
    SINE = "sine"  # radius + variation * sin(2 pi t / period)
    NONE = "none"  # there is no object


def _probability(text: str) -> Any:  # noqa: ANN401
    return parameter(0.0, f"Part of the estimates that {text}.", 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class RadiusParameters(Parameters):
    """Parameters of the source of radii."""

    profile: str = choice(
        Profile.CONSTANT,
        "The object's radius over time; none: no object, and estimates come from elsewhere.",
    )
    radius: float = parameter(
        0.0, "The object's radius [m]; 0: the middle of the gripper's range.", 0.0, 1.0
    )
    radius_variation: float = parameter(
        0.25,
        "Height of the step or amplitude of the sine, as a part of the radius.",
        -LARGEST_VARIATION,
        LARGEST_VARIATION,
    )
    radius_period: float = parameter(8.0, "Period of step and sine [s].", 0.01, 3600.0)
    estimate_rate: float = parameter(20.0, "Estimates per second [Hz].", 0.1, 100.0)
    estimate_noise: float = parameter(2.0e-5, "Standard deviation of the estimates [m].", 0.0, 0.1)
    estimate_bias: float = parameter(
        0.0, "Bias of the estimates [m]; positive: too large.", -0.1, 0.1
    )
    outlier_probability: float = _probability("are off by outlier_size")
    outlier_size: float = parameter(0.01, "Size of an outlier [m].", 0.0, 1.0)
    nan_probability: float = _probability("are not a number")
    dropout_probability: float = _probability("do not come")
    seed: int = parameter(0, "Seed of all noise.", 0, 1_000_000, read_only=True)


class RadiusEstimator:
    """Estimates an object's radius with random errors; the seed makes them repeatable.

    Each estimate takes the same number of random numbers, so that a change of one error leaves the
    others where they were.

    Args:
        values: the object and the errors.
        middle_radius: what a radius of 0 stands for [m].

    Attributes:
        values: may be replaced at any time.

    Example:
        >>> values = RadiusParameters(radius=0.02, estimate_noise=0.0, estimate_bias=0.001)
        >>> RadiusEstimator(values, middle_radius=0.02).estimates(until=0.1)
        [0.021, 0.021]
    """

    def __init__(self, values: RadiusParameters, middle_radius: float) -> None:
        self.values = values
        self._middle_radius = middle_radius
        self._random = np.random.default_rng(values.seed)
        self._time = 0.0

    def estimates(self, until: float) -> list[float]:
        """Return the estimates [m] that fall due before a time [s]; a float, as estimators give."""
        start, end = max(self._time, until - LONGEST_BACKLOG), max(self._time, until)
        self._time = end
        rate = self.values.estimate_rate
        due = range(math.ceil(start * rate), math.ceil(end * rate))
        radii = [self._radius(number / rate) for number in due]
        made = [self._estimate(radius) for radius in radii if radius is not None]
        return [estimate for estimate in made if estimate is not None]

    def true_radius(self) -> float | None:
        """Return the object's radius [m] now; None: there is no object."""
        return self._radius(self._time)

    def _radius(self, time: float) -> float | None:
        values, profile = self.values, Profile(self.values.profile)
        if profile is Profile.NONE:
            return None
        radius = values.radius or self._middle_radius
        phase = math.fmod(time, values.radius_period) / values.radius_period
        if profile is Profile.STEP:
            return radius * (1.0 + (values.radius_variation if phase >= 0.5 else 0.0))
        if profile is Profile.SINE:
            return radius * (1.0 + values.radius_variation * math.sin(2.0 * math.pi * phase))
        return radius

    def _estimate(self, radius: float) -> float | None:
        values, gauss = self.values, float(self._random.standard_normal())
        outlier, side, nan, dropout = self._random.random(4)
        if dropout < values.dropout_probability:
            return None
        if nan < values.nan_probability:
            return math.nan
        estimate = radius + values.estimate_bias + values.estimate_noise * gauss
        if outlier < values.outlier_probability:
            estimate += math.copysign(values.outlier_size, side - 0.5)
        return estimate
