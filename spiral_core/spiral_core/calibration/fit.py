# SPDX-License-Identifier: Apache-2.0
r"""The fit of a calibration model to readings: minimum, outliers, covariance.

.. math:: \min_x \sum_i \left(\frac{y_i(x) - y_i}{\sigma_i}\right)^2, \qquad
    x_k = \text{value}_k / \text{scale}_k

by scipy's trust-region reflective method. A trial that makes no actuator, or one whose limit lies
below a measured pressure, has no residual: the method then shortens its step.

The stated errors weigh the readings against each other; their common scale s, with
:math:`s^2 = \mathrm{RSS} / (m - p)`, comes from the residuals. The covariance is
:math:`s^2 (J^T J)^{-1}`, an interval :math:`\pm t_{m-p}` standard errors (Student's t), which is
right for few readings too. No scatter is no certainty: where the residuals are too small for the
stated errors (rounded alike, or exact), s = 1 and the normal distribution's quantile are taken.

Outliers are readings that lie farther from the fit to the others than chance allows. A reading is
compared with the fit to the others, in the fit's linearized model:

.. math:: t_i = \frac{r_i - J_i c}{s \sqrt{1 + J_i (J^T J)^{-1} J_i^T}}

with c, J and s of the others only (externally studentized). Up to a third of the readings are
taken away one by one, each time the one with the largest :math:`|t|`; the last that is beyond its
quantile decides how many are outliers, so that two do not hide each other. The level is shared by
all readings (Bonferroni).

Source: B. Rosner, Technometrics 25, 1983, 165-172; R. D. Cook, S. Weisberg, Residuals and
Influence in Regression, 1982, ch. 2; G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989,
ch. 2 and 5.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.actuator.actuator import Actuator
from spiral_core.brief import brief_repr
from spiral_core.calibration.model import (
    CalibrationModel,
    FittedQuantity,
    actuation_of,
    contradictions,
    effective_errors,
    measured_values,
    predict,
    starting_values,
)
from spiral_core.calibration.readings import Reading, ShapeReading
from spiral_core.errors import InvalidInputError, SolverError, SpiralError
from spiral_core.rod.types import Array, Section
from spiral_core.validation import require_in_range
from spiral_core.wrap.gripper import Gripper

# Probability that any of the readings is called an outlier where none is.
FALSE_ALARM = 0.01
# Share of the readings that can be outliers.
SHARE_MAX = 1.0 / 3.0
# Singular values below this part of the largest are combinations that the others do not see.
UNSEEN_BY_OTHERS = 1e-10
# Scatter of fewer degrees of freedom than this judges nothing.
FREEDOM_MIN = 2


# Scatter less probable than this, by the stated errors, is no accident.
IMPROBABLE = 1e-3
# Scatter that is larger than stated by less than this factor is nothing to warn of.
MUCH_LARGER = 2.0


class Scatter(Enum):
    """How readings scatter about a fit; the value is the advice."""

    AS_STATED = "the readings scatter as their stated errors say"
    TOO_LARGE = (
        "far more than the stated errors allow: the law does not describe the readings, some of "
        "them are wrong, or the errors were stated too small; the intervals follow the residuals"
    )
    TOO_SMALL = (
        "far less than the stated errors allow: the errors were stated too large, or the readings "
        "are not independent; the intervals follow the stated errors"
    )


def scatter_of(error_scale: float, degrees_of_freedom: int) -> Scatter:
    """Judge the scale of the errors by the chi-squared distribution.

    Args:
        error_scale: how many times larger than stated the errors are.
        degrees_of_freedom: of that scale, >= 1.

    Example:
        >>> [scatter_of(scale, 10).name for scale in (0.1, 0.5, 1.5, 3.0)]
        ['TOO_SMALL', 'AS_STATED', 'AS_STATED', 'TOO_LARGE']
    """
    from scipy.special import gammainc, gammaincc

    half, squares = 0.5 * degrees_of_freedom, 0.5 * degrees_of_freedom * error_scale**2
    if gammainc(half, squares) < IMPROBABLE:
        return Scatter.TOO_SMALL
    if error_scale > MUCH_LARGER and gammaincc(half, squares) < IMPROBABLE:
        return Scatter.TOO_LARGE
    return Scatter.AS_STATED


def owners_of(readings: Sequence[Reading]) -> NDArray[np.intp]:
    """Return the place of the reading of each component (m,)."""
    counts = [len(reading.measured) for reading in readings]
    return np.repeat(np.arange(len(counts)), counts)


class Studentized(NamedTuple):
    """One reading against the fit to others.

    Attributes:
        ratio: its residual over the error of the difference, in stated errors; the largest of its
            components.
        scale: of the others' errors, over the stated ones.
        freedom: degrees of freedom of that scale.
    """

    ratio: float
    scale: float
    freedom: int

    @property
    def accepted_scale(self) -> float:
        """The scale of the others' errors, or 1 where they scatter improbably little."""
        small = scatter_of(self.scale, max(self.freedom, 1)) is Scatter.TOO_SMALL
        return 1.0 if small else self.scale


