# SPDX-License-Identifier: Apache-2.0
"""A design report as one file: Markdown or HTML, its figure embedded."""

from __future__ import annotations

import html
from pathlib import Path

from spiral_core.design.report import DesignReport, DesignStep
from spiral_gripper.files.shown import reworded, shown
from spiral_gripper.files.storage import write_file
from spiral_gripper.reports.page import (
    PAGE_STYLE,
    Rows,
    figure_uri,
    html_table,
    markdown_table,
)
from spiral_gripper.reports.plots import design_figure
from spiral_gripper.reports.tables import answer_rows, relaxation_text


def write_report(report: DesignReport, path: Path) -> None:
    """Write a report; the suffix decides the format (.md, .html).

    Args:
        report: of the design procedure.
        path: the file.

    Raises:
        FileError: it cannot be written.
    """
    text = markdown_report(report) if path.suffix.lower() == ".md" else html_report(report)
    write_file(path, text)


def markdown_report(report: DesignReport) -> str:
    """Return a report in Markdown, the figure embedded as a data URI."""
    parts = [
        "# Spiral gripper: design report\n",
        f"**{_verdict(report)}**\n",
        _answer(report) + "\n",
    ]
    parts += [
        f"- sufficient change: {relaxation_text(relaxation)}" for relaxation in report.relaxations
    ]
    parts.append("")
    for title, header, rows in _sections(report):
        parts.append(f"## {title}\n")
        parts.append(markdown_table(header, rows))
    parts.append(f"![pressure against object radius]({figure_uri(design_figure(report))})\n")
    for step in report.steps:
        mark = "met" if step.satisfied else "NOT met"
        parts.append(f"## Step {step.number}: {step.title} ({mark})\n\n{reworded(step.remark)}\n")
        parts.append(markdown_table(("quantity", "value"), _figures(step)))
    return "\n".join(parts)


def html_report(report: DesignReport) -> str:
    """Return a report as one HTML page that needs no other file."""
    mark = "ok" if report.feasible else "no"
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        f"<title>Spiral gripper: design report</title><style>{PAGE_STYLE}</style></head><body>",
        "<h1>Spiral gripper: design report</h1>",
        f'<p class="{mark}"><strong>{html.escape(_verdict(report))}</strong></p>',
        f"<p>{html.escape(_answer(report))}</p>",
    ]
    if report.relaxations:
        items = "".join(
            f"<li>sufficient change: {html.escape(relaxation_text(r))}</li>"
            for r in report.relaxations
        )
        parts.append(f"<ul>{items}</ul>")
    for title, header, rows in _sections(report):
        parts.append(f"<h2>{html.escape(title)}</h2>{html_table(header, rows)}")
    parts.append(
        f'<img alt="pressure against object radius" src="{figure_uri(design_figure(report))}">'
    )
    for step in report.steps:
        mark, word = ("ok", "met") if step.satisfied else ("no", "not met")
        title = html.escape(f"Step {step.number}: {step.title}")
        parts.append(f'<h2>{title} <span class="{mark}">({word})</span></h2>')
        parts.append(f"<p>{html.escape(reworded(step.remark))}</p>")
        parts.append(html_table(("quantity", "value"), _figures(step)))
    parts.append("</body></html>\n")
    return "\n".join(parts)


def _verdict(report: DesignReport) -> str:
    return "feasible" if report.feasible else "not feasible"


def _answer(report: DesignReport) -> str:
    return reworded(report.message if report.feasible else report.binding.sentence)


def _sections(report: DesignReport) -> list[tuple[str, tuple[str, ...], Rows]]:
    """Return the tables of the answer: requirement, gripper, margins."""
    sections: list[tuple[str, tuple[str, ...], Rows]] = [
        ("Required", ("quantity", "value"), _requirement_rows(report)),
    ]
    design = report.design
    if design is None:
        return sections
    title = "Gripper" if report.feasible else "What comes nearest"
    sections.append((title, ("quantity", "value"), answer_rows(design)))
    margins = [
        (
            m.constraint.value,
            shown(m.value, m.constraint.unit),
            f"{m.constraint.wanted} {shown(m.bound, m.constraint.unit)}",
            f"{100.0 * m.relative:+.1f} %",
        )
        for m in sorted(design.margins, key=lambda m: m.relative)
    ]
    sections.append(("Margins", ("constraint", "figure", "bound", "room"), margins))
    return sections


def _requirement_rows(report: DesignReport) -> Rows:
    wanted = report.requirement
    limits = (
        ("object length", wanted.object_length, "m"),
        ("longest gripper", wanted.length_max, "m"),
        ("payload", wanted.payload, "kg"),
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


def _figures(step: DesignStep) -> Rows:
    return [(reworded(figure.name), shown(figure.value, figure.unit)) for figure in step.figures]
