# SPDX-License-Identifier: Apache-2.0
"""The command ``chart``: charts as pictures and as data."""

from __future__ import annotations

import math

import click

from spiral_gripper.cli.gripper import described, mounted
from spiral_gripper.cli.group import Group
from spiral_gripper.cli.output import print_json, write_picture
from spiral_gripper.cli.types import (
    FIBER_ANGLE,
    LENGTH,
    POSITIVE_LENGTH,
    PRESSURE,
    QuantityType,
    gripper_argument,
    mount_options,
    option,
    output_options,
    plot_option,
    turns_option,
    typed,
    wanted,
)
from spiral_gripper.cli.workers import computing, progress_bar

CHART_BETAS = tuple(math.radians(angle) for angle in (50.0, 60.0, 70.0, 80.0))


@click.group(cls=Group)
def chart() -> None:
    """Draw charts: design space, effect of gravity, pressure against radius, section."""


@chart.command("design-space")
@gripper_argument
@option("--beta", FIBER_ANGLE, "Fiber angle.", many="betas")
@turns_option
@option("--stretch-max", QuantityType(above=1.0), "Largest stretch of the tube.", shown=1.5)
@output_options
@plot_option
def design_space(
    gripper: str,
    betas: tuple[float, ...],
    turns_required: float,
    stretch_max: float,
) -> None:
    """Coil radius, object length and length over tube radius against stretch, for fiber angles.

    The tube and the first angle are GRIPPER's. Computed with the helix model: without gravity,
    for any material. --beta may be repeated.
    """
    _require_output()
    from spiral_core.design.charts import design_space as curves_of

    description = described(gripper)
    name, actuator = description.gripper.name, description.actuator
    mirrored = math.copysign(1.0, actuator.fiber_pair.beta)
    betas = betas or tuple(mirrored * beta for beta in CHART_BETAS)
    curves = curves_of(actuator, betas, turns_required, stretch_max)
    _print_data(curves)
    if wanted("plot"):
        from spiral_gripper.reports.plots import design_space_figure

        write_picture(design_space_figure(curves, name))


@chart.command()
@gripper_argument
@mount_options
@output_options
@plot_option
def gravity(gripper: str, **options: object) -> None:
    """Radius, gripper length and object length against pressure, with and without gravity."""
    _require_output()
    from spiral_core.design.charts import helix_range, pressure_range

    mount = mounted(described(gripper).gripper, options)
    with progress_bar("coiling"):
        heavy = pressure_range(mount)
    weightless = helix_range(mount, heavy.pressure)
    _print_data({"with_gravity": heavy, "without_gravity": weightless})
    if wanted("plot"):
        from spiral_gripper.reports.plots import gravity_figure

        write_picture(gravity_figure(heavy, weightless, mount.name))


@chart.command()
@gripper_argument
@option("--radius-min", POSITIVE_LENGTH, "Smallest object. [default: 1/4 of the largest]")
@option("--radius-max", LENGTH, "Largest object. [default: the largest]")
@mount_options
@output_options
@plot_option
def pressure(
    gripper: str,
    radius_min: float | None,
    radius_max: float | None,
    **options: object,
) -> None:
    """Pressure against object radius: overhang, perfect wrap, curling, and the tip criterion's.

    The gripper is closed on each of 21 objects, with contact and friction, as in wrap and grip.
    """
    _require_output()
    from spiral_core.design.charts import contact_chart
    from spiral_core.wrap.curve import WrapCurve
    from spiral_gripper.files.shown import shown

    curve = WrapCurve(mounted(described(gripper).gripper, options))
    high = curve.radius_max if radius_max is None else radius_max
    low = max(curve.radius_min, 0.25 * high) if radius_min is None else radius_min
    if low >= high:
        low_text = shown(low, "m") if radius_min is None else typed("radius_min")
        high_text = shown(high, "m") if radius_max is None else typed("radius_max")
        raise click.UsageError(f"--radius-min {low_text} is not below --radius-max {high_text}")
    with computing("closing on cylinders") as (executor, progress):
        data = contact_chart(curve, low, high, executor, progress)
    _print_data(data)
    if wanted("plot"):
        from spiral_gripper.reports.plots import regime_figure

        write_picture(regime_figure(data, curve.gripper.name))


@chart.command()
@gripper_argument
@option("--pressure", PRESSURE, "Gauge pressure; up to three.", many="pressures", required=True)
@output_options
@plot_option
def section(gripper: str, pressures: tuple[float, ...]) -> None:
    """Cross-section of the tube at pressures, colored by the wall's axial stretch."""
    _require_output()
    if len(pressures) > 3 or any(pressure < 0.0 for pressure in pressures):
        raise click.UsageError("--pressure may be given up to three times, and not below 0")
    from spiral_core.actuator.actuation import FreeActuation

    description = described(gripper)
    actuator = description.actuator
    actuation = FreeActuation(actuator)
    shapes = [actuation.unloaded_shape(pressure) for pressure in pressures]
    _print_data({"pressure": pressures, "shape": shapes})
    if wanted("plot"):
        from spiral_gripper.reports.plots import section_figure

        write_picture(section_figure(actuator, pressures, description.gripper.name))


def _require_output() -> None:
    if not (wanted("json") or wanted("plot")):
        raise click.UsageError("give --plot FILE, --json, or both")


def _print_data(data: object) -> None:
    if wanted("json"):
        print_json(data)