def studentized(
    residuals: Array, jacobian: Array, owners: NDArray[np.intp], fitted: NDArray[np.bool_]
) -> dict[int, Studentized]:
    """Return how far each reading is from the fit to the others, by its place.

    Args:
        residuals: (m,) of all components, over the stated errors.
        jacobian: (m, p) their derivatives by the parameters.
        owners: (m,) the reading of each component.
        fitted: (m,) which components are fitted.
    """
    lengths = np.linalg.norm(jacobian[fitted], axis=0)
    columns = jacobian / np.where(lengths > 0.0, lengths, 1.0)
    found = {}
    for one in dict.fromkeys(owners.tolist()):
        others = fitted & (owners != one)
        base, singular, directions = np.linalg.svd(columns[others], full_matrices=False)
        seen = singular > UNSEEN_BY_OTHERS * singular[0]
        parts = base.T[seen] @ residuals[others]
        freedom = int(others.sum() - seen.sum())
        left = residuals[others] - base.T[seen].T @ parts
        scale = float(np.linalg.norm(left)) / math.sqrt(max(freedom, 1))
        turned = columns[owners == one] @ directions[seen].T / singular[seen]
        off = residuals[owners == one] - turned @ parts
        ratios = off / np.sqrt(1.0 + np.sum(turned**2, axis=1))
        found[one] = Studentized(float(max(ratios, key=abs)), scale, freedom)
    return found


