# SPDX-License-Identifier: Apache-2.0
"""The command ``close``: a gripper closes on an object in real time."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click

from spiral_gripper.cli.gripper import described, mounted, require_pressure
from spiral_gripper.cli.output import print_result, say_written, write_picture
from spiral_gripper.cli.types import (
    LENGTH,
    PRESSURE,
    PRESSURE_RATE,
    TIME,
    flag,
    friction_option,
    gripper_argument,
    mount_options,
    option,
    output_options,
    plot_option,
    typed,
    wanted,
)
from spiral_gripper.cli.workers import progress_bar


@click.command()
@gripper_argument
@option("--radius", LENGTH, "Radius of the cylinder.", required=True)
@option("--rate", PRESSURE_RATE, "Rate at which the pressure rises.", required=True, metavar="RATE")
@option("--pressure", PRESSURE, "Final pressure; by default 1.15 times that of the perfect wrap.")
@option("--wait", TIME, "Time at the final pressure before the grip is judged.", shown="2 s")
@friction_option
@option(
    "--retardation-time",
    TIME,
    "Damping of the material; 5 to 50 ms for silicone and latex.",
    shown="16 ms",
)
@flag("--advise", "Also find the fastest rate that keeps 90 % of the slow grip's force.")
@flag(
    "--spread",
    "Repeat the closing with other details and print how far its figures scatter; a "
    "disorderly closing is always repeated.",
)
@option(
    "--animate",
    click.Path(dir_okay=False, path_type=Path),
    "Write an animation in real time to a .gif file.",
)
@mount_options
@output_options
@plot_option
def close(
    gripper: str,
    retardation_time: float,
    animate: Path | None,
    **options: Any,  # noqa: ANN401  # of the mount and of CloseQuestion
) -> int:
    """Simulate GRIPPER closing on a cylinder at a pressure rate, and print the grip.

    GRIPPER is the name of a shipped gripper or the path of a description file. The tube has mass
    and damping, and turns that touch early stick: a fast closing may hold a fraction of what a slow
    one holds. Ctrl-C ends the computation and prints what has been computed. Exit code 1: not all
    that was asked for was computed.
    """
    if animate is not None:
        if animate.suffix.lower() != ".gif":
            raise click.UsageError(f"--animate writes .gif files, got {animate.name}")
        if not os.access(animate.parent, os.W_OK):
            raise click.UsageError(
                f"cannot write {animate}: no folder {animate.parent} to write to"
            )
    from spiral_core.rod.motion.inertia import Damping
    from spiral_gripper.reports.closing.document import CLOSE, CloseQuestion, solve_close

    description = described(gripper)
    mount = mounted(description.gripper, options)
    question = CloseQuestion(mount, damping=Damping(retardation_time), **options)
    if question.pressure is not None:
        require_pressure(description, question.pressure, typed("pressure"))
    with progress_bar("closing") as moved:
        solved = solve_close(question, moved)
    title = f"{mount.name} closes on radius {typed('radius')} at {typed('rate')}"
    print_result(CLOSE, solved, title)
    if wanted("plot"):
        from spiral_gripper.reports.closing.plots import close_figure

        write_picture(close_figure(solved.closing))
    if animate is not None:
        from spiral_gripper.reports.closing.plots import write_animation

        with progress_bar("drawing") as drawn:
            write_animation(solved.closing, animate, drawn)
        say_written(animate)
    return 0 if solved.complete else 1
