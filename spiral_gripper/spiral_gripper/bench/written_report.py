# SPDX-License-Identifier: Apache-2.0
"""A calibration's report as one file: Markdown or HTML, its figures embedded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from spiral_gripper.bench.report import radius_lines, report_lines
from spiral_gripper.bench.residual_plot import pressure_figure, residual_figure
from spiral_gripper.bench.run import CalibrationResult
from spiral_gripper.reports.page import Page, Rows


def write_calibration_report(
    result: CalibrationResult, refusals: Sequence[str], name: str, level: float, path: Path
) -> None:
    """Write what a calibration found; the suffix decides the format (.md, .html).

    Args:
        result: of the calibration.
        refusals: why a radius cannot be gripped, a sentence each.
        name: of the gripper.
        level: confidence level of the intervals.
        path: the file.

    Raises:
        FileError: it cannot be written.
    """
    best = result.choice.best
    page = Page(f"Calibration of {name}")
    page.table(
        ("quantity", "value"), _rows(report_lines(result.choice, level, result.cross_validation))
    )
    if result.pressures:
        page.table(("object radius", "pressure"), _rows(radius_lines(result.pressures, level)))
    page.items([*(f"warning: {warning}" for warning in result.warnings), *refusals])
    page.picture("readings and residuals", residual_figure(best, name))
    band = pressure_figure(best, name, level)
    if band is not None:
        page.picture("pressure against object radius", band)
    page.write(path)


def _rows(lines: Sequence[str]) -> Rows:
    """Return report lines, each a quantity and its value, as rows of a table."""
    return [(line.partition(": ")[0].strip(), line.partition(": ")[2]) for line in lines]
