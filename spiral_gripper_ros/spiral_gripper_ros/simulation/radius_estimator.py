# SPDX-License-Identifier: Apache-2.0
r"""A simulated estimator of the object's radius, with errors.

.. math:: \hat r = r + b + \sigma n \pm o

with the bias :math:`b`, noise of standard deviation :math:`\sigma`, and now and then an outlier of
size :math:`o`, a NaN, or no estimate at all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spiral_core.validation import require_finite, require_in_range, require_non_negative
from spiral_gripper_ros.simulation.radius_source import ProfileSource

# After a longer pause of the simulation [s] what was due meanwhile is lost, as a stopped camera's
# images are.
LONGEST_BACKLOG = 1.0


@dataclass(frozen=True, slots=True)
class EstimatorErrors:
    """The errors of the estimates.

    Args:
        noise: standard deviation [m], >= 0.
        bias: [m].
        outlier_probability: that an estimate is off by ``outlier_size``, 0 to 1.
        outlier_size: [m], >= 0; the sign is random.
        nan_probability: that it is not a number, 0 to 1.
        dropout_probability: that there is none, 0 to 1.

    Raises:
        InvalidInputError: a value is out of its range.
    """

    noise: float = 0.0
    bias: float = 0.0
    outlier_probability: float = 0.0
    outlier_size: float = 0.0
    nan_probability: float = 0.0
    dropout_probability: float = 0.0

    def __post_init__(self) -> None:
        require_finite("bias", self.bias)
        for field in ("noise", "outlier_size"):
            require_non_negative(field, getattr(self, field))
        for field in ("outlier_probability", "nan_probability", "dropout_probability"):
            require_in_range(field, getattr(self, field), 0.0, 1.0)


class RadiusEstimator:
    """Estimates the radius of a source with random errors; the seed makes them repeatable.

    Each estimate takes the same number of random numbers, so that a change of one error leaves the
    others where they were.

    Args:
        source: of the true radius; None: there is no object, and there are no estimates.
        errors: of the estimates.
        seed: of the errors.

    Attributes:
        source, errors: may be replaced at any time.

    Example:
        >>> from spiral_gripper_ros.simulation.radius_source import ProfileSource, Shape
        >>> source = ProfileSource(Shape.CONSTANT, 0.02, variation=0.0, period=1.0, rate=20.0)
        >>> RadiusEstimator(source, EstimatorErrors(bias=0.001)).estimates(until=0.1)
        [0.021, 0.021]
    """

    def __init__(
        self, source: ProfileSource | None, errors: EstimatorErrors, seed: int = 0
    ) -> None:
        self.source = source
        self.errors = errors
        self._random = np.random.default_rng(seed)
        self._time = 0.0

    def estimates(self, until: float) -> list[float]:
        """Return the estimates [m] that fall due before a time [s]; a float, as estimators give."""
        start, end = max(self._time, until - LONGEST_BACKLOG), max(self._time, until)
        self._time = end
        if self.source is None:
            return []
        made = [self._estimate(radius) for radius in self.source.samples(start, end)]
        return [estimate for estimate in made if estimate is not None]

    def true_radius(self) -> float | None:
        """Return the object's radius [m] now; None: there is no object."""
        return None if self.source is None else self.source.true_radius(self._time)

    def _estimate(self, radius: float) -> float | None:
        errors, gauss = self.errors, float(self._random.standard_normal())
        outlier, side, nan, dropout = self._random.random(4)
        if dropout < errors.dropout_probability:
            return None
        if nan < errors.nan_probability:
            return math.nan
        estimate = radius + errors.bias + errors.noise * gauss
        if outlier < errors.outlier_probability:
            estimate += math.copysign(errors.outlier_size, side - 0.5)
        return estimate
