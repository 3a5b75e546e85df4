# SPDX-License-Identifier: Apache-2.0
"""The command ``model``: a gripper as a part of a robot's description."""

from __future__ import annotations

from pathlib import Path

import click

from spiral_gripper.cli.gripper import described, mounted
from spiral_gripper.cli.types import LENGTH, YAML_FILE, gripper_argument, mount_options


@click.command()
@gripper_argument
@click.option(
    "--radius", type=LENGTH, metavar="LENGTH", required=True, help="Of the object to be wrapped."
)
@mount_options
@click.option(
    "--output", "-o", type=YAML_FILE, metavar="FILE", help="A .yaml file.  [default: printed]"
)
def model(gripper: str, radius: float, output: Path | None, **options: object) -> None:
    """Print the swept volume and the collision spheres of GRIPPER, for its URDF.

    GRIPPER is the name of a shipped gripper or the path of a description file. The file is read by
    urdf/spiral_gripper.urdf.xacro of the package spiral_gripper_ros.
    """
    from spiral_gripper.cli.output import say_written
    from spiral_gripper.files.storage import write_file
    from spiral_gripper.reports.robot_model import model_as_yaml, solve_model

    text = model_as_yaml(solve_model(mounted(described(gripper).gripper, options), radius))
    if output is None:
        click.echo(text, nl=False)
    else:
        write_file(output, text)
        say_written(output)