def outliers(
    residuals: Array, jacobian: Array, owners: NDArray[np.intp], *, trust_stated: bool
) -> tuple[int, ...]:
    """Return the places of the readings that chance does not explain, the farthest first.

    Args:
        residuals: (m,) of all components, over the stated errors.
        jacobian: (m, p) their derivatives by the parameters.
        owners: (m,) the reading of each component.
        trust_stated: whether the stated errors count, too, where the others do not scatter more.
    """
    from scipy.special import ndtri, stdtrit

    kept = np.ones(len(owners), dtype=bool)
    order: list[int] = []
    found = 0
    for _ in range(int(SHARE_MAX * (len(set(owners.tolist())) - jacobian.shape[1]))):
        tests = studentized(residuals, jacobian, owners, kept)
        far = {one: abs(tests[one].ratio) / tests[one].accepted_scale for one in owners[kept]}
        worst = max(far, key=lambda one: far[one])
        test = tests[worst]
        if test.freedom < FREEDOM_MIN:
            break
        upper = 1.0 - 0.5 * FALSE_ALARM / int(kept.sum())
        by_scatter = float(stdtrit(test.freedom, upper)) * test.scale
        by_stated = float(ndtri(upper)) * max(test.scale, 1.0)
        if test.accepted_scale != test.scale:
            limit = by_stated
        else:
            limit = min(by_scatter, by_stated) if trust_stated else by_scatter
        order.append(worst)
        kept &= owners != worst
        if abs(test.ratio) > limit:
            found = len(order)
    return tuple(order[:found])


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
    ITERATION_LIMIT = "the fit did not converge; fix a constant, or choose a law with fewer"
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
    """

    values: Array
    residuals: Array
    jacobian: Array
    active: tuple[bool, ...]


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
        kept = ~np.isin(owners_of(self.readings), excluded)
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

    def solve(self, start: Sequence[float]) -> Solution:
        """Return the minimum near ``start``.

        Raises:
            SolverError: it was not found.
            SpiralError: the start itself predicts nothing.
        """
        from scipy.optimize import least_squares

        scales = np.array(self.model.scales())
        low, high = np.array(self.model.limits()).T / scales
        begin = np.clip(start / scales, low + DIFFERENCE_STEP, high - DIFFERENCE_STEP)
        self.residuals(begin * scales)  # the start must be an answer: say why if not

        def residuals(x: Array) -> Array:
            return self._residuals_or_nan(x * scales)

        found = least_squares(
            residuals,
            begin,
            jac=partial(difference_jacobian, residuals),
            bounds=(low, high),
            x_scale="jac",
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            gtol=TOLERANCE,
            max_nfev=EVALUATIONS_MAX,
        )
        if found.status <= 0:
            raise SolverError(CalibrationStatus.ITERATION_LIMIT, found.optimality, found.nfev)
        active = np.minimum(found.x - low, high - found.x) < 2.0 * DIFFERENCE_STEP
        jacobian: Array = np.asarray(found.jac)
        _require_stationary(found.fun, jacobian[:, ~active], found.nfev)
        return Solution(found.x * scales, found.fun, jacobian / scales, tuple(active.tolist()))

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


def _require_stationary(residuals: Array, jacobian: Array, evaluations: int) -> None:
    """Raise SolverError if a step of the free scaled parameters would still lower the cost.

    The method also ends where it meets what makes no actuator: then a part of the residuals is
    left that the parameters could remove (the relative offset of Bates and Watts).
    """
    base, singular, _ = np.linalg.svd(jacobian, full_matrices=False)
    parts = base.T @ residuals
    # What would take an endless step to remove is not seen by the readings: no way to go.
    base, parts = (x[..., np.abs(parts) < STEP_MAX * singular] for x in (base, parts))
    removable = float(np.linalg.norm(parts))
    left = float(np.linalg.norm(residuals - base @ parts))
    if removable > max(OFFSET_MAX * left, EXACT * math.sqrt(len(residuals))):
        raise SolverError(CalibrationStatus.STUCK, removable, evaluations)


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
    def stiffness(self) -> Section:
        """EI and GJ: fitted, given, or the fitted material's."""
        return self.model.stiffness_from([float(value) for value in self.values])

    @property
    def fitted(self) -> NDArray[np.bool_]:
        """Which components were fitted (m,), and not left out as outliers."""
        return ~np.isin(owners_of(self.readings), self.excluded)

    @property
    def standardized_residuals(self) -> Array:
        """Distance of each reading from the fit to the others, in standard errors of it (n,).

        Externally studentized; of a point's coordinates the largest. The errors are scaled as the
        others scatter, or as stated if these scatter improbably little.
        """
        tests = studentized(self.residuals, self.jacobian, owners_of(self.readings), self.fitted)
        return np.array([one.ratio / one.accepted_scale for one in tests.values()])

    @property
    def outliers(self) -> tuple[int, ...]:
        """Places of the readings that chance does not explain, the farthest first.

        The readings that a robust fit left out are among them.
        """
        found = outliers(self.residuals, self.jacobian, owners_of(self.readings), trust_stated=True)
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


# Condition index above which regression texts call parameters collinear.
CONDITION_MAX = 30.0
# Effect on all readings together, in standard errors, of changing a combination of parameters by
# their own magnitude, below which they are not fitted but left over.
UNSEEN = 1e-3
# Share of a weak direction below which a parameter is not counted as part of it.
SHARE_MIN = 0.2
# Relative standard error above which a parameter is called undetermined by itself.
RELATIVE_ERROR_MAX = 0.5

_STIFFNESSES = {
    FittedQuantity.BENDING_STIFFNESS.value,
    FittedQuantity.TORSIONAL_STIFFNESS.value,
}


