# SPDX-License-Identifier: Apache-2.0
r"""Outliers: readings that lie farther from the fit to the others than chance allows.

A reading is compared with the fit to the others, in the fit's linearized model:

.. math:: t_i = \frac{r_i - J_i c}{s \sqrt{1 + J_i (J^T J)^{-1} J_i^T}}

with c, J and s of the others only (externally studentized). Up to a third of the readings are
taken away one by one, each time the one with the largest :math:`|t|`; the last that is beyond its
quantile decides how many are outliers, so that two do not hide each other. The level is shared by
all readings (Bonferroni).

Source: B. Rosner, Technometrics 25, 1983, 165-172; R. D. Cook, S. Weisberg, Residuals and
Influence in Regression, 1982, ch. 2.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spiral_core.rod.types import Array

# Probability that any of the readings is called an outlier where none is.
FALSE_ALARM = 0.01
# Share of the readings that can be outliers.
SHARE_MAX = 1.0 / 3.0
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
    residuals: Array, jacobian: Array, chosen: NDArray[np.bool_], others: NDArray[np.bool_]
) -> Studentized:
    """Return how far one reading is from the fit to other readings.

    Args:
        residuals: (m,) of all components, over the stated errors.
        jacobian: (m, p) their derivatives by the parameters.
        chosen: (m,) which components are the reading's.
        others: (m,) which ones are fitted.
    """
    rows, left = jacobian[others], residuals[others]
    lengths = np.linalg.norm(rows, axis=0)
    base, singular, directions = np.linalg.svd(
        rows / np.where(lengths > 0.0, lengths, 1.0), full_matrices=False
    )
    seen = singular > 1e-10 * max(float(singular[0]), 1.0)
    freedom = len(left) - int(seen.sum())
    parts = base.T[seen] @ left
    scale = float(np.sqrt(np.sum((left - base.T[seen].T @ parts) ** 2) / max(freedom, 1)))
    turned = (jacobian[chosen] / np.where(lengths > 0.0, lengths, 1.0)) @ directions[seen].T
    turned = turned / singular[seen]
    off = residuals[chosen] - turned @ parts
    ratios = off / np.sqrt(1.0 + np.sum(turned**2, axis=1))
    return Studentized(float(ratios[np.argmax(np.abs(ratios))]), scale, freedom)


def deleted(
    residuals: Array, jacobian: Array, owners: NDArray[np.intp], fitted: NDArray[np.bool_]
) -> list[Studentized]:
    """Return how far each reading is from the fit to the others.

    Args:
        residuals: (m,) of all components, over the stated errors.
        jacobian: (m, p) their derivatives by the parameters.
        owners: (m,) the reading of each component.
        fitted: (m,) which components are fitted.
    """
    return [
        studentized(residuals, jacobian, owners == one, fitted & (owners != one))
        for one in dict.fromkeys(owners.tolist())
    ]


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
        left = dict.fromkeys(owners[kept].tolist())
        named = {
            one: studentized(residuals, jacobian, owners == one, kept & (owners != one))
            for one in left
        }
        worst = max(named, key=lambda one: abs(named[one].ratio) / named[one].accepted_scale)
        test = named[worst]
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
