# SPDX-License-Identifier: Apache-2.0
r"""The result of a calibration: values, their uncertainty, and the actuator's stable range.

The stated errors weigh the readings against each other; their common scale s, with
:math:`s^2 = \mathrm{RSS} / (m - p)`, comes from the residuals. The covariance is
:math:`s^2 (J^T J)^{-1}`, an interval :math:`\pm t_{m-p}` standard errors (Student's t), which is
right for few readings too. No scatter is no certainty: where the residuals are too small for the
stated errors (rounded alike, or exact), s = 1 and the normal distribution's quantile are taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.actuator.actuator import Actuator
from spiral_core.brief import brief_repr
from spiral_core.calibration.model import CalibrationModel
from spiral_core.calibration.outliers import Scatter, deleted, outliers, scatter_of
from spiral_core.calibration.predict import measured_values
from spiral_core.calibration.readings import Reading
from spiral_core.errors import InvalidInputError
from spiral_core.rod.types import Array, RodStiffness
from spiral_core.validation import require_in_range
from spiral_core.wrap.gripper import Gripper

DEFAULT_LEVEL = 0.95


class Interval(NamedTuple):
    """A confidence interval, in the unit of what it is for."""

    low: float
    high: float


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    r"""Fitted parameters with their covariance and residuals.

    Attributes:
        model: what was fitted.
        readings: what it was fitted to.
        values: (p,) the parameters, named by ``names``, in SI units.
        covariance: (p, p) of the values.
        degrees_of_freedom: fitted components minus parameters.
        residuals: (m,) predicted minus measured, over the stated error of each component.
        errors: (m,) those errors: stated, and for a stated error of the pressure its share.
        jacobian: (m, p) derivatives of ``residuals`` by the parameters.
        error_scale: how many times larger than stated the errors are, judged by the residuals.
        at_bound: names of parameters that ended at a bound; their intervals mean little.
        excluded: places of the readings that a robust fit left out, the farthest first.
        actuation: the fitted pressure-stretch relation; its ``stretch_limit``, ``pressure_limit``
            and ``limit`` tell over which range it is stable (dP/d lambda_1 > 0) and what ends that.
        gripper: the mounted gripper with the fitted values, if one was given.
    """

    __repr__ = brief_repr

    model: CalibrationModel
    readings: tuple[Reading, ...]
    values: Array
    covariance: Array
    degrees_of_freedom: int
    residuals: Array
    errors: Array
    jacobian: Array
    error_scale: float
    at_bound: tuple[str, ...]
    excluded: tuple[int, ...]
    actuation: FreeActuation
    gripper: Gripper | None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return self.model.names

    @property
    def actuator(self) -> Actuator:
        """The actuator with the fitted constants."""
        return self.actuation.actuator

    @property
    def stiffness(self) -> RodStiffness:
        """EI and GJ: fitted, given, or the fitted material's."""
        return self.model.stiffness_from([float(value) for value in self.values])

    @property
    def owners(self) -> NDArray[np.intp]:
        """The place of the reading of each component (m,)."""
        counts = [len(reading.measured) for reading in self.readings]
        return np.repeat(np.arange(len(counts)), counts)

    @property
    def fitted(self) -> NDArray[np.bool_]:
        """Which components were fitted (m,), and not left out as outliers."""
        return ~np.isin(self.owners, self.excluded)

    @property
    def standardized_residuals(self) -> Array:
        """Distance of each reading from the fit to the others, in standard errors of it (n,).

        Externally studentized; of a point's coordinates the largest. The errors are scaled as the
        others scatter, or as stated if these scatter improbably little.
        """
        tests = deleted(self.residuals, self.jacobian, self.owners, self.fitted)
        return np.array([one.ratio / one.accepted_scale for one in tests])

    @property
    def outliers(self) -> tuple[int, ...]:
        """Places of the readings that chance does not explain, the farthest first.

        The readings that a robust fit left out are among them.
        """
        found = outliers(self.residuals, self.jacobian, self.owners, trust_stated=True)
        return (*self.excluded, *(one for one in found if one not in self.excluded))

    @property
    def scatter(self) -> Scatter:
        """Whether the readings scatter about the fit as their stated errors say."""
        return scatter_of(self.error_scale, self.degrees_of_freedom)

    @property
    def standard_errors(self) -> Array:
        """Standard error of each parameter (p,)."""
        errors: Array = np.sqrt(np.diag(self.covariance))
        return errors

    @property
    def correlation(self) -> Array:
        """Correlation of the parameters (p, p); ones on the diagonal."""
        errors = self.standard_errors
        correlation: Array = self.covariance / np.outer(errors, errors)
        np.fill_diagonal(correlation, 1.0)
        return correlation

    def value(self, name: str) -> float:
        """Return one parameter by its name.

        Raises:
            InvalidInputError: there is no such parameter.
        """
        return float(self.values[self.index(name)])

    def index(self, name: str) -> int:
        """Return the place of a parameter in the arrays.

        Raises:
            InvalidInputError: there is no such parameter.
        """
        if name not in self.names:
            raise InvalidInputError("name", name, f"one of {', '.join(self.names)}")
        return self.names.index(name)

    def interval_factor(self, level: float = DEFAULT_LEVEL) -> float:
        """Return how many standard errors an interval reaches to either side.

        Args:
            level: confidence level, in (0, 1).

        Raises:
            InvalidInputError: ``level`` is not between 0 and 1.
        """
        stated = self.scatter is Scatter.TOO_SMALL
        return student_quantile(level, math.inf if stated else self.degrees_of_freedom)

    def interval(self, name: str, level: float = DEFAULT_LEVEL) -> Interval:
        """Return the confidence interval of one parameter, from Student's t.

        Args:
            name: of the parameter.
            level: share of repeated bench tests whose interval holds the true value, in (0, 1).

        Raises:
            InvalidInputError: there is no such parameter, or ``level`` is not between 0 and 1.
        """
        k = self.index(name)
        half = self.interval_factor(level) * self.standard_errors[k]
        return Interval(float(self.values[k] - half), float(self.values[k] + half))

    @property
    def predictions(self) -> Array:
        """What the fitted model predicts for each measured component (m,)."""
        predicted: Array = measured_values(self.readings) + self.residuals * self.errors
        return predicted

    @property
    def information_criterion(self) -> float:
        r"""Corrected Akaike criterion AICc; of two laws for the same readings, lower is better.

        .. math:: m \ln(2 \pi \mathrm{RSS} / m) + m + 2 \sum \ln \sigma_i + 2 k
            + \frac{2 k (k + 1)}{m - k - 1}, \qquad k = p + 1

        Infinite where there are too few readings to compare laws at all. The second-order
        correction is for small samples; the error scale counts as a parameter.

        Source: K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed.,
        2002, ch. 7.
        """
        count, k = len(self.residuals), self._degrees()
        if not count - k - 1 > 0:
            return math.inf
        return self._deviance() + 2.0 * k + 2.0 * k * (k + 1) / (count - k - 1)

    @property
    def bayesian_criterion(self) -> float:
        r"""Schwarz's criterion BIC: as AICc with the penalty :math:`k \ln m`."""
        return self._deviance() + self._degrees() * math.log(len(self.residuals))

    def _degrees(self) -> int:
        """Return how many values were fitted: a reading that was left out counts as fitted."""
        return len(self.values) + 1 + int(np.sum(~self.fitted))

    def _deviance(self) -> float:
        """Return -2 ln L at the fitted error scale."""
        count = len(self.residuals)
        variance = float(np.sum(self.residuals[self.fitted] ** 2)) / count
        # A perfect fit has no scale: the smallest positive float stands for its variance.
        scale = math.log(2.0 * math.pi * max(variance, np.finfo(np.float64).tiny))
        return count * (scale + 1.0) + 2.0 * float(np.log(self.errors).sum())


def student_quantile(level: float, degrees_of_freedom: float) -> float:
    """Return the half width of a two-sided interval, in standard errors.

    Args:
        level: confidence level, in (0, 1).
        degrees_of_freedom: of the error scale, >= 1; infinite for errors that are known.

    Raises:
        InvalidInputError: ``level`` is not between 0 and 1.

    Example:
        >>> round(student_quantile(0.95, 10), 4)
        2.2281
    """
    from scipy.special import ndtri, stdtrit

    require_in_range("level", level, 0.0, 1.0)
    if not 0.0 < level < 1.0:
        raise InvalidInputError("level", level, "between 0 and 1, both excluded")
    below = 0.5 + 0.5 * level
    known = math.isinf(degrees_of_freedom)
    return float(ndtri(below) if known else stdtrit(degrees_of_freedom, below))
