# SPDX-License-Identifier: Apache-2.0
r"""Statistics of a least-squares fit: covariance, intervals, scatter, outliers.

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
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError, SpiralError
from spiral_core.rod.types import Array
from spiral_core.validation import require_in_range

DEFAULT_LEVEL = 0.95
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


def _accepted(error_scale: float, degrees_of_freedom: int) -> float:
    """Return the scale of the errors, or 1 where they scatter improbably little."""
    scatter = scatter_of(error_scale, max(degrees_of_freedom, 1))
    return 1.0 if scatter is Scatter.TOO_SMALL else error_scale


class Interval(NamedTuple):
    """A confidence interval, in the unit of what it is for."""

    low: float
    high: float


@dataclass(frozen=True, slots=True, eq=False, repr=False, kw_only=True)
class Fit:
    """Fitted parameters with their covariance and residuals.

    Attributes:
        names: of the parameters.
        values: (p,) the parameters, in SI units.
        covariance: (p, p) of the values.
        residuals: (m,) predicted minus measured, over the stated error of each component.
        degrees_of_freedom: fitted components minus parameters.
        error_scale: how many times larger than stated the errors are, judged by the residuals.
        at_bound: names of parameters that ended at a bound; their intervals mean little.
    """

    __repr__ = brief_repr

    names: tuple[str, ...]
    values: Array
    covariance: Array
    residuals: Array
    degrees_of_freedom: int
    error_scale: float
    at_bound: tuple[str, ...]

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

    def index(self, name: str) -> int:
        """Return the place of a parameter in the arrays.

        Raises:
            InvalidInputError: there is no such parameter.
        """
        if name not in self.names:
            raise InvalidInputError("name", name, f"one of {', '.join(self.names)}")
        return self.names.index(name)

    def value(self, name: str) -> float:
        """Return one parameter by its name.

        Raises:
            InvalidInputError: there is no such parameter.
        """
        return float(self.values[self.index(name)])

    def interval_factor(self, level: float = DEFAULT_LEVEL) -> float:
        """Return how many standard errors an interval reaches to either side.

        Args:
            level: confidence level, in (0, 1).

        Raises:
            InvalidInputError: ``level`` is not between 0 and 1.
        """
        from scipy.special import ndtri, stdtrit

        if not 0.0 < require_in_range("level", level, 0.0, 1.0) < 1.0:
            raise InvalidInputError("level", level, "between 0 and 1, both excluded")
        below = 0.5 + 0.5 * level
        if self.scatter is Scatter.TOO_SMALL:
            return float(ndtri(below))
        return float(stdtrit(self.degrees_of_freedom, below))

    def interval(self, name: str, level: float = DEFAULT_LEVEL) -> Interval:
        """Return the confidence interval of one parameter, from Student's t.

        Args:
            name: of the parameter.
            level: share of repeated bench tests whose interval holds the true value, in (0, 1).

        Raises:
            InvalidInputError: there is no such parameter, or ``level`` is not between 0 and 1.
        """
        value = self.value(name)
        half = self.interval_factor(level) * float(self.standard_errors[self.index(name)])
        return Interval(value - half, value + half)


def covariance_and_scale(residuals: Array, jacobian: Array) -> tuple[Array, float]:
    """Return the parameters' covariance (p, p) at a minimum, and the scale of the errors.

    A direction that no reading sees at all would divide by zero; the rounding error of the largest
    singular value stands in, and shows as an absurdly wide interval.

    Args:
        residuals: (m,) over the stated errors.
        jacobian: (m, p) their derivatives by the parameters.
    """
    freedom = len(residuals) - jacobian.shape[1]
    scale = math.sqrt(float(residuals @ residuals) / freedom)
    lengths = np.linalg.norm(jacobian, axis=0)
    lengths = np.where(lengths > 0.0, lengths, np.finfo(np.float64).tiny ** 0.25)
    _, singular, directions = np.linalg.svd(jacobian / lengths, full_matrices=False)
    floor = np.finfo(np.float64).eps * max(float(singular[0]), 1.0)
    scaled = directions / np.maximum(singular, floor)[:, None] / lengths
    return _accepted(scale, freedom) ** 2 * scaled.T @ scaled, scale


def slope(function: Callable[[Array], Array], at: Array, step: Array) -> Array | None:
    """Return the change of a function per step: of both sides, or of one where one has no value.

    Args:
        function: raises SpiralError where it has no value.
        at: where to differentiate.
        step: to either side.

    Returns:
        The difference quotient; None where at most one of the three points has a value.
    """
    known: list[tuple[float, Array]] = []
    for sign in (1.0, -1.0, 0.0):
        with suppress(SpiralError):
            known.append((sign, function(at + sign * step)))
        if len(known) == 2:
            (one, there), (other, here) = known
            quotient: Array = (there - here) / (one - other)
            return quotient
    return None


class Studentized(NamedTuple):
    """One reading against the fit to others.

    Attributes:
        ratio: its residual over the error of the difference, in stated errors; the largest of its
            components.
        scale: of the others' errors, over the stated ones.
        freedom: degrees of freedom of that scale.
        accepted: that scale, or 1 where they scatter improbably little.
    """

    ratio: float
    scale: float
    freedom: int
    accepted: float


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
    for place in dict.fromkeys(owners.tolist()):
        own = owners == place
        others = fitted & ~own
        base, singular, directions = np.linalg.svd(columns[others], full_matrices=False)
        seen = singular > UNSEEN_BY_OTHERS * singular.max(initial=0.0)
        base, turned = base[:, seen], columns[own] @ directions[seen].T / singular[seen]
        parts = base.T @ residuals[others]
        freedom = int(others.sum() - seen.sum())
        scale = float(np.linalg.norm(residuals[others] - base @ parts))
        scale /= math.sqrt(max(freedom, 1))
        ratios = (residuals[own] - turned @ parts) / np.sqrt(1.0 + np.sum(turned**2, axis=1))
        ratio = float(max(ratios, key=abs))
        found[place] = Studentized(ratio, scale, freedom, _accepted(scale, freedom))
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
        worst = max(owners[kept], key=lambda k: abs(tests[k].ratio) / tests[k].accepted)
        test = tests[worst]
        if test.freedom < FREEDOM_MIN:
            break
        upper = 1.0 - 0.5 * FALSE_ALARM / int(kept.sum())
        by_scatter = float(stdtrit(test.freedom, upper)) * test.scale
        by_stated = float(ndtri(upper)) * max(test.scale, 1.0)
        limit = min(by_scatter, by_stated) if trust_stated else by_scatter
        if test.accepted != test.scale:
            limit = by_stated
        order.append(int(worst))
        kept &= owners != worst
        if abs(test.ratio) > limit:
            found = len(order)
    return tuple(order[:found])
