# SPDX-License-Identifier: Apache-2.0
"""The command ``approach``: how an arm should hold a gripper."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import click

from spiral_gripper.cli.gripper import described
from spiral_gripper.cli.output import print_json, write_picture
from spiral_gripper.cli.types import (
    NUMBER,
    POSITIVE_LENGTH,
    QuantityType,
    flag,
    friction_option,
    gripper_argument,
    jobs_option,
    option,
    output_options,
    payload_option,
    plot_option,
    results_option,
    typed,
    unit_vector,
    wanted,
)
from spiral_gripper.cli.workers import computing


@click.command()
@gripper_argument
@option("--radius", POSITIVE_LENGTH, "Radius of a cylinder.", required=True)
@option(
    "--object-axis",
    NUMBER,
    "Direction of the object in the world.",
    nargs=3,
    required=True,
    metavar="X Y Z",
)
@option(
    "--gravity",
    NUMBER,
    "Direction of gravity in the world.",
    nargs=3,
    metavar="X Y Z",
    default=(0.0, 0.0, -1.0),
    show_default="0 0 -1",
)
@payload_option
@friction_option
@option(
    "--tilt-max",
    QuantityType("ANGLE", above=0.0, most="180 deg"),
    "Largest angle between the tube at the base and gravity that the arm can reach.",
    shown="180 deg",
)
@flag("--coarse", "Only whether it grips, and poses; no regions.")
@results_option
@jobs_option
@output_options
@plot_option
def approach(
    gripper: str,
    radius: float,
    object_axis: tuple[float, float, float],
    gravity: tuple[float, float, float],
    payload: float | None,
    friction: float | None,
    tilt_max: float,
    coarse: bool,
    results: Path | None,
) -> int:
    """Print how an arm should hold GRIPPER to grip an object that stands in the world.

    GRIPPER is the name of a shipped gripper or the path of a description file; its mount does not
    count. Up to three poses of the base, each more than 20 degrees from the others, the best first:
    the largest region of capture, then the largest holding force. Exit code 1: no pose grips.
    """
    from spiral_core.grip.approach import ApproachTask, find_approaches
    from spiral_core.wrap.gripper import STANDARD_GRAVITY
    from spiral_gripper.reports.grip.approach import answer_as_dict, print_answer
    from spiral_gripper.reports.grip.study import approach_file

    x, y, z = unit_vector("--gravity", gravity)
    own = described(gripper).gripper
    if friction is not None:
        own = replace(own, friction_coefficient=friction)
    task = ApproachTask(
        own,
        radius,
        unit_vector("--object-axis", object_axis),
        (STANDARD_GRAVITY * x, STANDARD_GRAVITY * y, STANDARD_GRAVITY * z),
        payload,
        min(tilt_max, math.pi),
    )
    store = approach_file(results, task)
    with computing("closing") as (executor, progress):
        answer = find_approaches(
            task,
            coarse=coarse,
            executor=executor,
            progress=progress,
            known=store.known,
            keep=store.keep,
        )
    if wanted("json"):
        print_json(answer_as_dict(answer))
    else:
        from rich.console import Console

        print_answer(answer, Console())
    if wanted("plot") and answer.approaches:
        from spiral_gripper.reports.grip.plots import approach_figure

        write_picture(approach_figure(answer, f"{own.name} on radius {typed('radius')}"))
    return 0 if answer.approaches else 1
