# SPDX-License-Identifier: Apache-2.0
"""The command ``sweep``: many designs or grips at once, on all cores."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from spiral_gripper.cli.group import Group
from spiral_gripper.cli.output import print_json, write_picture
from spiral_gripper.cli.requirement import gravity_of, requirement_from, requirement_options
from spiral_gripper.cli.types import (
    FRICTION,
    NUMBER,
    POSITIVE_LENGTH,
    jobs_option,
    option,
    output_options,
    plot_option,
    results_option,
    wanted,
)
from spiral_gripper.cli.workers import computing

MOST_ANGLES = 181


@click.group(cls=Group)
def sweep() -> None:
    """Compute many designs or grips at once."""


@sweep.command("map")
@requirement_options
@option("--angles", click.IntRange(2, MOST_ANGLES), "Number of fiber angles.", shown=15)
@option("--tube-radius-min", POSITIVE_LENGTH, "Smallest inner radius of the tube.", shown="2 mm")
@option("--tube-radius-max", POSITIVE_LENGTH, "Largest inner radius of the tube.", shown="8 mm")
@option("--tube-radii", click.IntRange(2, 181), "Number of tube radii.", shown=13)
@option("--wall", POSITIVE_LENGTH, "Wall thickness of all tubes.", shown="1/32 in")
@jobs_option
@output_options
@plot_option
def feasibility(
    angles: int,
    tube_radius_min: float,
    tube_radius_max: float,
    tube_radii: int,
    wall: float,
    **options: Any,  # noqa: ANN401  # of the requirement
) -> None:
    """Map where the seven steps of design find grippers, over fiber angle and tube radius.

    They judge a wrap by the tip criterion; design also closes its gripper on the objects.
    The angles are those between the first and the last --beta, by default 40 to 85 deg.
    """
    betas = options["fiber_angles_beta"] or (math.radians(40.0), math.radians(85.0))
    if not min(betas) < max(betas):
        raise click.UsageError("give --beta twice, the first and the last angle, or not at all")
    if len(options["fiber_angles_gamma"]) > 1:
        raise click.UsageError("give --gamma once at most: map varies --beta and the tube")
    if options["tubes"]:
        raise click.UsageError(
            "--tube does not go with map, which varies the tube: give --tube-radius-min, "
            "--tube-radius-max and --wall"
        )
    if not tube_radius_min < tube_radius_max:
        raise click.UsageError("--tube-radius-min must be below --tube-radius-max")
    requirement = requirement_from(options)

    import numpy as np

    from spiral_core.design.sweep import feasibility_map

    with computing("solving") as (executor, progress):
        result = feasibility_map(
            requirement,
            np.linspace(min(betas), max(betas), angles).tolist(),
            np.linspace(tube_radius_min, tube_radius_max, tube_radii).tolist(),
            wall,
            executor,
            progress,
        )
    if wanted("json"):
        print_json(result)
    else:
        click.echo(
            f"{100.0 * (result.room >= 0.0).mean():.0f} % of {result.room.size} candidates "
            "are feasible"
        )
    if wanted("plot"):
        from spiral_gripper.reports.plots import feasibility_figure

        write_picture(feasibility_figure(result))


@sweep.command()
@requirement_options
@jobs_option
@output_options
@plot_option
def pareto(**options: object) -> None:
    """List the Pareto-optimal designs in pressure, strain and length.

    Each of them is closed on the largest, the middle and the smallest object, with contact and
    friction; what does not wrap them where its free coil lies is left out.
    """
    requirement = requirement_from(options, contact=True)

    from spiral_core.design.sweep import closed_pareto_set, solve_points

    with computing("solving") as (executor, progress):
        points = solve_points(requirement, requirement.candidates(), executor, progress)
    with computing("closing") as (executor, progress):
        best = closed_pareto_set(requirement, points, executor, progress)
    if wanted("json"):
        from spiral_gripper.reports.design_document import POINT
        from spiral_gripper.reports.fields import document_of

        print_json([document_of(POINT, point) for point in best])
    else:
        from rich.console import Console

        from spiral_gripper.reports.tables import print_points

        feasible = sum(point.feasible for point in points)
        title = f"{len(best)} of {feasible} feasible designs ({len(points)} candidates)"
        print_points(title, best, Console())
    if wanted("plot"):
        from spiral_gripper.reports.plots import pareto_figure

        write_picture(pareto_figure(points, best))


@sweep.command()
@click.argument("grippers", metavar="GRIPPER...", nargs=-1, required=True)
@option("--radius", POSITIVE_LENGTH, "Radius of a cylinder.", many="radii", required=True)
@option(
    "--friction",
    FRICTION,
    "Friction coefficient of tube and object; by default each gripper file's, or 0.3.",
    many="frictions",
    metavar="MU",
)
@option(
    "--gravity-direction",
    NUMBER,
    "Direction of gravity in the base frame; 1 0 0 for a gripper that hangs. "
    "[default: as in the gripper files]",
    many="directions",
    nargs=3,
    metavar="X Y Z",
)
@results_option
@jobs_option
@output_options
@plot_option
def grips(
    grippers: tuple[str, ...],
    radii: tuple[float, ...],
    frictions: tuple[float, ...],
    directions: tuple[tuple[float, float, float], ...],
    results: Path | None,
) -> int:
    """Close every GRIPPER on every object, with every friction and mount.

    --radius, --friction and --gravity-direction may be repeated. Forces are those at each grip's
    recommended pressure after slow closing. Ctrl-C prints the grips that are done; exit code 1.
    """
    from spiral_core.grip.grip import GripCase, GripOutcome, grip_cases, solve_cases
    from spiral_gripper.cli.gripper import described
    from spiral_gripper.reports.grip.study import (
        ResultFile,
        case_as_dict,
        key_of,
        print_outcomes,
    )

    cases: tuple[GripCase, ...] = ()
    for own in [described(name).gripper for name in grippers]:
        gravities = [gravity_of(own.gravity, direction) for direction in directions]
        cases += grip_cases([own], radii, frictions or None, gravities or None)
    keys, store = [key_of(case) for case in cases], ResultFile(results, (), GripOutcome)
    known = {n: store.known[key] for n, key in enumerate(keys) if key in store.known}
    done = dict(known)

    def keep(number: int, outcome: GripOutcome) -> None:
        done[number] = outcome
        store.keep(keys[number], outcome)

    interrupted = False
    try:
        with computing("solving") as (executor, progress):
            solve_cases(cases, executor, progress, known=known, keep=keep)
    except KeyboardInterrupt:
        interrupted = True
        click.echo(f"interrupted: {len(done)} of {len(cases)} grips are done", err=True)
    cases = tuple(cases[number] for number in sorted(done))
    outcomes = [done[number] for number in sorted(done)]
    if wanted("json"):
        print_json([case_as_dict(*pair) for pair in zip(cases, outcomes, strict=True)])
    else:
        from rich.console import Console

        print_outcomes(cases, outcomes, Console())
    if wanted("plot") and cases:
        from spiral_gripper.reports.grip.plots import study_accuracy, window_figure

        caption = study_accuracy(cases, outcomes)
        write_picture(window_figure(cases, outcomes, caption))
    return 1 if interrupted else 0
