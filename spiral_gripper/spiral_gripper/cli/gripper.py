# SPDX-License-Identifier: Apache-2.0
"""The commands ``shape``, ``wrap`` and ``grip``: what one gripper does."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from spiral_gripper.cli.output import (
    print_json,
    print_result,
    print_rows,
    say_written,
    write_picture,
)
from spiral_gripper.cli.requirement import gravity_from
from spiral_gripper.cli.types import (
    FORCE,
    PRESSURE,
    Suffixed,
    flag,
    friction_option,
    gripper_argument,
    mount_options,
    note_unit,
    object_options,
    option,
    output_options,
    payload_option,
    place_options,
    plot_option,
    sensitivity_option,
    typed,
    typed_all,
    unit_vector,
    wanted,
)
from spiral_gripper.cli.workers import computing, progress_bar

if TYPE_CHECKING:
    from spiral_core.rod.types import Vector
    from spiral_core.wrap.gripper import Gripper
    from spiral_gripper.files.description import GripperDescription
    from spiral_gripper.reports.grip.document import GripQuestion, SolvedGrip
    from spiral_gripper.reports.grip.sensitivity import Varied

# Options of grip that go with --table.
_OF_A_TABLE = ("gripper", "--table", "--table-radii", "--json", "--units")
# Settling times of a table follow ramps at this rate [Pa/s], the default of the node's
# pressure.rate_up.
RAMP = 15.0e3


@click.command()
@gripper_argument
@option("--pressure", PRESSURE, "Gauge pressure.", required=True)
@mount_options
@output_options
@plot_option
def shape(gripper: str, pressure: float, **options: object) -> None:
    """Print the shape of GRIPPER at a pressure.

    GRIPPER is the name of a shipped gripper or the path of a description file. Positions are in
    the base frame: the tube leaves the base along +x, +y points towards the straight fiber.
    """
    from spiral_gripper.reports.wrap_document import SHAPE, solve_shape

    description = described(gripper)
    mount = mounted(description.gripper, options)
    require_pressure(description, pressure, typed("pressure"))
    title = f"{mount.name} at {typed('pressure')}"
    solved = solve_shape(mount, pressure)
    print_result(SHAPE, solved, title)
    if wanted("plot"):
        from spiral_gripper.reports.shaded import tube_surface
        from spiral_gripper.reports.shape_plots import shape_figure

        tube = tube_surface(solved.state.positions, mount.tube.outer_radius)
        write_picture(shape_figure([tube], title))


@click.command()
@gripper_argument
@object_options
@place_options
@option("--pressure", PRESSURE, "Print the wrap at this pressure.")
@flag("--tip-criterion", "Estimate with the free coil alone, without contact.")
@sensitivity_option
@mount_options
@output_options
@plot_option
def wrap(
    gripper: str,
    radius: float | None,
    profile: Path | None,
    place: Vector | None,
    find_place: bool,
    pressure: float | None,
    tip_criterion: bool,
    sensitivity: bool,
    **options: object,
) -> None:
    """Print the pressures at which GRIPPER is wrapped around an object.

    GRIPPER is the name of a shipped gripper or the path of a description file. The gripper closes
    slowly on the object, with contact and the friction of its file, or 0.3, as in grip, which also
    computes forces. Figures are those at --pressure, else at the recommended pressure.
    --tip-criterion: when the free coil's tip has the object's radius.
    """
    if (radius is None) == (profile is None):
        raise click.UsageError("give either --radius or --profile")
    if tip_criterion and profile is not None and pressure is not None:
        raise click.UsageError("with --tip-criterion --pressure goes with --radius")
    if tip_criterion and (place or find_place):
        raise click.UsageError("--tip-criterion knows no place but the free coil's")
    from spiral_gripper.reports.grip.document import GripQuestion, solve_question
    from spiral_gripper.reports.grip.rows import wrap_as_dict, wrap_rows
    from spiral_gripper.reports.wrap_document import solve_profile, solve_wrap

    description = described(gripper)
    mount = mounted(description.gripper, options)
    if pressure is not None:
        require_pressure(description, pressure, typed("pressure"))
    closed, coiled, asked = None, mount, pressure
    pressures = () if pressure is None else (pressure,)
    question = GripQuestion(mount, radius, profile, pressures=pressures, place=place)
    if not tip_criterion:
        question = located(question, find_place)
        with progress_bar("closing", quiet=not sys.stderr.isatty()) as progress:
            closed = solve_question(question, progress, forces=False)
        coiled, asked = replace(mount, object_axis=None), None  # the coil that it was laid into
    free = (
        solve_wrap(coiled, float(radius or 0.0), asked)
        if profile is None
        else solve_profile(coiled, profile)
    )
    method = "tip" if closed is None else "wrap"
    varied = _varied(method, question, description, closed) if sensitivity else None
    if wanted("json"):
        print_json(wrap_as_dict(free, closed) | (varied.as_dict() if varied else {}))
    else:
        print_rows(mount.name, wrap_rows(free, closed))
        _print_varied(varied)
    if wanted("plot"):
        from spiral_gripper.reports.grip.plots import wrap_figure

        around = "" if radius is None else f" around {typed('radius')},"
        write_picture(wrap_figure(free, closed, f"{mount.name}{around} at"))


@click.command()
@gripper_argument
@object_options
@place_options
@friction_option
@flag(
    "--frictionless-closing",
    "Close without friction, then pull with friction: the best case.",
    to="frictionless",
)
@flag("--every-direction", "Also pull sideways and along gravity, and twist.")
@option(
    "--pressure",
    PRESSURE,
    "Look at this pressure in place of ten. May be repeated.",
    many="pressures",
)
@payload_option
@flag(
    "--spread",
    "Close again with the object moved aside by a millionth of the length, and print what "
    "that changes.",
)
@option("--force-max", FORCE, "Greatest sum of normal forces on the object.")
@flag(
    "--table",
    "Write the grips on all radii, as the file describes the gripper, to NAME.grips.json beside "
    "it, for the ROS 2 node. Takes some minutes.",
)
@option(
    "--table-radii",
    click.IntRange(2, 50),
    "Number of radii that a table begins with; up to ten times as many where it is refined.",
    shown=6,
)
@sensitivity_option
@mount_options
@output_options
@plot_option
def grip(
    gripper: str,
    find_place: bool,
    table: bool,
    table_radii: int,
    sensitivity: bool,
    **options: Any,  # noqa: ANN401  # of the mount and of GripQuestion
) -> int:
    """Print the pressures at which GRIPPER holds an object, and the forces that it holds.

    GRIPPER is the name of a shipped gripper or the path of a description file. The object lies in
    the coil, along --object-axis or along the coil's own direction, and the pressure rises slowly.
    Forces are computed by moving the object until it slips, with contact and friction. With
    --pressure the figures are those at the first one given, else at the recommended pressure. Exit
    code 1: no pressure looked at carries the payload within the greatest force; or no radius of
    the --table is held.
    """
    given = _options_given()
    if table:
        return _tabulate(gripper, table_radii, given)
    if "--table-radii" in given:
        raise click.UsageError("--table-radii goes with --table")
    if (options["radius"] is None) == (options["profile"] is None):
        raise click.UsageError("give either --radius or --profile")
    from spiral_gripper.reports.grip.document import GripQuestion, solve_question
    from spiral_gripper.reports.grip.rows import GRIP, grip_as_dict, print_forces

    description = described(gripper)
    mount = mounted(description.gripper, options)
    question = GripQuestion(mount, **options)
    texts = typed_all("pressures") if question.pressures else ()
    for pressure, text in zip(question.pressures, texts, strict=True):
        require_pressure(description, pressure, text)
    if question.payload is not None and not any(mount.gravity):
        raise click.UsageError("--payload needs gravity, and the mount has none")
    question = located(question, find_place)
    with progress_bar("closing, then pulling") as progress:
        solved = solve_question(question, progress)
    varied = _varied("grip", question, description, solved) if sensitivity else None
    if wanted("json"):
        print_json(grip_as_dict(solved) | (varied.as_dict() if varied else {}))
    else:
        from rich.console import Console

        from spiral_gripper.reports.fields import rows_of

        print_rows(f"{mount.name}, will it hold?", rows_of(GRIP, solved))
        print_forces(solved, Console())
        _print_varied(varied)
    if wanted("plot"):
        from spiral_gripper.reports.grip.plots import grip_figure

        what = question.profile or f"radius {typed('radius')}"
        figure = grip_figure(solved.grip, f"{mount.name} on {what}", solved.point.pressure)
        write_picture(figure)
    return 0 if solved.refusal is None else 1


def _options_given() -> list[str]:
    """Return the options of this command that were typed."""
    context = click.get_current_context()
    sources = {
        one.opts[0]: context.get_parameter_source(str(one.name)) for one in context.command.params
    }
    return [name for name, source in sources.items() if source is ParameterSource.COMMANDLINE]


def _tabulate(gripper: str, count: int, given: list[str]) -> int:
    """Write the table of grips of a description file beside it; return the exit code.

    Raises:
        click.UsageError: another option was given, or the name of a shipped gripper.
    """
    others = [name for name in given if name not in _OF_A_TABLE]
    if others:
        raise click.UsageError(
            f"--table does not go with {', '.join(others)}: its grips are those that the file "
            "describes, for all radii"
        )
    from spiral_core.grip.table import TOLERANCE
    from spiral_core.grip.tabulate import solve_table
    from spiral_gripper.files.grips import SUFFIX, write_grips
    from spiral_gripper.files.shown import shown, shown_range

    description = described(gripper)
    path = own_file_beside(description, gripper, SUFFIX)
    with computing("closing, then pulling") as (executor, progress):
        found = solve_table(description.gripper, count, RAMP, executor, progress)
    write_grips(found, description)
    pairs = zip(found.radii, found.grips, strict=True)
    not_held = [radius for radius, held in pairs if held is None]
    known = [error for error in found.errors if error < math.inf]
    error = max(known, default=None)
    if wanted("json"):
        print_json({"path": str(path), "radii": found.radii, "error": error, "not_held": not_held})
    else:
        click.echo(
            f"{description.gripper.name}: {len(found.radii)} radii "
            f"{shown_range(found.radii[0], found.radii[-1])}; forces between them are off by at "
            f"most {100.0 * (error or 0.0):.2g} %, and not stated above {100.0 * TOLERANCE:g} %; "
            f"not held: {', '.join(shown(radius, 'm') for radius in not_held) or 'none'}"
        )
        say_written(path)
    return 0 if len(not_held) < len(found.radii) else 1


def own_file_beside(description: GripperDescription, name: str, suffix: str) -> Path:
    """Return the path of a file to write beside a description, where files can be written.

    Raises:
        click.UsageError: the gripper was given by the name of a shipped one.
    """
    from spiral_gripper.files.beside import path_beside
    from spiral_gripper.files.catalog import available_grippers

    if name in available_grippers():
        raise click.UsageError(
            f"--table writes a file beside that of the gripper, and {name} is a shipped one; copy "
            f"it first: spiral-gripper grippers show {name} > mine.yaml"
        )
    return Suffixed((".json",)).convert(path_beside(description, suffix), None, None)


def _varied(
    name: str,
    question: GripQuestion,
    description: GripperDescription,
    solved: SolvedGrip | None,
) -> Varied:
    """Return what the inputs of a question change, and how they were solved."""
    from spiral_gripper.reports.grip.sensitivity import METHODS, solve_sensitivity

    method = METHODS[name]
    setup, pressure = (None, 0.0) if solved is None else (solved.grip.setup, solved.point.pressure)
    with computing("changing every input") as (executor, progress):
        return solve_sensitivity(method, question, description, setup, pressure, executor, progress)


def _print_varied(varied: Varied | None) -> None:
    if varied is not None:
        from rich.console import Console

        Console().print(varied.table())


def located(question: GripQuestion, find_place: bool) -> GripQuestion:
    """Return a question with the object where it is held, if a place is to be found.

    Raises:
        click.UsageError: a place is given as well.
    """
    if not find_place:
        return question
    if question.place is not None:
        raise click.UsageError("give either --place or --find-place")
    from spiral_gripper.reports.grip.document import placed

    with computing("looking for a place") as (executor, progress):
        return placed(question, executor, progress)


def mounted(gripper: Gripper, options: dict[str, Any]) -> Gripper:
    """Return a gripper with the mount that the options state."""
    gravity = gravity_from(options, gripper.gravity)
    axis = options.pop("object_axis")
    if gravity is not None:
        gripper = replace(gripper, gravity=gravity)
    if axis:
        gripper = replace(gripper, object_axis=unit_vector("--object-axis", axis))
    return gripper


def described(name_or_path: str) -> GripperDescription:
    """Return a description file's content; print its warnings on standard error."""
    from spiral_gripper.files.description import load_description

    description = load_description(name_or_path)
    note_unit(description.written["limits.pressure_max"], "PRESSURE")
    for warning in description.warnings:
        click.echo(f"warning: {warning}", err=True)
    return description


def require_pressure(description: GripperDescription, pressure: float, text: str) -> None:
    """Refuse a pressure [Pa], typed as ``text``, outside the gripper's limits.

    Raises:
        click.UsageError: it is negative, or above the file's limit.
    """
    if pressure < 0.0:
        raise click.UsageError(f"--pressure {text} is below 0: pressures are gauge pressures")
    if pressure > description.gripper.pressure_max:
        limit = description.written["limits.pressure_max"]
        raise click.UsageError(
            f"--pressure {text} is above limits.pressure_max, {limit}, of {description.source.name}"
        )
