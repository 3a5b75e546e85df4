"""Whether logged grips have drifted from the model, and which correction they suggest.

A log pairs an object's radius with the pressure at which contact was seen. Its deviation from the
model's pressure is either a factor (the elastomer has softened or stiffened: every constant scales)
or an offset (the sensor's zero has moved). This module suggests; it changes nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from spiral_core.calibration.result import DEFAULT_LEVEL, Interval, student_quantile
from spiral_core.errors import InvalidInputError, NotGrippableError
from spiral_core.rod.types import Array
from spiral_core.validation import require_positive
from spiral_core.wrap.curve import WrapCurve

# With fewer grips one outlier would decide; Student's quantile for one degree of freedom is 12.7.
RECORDS_MIN = 4


@dataclass(frozen=True, slots=True)
class GripRecord:
    """One logged grip.

    Args:
        object_radius: radius of the object [m], > 0.
        pressure: gauge pressure at which contact was seen [Pa], > 0.

    Raises:
        InvalidInputError: a value is not positive and finite.
    """

    object_radius: float
    pressure: float

    def __post_init__(self) -> None:
        require_positive("object_radius", self.object_radius)
        require_positive("pressure", self.pressure)


class DriftKind(Enum):
    """What kind of deviation the log shows; the value tells what may be behind it."""

    NONE = "the log agrees with the model: no correction"
    FACTOR = (
        "pressures deviate by a common factor: the elastomer has softened (below 1) or stiffened "
        "(above 1); calibrate again, or multiply every pressure constant by the factor"
    )
    OFFSET = (
        "pressures deviate by a common amount: check the zero of the pressure sensor, then "
        "subtract the offset from what it reads"
    )


@dataclass(frozen=True, slots=True)
class DriftSuggestion:
    """What a log of grips suggests; nothing has been changed.

    Attributes:
        kind: which correction fits best, or none.
        correction: the factor, the offset [Pa], or 0 for none.
        interval: its confidence interval.
        scatter_before: root mean square of logged minus modeled pressure [Pa].
        scatter_after: the same with the correction.
        not_grippable: radii in the log that the model says cannot be gripped [m]; not used.
    """

    kind: DriftKind
    correction: float
    interval: Interval
    scatter_before: float
    scatter_after: float
    not_grippable: tuple[float, ...]

    def __str__(self) -> str:
        if self.kind is DriftKind.NONE:
            return str(self.kind.value)
        low, high = self.interval
        return f"{self.correction:.6g} ({low:.6g} to {high:.6g}): {self.kind.value}"


def suggest_drift_correction(
    curve: WrapCurve, records: Sequence[GripRecord], level: float = DEFAULT_LEVEL
) -> DriftSuggestion:
    r"""Return the correction that logged grips suggest, if any.

    Both corrections have one parameter, fitted by least squares to the logged pressures
    :math:`P_i` and the model's :math:`\hat P_i`: :math:`P_i = f \hat P_i` and
    :math:`P_i = \hat P_i + b`. The better of the two is suggested if its interval excludes no
    correction (f = 1, b = 0). As the better of two is looked at, half the doubt is left to each
    (Bonferroni): a log without drift is found to drift in at most ``1 - level`` of cases.

    Args:
        curve: the model's pressures.
        records: the log, at least four grips that the model allows.
        level: confidence level, in (0, 1).

    Raises:
        InvalidInputError: too few records, or ``level`` is not in (0, 1).
        SolverError: a shape could not be certified.
    """
    logged, modeled, refused = _pairs(curve, records)
    if len(logged) < RECORDS_MIN:
        raise InvalidInputError(
            "records", f"{len(logged)} grips in the model's range", f"at least {RECORDS_MIN}"
        )
    quantile = student_quantile(0.5 * (1.0 + level), len(logged) - 1)
    before = _root_mean_square(logged - modeled)
    factor = float(logged @ modeled / (modeled @ modeled))
    offset = float(np.mean(logged - modeled))
    by_factor, by_offset = logged - factor * modeled, logged - modeled - offset
    if by_factor @ by_factor <= by_offset @ by_offset:
        left, kind, value, neutral = by_factor, DriftKind.FACTOR, factor, 1.0
        information = float(modeled @ modeled)
    else:
        left, kind, value, neutral = by_offset, DriftKind.OFFSET, offset, 0.0
        information = float(len(logged))
    error = float(np.sqrt(left @ left / (len(logged) - 1) / information))
    interval = Interval(value - quantile * error, value + quantile * error)
    if interval.low <= neutral <= interval.high:
        return DriftSuggestion(
            DriftKind.NONE, 0.0, Interval(0.0, 0.0), before, before, tuple(refused)
        )
    return DriftSuggestion(kind, value, interval, before, _root_mean_square(left), tuple(refused))


def _pairs(curve: WrapCurve, records: Sequence[GripRecord]) -> tuple[Array, Array, list[float]]:
    """Return logged and modeled pressures [Pa], and the radii that the model refuses [m]."""
    logged, modeled, refused = [], [], []
    for record in records:
        try:
            modeled.append(curve.pressure_from_radius(record.object_radius))
        except NotGrippableError:
            refused.append(record.object_radius)
            continue
        logged.append(record.pressure)
    return np.array(logged), np.array(modeled), refused


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
