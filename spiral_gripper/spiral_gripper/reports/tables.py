# SPDX-License-Identifier: Apache-2.0
"""Tables for people, with rich."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from spiral_core.actuator.actuator import Actuator, windings_of
from spiral_core.design.evaluation import Evaluation
from spiral_core.design.report import Design, DesignReport
from spiral_core.rounding import signed_percent
from spiral_gripper.files.shown import shown, shown_message
from spiral_gripper.reports.design_document import DESIGN, winding_rows_of
from spiral_gripper.reports.fields import Rows, rows_of

MARGIN_HEADER = ("constraint", "figure", "bound", "room")


def print_report(report: DesignReport, console: Console) -> None:
    """Print a design report: the steps, the answer, the margins."""
    for step in report.steps:
        mark = "[green]ok[/]" if step.satisfied else "[red]no[/]"
        remark = escape(shown_message(step.remark))
        console.print(f"[bold]{step.number} {step.title}[/] {mark}  {remark}", highlight=False)
        figures = Table.grid(padding=(0, 3))
        for figure in step.figures:
            figures.add_row(f"    {shown_message(figure.name)}", shown(figure.value, figure.unit))
        console.print(figures)
    if report.design is not None:
        console.print(row_table(answer_title(report), rows_of(DESIGN, report.design)))
        margins = Table(*MARGIN_HEADER, title="Margins", title_justify="left")
        met = sorted((margin.relative, margin.is_met) for margin in report.design.margins)
        for (*texts, room), (_, is_met) in zip(margin_rows(report.design), met, strict=True):
            margins.add_row(*texts, f"[{'green' if is_met else 'red'}]{room}[/]")
        console.print(margins)
    if report.feasible:
        console.print(f"[bold green]feasible[/]: {escape(shown_message(report.message))}")
        return
    console.print(f"[bold red]not feasible[/]: {escape(shown_message(report.binding.sentence))}")
    for relaxation in report.relaxations:
        change = escape(shown_message(relaxation.sentence))
        console.print(f"  sufficient change: {change}", highlight=False)
    if not report.relaxations:
        console.print(f"  {escape(shown_message(report.outlook))}", highlight=False)


def answer_title(report: DesignReport) -> str:
    """Return the heading of a report's design."""
    return "Gripper" if report.feasible else "What comes nearest"


def row_table(title: str, rows: Rows) -> Table:
    """Return names and figures in two columns."""
    table = Table(title=escape(title), title_justify="left", show_header=False)
    for row in rows:
        table.add_row(*map(escape, row))
    return table


def print_points(title: str, points: Sequence[Evaluation], console: Console) -> None:
    """Print candidates of a sweep."""
    columns = ("tube", "beta", "pressure", "strain", "length", "least room")
    table = Table(*columns, title=title, title_justify="left")
    for point in points:
        figures = ((point.pressure, "Pa"), (point.strain, "1"), (point.length, "m"))
        table.add_row(
            escape(point.candidate.tube.name),
            shown_message(point.candidate.angles).removeprefix("beta "),
            *("" if value is None else shown(value, unit) for value, unit in figures),
            f"{point.binding.constraint.value} {signed_percent(point.binding.relative)}",
        )
    console.print(table)


def winding_rows(actuator: Actuator, end_allowance: float) -> Rows:
    """Return how to cut and wind an actuator, as names and figures.

    Args:
        actuator: the actuator.
        end_allowance: tube that plug and fitting take up at each end [m].
    """
    tube = actuator.tube
    bore, wall, length, cut, more = (
        shown(size, "m")
        for size in (2.0 * tube.inner_radius, tube.wall_thickness, tube.length,
                     tube.length + 2.0 * end_allowance, end_allowance)
    )  # fmt: skip
    rows = [
        ("tube, bore x wall", f"{bore} x {wall}"),
        ("length between the fittings", length),
        ("cut length", f"{cut}, with {more} at each end"),
        *winding_rows_of(windings_of(actuator)),
    ]
    for fiber in actuator.single_fibers:
        angle = shown(fiber.angle, "rad")
        kind = f"single fiber at {angle}" if fiber.angle else "straight fiber"
        place = f", {shown(fiber.position, 'rad')} around the tube" if fiber.position else ""
        rows.append((kind, f"fiber {shown(tube.length / math.cos(fiber.angle), 'm')}{place}"))
    return rows


def margin_rows(design: Design) -> list[tuple[str, str, str, str]]:
    """Return the room on every constraint, the least first, under :data:`MARGIN_HEADER`."""
    rows = []
    for margin in sorted(design.margins, key=lambda margin: margin.relative):
        limit = margin.constraint
        bound = f"{limit.wanted} {shown(margin.bound, limit.unit)}"
        room = signed_percent(margin.relative)
        rows.append((limit.value, shown(margin.value, limit.unit), bound, room))
    return rows
