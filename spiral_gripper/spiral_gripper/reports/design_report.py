# SPDX-License-Identifier: Apache-2.0
"""A design report as one file: Markdown or HTML, its figure embedded."""

from __future__ import annotations

from pathlib import Path

from spiral_core.design.report import DesignReport
from spiral_gripper.files.shown import shown, shown_message
from spiral_gripper.reports.design_document import DESIGN
from spiral_gripper.reports.fields import rows_of
from spiral_gripper.reports.page import Page, Rows
from spiral_gripper.reports.plots import design_figure
from spiral_gripper.reports.tables import (
    MARGIN_HEADER,
    answer_title,
    margin_rows,
)

_HEADER = ("quantity", "value")


def write_report(report: DesignReport, path: Path) -> None:
    """Write a report; the suffix decides the format (.md, .html).

    Args:
        report: of the design procedure.
        path: the file.

    Raises:
        FileError: it cannot be written.
    """
    page = Page("Spiral gripper: design report")
    page.verdict("feasible" if report.feasible else "not feasible", good=report.feasible)
    page.paragraph(shown_message(report.message if report.feasible else report.binding.sentence))
    page.items([f"sufficient change: {shown_message(one.sentence)}" for one in report.relaxations])
    page.heading("Required")
    page.table(_HEADER, _requirement_rows(report))
    if report.design is not None:
        page.heading(answer_title(report))
        page.table(_HEADER, rows_of(DESIGN, report.design))
        page.heading("Margins")
        page.table(MARGIN_HEADER, margin_rows(report.design))
    page.picture("pressure against object radius", design_figure(report))
    for step in report.steps:
        met = "(met)" if step.satisfied else "(not met)"
        page.heading(f"Step {step.number}: {step.title}", met, good=step.satisfied)
        page.paragraph(shown_message(step.remark))
        figures = [(shown_message(one.name), shown(one.value, one.unit)) for one in step.figures]
        page.table(_HEADER, figures)
    page.write(path)


def _requirement_rows(report: DesignReport) -> Rows:
    wanted = report.requirement
    limits = (
        ("object length", wanted.object_length, "m"),
        ("longest gripper", wanted.length_max, "m"),
        ("payload", wanted.payload, "kg"),
        ("tolerance", wanted.tolerance, "m"),
        ("largest pressure", wanted.pressure_max, "Pa"),
        ("largest strain", wanted.strain_max, "1"),
    )
    return [
        ("objects", f"{shown(wanted.radius_min, 'm')} to {shown(wanted.radius_max, 'm')}"),
        ("turns", f"{wanted.turns_required:.4g}"),
        *((name, "not limited" if v is None else shown(v, unit)) for name, v, unit in limits),
        ("gravity in the base frame", f"{', '.join(f'{g:.4g}' for g in wanted.gravity)} m/s^2"),
        ("preference", wanted.preference.value),
        ("candidates", f"{report.candidates}, {len(report.tried)} of them solved as rods"),
    ]
