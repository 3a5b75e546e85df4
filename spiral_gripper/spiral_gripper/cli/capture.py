# SPDX-License-Identifier: Apache-2.0
"""The command ``capture``: how far off an object may be."""

from __future__ import annotations

from pathlib import Path

import click

from spiral_gripper.cli.gripper import described, mounted, own_file_beside, require_pressure
from spiral_gripper.cli.output import print_result, say_written, write_picture
from spiral_gripper.cli.types import (
    POSITIVE_LENGTH,
    PRESSURE,
    flag,
    friction_option,
    gripper_argument,
    jobs_option,
    mount_options,
    option,
    output_options,
    payload_option,
    plot_option,
    results_option,
    typed,
    wanted,
)
from spiral_gripper.cli.workers import computing, progress_bar


@click.command()
@gripper_argument
@option("--radius", POSITIVE_LENGTH, "Radius of a cylinder.", required=True)
@payload_option
@friction_option
@option("--pressure", PRESSURE, "Close up to this pressure.  [default: the recommended one]")
@results_option
@flag(
    "--table",
    "Add the region to NAME.capture.json beside the gripper's file, for plan_wrap of the ROS 2 "
    "node.",
)
@mount_options
@jobs_option
@output_options
@plot_option
def capture(
    gripper: str,
    radius: float,
    payload: float | None,
    friction: float | None,
    pressure: float | None,
    results: Path | None,
    table: bool,
    **options: object,
) -> int:
    """Print how far off an object may be for GRIPPER to end wrapped around it and holding.

    GRIPPER is the name of a shipped gripper or the path of a description file. It closes slowly up
    to one pressure, with contact and friction, on the object in many misplacements: shifted across
    its axis, tilted, thicker or thinner. Exit code 1: it is not held in its place.
    """
    from spiral_core.errors import NotGrippableError
    from spiral_core.grip.capture import CaptureOutcome, capture_region
    from spiral_core.grip.grip import recommended_grip
    from spiral_core.grip.setup import lay_into_coil
    from spiral_gripper.files.regions import SUFFIX, write_region
    from spiral_gripper.files.shown import shown_message
    from spiral_gripper.reports.grip.capture import CAPTURE
    from spiral_gripper.reports.grip.study import capture_file

    description = described(gripper)
    if table:
        own_file_beside(description, gripper, SUFFIX)
    mount = mounted(description.gripper, options)
    if payload is not None and not any(mount.gravity):
        raise click.UsageError("--payload needs gravity, and the mount has none")
    if pressure is not None:
        require_pressure(description, pressure, typed("pressure"))
    setup = lay_into_coil(mount, radius, friction=friction)
    if pressure is None:
        try:
            with progress_bar("closing, then pulling") as progress:
                pressure = recommended_grip(setup, payload, progress).pressure
        except NotGrippableError as error:
            click.echo(f"not held: {shown_message(error)}", err=True)
            return 1
    store = capture_file(results, setup, pressure, payload)
    with computing("closing") as (executor, progress):
        region = capture_region(
            setup,
            pressure,
            payload,
            executor=executor,
            progress=progress,
            known=store.known,
            keep=store.keep,
        )
    print_result(CAPTURE, region, f"{mount.name}, how far off may it be?")
    if table and region.center is CaptureOutcome.HOLDS:
        say_written(write_region(region, description))
    elif table:
        click.echo("not held: no region is written", err=True)
    if wanted("plot"):
        from spiral_gripper.reports.grip.plots import capture_figure

        write_picture(capture_figure(region, f"{mount.name} on radius {typed('radius')}"))
    return 0 if region.center is CaptureOutcome.HOLDS else 1