@dataclass(frozen=True, slots=True)
class WeakDirection:
    """A combination of parameters that the readings hardly determine.

    Attributes:
        names: the parameters that take part.
        condition: how many times weaker its effect is than the strongest combination's.
        stretch_min: least stretch among the readings, by the fitted actuator.
        stretch_max: largest stretch among them.
        advice: what to measure, or what to fix.
    """

    __repr__ = brief_repr

    names: tuple[str, ...]
    condition: float
    stretch_min: float
    stretch_max: float
    advice: str

    def __str__(self) -> str:
        return (
            f"{' and '.join(self.names)} cannot be told apart over stretches "
            f"{self.stretch_min:.3f} to {self.stretch_max:.3f} "
            f"(condition index {self.condition:.3g}): {self.advice}"
            if len(self.names) > 1
            else f"{self.names[0]} is not determined: {self.advice}"
        )


def require_seen(calibration: Calibration) -> None:
    """Refuse a fit of parameters on which no reading depends.

    Args:
        calibration: the fit; parameters at their bounds are not looked at.

    Raises:
        InvalidInputError: changing some combination of parameters by their own magnitude moves all
            readings together by less than a thousandth of their error.
    """
    names = [name for name in calibration.names if name not in calibration.at_bound]
    columns = [calibration.index(name) for name in names]
    scales = np.array(calibration.model.scales())[columns] / max(calibration.error_scale, 1.0)
    effects = calibration.jacobian[calibration.fitted][:, columns] * scales
    if not names:
        return
    _, singular, directions = np.linalg.svd(effects, full_matrices=False)
    if singular[-1] >= UNSEEN:
        return
    shares = zip(names, np.abs(directions[-1]), strict=True)
    unseen = tuple(name for name, share in shares if share >= SHARE_MIN)
    pressures = [reading.pressure for reading in calibration.readings]
    raise InvalidInputError(
        "readings",
        f"{len(pressures)} readings from {min(pressures):.6g} Pa to {max(pressures):.6g} Pa",
        f"such that they depend on {' and '.join(unseen)} ({_advice(calibration, unseen)})",
    )


def condition_indices(calibration: Calibration) -> tuple[float, ...]:
    """Return how much weaker each combination of parameters acts than the strongest, from 1 up.

    Ratios of the singular values of the Jacobian, its columns scaled to length one.

    Source: D. A. Belsley, E. Kuh, R. E. Welsch, Regression Diagnostics, 1980, ch. 3.
    """
    singular, _ = _directions(calibration)
    return tuple(float(singular[0] / max(one, np.finfo(np.float64).tiny)) for one in singular)


def weak_directions(calibration: Calibration) -> tuple[WeakDirection, ...]:
    """Return the combinations of parameters that the readings do not determine, the weakest first.

    Empty if all are determined. A weak combination may be harmless: the pressure for a radius may
    not depend on it either, which its uncertainty shows.

    Args:
        calibration: the fit.
    """
    singular, directions = _directions(calibration)
    found: list[WeakDirection] = []
    for value, direction in zip(singular[::-1], directions[::-1], strict=True):
        condition = float(singular[0] / max(value, np.finfo(np.float64).tiny))
        shares = zip(calibration.names, direction, strict=True)
        names = tuple(name for name, share in shares if abs(share) >= SHARE_MIN)
        if condition > CONDITION_MAX:
            found.append(_weak(calibration, names, condition))
    named = {name for weak in found for name in weak.names}
    relative = calibration.standard_errors / np.abs(calibration.values)
    for name, error in zip(calibration.names, relative, strict=True):
        if name not in named and error > RELATIVE_ERROR_MAX:
            found.append(_weak(calibration, (name,), condition_indices(calibration)[-1]))
    return tuple(found)


def _directions(calibration: Calibration) -> tuple[np.ndarray, np.ndarray]:
    """Return singular values and right vectors of the Jacobian with columns of length one."""
    jacobian = calibration.jacobian[calibration.fitted]
    lengths = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / np.where(lengths > 0.0, lengths, 1.0)
    _, singular, directions = np.linalg.svd(scaled, full_matrices=False)
    return singular, directions


