# SPDX-License-Identifier: Apache-2.0
"""A calibration as a table of fields."""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING

from spiral_core import FittedQuantity
from spiral_core.calibration.regression import Interval
from spiral_gripper.files.fields import CONSTANTS, FIELDS
from spiral_gripper.files.shown import shown, shown_message
from spiral_gripper.reports.fields import Field, Json, Rows, data

if TYPE_CHECKING:
    from spiral_gripper.bench.run import CalibrationResult

# Fields of a gripper's file that a fit determines, by the quantity's name.
FIELD_OF_QUANTITY = {
    **{name: f"material.{name}" for name in CONSTANTS},
    FittedQuantity.BENDING_STIFFNESS.value: "stiffness.bending",
    FittedQuantity.TORSIONAL_STIFFNESS.value: "stiffness.torsional",
    FittedQuantity.STRAIGHT_FIBER_RADIUS.value: "fibers.straight_fiber_radius",
}
# A limit of pressure past this many times the readings' is no figure of the actuator.
_BEYOND_READINGS = 10.0


def interval_text(
    value: float, interval: Interval, unit: str, level: float, digits: int = 4
) -> str:
    """Return a figure in SI with its interval, in the unit that is shown.

    Example:
        >>> from spiral_core.calibration.regression import Interval
        >>> interval_text(47.2e3, Interval(45.3e3, 49.1e3), "Pa", 0.95)
        '47.2 kPa, 95 % interval 45.3 to 49.1 kPa'
        >>> interval_text(0.096, Interval(0.09, 0.102), "N m^2", 0.95)  # the longest ones in SI
        '96000 N mm^2, 95 % interval 90000 N mm^2 to 0.102 N m^2'
    """
    low, high = (shown(end, unit, digits) for end in interval)
    low = low.removesuffix("".join(high.partition(" ")[1:]))
    return f"{shown(value, unit, digits)}, {100.0 * level:.4g} % interval {low} to {high}"


def radius_rows(result: CalibrationResult) -> Rows:
    """Return the pressure that wraps each radius with its uncertainty."""
    rows = []
    for one in result.pressures:
        text = interval_text(one.pressure, one.interval, "Pa", result.level)
        failed = f" ({one.failed_draws:.0%} of draws cannot grip it)" if one.failed_draws else ""
        rows.append((shown(one.radius, "m"), f"wrapped from {text}{failed}"))
    return rows


def _values(result: CalibrationResult) -> Json:
    best = result.choice.best
    return {
        name: {
            "value": best.value(name),
            "standard_error": best.standard_errors[best.index(name)],
            "interval": best.interval(name, result.level),
        }
        for name in best.names
    }


def _value_rows(result: CalibrationResult) -> Rows:
    rows = []
    for name, one in _values(result).items():
        dimension = FIELDS[FIELD_OF_QUANTITY[name]].dimension
        unit = "1" if dimension is None else dimension.si_unit
        rows.append((name, interval_text(one["value"], one["interval"], unit, result.level, 5)))
    return rows


def _correlation_rows(result: CalibrationResult) -> Rows:
    best = result.choice.best
    pairs = combinations(enumerate(best.names), 2)
    return [
        (f"correlation of {first} and {second}", f"{best.correlation[i, k]:+.4f}")
        for (i, first), (k, second) in pairs
    ]


def _stable(result: CalibrationResult) -> Rows:
    """Return how far the fitted actuator can be used; no pressure is stated far past the data."""
    best = result.choice.best
    actuation = best.actuation
    limit = actuation.pressure_limit
    reason = f"stretch {actuation.stretch_limit:.4f}: {actuation.limit.value}"
    if limit > _BEYOND_READINGS * max(reading.pressure for reading in best.readings):
        near = "at all pressures near the readings; far above them it ends at"
        return [("stable", f"{near} {reason}")]
    return [("stable up to", f"{shown(limit, 'Pa')}, {reason}")]


def _left_out(result: CalibrationResult) -> str | None:
    found = result.cross_validation
    if found is None:
        return None
    text = f"{found.error_scale:.3g} times the stated errors (rms)"
    text += f", {found.share_of_largest:.2%} of the largest reading"
    missed = ", ".join(shown(pressure, "Pa") for pressure in found.not_predicted)
    return f"{text}; not predicted: {missed}" if missed else text


def _laws(result: CalibrationResult) -> list[Json]:
    choice = result.choice
    return [
        {
            "law": one.model.fitted_law.__name__,
            "aicc": one.information_criterion,
            "bic": one.bayesian_criterion,
            "weight": weight,
        }
        for one, weight in zip(choice.calibrations, choice.weights, strict=True)
    ]


def _compared(result: CalibrationResult) -> Rows:
    """Return a row for each law that was compared; none if there was only one."""
    laws, failures = _laws(result), result.choice.failures
    if len(laws) + len(failures) < 2:
        return []
    rows = [("laws compared (lower AICc is better)", "")]
    for one in laws:
        few = math.isinf(one["aicc"])
        criterion = "too few readings" if few else f"{one['aicc']:.2f}"
        text = f"AICc {criterion}, weight {one['weight']:.2f}, BIC {one['bic']:.2f}"
        rows.append((f"  {one['law']}", text))
    return rows + [
        (f"  {name}", f"not fitted: {shown_message(reason)}") for name, reason in failures
    ]


CALIBRATION = (
    Field("law", "law", "choice.best.model.fitted_law.__name__", "{}"),
    Field("readings", "readings", lambda r: len(r.choice.best.readings), lambda r: (
        f"{len(r.choice.best.readings)}, degrees of freedom: {r.choice.best.degrees_of_freedom}"
    )),
    *data(degrees_of_freedom="choice.best.degrees_of_freedom", level="level"),
    Field("values", "", _values, _value_rows),
    Field("correlation", "", "choice.best.correlation", _correlation_rows),
    Field("error_scale", "residuals", "choice.best.error_scale",
          "{:.3g} times the stated errors"),
    *data(
        standardized_residuals="choice.best.standardized_residuals",
        outliers="choice.best.outliers",
        left_out="choice.best.excluded",
    ),
    Field("pressure_limit", "", "choice.best.actuation.pressure_limit", _stable),
    Field("stretch_limit", "", "choice.best.actuation.stretch_limit"),
    Field("leave_one_out_error", "leave-one-out error", lambda r: (
        r.cross_validation and r.cross_validation.error
    ), _left_out),
    Field("laws", "", _laws, _compared),
    *data(
        failures=lambda r: [{"law": law, "reason": reason} for law, reason in r.choice.failures],
        warnings="warnings",
        pressures="pressures",
    ),
)  # fmt: skip
