# SPDX-License-Identifier: Apache-2.0
"""A picture of a calibration: measured and fitted values, and residuals.

Needs matplotlib (the ``plot`` extra).
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from spiral_core import (
    ShapeReading,
    SpiralError,
    WrapCurve,
    pressure_uncertainty,
    regime_chart,
)
from spiral_core.calibration.fit import Calibration
from spiral_core.calibration.uncertainty import RadiusPressure
from spiral_gripper.bench.measurements import COLUMNS, KINDS, Kind
from spiral_gripper.files.shown import axis_label, in_units
from spiral_gripper.reports.plots import regime_figure
from spiral_gripper.reports.style import COLORS, paper_style, set_title, style_axes

# Of the band: radii, and the smallest as a part of the largest.
BAND_POINTS, SMALLEST = 9, 0.25
_MEASURED, _FITTED, _COORDINATES = COLORS[0], COLORS[2], (COLORS[0], COLORS[1], COLORS[4])


@paper_style()
def residual_figure(calibration: Calibration, name: str) -> Figure:
    """Return a figure with a row for each kind of reading: the fit on the left, residuals right.

    Bars and the band are two stated standard errors, as the readings' author claims: readings that
    contradict the fit show as such.

    Args:
        calibration: the fit to show.
        name: of the gripper.
    """
    found = {type(reading) for reading in calibration.readings}
    kinds = [kind for kind in KINDS if kind.reading in found]
    figure = Figure(figsize=(7.0, 0.4 + 2.4 * len(kinds)), layout="constrained")
    rows = figure.subplots(len(kinds), 2, squeeze=False)
    for kind, (fit, left_over) in zip(kinds, rows, strict=True):
        _draw_kind(calibration, kind, fit, left_over)
    law = calibration.model.fitted_law.__name__
    scale = f"residuals {calibration.error_scale:.3g} times the stated errors"
    set_title(figure, f"{name}: {law}, {len(calibration.readings)} readings, {scale}")
    return figure


def pressure_figure(calibration: Calibration, name: str, level: float) -> Figure | None:
    """Return pressure against radius with the regimes and the calibration's interval as a band.

    None where no gripper was calibrated, or it makes no coil. Radii whose interval cannot be
    computed leave a gap.

    Args:
        calibration: the fit.
        name: of the gripper.
        level: confidence level of the interval, in (0, 1).
    """
    if calibration.gripper is None:
        return None
    try:
        curve = WrapCurve(calibration.gripper)
    except SpiralError:
        return None
    smallest = max(curve.radius_min, SMALLEST * curve.radius_max)
    found: list[RadiusPressure] = []
    for radius in np.linspace(smallest, curve.radius_max, BAND_POINTS + 2)[1:-1]:
        with suppress(SpiralError):
            found += pressure_uncertainty(calibration, [float(radius)], level)
    chart = regime_chart(curve, smallest, curve.radius_max)
    return regime_figure(chart, f"{name}, calibrated, {100.0 * level:.4g} % interval", found)


def _draw_kind(calibration: Calibration, kind: Kind, fit: Axes, left_over: Axes) -> None:
    """Draw one kind of reading: measured, fitted (a line, or the crosses of shapes), residuals."""
    unit, readings = COLUMNS[kind.name].si_unit, calibration.readings
    counts = [len(one.measured) for one in readings]
    chosen = np.repeat([isinstance(one, kind.reading) for one in readings], counts)
    pressures = np.repeat([one.pressure for one in readings], counts)
    at = in_units(pressures[chosen], "Pa")
    predicted = in_units(calibration.predictions[chosen], unit)
    errors = in_units(calibration.errors[chosen], unit)
    residuals = calibration.residuals[chosen]
    shape = kind.reading is ShapeReading
    parts = zip("xyz", _COORDINATES, strict=True) if shape else [("", _MEASURED)]
    for offset, (coordinate, color) in enumerate(parts):
        one = slice(offset, None, 3 if shape else 1)
        fit.errorbar(
            at[one], (predicted - residuals * errors)[one], 2.0 * errors[one], fmt="o", color=color,
            markersize=4 if shape else 3.5, label=f"{coordinate}, measured".removeprefix(", "),
        )  # fmt: skip
        if shape:
            fit.plot(at[one], predicted[one], "x", color="black", markersize=7)
    if shape:
        fit.plot([], [], "x", color="black", label="fitted")
    else:
        order = np.argsort(at, kind="stable")
        fit.plot(at[order], predicted[order], "-", color=_FITTED, label="fitted")
    left_over.axhspan(-2.0, 2.0, color="#e6e6e6", lw=0.0, label="± 2 stated errors")
    left_over.axhline(0.0, color="black", linewidth=0.8)
    left_over.plot(at, residuals, "o", color=_MEASURED, markersize=3.5)
    name = "coordinate" if shape else kind.name.replace("_", " ")
    fit.set(xlabel=axis_label("pressure", "Pa"), ylabel=axis_label(name, unit))
    left_over.set(xlabel=axis_label("pressure", "Pa"))
    left_over.set(ylabel="(fitted - measured) / stated error")
    left_over.margins(y=0.15)
    for axes in (fit, left_over):
        style_axes(axes)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