def _weak(calibration: Calibration, names: tuple[str, ...], condition: float) -> WeakDirection:
    stretches = [
        calibration.actuation.stretch_from_pressure(reading.pressure)
        for reading in calibration.readings
    ]
    return WeakDirection(
        names, condition, min(stretches), max(stretches), _advice(calibration, names)
    )


def _advice(calibration: Calibration, names: tuple[str, ...]) -> str:
    """Return what would tell these parameters apart."""
    has_shapes = any(isinstance(reading, ShapeReading) for reading in calibration.readings)
    if _STIFFNESSES & set(names):
        if not has_shapes:
            return (
                "only a shape that gravity bends depends on EI and GJ; "
                "measure positions of a long actuator, or leave them to the material"
            )
        return (
            "measure shapes in a second mount, with gravity across the tube, and at low pressure "
            "where the weight bends and twists it most"
        )
    if FittedQuantity.STRAIGHT_FIBER_RADIUS.value in names:
        return (
            "a bend angle sees stretch over radius only; "
            "add the extension of a straight section, or fix straight_fiber_radius"
        )
    if len(names) == 1:
        return "measure at higher pressures and more often, or fix it"
    return (
        "measure to a larger stretch, or a section wound at angles farther from 90 degrees (there "
        "I1 = I2), or fix one of them, or choose a law with fewer constants"
    )


# Rounds in which errors that depend on the model's slope, or the outliers, settle; each changes
# them far less than the one before, and readings do not carry more than two digits of an error.
ROUNDS = 4


def calibrate(
    model: CalibrationModel,
    readings: Sequence[Reading],
    *,
    robust: bool = False,
    start: Sequence[float] | None = None,
) -> Calibration:
    """Return the parameters that meet the readings best, and how sure they are.

    Args:
        model: what is known, and what to fit.
        readings: what was measured; more components than parameters.
        robust: whether to leave out the readings that chance does not explain, at most a third.
        start: values to start from; None takes those of the model's actuator.

    Returns:
        The calibration. :func:`spiral_core.weak_directions` says whether the readings tell the
        parameters apart.

    Raises:
        InvalidInputError: too few readings, readings that go the other way than the actuator can
            (all of a kind, or unless ``robust`` a single one), or unless ``robust`` lie far apart
            at one pressure, readings that do not depend on a parameter, or a reading that needs a
            gripper without one.
        ActuationLimitError: the readings' pressures are past what any start reaches.
        SolverError: the fit did not converge.

    Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, ch. 2 and 5; outliers:
    :mod:`spiral_core.calibration.fit`.

    Example:
        >>> import math
        >>> from spiral_core import FiberAngles, FreeActuation, Actuator, NeoHookean, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=NeoHookean(c1=100.0e3),
        ... )
        >>> section = actuator.without_single_fibers()  # what extension is measured on
        >>> truth = FreeActuation(replace(section, material=NeoHookean(c1=145.0e3)))
        >>> from spiral_core.calibration.readings import ExtensionReading
        >>> readings = [
        ...     ExtensionReading(p, 0.1 * (truth.stretch_from_pressure(p) - 1.0), 0.1, 1.0e-4)
        ...     for p in (20.0e3, 40.0e3, 60.0e3)
        ... ]
        >>> round(calibrate(CalibrationModel(actuator), readings).value("c1"))
        145000
    """
    readings = tuple(readings)
    _require_enough(model, readings)
    try:
        values = starting_values(model, readings) if start is None else tuple(start)
        first = model.trial(values)
    except InvalidInputError as error:
        raise _held_or(error, model) from None
    for one in contradictions(first, readings, robust=robust):
        at = readings[one.places[0]].pressure
        read = " and ".join(f"{value:.6g}" for value in one.values)
        raise InvalidInputError(one.quantity, f"{read} (SI) at {at:.6g} Pa", one.reason)
    errors = effective_errors(first, readings)
    problem = Problem(model, readings, errors)
    try:
        solution = problem.solve(values)
    except SolverError as error:
        raise _held_or(error, model) from None
    weighing = any(reading.pressure_error > 0.0 for reading in readings)
    excluded: tuple[int, ...] = ()
    full = problem
    for _ in range(ROUNDS if weighing or robust else 0):
        trial = model.trial(solution.values.tolist())
        full = replace(problem, errors=effective_errors(trial, readings))
        found = _outliers(full, solution.values) if robust else ()
        settled = not weighing and set(found) == set(excluded)
        excluded = found
        if settled:
            break
        solution = full.without(excluded).solve(solution.values.tolist())
    calibration = _calibration(full, solution, excluded)
    require_seen(calibration)
    return calibration


