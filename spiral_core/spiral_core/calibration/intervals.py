# SPDX-License-Identifier: Apache-2.0
r"""Intervals from the profile of the cost, for parameters with asymmetric uncertainty.

One parameter is held, the others are fitted again: the values for which

.. math:: S(\theta_k) - S_\mathrm{min} \le s^2 t^2_{m-p}

make the interval. Where the model is linear in its parameters it is the same as that of
:meth:`spiral_core.Calibration.interval`; where the data bound a parameter on one side only, it
shows.
"""

from __future__ import annotations

import math

import numpy as np

from spiral_core.calibration.outliers import Scatter
from spiral_core.calibration.problem import Problem
from spiral_core.calibration.result import (
    DEFAULT_LEVEL,
    Calibration,
    Interval,
)
from spiral_core.errors import SpiralError

# The interval's end is sought up to this many linear half widths away; farther out it is open.
FARTHEST = 20.0
# Bisection locates the end to this fraction of a linear half width.
FINENESS = 1e-3


def profile_interval(calibration: Calibration, name: str, level: float = DEFAULT_LEVEL) -> Interval:
    """Return the profile-likelihood interval of one parameter.

    Args:
        calibration: the fit.
        name: of the parameter.
        level: confidence level, in (0, 1).

    Returns:
        The interval; an end that the readings do not bound is infinite, or the model's bound.

    Raises:
        InvalidInputError: there is no such parameter, or ``level`` is not in (0, 1).

    Source: D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications, 1988,
    ch. 6.
    """
    return Interval(
        _end(calibration, name, level, -1.0),
        _end(calibration, name, level, 1.0),
    )


def _end(calibration: Calibration, name: str, level: float, side: float) -> float:
    """Return one end of the interval, below (-1) or above (+1) the fitted value."""
    k = calibration.index(name)
    quantile = calibration.interval_factor(level)
    known = calibration.scatter is Scatter.TOO_SMALL
    threshold = (quantile * (1.0 if known else calibration.error_scale)) ** 2
    best = float(calibration.values[k])
    half = min(quantile * float(calibration.standard_errors[k]), abs(best) or math.inf)
    low, high = calibration.model.limits()[k]

    def inside(distance: float) -> float:
        """Return how far the profile is below its threshold, at a distance in half widths."""
        value = best + side * distance * half
        if not low <= value <= high:
            return -1.0
        return threshold - _rise(calibration, k, value)

    far = 1.0
    while inside(far) > 0.0:
        far *= 2.0
        if far > FARTHEST:
            return side * math.inf
    near = 0.0 if far == 1.0 else 0.5 * far
    # The end is located against its own size too, down to a thousandth of that of the half width.
    while far - near > FINENESS * min(1.0, max(abs(best / half + side * near), FINENESS)):
        middle = 0.5 * (near + far)
        near, far = (middle, far) if inside(middle) > 0.0 else (near, middle)
    return best + side * near * half


def _rise(calibration: Calibration, k: int, value: float) -> float:
    """Return how much the cost rises with one parameter held and the others fitted again."""
    problem = Problem(calibration.model, calibration.readings, calibration.errors)
    problem = problem.without(calibration.excluded)
    # Where the others would be if the model were linear: constants that only their sum is known of
    # must move together, or there is no actuator to start from.
    column = calibration.covariance[:, k] / calibration.covariance[k, k]
    start = calibration.values + (value - calibration.values[k]) * column
    try:
        residuals = problem.solve(start.tolist(), held={k: value}).residuals
    except SpiralError:  # no actuator has this value: infinitely unlikely
        return math.inf
    least = float(np.sum(calibration.residuals[calibration.fitted] ** 2))
    return float(residuals @ residuals) - least
