# SPDX-License-Identifier: Apache-2.0
"""A calibration's report as one file: Markdown or HTML, its figures embedded."""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path

from spiral_gripper.bench.command import CommandResult
from spiral_gripper.bench.report import radius_lines, report_lines
from spiral_gripper.bench.residual_plot import pressure_figure, residual_figure
from spiral_gripper.files.storage import write_file
from spiral_gripper.reports.page import (
    PAGE_STYLE,
    Rows,
    figure_uri,
    html_table,
    markdown_table,
)

_HEADER = ("quantity", "value")


def write_calibration_report(
    result: CommandResult, refusals: Sequence[str], name: str, level: float, path: Path
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
    title = f"Calibration of {name}"
    best = result.choice.best
    pictures = {"readings and residuals": residual_figure(best, name)}
    band = pressure_figure(best, name, level)
    if band is not None:
        pictures["pressure against object radius"] = band
    images = {text: figure_uri(figure) for text, figure in pictures.items()}
    rows = _rows(report_lines(result.choice, level, result.cross_validation))
    pressures = _rows(radius_lines(result.pressures, level))
    remarks = [*(f"warning: {warning}" for warning in result.warnings), *refusals]
    if path.suffix.lower() == ".md":
        parts = [f"# {title}\n", markdown_table(_HEADER, rows)]
        parts += [markdown_table(("object radius", "pressure"), pressures)] if pressures else []
        parts += [f"- {remark}" for remark in remarks]
        parts += [f"\n![{what}]({image})\n" for what, image in images.items()]
        text = "\n".join(parts)
    else:
        items = "".join(f"<li>{html.escape(remark)}</li>" for remark in remarks)
        text = (
            f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
            f"<title>{html.escape(title)}</title><style>{PAGE_STYLE}</style></head><body>\n"
            f"<h1>{html.escape(title)}</h1>\n{html_table(_HEADER, rows)}\n"
            + (html_table(("object radius", "pressure"), pressures) if pressures else "")
            + (f"<ul>{items}</ul>\n" if items else "")
            + "".join(f'<img alt="{what}" src="{image}">\n' for what, image in images.items())
            + "</body></html>\n"
        )
    write_file(path, text)


def _rows(lines: Sequence[str]) -> Rows:
    """Return report lines, each a quantity and its value, as rows of a table."""
    return [(line.partition(": ")[0].strip(), line.partition(": ")[2]) for line in lines]
