# SPDX-License-Identifier: Apache-2.0
"""The command ``spiral-gripper calibrate``: bench measurements to a gripper file and a plot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from spiral_gripper.cli.output import (
    print_json,
    print_lines,
    print_result,
    say_written,
    write_picture,
)
from spiral_gripper.cli.types import (
    LENGTH,
    REPORT_FILE,
    YAML_FILE,
    QuantityType,
    error_text,
    flag,
    option,
    output_options,
    plot_option,
    wanted,
)
from spiral_gripper.cli.workers import progress_bar

if TYPE_CHECKING:
    from spiral_gripper.bench.measurements import Measurements
    from spiral_gripper.bench.options import CalibrationOptions
    from spiral_gripper.files.description import GripperDescription

# Stated here too, so that --help loads nothing heavy; a test holds them to their sources.
LAWS = ("neo_hookean", "mooney_rivlin", "yeoh", "gent")
QUANTITIES = ("bending_stiffness", "torsional_stiffness", "straight_fiber_radius")
DEFAULT_LEVEL = 0.95
DRAWS_MIN = 40
# So many take some minutes; the interval's ends are then known to a hundredth of its width.
DRAWS_MAX = 100_000


@click.command()
@click.argument("gripper")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@option(
    "--law",
    click.Choice(LAWS),
    "Law to fit; several are compared by AICc. [default: the file's own; "
    "neo_hookean where the readings do not determine its constants]",
    many="laws",
)
@option(
    "--fit",
    click.Choice(QUANTITIES),
    "Quantity to fit in addition to the law's constants.",
    many="quantities",
)
@option(
    "--hold",
    str,
    'Constant to keep at a value, such as "c2=15 kPa".',
    many="hold",
    metavar="NAME=VALUE",
)
@option(
    "--unit",
    str,
    'Unit of a column without one, such as "pressure=psi".',
    many="units",
    metavar="COLUMN=UNIT",
)
@option(
    "--error",
    str,
    'Standard error, such as "extension=0.2 mm" or "bend_angle=2 %".',
    many="errors",
    metavar="COLUMN=ERROR",
)
@option(
    "--section-length",
    QuantityType("LENGTH", above=0.0, most="10 m"),
    "Unstretched length of the measured section. [default: the tube's length]",
)
@option("--ignore", str, "Column to ignore.", many="ignored", metavar="HEADING")
@flag("--robust", "Leave out outliers, at most a third of the readings.")
@flag("--accept-implausible", "Accept readings that look like a mix-up of units.")
@flag(
    "--measured-curve",
    "Fit nothing: write the measured curvature and torsion into the gripper file.",
)
@flag("--free-swing", "Fit the damping of material and air to the tip's displacement against time.")
@option(
    "--radius",
    LENGTH,
    "Object radius for which to print the pressure that wraps it, with its interval.",
    many="radii",
)
@option(
    "--draws",
    click.IntRange(DRAWS_MIN, DRAWS_MAX),
    "Number of Monte Carlo draws for the intervals of --radius; without it they are "
    "propagated linearly.",
)
@option("--seed", click.IntRange(min=0), "Seed of the Monte Carlo draws.", shown=0)
@option(
    "--level",
    click.FloatRange(0.0, 1.0, min_open=True, max_open=True),
    "Confidence level of the intervals.",
    shown=DEFAULT_LEVEL,
)
@option("--save", YAML_FILE, "Gripper file to write. [default: a new file beside the original]")
@flag("--no-save", "Write no gripper file.")
@output_options
@plot_option
@option("--report", REPORT_FILE, "Write a report to a .md or .html file.")
def calibrate(
    gripper: str,
    files: tuple[Path, ...],
    measured_curve: bool,
    free_swing: bool,
    save: Path | None,
    no_save: bool,
    report: Path | None,
    **options: Any,  # noqa: ANN401  # of parse_options
) -> int:
    """Fit a gripper's constants to bench measurements.

    GRIPPER is the name of a shipped gripper or a description file, FILES are CSV files with units
    in their headings. The calibrated description is written beside the original; nothing is
    overwritten.
    """
    if save is not None and no_save:
        raise click.UsageError("--save and --no-save exclude each other")
    from spiral_gripper.bench.options import parse_options
    from spiral_gripper.bench.run import load_files
    from spiral_gripper.cli.gripper import described

    if options["draws"] is not None and not options["radii"]:
        raise click.UsageError("--draws goes with --radius, whose interval it draws")
    if options["seed"] and options["draws"] is None:
        raise click.UsageError("--seed goes with --draws")
    description = described(gripper)
    stated = parse_options(free_swing=free_swing, **options)
    if free_swing:
        if measured_curve or save is not None:
            raise click.UsageError("--free-swing writes no gripper file and excludes other kinds")
        _refuse_unused("--free-swing fits the damping only", stated, report, "--hold", "--level")
        if stated.section_length is not None:
            raise click.UsageError("--free-swing takes the gripper's length: no --section-length")
        from spiral_gripper.bench.swing import FREE_SWING, fit_free_swing

        print_result(FREE_SWING, fit_free_swing(description, files, stated))
        return 0
    measurements = load_files(description, files, stated)
    if measured_curve:
        _refuse_unused("--measured-curve fits nothing", stated, report, "--accept-implausible")
        return _write_curve(description, measurements, stated, save, no_save)
    from spiral_gripper.bench.report import CALIBRATION, radius_rows
    from spiral_gripper.bench.run import calibrate_gripper
    from spiral_gripper.reports.fields import document_of, rows_of

    with progress_bar("fitting") as progress:
        result = calibrate_gripper(description, measurements, stated, progress)
    typed_values = click.get_current_context().obj or {}
    # Radii that cannot be gripped do not stop the rest.
    refusals = [error_text(error, typed_values) for error in result.refusals]
    if wanted("json"):
        print_json({**document_of(CALIBRATION, result), "refusals": refusals})
    else:
        warnings = [("warning", warning) for warning in result.warnings]
        print_lines([*rows_of(CALIBRATION, result), *warnings, *radius_rows(result)])
    name, best = description.gripper.name, result.choice.best
    if wanted("plot"):
        from spiral_gripper.bench.residual_plot import residual_figure

        write_picture(residual_figure(best, name))
    if report is not None:
        from spiral_gripper.bench.written_report import write_calibration_report

        write_calibration_report(result, refusals, name, report)
        say_written(report)
    if not no_save:
        from spiral_gripper.bench.calibrated_file import write_calibrated_description

        sources = [one.source for one in measurements]
        say_written(write_calibrated_description(description, best, sources, save))
    if refusals:
        raise click.ClickException("\n".join(refusals))
    return 0


def _write_curve(
    description: GripperDescription,
    measurements: list[Measurements],
    options: CalibrationOptions,
    save: Path | None,
    no_save: bool,
) -> int:
    """Print the measured actuation curve, and write it into a gripper file."""
    from spiral_gripper.bench.run import measured_curve
    from spiral_gripper.files.shown import shown

    curve = measured_curve(description, measurements, options)
    if wanted("json"):
        names = ("pressures", "curvatures", "torsions")
        print_json({name: getattr(curve, name) for name in names})
    else:
        click.echo(f"measured up to {shown(curve.pressure_limit, 'Pa')}")
    if not no_save:
        from spiral_gripper.bench.calibrated_file import write_measured_description

        sources = [one.source for one in measurements]
        say_written(write_measured_description(description, curve, sources, save))
    return 0


def _refuse_unused(
    reason: str, options: CalibrationOptions, report: Path | None, *but: str
) -> None:
    """Refuse options that a fit of the law has, where there is none."""
    given = {
        "--law": options.laws,
        "--fit": options.quantities,
        "--hold": options.fixed,
        "--robust": options.robust,
        "--radius": options.radii,
        "--draws": options.draws,
        "--level": options.level != DEFAULT_LEVEL,
        "--accept-implausible": options.accept_implausible,
        "--plot": wanted("plot"),
        "--report": report,
    }
    for name, value in given.items():
        if value and name not in but:
            raise click.UsageError(f"{reason}: leave {name} out")
