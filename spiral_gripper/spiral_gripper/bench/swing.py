# SPDX-License-Identifier: Apache-2.0
"""A free swing of the tip: from its CSV file to the damping, as a table of fields."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from spiral_core import InvalidInputError, SwingReading, fit_swing, vibrations
from spiral_core.calibration.regression import Scatter
from spiral_core.calibration.swing import SwingFit
from spiral_gripper.bench.measurements import COLUMNS, SWING, readings_of
from spiral_gripper.bench.options import CalibrationOptions
from spiral_gripper.bench.report import interval_text
from spiral_gripper.files.description import GripperDescription
from spiral_gripper.files.shown import shown
from spiral_gripper.files.table import TableError, read_table
from spiral_gripper.reports.fields import Field, Json, Rows, data

# Larger swings, as a fraction of the length, decay otherwise than small ones.
LARGE_SWING = 0.15
UNITS = {"retardation_time": "s", "air": "1"}


class SolvedSwing(NamedTuple):
    """A free swing, fitted.

    Attributes:
        fit: of the damping.
        length: of the tube [m].
        level: confidence level of the intervals, in (0, 1).
    """

    fit: SwingFit
    length: float
    level: float


def fit_free_swing(
    description: GripperDescription,
    files: Sequence[Path],
    options: CalibrationOptions,
) -> SolvedSwing:
    """Return the damping of a gripper from a file of its free swing.

    Args:
        description: the gripper, mounted as it was when it swung.
        files: one CSV file with the columns time, displacement and pressure.
        options: what is stated beside the file, and the factor on the air's drag if it is held.

    Raises:
        TableError: the file cannot be used; the error names every bad line and column.
        InvalidInputError: it holds no swing of this gripper.
        SolverError: the fit did not converge.
    """
    if len(files) != 1:
        raise InvalidInputError("--free-swing", f"{len(files)} files", "with one file, one swing")
    readings, pressure = _read(files[0], options)
    for name, text in options.errors.items():
        with suppress(TableError):
            if _read(files[0], replace(options, errors={})) == (readings, pressure):
                requirement = f"left out: the column {name}_error states it"
                raise InvalidInputError(f"--error {name}", text, requirement)
    most = description.gripper.pressure_max
    if not pressure <= most:
        requirement = f"at most the gripper's limit, {shown(most, 'Pa')}"
        raise InvalidInputError("pressure", shown(pressure, "Pa"), requirement)
    swing = vibrations(description.gripper, pressure, 1).swings[0]
    length, places = description.gripper.tube.length, [one.displacement for one in readings]
    width = max(places) - min(places)
    if not width <= 2.0 * length:
        told = f"a swing {shown(width, 'm', 3)} wide"
        requirement = f"at most twice the tube's length, {shown(length, 'm', 3)}: check the unit"
        raise InvalidInputError("displacement", told, requirement)
    fit = fit_swing(swing, readings, air=options.fixed.get("air"))
    return SolvedSwing(fit, length, options.level)


def _warnings(solved: SolvedSwing) -> list[str]:
    """Return the reasons to doubt a fit, a sentence each."""
    found, fit = [], solved.fit
    if fit.amplitude > LARGE_SWING * solved.length:
        most = shown(LARGE_SWING * solved.length, "m", 2)
        found.append(f"the swing is large: leave out what comes before it is below {most}")
    if fit.scatter is not Scatter.AS_STATED:
        scale = f"the residuals are {fit.error_scale:.3g} times the stated errors"
        found.append(f"{scale}, {fit.scatter.value.replace('the law does', 'one swing does')}")
    found += [f"{name} ended at zero" for name in fit.at_bound]
    if "air" in fit.names and not fit.interval("air").low > 0.0:
        found.append(
            "the readings do not separate the damping of air and material: use --hold air=1"
        )
    return found


def _values(solved: SolvedSwing) -> Json:
    fit = solved.fit
    return {
        name: {"value": float(value), "interval": fit.interval(name, solved.level)}
        for name, value in zip(fit.names, fit.values, strict=True)
    }


def _value_rows(solved: SolvedSwing) -> Rows:
    return [
        (name, interval_text(one["value"], one["interval"], UNITS[name], solved.level))
        for name, one in _values(solved).items()
    ]


FREE_SWING = (
    *data(values=_values, level="level"),
    Field("frequency", lambda s: f"free swing of {s.fit.frequency:.3g} Hz", "fit.frequency",
          lambda s: f"{shown(s.fit.amplitude, 'm', 3)} at first"),
    Field("amplitude", "", "fit.amplitude", _value_rows),
    *data(readings=lambda s: len(s.fit.residuals), degrees_of_freedom="fit.degrees_of_freedom"),
    Field("error_scale", "residuals", "fit.error_scale", "{:.3g} times the stated errors"),
    Field("warnings", "", _warnings, lambda s: [("warning", text) for text in _warnings(s)]),
)  # fmt: skip


def _read(path: Path, options: CalibrationOptions) -> tuple[list[SwingReading], float]:
    """Return the readings of a file, and the one pressure at which they were made [Pa]."""
    table = read_table(path, COLUMNS, options.units, options.ignored)
    readings = [reading for _, reading in readings_of(table, (SWING,), options)]
    for heading in options.ignored:
        if heading not in table.headings:
            table.note(table.header_line, heading, "is to be ignored, but there is no such heading")
    pressure = table.rows[0].values["pressure"]
    for row in table.rows:
        if not row.values["pressure"] == pressure >= 0.0:
            table.note(row.line, "pressure", "must be one gauge pressure >= 0 for a swing")
    if len({one.time for one in readings}) < len(readings):
        table.note(None, "time", "holds a time twice: one swing a file")
    table.raise_problems()
    return readings, pressure
