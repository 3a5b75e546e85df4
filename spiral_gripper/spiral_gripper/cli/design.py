# SPDX-License-Identifier: Apache-2.0
"""The command ``design``."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from spiral_gripper.cli.output import print_json, say_written, write_picture
from spiral_gripper.cli.requirement import PREFERENCES, requirement_from, requirement_options
from spiral_gripper.cli.types import (
    POSITIVE_LENGTH,
    REPORT_FILE,
    YAML_FILE,
    flag,
    option,
    output_options,
    plot_option,
    typed_units,
    wanted,
)
from spiral_gripper.cli.workers import progress_bar

INFEASIBLE = 1
EXAMPLE = """\b
Example:
  spiral-gripper design --radius-min "11 mm" --radius-max "30 mm" \\
      --tube "3/8 in x 1/32 in" --turns 1.5 --object-length "250 mm"
"""


@click.command(epilog=EXAMPLE)
@requirement_options
@option(
    "--prefer",
    click.Choice(PREFERENCES),
    "Which of several feasible designs to choose.",
    shown=PREFERENCES[0],
)
@option(
    "--tolerance",
    POSITIVE_LENGTH,
    "Shift across its axis from which an object must still be held, computed with contact.",
)
@flag("--paper", "The paper's seven steps alone: nothing is closed on an object.")
@output_options
@plot_option
@option("--report", REPORT_FILE, "Write a report to a .md or .html file.")
@option(
    "--save",
    YAML_FILE,
    "Write the gripper's description to a .yaml file, for the node and the other commands.",
)
def design(
    report: Path | None,
    save: Path | None,
    paper: bool,
    **options: object,
) -> int:
    """Design a gripper for given objects and limits.

    The paper's seven steps: tube, radius ratios, fiber angle, length, object length, correction
    for gravity, exact pressure-radius curve. In an eighth the gripper closes on the largest, the
    middle and the smallest object, with contact and friction. Exit code 1: no design is feasible;
    the output states the limit that prevents it and the smallest change that makes one feasible.
    """
    if paper and options["tolerance"] is not None:
        raise click.UsageError("--tolerance needs contact, which --paper leaves out")
    requirement = requirement_from(options, contact=not paper)

    from spiral_core.design.procedure import design_gripper
    from spiral_gripper.files.shown import shown_message, units_shown

    context = click.get_current_context()
    context.with_resource(units_shown(typed_units(context.obj or {})))
    with progress_bar("designing", quiet=not sys.stderr.isatty()) as move:
        result = design_gripper(
            requirement, lambda done, total, _: move(done, total), contact=not paper
        )
    if wanted("json"):
        from spiral_gripper.reports.design_document import report_as_dict

        print_json(report_as_dict(result))
    else:
        from rich.console import Console

        from spiral_gripper.reports.tables import print_report

        print_report(result, Console())
    if result.design is not None:
        from spiral_gripper.files.plausibility import THIN_WALL, warnings_of_size

        for warning in warnings_of_size(result.design.tube, THIN_WALL):
            click.echo(f"warning: {warning}", err=True)
    if save is not None:
        if not result.feasible or result.design is None:
            reason = shown_message(result.binding.sentence)
            raise click.ClickException(f"nothing is saved: not feasible: {reason}")
        from spiral_gripper.files.storage import write_file
        from spiral_gripper.reports.design_document import description_text

        write_file(save, description_text(result.design, save.stem), replace=False)
        say_written(save)
    if wanted("plot"):
        from spiral_gripper.reports.plots import design_figure

        write_picture(design_figure(result))
    if report is not None:
        from spiral_gripper.reports.design_report import write_report

        write_report(result, report)
        say_written(report)
    return 0 if result.feasible else INFEASIBLE
