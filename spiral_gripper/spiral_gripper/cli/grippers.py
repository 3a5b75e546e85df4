# SPDX-License-Identifier: Apache-2.0
"""The commands ``grippers list``, ``show`` and ``check``: gripper description files."""

from __future__ import annotations

from typing import Any

import click

from spiral_gripper.cli.gripper import described
from spiral_gripper.cli.group import Group
from spiral_gripper.cli.output import print_json
from spiral_gripper.cli.types import gripper_argument, json_option, output_options, wanted


@click.group(cls=Group)
def grippers() -> None:
    """List, show and check gripper files."""


@grippers.command("list")
@json_option
def list_grippers() -> None:
    """List the shipped grippers."""
    from spiral_gripper.files.catalog import available_grippers
    from spiral_gripper.files.description import load_description

    found = {name: load_description(name).description for name in available_grippers()}
    if wanted("json"):
        print_json([{"name": name, "description": text} for name, text in found.items()])
        return
    for name, text in found.items():
        click.echo(f"{name}  {text}")


@grippers.command()
@gripper_argument
@json_option
def show(gripper: str) -> None:
    """Print GRIPPER's file, as a start for your own; with --json its content in SI units.

    GRIPPER is the name of a shipped gripper or the path of a description file.
    """
    if wanted("json"):
        print_json(_document(gripper))
        return
    from spiral_gripper.files.catalog import find_description, read_description_text

    click.echo(read_description_text(find_description(gripper)), nl=False)


@grippers.command()
@gripper_argument
@output_options
def check(gripper: str) -> int:
    """Print whether GRIPPER's file is valid, its warnings, and the radii it grips.

    GRIPPER is the name of a shipped gripper or the path of a description file. It closes on
    cylinders over its range, with contact and friction, as in wrap and grip. Exit codes: 1, it
    grips none of them; 2, the file cannot be used.
    """
    from spiral_core.grip.places import held_radii
    from spiral_core.grip.setup import friction_of
    from spiral_gripper.cli.workers import computing
    from spiral_gripper.files.shown import shown_range

    description = described(gripper)
    with computing("closing on cylinders") as (executor, progress):
        ranges = held_radii(description.gripper, executor, progress)
    friction = friction_of(description.gripper, None)
    if wanted("json"):
        reach = [ranges[0][0], ranges[-1][1]] if ranges else None
        found = {"radius_range": reach, "radius_ranges": ranges, "friction": friction}
        print_json({"source": str(description.source), **found})
        return 0 if ranges else 1
    limit = description.written["limits.pressure_max"]
    reached = ", ".join(f"from {shown_range(*each)}" for each in ranges)
    said = f"grips radii {reached}," if ranges else "grips no radius where its free coil lies,"
    click.echo(f"{description.gripper.name}: valid; {said} up to {limit}, friction {friction:g}")
    return 0 if ranges else 1


def _document(name_or_path: str) -> dict[str, Any]:
    """Return the content of a description file, in SI."""
    description = described(name_or_path)
    gripper, actuator = description.gripper, description.actuator
    section = gripper.stiffness
    return {
        "source": str(description.source),
        "name": gripper.name,
        "description": description.description,
        "tube": actuator.tube,
        "fibers": actuator.fibers,
        "law": type(actuator.material).__name__,
        "material": actuator.material,
        "density": description.density,
        "stiffness": {
            "bending": section.bending,
            "torsional": section.torsional,
            "sideways": section.sideways,
            "coupling": section.coupling,
        },
        "gravity": gripper.gravity,
        "object_axis": gripper.object_axis,
        "pressure_max": gripper.pressure_max,
        "actuation_limit": gripper.actuation.pressure_limit,
        "turns_required": gripper.turns_required,
        "friction_coefficient": gripper.friction_coefficient,
        "warnings": description.warnings,
    }