def _held_or(error: SpiralError, model: CalibrationModel) -> SpiralError:
    """Return why a fit failed: with constants that are held, most likely those."""
    if not model.fixed:
        return error
    held = ", ".join(f"{name} = {value:g}" for name, value in model.fixed.items())
    free = " and ".join(model.names)
    requirement = f"such that some {free} makes a law that meets the readings; leave them free"
    return InvalidInputError("held constants", held, requirement)


def _require_enough(model: CalibrationModel, readings: Sequence[Reading]) -> None:
    """Refuse readings that leave nothing over to judge the errors by."""
    count = len(measured_values(readings))
    if not count > len(model.names):
        names = ", ".join(model.names)
        raise InvalidInputError(
            "readings",
            f"{count} measured values",
            f"at least {len(model.names) + 1}, to fit {names} and judge the errors",
        )
    # Repeats at one pressure tell how they scatter, not another parameter.
    told = {
        (type(one), one.pressure, getattr(one, "arc_length", None)): len(one.measured)
        for one in readings
        if one.pressure > 0.0 or isinstance(one, ShapeReading)
    }
    if not sum(told.values()) >= len(model.names):
        raise InvalidInputError(
            "readings",
            f"{len(told)} different pressures above 0",
            f"made at {len(model.names)} different pressures above 0 at least, or of several "
            f"kinds, to tell {' and '.join(model.names)}",
        )


def _outliers(problem: Problem, values: Array) -> tuple[int, ...]:
    """Return the readings that chance does not explain at a solution."""
    residuals, jacobian = problem.residuals(values), problem.jacobian(values)
    return outliers(residuals, jacobian, owners_of(problem.readings), trust_stated=False)


def _calibration(problem: Problem, solution: Solution, excluded: tuple[int, ...]) -> Calibration:
    """Return the result with its covariance; readings that were left out have residuals too."""
    freedom = len(solution.residuals) - len(solution.values)
    variance = float(solution.residuals @ solution.residuals) / freedom
    small = scatter_of(math.sqrt(variance), freedom) is Scatter.TOO_SMALL
    accepted = 1.0 if small else variance  # by which the stated errors are scaled, squared
    values = solution.values
    active = zip(problem.model.names, solution.active, strict=True)
    return Calibration(
        model=problem.model,
        readings=problem.readings,
        values=values,
        covariance=accepted * inverse_information(solution.jacobian),
        degrees_of_freedom=freedom,
        residuals=problem.residuals(values) if excluded else solution.residuals,
        errors=problem.errors,
        jacobian=problem.jacobian(values) if excluded else solution.jacobian,
        error_scale=math.sqrt(variance),
        at_bound=tuple(name for name, hit in active if hit),
        excluded=excluded,
        actuation=actuation_of(problem.model.actuator_from(values.tolist())),
        gripper=problem.model.trial(values.tolist()).gripper,
    )


def inverse_information(jacobian: Array) -> Array:
    """Return (J^T J)^-1 by singular values of J with its columns scaled to length one.

    A direction that no reading sees at all would divide by zero; the smallest positive float times
    the largest singular value stands in, and shows as an absurdly wide interval.
    """
    lengths = np.linalg.norm(jacobian, axis=0)
    lengths = np.where(lengths > 0.0, lengths, np.finfo(np.float64).tiny ** 0.25)
    _, singular, directions = np.linalg.svd(jacobian / lengths, full_matrices=False)
    floor = np.finfo(np.float64).eps * max(float(singular[0]), 1.0)
    scaled = directions / np.maximum(singular, floor)[:, None]
    inverse: Array = scaled.T @ scaled / np.outer(lengths, lengths)
    return inverse
