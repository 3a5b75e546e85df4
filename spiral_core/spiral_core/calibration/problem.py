# SPDX-License-Identifier: Apache-2.0
r"""The nonlinear least-squares problem of a calibration, in scaled parameters.

.. math:: \min_x \sum_i \left(\frac{y_i(x) - y_i}{\sigma_i}\right)^2, \qquad
    x_k = \text{value}_k / \text{scale}_k

by scipy's trust-region reflective method. A trial that makes no actuator, or one whose limit lies
below a measured pressure, has no residual: the method then shortens its step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import partial

import numpy as np

from spiral_core.calibration.model import CalibrationModel
from spiral_core.calibration.predict import measured_values, predict
from spiral_core.calibration.readings import Reading
from spiral_core.errors import SolverError, SpiralError
from spiral_core.rod.types import Array

# Step of the central differences in scaled parameters: their error is its square, 1e-8, while a
# rod's tolerance of 1e-8 L shows as 1e-4 of a derivative, which costs no more than an iteration.
DIFFERENCE_STEP = 1e-4
# Relative change of the cost or the parameters at which the fit ends: far below any standard error,
# as the method converges quadratically there.
TOLERANCE = 1e-8
EVALUATIONS_MAX = 200
# Share of the residuals that parameters could still remove when the fit counts as done: a hundredth
# moves them by a hundredth of a standard error.
OFFSET_MAX = 1e-2
# Steps of more than this many magnitudes of the parameters lead nowhere.
STEP_MAX = 1e3
# Residuals of this size, in standard errors, are rounding: the readings are met exactly.
EXACT = 1e-5


class CalibrationStatus(Enum):
    """How a fit ended; the value is advice to the user. Only ``CONVERGED`` is an answer."""

    CONVERGED = "the fit converged"
    ITERATION_LIMIT = (
        "the fit did not converge; fix a constant, choose a law with fewer, or give bounds"
    )
    STUCK = (
        "the fit ran into values that make no actuator up to the measured pressures; "
        "check the readings' units and the actuator's dimensions, or choose another law"
    )


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """A minimum of the problem.

    Attributes:
        values: parameters (p,) in their own units.
        residuals: (m,) weighted residuals there.
        jacobian: (m, p) derivatives of the residuals by the parameters, in their own units.
        active: (p,) whether a parameter ended at one of its bounds.
        evaluations: how many trials were made.
    """

    values: Array
    residuals: Array
    jacobian: Array
    active: tuple[bool, ...]
    evaluations: int


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Readings to be met by a model.

    Attributes:
        model: what is fitted.
        readings: what was measured.
        errors: (m,) standard error of each component.
    """

    model: CalibrationModel
    readings: tuple[Reading, ...]
    errors: Array

    def without(self, excluded: Sequence[int]) -> Problem:
        """Return the problem without some readings, by their places."""
        counts = [len(reading.measured) for reading in self.readings]
        kept = np.repeat([k not in excluded for k in range(len(counts))], counts)
        readings = tuple(one for k, one in enumerate(self.readings) if k not in excluded)
        return Problem(self.model, readings, self.errors[kept])

    def residuals(self, values: Array) -> Array:
        """Return (m,) predicted minus measured over the error.

        Args:
            values: parameters (p,) in their own units.

        Raises:
            SpiralError: these values predict nothing at some measured pressure.
        """
        trial = self.model.trial(values.tolist())
        residuals: Array = (
            predict(trial, self.readings) - measured_values(self.readings)
        ) / self.errors
        return residuals

    def solve(self, start: Sequence[float], held: Mapping[int, float] | None = None) -> Solution:
        """Return the minimum near ``start``, with the parameters in ``held`` kept at a value.

        Raises:
            SolverError: it was not found.
            SpiralError: the start itself predicts nothing.
        """
        from scipy.optimize import least_squares

        split = self._split(start, held or {})
        begin = split.values(split.begin)
        residuals = self.residuals(begin)  # the start must be an answer: say why if not
        if not split.free:
            return Solution(begin, residuals, np.empty((len(residuals), 0)), (), 1)

        def residuals_of(x: Array) -> Array:
            return self._residuals_or_nan(split.values(x))

        found = least_squares(
            residuals_of,
            split.begin,
            jac=partial(self._jacobian, split),
            bounds=(split.low, split.high),
            x_scale="jac",
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            gtol=TOLERANCE,
            max_nfev=EVALUATIONS_MAX,
        )
        if found.status <= 0:
            raise SolverError(CalibrationStatus.ITERATION_LIMIT, found.optimality, found.nfev)
        solution = self._solution(split, found.x, found.nfev)
        self._require_stationary(solution, split.free)
        return solution

    def _split(self, start: Sequence[float], held: Mapping[int, float]) -> _Split:
        """Return which parameters are free, where they start and what bounds them."""
        scales = np.array(self.model.scales())
        free = [k for k in range(len(scales)) if k not in held]
        base = np.array([held.get(k, value) for k, value in enumerate(start)]) / scales
        low, high = np.array(self.model.limits()).T[:, free] / scales[free]
        return _Split(scales, base, free, low, high)

    def _solution(self, split: _Split, x: Array, evaluations: int) -> Solution:
        """Return a solution from the free scaled parameters."""
        inside = np.minimum(x - split.low, split.high - x) >= 2.0 * DIFFERENCE_STEP
        jacobian = self._jacobian(split, x) / split.scales[split.free]
        active = dict(zip(split.free, ~inside, strict=True))
        return Solution(
            split.values(x),
            self.residuals(split.values(x)),
            jacobian,
            tuple(bool(active.get(k, False)) for k in range(len(split.scales))),
            evaluations,
        )

    def _require_stationary(self, solution: Solution, free: Sequence[int]) -> None:
        """Raise SolverError if a step within the bounds would still lower the cost.

        The method also ends where it meets what makes no actuator: then a part of the residuals
        is left that the parameters could remove (the relative offset of Bates and Watts).
        """
        residuals = solution.residuals
        moving = [k for k in free if not solution.active[k]]
        columns = solution.jacobian[:, [free.index(k) for k in moving]]
        scaled = columns * np.array(self.model.scales())[moving]
        base, singular, _ = np.linalg.svd(scaled, full_matrices=False)
        parts = base.T @ residuals
        # What would take an endless step to remove is not seen by the readings: no way to go.
        base, parts = (x[..., np.abs(parts) < STEP_MAX * singular] for x in (base, parts))
        removable = float(np.linalg.norm(parts))
        left = float(np.linalg.norm(residuals - base @ parts))
        if removable > max(OFFSET_MAX * left, EXACT * math.sqrt(len(residuals))):
            raise SolverError(CalibrationStatus.STUCK, removable, solution.evaluations)

    def jacobian(self, values: Array) -> Array:
        """Return (m, p) derivatives of the residuals by the parameters, in their own units."""
        scales = np.array(self.model.scales())
        jacobian: Array = (
            difference_jacobian(lambda x: self._residuals_or_nan(x * scales), values / scales)
            / scales
        )
        return jacobian

    def _residuals_or_nan(self, values: Array) -> Array:
        """Return the residuals, or NaN throughout where there are none: the step is shortened."""
        try:
            return self.residuals(values)
        except SpiralError:
            return np.full(len(self.errors), np.nan)

    def _jacobian(self, split: _Split, x: Array) -> Array:
        """Return (m, free) derivatives by the free scaled parameters."""
        return difference_jacobian(lambda y: self._residuals_or_nan(split.values(y)), x)


