# SPDX-License-Identifier: Apache-2.0
"""A calibration's report as one file: Markdown or HTML, its figures embedded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from spiral_gripper.bench.report import CALIBRATION, radius_rows
from spiral_gripper.bench.residual_plot import pressure_figure, residual_figure
from spiral_gripper.bench.run import CalibrationResult
from spiral_gripper.reports.fields import rows_of
from spiral_gripper.reports.page import Page


def write_calibration_report(
    result: CalibrationResult, refusals: Sequence[str], name: str, path: Path
) -> None:
    """Write what a calibration found; the suffix decides the format (.md, .html).

    Args:
        result: of the calibration.
        refusals: why a radius cannot be gripped, a sentence each.
        name: of the gripper.
        path: the file.

    Raises:
        FileError: it cannot be written.
    """
    best = result.choice.best
    page = Page(f"Calibration of {name}")
    page.table(("quantity", "value"), rows_of(CALIBRATION, result))
    if result.pressures:
        page.table(("object radius", "pressure"), radius_rows(result))
    page.items([*(f"warning: {warning}" for warning in result.warnings), *refusals])
    page.picture("readings and residuals", residual_figure(best, name))
    band = pressure_figure(best, name, result.level)
    if band is not None:
        page.picture("pressure against object radius", band)
    page.write(path)
