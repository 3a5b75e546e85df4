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
from spiral_core.design.report import Design, DesignReport, DesignStep
from spiral_gripper.files.shown import shown, shown_message
from spiral_gripper.reports.design_document import DESIGN, winding_text
from spiral_gripper.reports.fields import rows_of

MARGIN_HEADER = ("constraint", "figure", "bound", "room")


def print_report(report: DesignReport, console: Console) -> None:
    """Print a design report: the steps, the answer, the margins."""
    for step in report.steps:
        _print_step(step, console)
    if report.design is not None:
        console.print(row_table(answer_title(report), rows_of(DESIGN, report.design)))
        console.print(_margins_table(report.design))
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


def row_table(title: str, rows: Sequence[tuple[str, str]]) -> Table:
    """Return names and figures in two columns."""
    table = Table(title=escape(title), title_justify="left", show_header=False)
    for name, text in rows:
        table.add_row(escape(name), escape(text))
    return table


def print_points(title: str, points: Sequence[Evaluation], console: Console) -> None:
    """Print candidates of a sweep."""
    table = Table(title=title, title_justify="left")
    for heading in ("tube", "beta", "pressure", "strain", "length", "least room"):
        table.add_column(heading)
    for point in points:
        table.add_row(
            escape(point.candidate.tube.name),
            shown_message(point.candidate.angles).removeprefix("beta "),
            "" if point.pressure is None else shown(point.pressure, "Pa"),
            "" if point.strain is None else shown(point.strain, "1"),
            "" if point.length is None else shown(point.length, "m"),
            f"{point.binding.constraint.value} {100.0 * point.binding.relative:+.1f} %",
        )
    console.print(table)


def winding_rows(actuator: Actuator, end_allowance: float) -> list[tuple[str, str]]:
    """Return how to cut and wind an actuator, as names and figures.

    Args:
        actuator: the actuator.
        end_allowance: tube that plug and fitting take up at each end [m].
    """
    tube = actuator.tube
    rows = [
        ("tube, bore x wall", f"{_mm(2.0 * tube.inner_radius)} x {_mm(tube.wall_thickness)}"),
        ("length between the fittings", _mm(tube.length)),
        ("cut length", _mm(tube.length + 2.0 * end_allowance)),
    ]
    rows += [
        (f"winding at {shown(w.angle, 'rad')}", winding_text(w)) for w in windings_of(actuator)
    ]
    for fiber in actuator.single_fibers:
        kind = (
            "straight fiber"
            if fiber.angle == 0.0
            else f"single fiber at {shown(fiber.angle, 'rad')}"
        )
        place = f", {shown(fiber.position, 'rad')} around the tube" if fiber.position else ""
        rows.append((kind, f"fiber {_mm(tube.length / math.cos(fiber.angle))}{place}"))
    return rows


def _mm(length: float) -> str:
    return shown(length, "m")


def _print_step(step: DesignStep, console: Console) -> None:
    mark = "[green]ok[/]" if step.satisfied else "[red]no[/]"
    console.print(
        f"[bold]{step.number} {step.title}[/] {mark}  {escape(shown_message(step.remark))}",
        highlight=False,
    )
    table = Table.grid(padding=(0, 3))
    for figure in step.figures:
        table.add_row(f"    {shown_message(figure.name)}", shown(figure.value, figure.unit))
    console.print(table)


def margin_rows(design: Design) -> list[tuple[str, str, str, str]]:
    """Return the room on every constraint, the least first, under :data:`MARGIN_HEADER`."""
    return [
        (
            margin.constraint.value,
            shown(margin.value, margin.constraint.unit),
            f"{margin.constraint.wanted} {shown(margin.bound, margin.constraint.unit)}",
            f"{100.0 * margin.relative:+.1f} %",
        )
        for margin in sorted(design.margins, key=lambda margin: margin.relative)
    ]


def _margins_table(design: Design) -> Table:
    table = Table(*MARGIN_HEADER, title="Margins", title_justify="left")
    met = sorted((margin.relative, margin.is_met) for margin in design.margins)
    for (*texts, room), (_, is_met) in zip(margin_rows(design), met, strict=True):
        table.add_row(*texts, f"[{'green' if is_met else 'red'}]{room}[/]")
    return table