@dataclass(frozen=True, slots=True, eq=False)
class _Split:
    """Parameters in free ones, scaled, and held ones.

    Attributes:
        scales: magnitude of each parameter (p,).
        base: scaled values of all (p,), of which only the held ones stay.
        free: places of the free ones.
        low: their lower bounds, scaled.
        high: their upper bounds, scaled.
    """

    scales: Array
    base: Array
    free: list[int]
    low: Array
    high: Array

    @property
    def begin(self) -> Array:
        """Free scaled parameters to start from, a step inside of their bounds."""
        begin: Array = np.clip(
            self.base[self.free], self.low + DIFFERENCE_STEP, self.high - DIFFERENCE_STEP
        )
        return begin

    def values(self, x: Array) -> Array:
        """Return all parameters (p,) in their own units from the free scaled ones."""
        scaled: Array = self.base.copy()
        scaled[self.free] = x
        return scaled * self.scales


def difference_jacobian(function: Callable[[Array], Array], at: Array) -> Array:
    """Return (m, p) central differences of a function; one-sided where one side has none.

    Args:
        function: from (p,) of magnitude 1 to (m,), NaN throughout where it has no value.
        at: where to differentiate (p,).

    Raises:
        SolverError: the function has a value on neither side.
    """
    columns = [_difference(function, at, step) for step in DIFFERENCE_STEP * np.eye(len(at))]
    return np.column_stack(columns)


def _difference(function: Callable[[Array], Array], at: Array, step: Array) -> Array:
    """Return the derivative of a function along one step, over the step's length."""
    known: list[tuple[float, Array]] = []
    for sign in (1.0, -1.0, 0.0):
        if len(known) < 2:
            values = function(at + sign * step)
            known += [(sign, values)] if np.isfinite(values).all() else []
    if len(known) < 2:
        raise SolverError(CalibrationStatus.STUCK, math.inf, 1)
    (sign, values), (other_sign, other_values) = known
    return (values - other_values) / ((sign - other_sign) * DIFFERENCE_STEP)
