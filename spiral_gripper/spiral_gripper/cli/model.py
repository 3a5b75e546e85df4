# SPDX-License-Identifier: Apache-2.0
"""The commands ``model`` and ``winding-sheet``: a gripper for a robot, and for the workshop."""

from __future__ import annotations

from pathlib import Path

import click

from spiral_gripper.cli.gripper import described, mounted
from spiral_gripper.cli.output import print_rows, say_written
from spiral_gripper.cli.types import (
    LENGTH,
    YAML_FILE,
    Suffixed,
    gripper_argument,
    mount_options,
    option,
    typed,
    units_option,
)
from spiral_gripper.cli.workers import progress_bar

SHEET_FILE = Suffixed((".pdf", ".svg"))


@click.command()
@gripper_argument
@option("--radius", LENGTH, "Radius of the object.", required=True)
@mount_options
@option("--save", YAML_FILE, "Write the model to a .yaml file.  [default: print it]")
def model(gripper: str, radius: float, save: Path | None, **options: object) -> None:
    """Print the swept volume and the collision spheres of GRIPPER, for its URDF.

    GRIPPER is the name of a shipped gripper or the path of a description file. The xacro file
    urdf/spiral_gripper.urdf.xacro of the package spiral_gripper_ros reads the output.
    """
    from spiral_core.grip.grip import solve_grip
    from spiral_core.grip.setup import lay_into_coil
    from spiral_gripper.files.storage import write_file
    from spiral_gripper.reports.robot_model import model_as_yaml, model_of

    setup = lay_into_coil(mounted(described(gripper).gripper, options), radius)
    with progress_bar("closing") as progress:
        grip = solve_grip(setup, (), pressures=(), progress=progress)
    text = model_as_yaml(model_of(grip, radius))
    if save is None:
        click.echo(text, nl=False)
    else:
        write_file(save, text)
        say_written(save)


@click.command("winding-sheet")
@gripper_argument
@option(
    "--end-allowance", LENGTH, "Length of tube for plug and fitting at each end.", shown="20 mm"
)
@option("--save", SHEET_FILE, "Write the template, .pdf or .svg.")
@units_option
def winding_sheet(gripper: str, end_allowance: float, save: Path | None) -> None:
    """Print cut length, pitches and fiber lengths of GRIPPER; write a winding template.

    GRIPPER is the name of a shipped gripper or the path of a description file. The template shows
    the fibers on the unrolled tube in true size: print it at 100 %, lay it around the tube.
    """
    from spiral_gripper.reports.tables import winding_rows

    if end_allowance < 0.0:
        raise click.UsageError(f"--end-allowance {typed('end_allowance')} is below 0")
    description = described(gripper)
    name, actuator = description.gripper.name, description.actuator
    print_rows(name, winding_rows(actuator, end_allowance))
    if save is not None:
        from spiral_gripper.reports.winding_sheet import write_winding_sheet

        write_winding_sheet(actuator, name, end_allowance, save)
        say_written(save)
