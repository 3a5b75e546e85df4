# SPDX-License-Identifier: Apache-2.0
"""The reasons to doubt a calibration, a sentence each."""

from __future__ import annotations

import math
from collections.abc import Sequence

from spiral_core import weak_directions
from spiral_core.calibration.fit import Calibration
from spiral_core.calibration.readings import Reading
from spiral_core.calibration.regression import Scatter
from spiral_core.calibration.uncertainty import RadiusPressure
from spiral_gripper.bench.measurements import Measurements
from spiral_gripper.files.shown import shown


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
    places, found = _places(measurements), []
    for k in calibration.outliers:
        out = k in calibration.excluded
        remedy = "--robust left it out" if out else "check it, or leave it out with --robust"
        found.append(
            f"{places[k]}: the reading at {shown(calibration.readings[k].pressure, 'Pa')} is "
            f"{abs(calibration.standardized_residuals[k]):.1f} standard errors off the fit to the "
            f"others, more than chance allows; {remedy}"
        )
    return found


def copy_warnings(measurements: Sequence[Measurements]) -> list[str]:
    """Return a warning that names the rows that are copies of others, if there are any."""
    first: dict[Reading, str] = {}
    copies: list[str] = []
    readings = [reading for one in measurements for reading in one.readings]
    for place, reading in zip(_places(measurements), readings, strict=True):
        if reading in first and reading.pressure > 0.0:
            copies.append(f"{place} (of {first[reading]})")
        first.setdefault(reading, place)
    advice = "they narrow the intervals: leave them out"
    return [f"copies of other readings: {', '.join(copies)}; {advice}"] if copies else []


def contact_warnings(calibration: Calibration, measurements: Sequence[Measurements]) -> list[str]:
    """Return a warning that names the cylinders that are not wrapped by contact, if any are."""
    all_places, left_out = _places(measurements), calibration.excluded
    places = [
        all_places[k]
        for k, one in enumerate(calibration.readings)
        if getattr(one, "contact_shift", None) == 0.0 and k not in left_out
    ]
    advice = "its radius is compared by the tip criterion, some percent off: leave it out"
    reason = "the fitted gripper does not wrap this cylinder by contact"
    return [f"{', '.join(places)}: {reason}; {advice}"] if places else []


def rival_warnings(results: Sequence[RadiusPressure]) -> list[str]:
    """Return a warning for each law that the readings allow, and that predicts otherwise."""
    found = []
    for one in results:
        for rival in one.rivals:
            if one.own_interval.low <= rival.pressure <= one.own_interval.high:
                continue
            other = "cannot grip it"
            if math.isfinite(rival.pressure):
                other = f"predicts {shown(rival.pressure, 'Pa')}"
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
