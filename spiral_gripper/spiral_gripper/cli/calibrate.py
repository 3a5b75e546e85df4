"""The command ``spiral-gripper calibrate``: bench measurements to a gripper file and a plot."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import click

from spiral_gripper.cli.types import Quantity

# Stated here too, so that --help loads nothing heavy; a test holds them to their sources.
LAWS: Final = ("neo_hookean", "mooney_rivlin", "yeoh", "gent")
QUANTITIES: Final = ("bending_stiffness", "torsional_stiffness", "straight_fiber_radius")
DEFAULT_LEVEL: Final = 0.95
DRAWS_MIN: Final = 40
# So many take some minutes; the interval's ends are then known to a hundredth of its width.
DRAWS_MAX: Final = 100_000


@click.command()
@click.argument("gripper")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--law",
    "laws",
    multiple=True,
    type=click.Choice(LAWS),
    help="Law to fit; several are compared by AICc. Default: the description's own.",
)
@click.option(
    "--fit",
    "quantities",
    multiple=True,
    type=click.Choice(QUANTITIES),
    help="What to fit beside the law's constants.",
)
@click.option(
    "--hold",
    multiple=True,
    metavar="NAME=VALUE",
    help='Constant that is held, such as "c2=15 kPa".',
)
@click.option(
    "--unit",
    "units",
    multiple=True,
    metavar="COLUMN=UNIT",
    help='Unit of a column without one, such as "pressure=psi".',
)
@click.option(
    "--error",
    "errors",
    multiple=True,
    metavar="COLUMN=ERROR",
    help='Standard error, such as "extension=0.2 mm" or "bend_angle=2 %".',
)
@click.option(
    "--section-length",
    type=Quantity("LENGTH"),
    metavar="LENGTH",
    help="Unstretched length that was measured. Default: the tube's.",
)
@click.option(
    "--ignore", "ignored", multiple=True, metavar="HEADING", help="Column that is no measurement."
)
@click.option("--robust", is_flag=True, help="Allow for outliers (Huber's loss).")
@click.option(
    "--accept-implausible",
    is_flag=True,
    help="Take the readings as they are, even if a mix-up of units is likely.",
)
@click.option(
    "--measured-curve",
    is_flag=True,
    help="Fit nothing: write the measured curvature and torsion into the gripper file.",
)
@click.option(
    "--radius",
    "radii",
    multiple=True,
    type=Quantity("LENGTH"),
    metavar="LENGTH",
    help="Object radius whose pressure is wanted with its uncertainty.",
)
@click.option(
    "--draws",
    type=click.IntRange(DRAWS_MIN, DRAWS_MAX),
    help="Use so many Monte Carlo draws for it, in place of linear propagation.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Of the Monte Carlo draws.",
)
@click.option(
    "--level",
    type=click.FloatRange(0.0, 1.0, min_open=True, max_open=True),
    default=DEFAULT_LEVEL,
    show_default=True,
    help="Confidence level.",
)
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    help="Gripper file to write. Default: a new file beside the original.",
)
@click.option("--no-output", is_flag=True, help="Report only: write no gripper file.")
@click.option("--plot", type=click.Path(path_type=Path), help="Residual plot to write.")
def calibrate(
    gripper: str,
    files: tuple[Path, ...],
    **options: Any,  # noqa: ANN401  # the fields of CommandOptions
) -> None:
    """Fit a gripper's constants to bench measurements.

    GRIPPER is the name of a shipped gripper or a description file, FILES are CSV files with units
    in their headings. The calibrated description is written beside the original; nothing is
    overwritten.
    """
    from spiral_gripper.bench.command import CommandOptions, run_command

    for line in run_command(gripper, files, CommandOptions(**options)):
        click.echo(line)
