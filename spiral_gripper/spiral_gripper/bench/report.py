# SPDX-License-Identifier: Apache-2.0
"""The report on a calibration: lines of text, in the units shown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from spiral_core import (
    Calibration,
    CrossValidation,
    FittedQuantity,
    LawChoice,
    RadiusPressure,
    Reading,
    weak_directions,
)
from spiral_core.calibration.regression import Scatter
from spiral_gripper.bench.measurements import Measurements
from spiral_gripper.files.shown import number, shown, shown_message

_UNIT_OF_QUANTITY = {
    FittedQuantity.BENDING_STIFFNESS.value: "N m^2",
    FittedQuantity.TORSIONAL_STIFFNESS.value: "N m^2",
    FittedQuantity.STRAIGHT_FIBER_RADIUS.value: "m",
    "extension_limit": "1",
}
# A limit of pressure past this many times the readings' is no figure of the actuator.
_BEYOND_READINGS = 10.0


def report_lines(
    choice: LawChoice, level: float, cross_validation: CrossValidation | None
) -> list[str]:
    """Return the report on the best fit of a choice, and how the other laws compare.

    Args:
        choice: the fits.
        level: confidence level of the intervals, in (0, 1).
        cross_validation: leave-one-out errors of the best fit, if they were asked for.
    """
    best = choice.best
    lines = [
        f"law: {best.model.fitted_law.__name__}",
        f"readings: {len(best.readings)}, degrees of freedom: {best.degrees_of_freedom}",
        *_value_lines(best, level),
        *_correlation_lines(best),
        f"residuals: {best.error_scale:.3g} times the stated errors",
        _stability_line(best),
    ]
    if cross_validation is not None:
        lines.append(_cross_validation_line(cross_validation))
    return lines + _comparison_lines(choice)


def warnings_of(calibration: Calibration) -> list[str]:
    """Return the reasons to doubt a fit, a sentence each."""
    found = [str(weak) for weak in weak_directions(calibration)]
    found += [f"{name} ended at its bound" for name in calibration.at_bound]
    if calibration.scatter is not Scatter.AS_STATED:
        scale = f"the residuals are {calibration.error_scale:.3g} times the stated errors"
        found.append(f"{scale}, {calibration.scatter.value}")
    return found


def outlier_warnings(calibration: Calibration, measurements: Sequence[Measurements]) -> list[str]:
    """Return a warning for each reading that chance does not explain, with its file and line."""
    places = _places(measurements)
    off = calibration.standardized_residuals
    return [
        f"{places[k]}: the reading at {shown(calibration.readings[k].pressure, 'Pa')} is "
        f"{abs(off[k]):.1f} standard errors off the fit to the others, more than chance allows; "
        + (
            "--robust left it out"
            if k in calibration.excluded
            else "check it, or leave it out with --robust"
        )
        for k in calibration.outliers
    ]


def copy_warnings(measurements: Sequence[Measurements]) -> list[str]:
    """Return a warning that names the rows that are copies of others, if there are any."""
    first: dict[Reading, str] = {}
    copies: list[str] = []
    readings = [reading for one in measurements for reading in one.readings]
    for place, reading in zip(_places(measurements), readings, strict=True):
        if reading in first and reading.pressure > 0.0:
            copies.append(f"{place} (of {first[reading]})")
        first.setdefault(reading, place)
    if not copies:
        return []
    return [
        f"copies of other readings: {', '.join(copies)}; they narrow the intervals: leave them out"
    ]


def rival_warnings(results: Sequence[RadiusPressure]) -> list[str]:
    """Return a warning for each law that the readings allow, and that predicts otherwise."""
    found = []
    for one in results:
        for rival in one.rivals:
            if one.own_interval.low <= rival.pressure <= one.own_interval.high:
                continue
            other = (
                f"predicts {shown(rival.pressure, 'Pa')}"
                if math.isfinite(rival.pressure)
                else "cannot grip it"
            )
            found.append(
                f"{shown(one.radius, 'm')}: the readings do not tell the fitted law from "
                f"{rival.law}, which {other}, not {shown(one.pressure, 'Pa')}; the interval covers "
                "both. Measure "
                "what tells them apart, such as the radius that a pressure wraps (object_radius)"
            )
    return found


def _places(measurements: Sequence[Measurements]) -> list[str]:
    """Return file and line of each reading."""
    return [f"{one.source}:{line}" for one in measurements for line in one.lines]


def radius_lines(results: Sequence[RadiusPressure], level: float) -> list[str]:
    """Return the pressure for each radius with its uncertainty.

    Example:
        >>> from spiral_core import Interval
        >>> result = RadiusPressure(0.021, 47.2e3, 0.9e3, *[Interval(45.3e3, 49.1e3)] * 2)
        >>> radius_lines([result], 0.95)
        ['21 mm: 47.2 kPa, 95 % interval 45.3 to 49.1 kPa']
    """
    lines = []
    for one in results:
        low, high = number(one.interval.low, "Pa"), shown(one.interval.high, "Pa")
        failed = f" ({one.failed_draws:.0%} of draws cannot grip it)" if one.failed_draws else ""
        lines.append(
            f"{shown(one.radius, 'm')}: {shown(one.pressure, 'Pa')}, "
            f"{100.0 * level:.4g} % interval {low} to {high}{failed}"
        )
    return lines


def calibration_as_dict(
    choice: LawChoice, level: float, cross_validation: CrossValidation | None
) -> dict[str, Any]:
    """Return the report on the best fit for programs, in SI."""
    best = choice.best
    values = {
        name: {
            "value": best.value(name),
            "standard_error": float(best.standard_errors[best.index(name)]),
            "interval": list(best.interval(name, level)),
        }
        for name in best.names
    }
    fits = zip(choice.calibrations, choice.weights, strict=True)
    return {
        "law": best.model.fitted_law.__name__,
        "readings": len(best.readings),
        "degrees_of_freedom": best.degrees_of_freedom,
        "level": level,
        "values": values,
        "correlation": best.correlation.tolist(),
        "error_scale": best.error_scale,
        "standardized_residuals": best.standardized_residuals.tolist(),
        "outliers": list(best.outliers),
        "left_out": list(best.excluded),
        "pressure_limit": best.actuation.pressure_limit,
        "stretch_limit": best.actuation.stretch_limit,
        "leave_one_out_error": None if cross_validation is None else cross_validation.error,
        "laws": [
            {
                "law": one.model.fitted_law.__name__,
                "aicc": one.information_criterion,
                "bic": one.bayesian_criterion,
                "weight": weight,
            }
            for one, weight in fits
        ],
        "failures": [{"law": name, "reason": reason} for name, reason in choice.failures],
    }


def _value_lines(calibration: Calibration, level: float) -> list[str]:
    lines = []
    for name in calibration.names:
        unit = _UNIT_OF_QUANTITY.get(name, "Pa")
        interval = calibration.interval(name, level)
        value, high = (shown(x, unit, 5) for x in (calibration.value(name), interval.high))
        low = number(interval.low, unit, 5)
        lines.append(f"{name}: {value}, {100.0 * level:.4g} % interval {low} to {high}")
    return lines


def _stability_line(calibration: Calibration) -> str:
    """Return how far the fitted actuator can be used; no pressure is stated far past the data."""
    actuation = calibration.actuation
    limit = actuation.pressure_limit
    beyond = limit > _BEYOND_READINGS * max(reading.pressure for reading in calibration.readings)
    reason = f"stretch {actuation.stretch_limit:.4f}: {actuation.limit.value}"
    if beyond:
        return f"stable at all pressures near the readings; far above them it ends at {reason}"
    return f"stable up to: {shown(limit, 'Pa')}, {reason}"


def _correlation_lines(calibration: Calibration) -> list[str]:
    correlation = calibration.correlation
    names = calibration.names
    return [
        f"correlation of {names[i]} and {names[k]}: {correlation[i, k]:+.4f}"
        for i in range(len(names))
        for k in range(i + 1, len(names))
    ]


def _cross_validation_line(result: CrossValidation) -> str:
    missed = (
        f"; not predicted: {', '.join(shown(p, 'Pa') for p in result.not_predicted)}"
        if result.not_predicted
        else ""
    )
    return (
        f"leave-one-out error: {result.error_scale:.3g} times the stated errors (rms), "
        f"{result.share_of_largest:.2%} of the largest reading{missed}"
    )


def _comparison_lines(choice: LawChoice) -> list[str]:
    """Return one line for each law that was compared; none if there was only one."""
    if len(choice.calibrations) + len(choice.failures) < 2:
        return []
    lines = ["laws compared (lower AICc is better):"]
    for one, weight in zip(choice.calibrations, choice.weights, strict=True):
        criterion = one.information_criterion
        written = "too few readings" if math.isinf(criterion) else f"{criterion:.2f}"
        lines.append(
            f"  {one.model.fitted_law.__name__}: AICc {written}, weight {weight:.2f}, "
            f"BIC {one.bayesian_criterion:.2f}"
        )
    for name, reason in choice.failures:
        lines.append(f"  {name}: not fitted: {shown_message(reason)}")
    return lines
