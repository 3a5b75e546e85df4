# SPDX-License-Identifier: Apache-2.0
"""Charts as pictures, with matplotlib (the extra ``plot``); no window is ever opened."""

from __future__ import annotations

import math
from collections.abc import Sequence
from textwrap import wrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, TwoSlopeNorm
from matplotlib.figure import Figure

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.actuator.actuator import Actuator
from spiral_core.actuator.section import Ring, motion_at, section_path
from spiral_core.actuator.tube import Tube
from spiral_core.calibration.uncertainty import RadiusPressure
from spiral_core.design.charts import DesignSpace, PressureRange, RegimeChart
from spiral_core.design.evaluation import Evaluation
from spiral_core.design.report import DesignReport
from spiral_core.design.sweep import FeasibilityMap
from spiral_gripper.files.shown import axis_label, in_units, shown, shown_message
from spiral_gripper.reports.style import (
    BELOW,
    BESIDE,
    COLORS,
    CURLING_COLOR,
    OVERHANG_COLOR,
    PERFECT_COLOR,
    color_of,
    panels,
    paper_style,
    set_title,
)

# Points around a drawn section.
SECTION_ANGLES = 181
# Larger ratios are not useful for design and would compress the rest of the chart.
LARGEST_RATIO = 20.0
# A pressure limit this many times above the rest of a chart is told in the legend only.
FAR_LIMIT = 2.0
# Letters of a title over axes with a legend beside them.
TITLE_WIDTH = 36


@paper_style()
def design_figure(report: DesignReport) -> Figure:
    """Return the pressure-radius curve of a report's design, with what was required."""
    figure, (axes,) = panels(1)
    if report.design is None:
        axes.set_axis_off()
        axes.text(0.5, 0.5, "nothing wraps the largest object", ha="center")
        return figure
    curve, wanted = report.design.curve, report.requirement
    radii = in_units([point.radius for point in curve], "m")
    pressures = in_units([point.pressure for point in curve], "Pa")
    axes.plot(radii, pressures, color=PERFECT_COLOR, label="perfect wrap")
    low, high = in_units([wanted.radius_min, wanted.radius_max], "m").tolist()
    axes.axvspan(low, high, color=CURLING_COLOR, alpha=0.18, lw=0.0, label="objects required")
    if wanted.pressure_max is not None:
        limit = float(in_units(wanted.pressure_max, "Pa"))
        axes.axhline(limit, color=COLORS[2], ls="--", label="pressure limit")
    axes.set(xlabel=axis_label("object radius", "m"), ylabel=axis_label("pressure", "Pa"))
    axes.set_ylim(bottom=0.0, top=1.08 * axes.get_ylim()[1])
    set_title(figure, shown_message(report.design.sentence), 64)
    figure.legend(loc=BELOW, ncols=3)
    return figure


@paper_style()
def regime_figure(
    chart: RegimeChart, name: str, uncertain: Sequence[RadiusPressure] = ()
) -> Figure:
    """Return the tip criterion's pressure against object radius; regimes of contact as areas.

    Args:
        chart: the pressures.
        name: of the gripper.
        uncertain: pressures with the intervals of a calibration, drawn as a band.
    """
    figure, (axes,) = panels(1)
    radius, tip = in_units(chart.radius, "m"), in_units(chart.tip, "Pa")
    limit, top = float(in_units(chart.pressure_max, "Pa")), 1.15 * float(np.nanmax(tip))
    if limit < FAR_LIMIT * top:
        top = max(top, 1.05 * limit)
    _draw_regimes(axes, chart, min(limit, top))
    axes.plot(radius, tip, color=COLORS[0], lw=1.2, label="tip criterion")
    label = f"pressure limit,\n{shown(chart.pressure_max, 'Pa')}"
    axes.axhline(limit, color="black", lw=0.8, ls="--", label=label)
    if uncertain:
        low, high = (in_units([one.interval[end] for one in uncertain], "Pa") for end in (0, 1))
        at = in_units([one.radius for one in uncertain], "m")
        axes.fill_between(
            at, low, high, facecolor="none", edgecolor=COLORS[2], hatch="////", lw=0.8,
            label="confidence interval\nof the calibration",
        )  # fmt: skip
    axes.set(xlabel=axis_label("object radius", "m"), ylabel=axis_label("pressure", "Pa"))
    axes.set(xlim=(radius.min(), radius.max()), ylim=(0.0, top))
    title = name if chart.onset_wrap is not None else f"{name}, by the tip criterion"
    axes.set_title("\n".join(wrap(title, TITLE_WIDTH)), parse_math=False)
    figure.legend(loc=BESIDE)
    return figure


def _draw_regimes(axes: Axes, chart: RegimeChart, top: float) -> None:
    """Draw the regimes up to a pressure in the units shown, where contact was computed."""
    if chart.onset_wrap is None or chart.onset_curling is None or chart.loss is None:
        return
    radius, onset = in_units(chart.radius, "m"), in_units(chart.onset_wrap, "Pa")
    loss = np.fmin(in_units(chart.loss, "Pa"), top)
    curling = np.fmin(in_units(chart.onset_curling, "Pa"), loss)
    held = np.isfinite(onset)
    areas = (
        (np.zeros_like(onset), onset, OVERHANG_COLOR, "overhang"),
        (onset, curling, PERFECT_COLOR, "perfect wrap,\nwith contact"),
        (curling, loss, CURLING_COLOR, "curling"),
    )
    axes.axhspan(0.0, top, color="#e6e6e6", lw=0.0, label="not held")
    for bottom, edge, color, label in areas:
        axes.fill_between(radius, bottom, edge, held, color="white", lw=0.0)
        axes.fill_between(radius, bottom, edge, held, color=color, alpha=0.5, lw=0.0, label=label)


@paper_style()
def design_space_figure(curves: Sequence[DesignSpace], name: str) -> Figure:
    """Return the paper's three charts side by side, one curve per angle."""
    figure, axes_list = panels(3)
    for number, curve in enumerate(curves):
        label = f"{math.degrees(curve.fiber_angle_beta):.4g}°"
        useful = curve.radius_ratio > 0.0
        ratios = (curve.radius_ratio, curve.object_length_ratio, curve.length_ratio)
        for axes, ratio in zip(axes_list, ratios, strict=True):
            axes.plot(curve.stretch[useful], ratio[useful], color=color_of(number), label=label)
    titles = ("object radius / r", "object length / r", "gripper length / r")
    for axes, title in zip(axes_list, titles, strict=True):
        axes.set(xlabel="stretch λ₁", ylabel=title)
        # Away from rest, where the curves are infinite.
        values = [np.asarray(line.get_ydata(), dtype=np.float64) for line in axes.get_lines()]
        top = max(np.interp(0.15 * len(v), np.arange(len(v)), v) for v in values)
        axes.set_ylim(0.0, float(1.1 * top))
    axes_list[0].set_ylim(0.0, LARGEST_RATIO)
    set_title(figure, f"tube of {name}, helix model")
    figure.legend(*axes_list[0].get_legend_handles_labels(), loc=BESIDE, title="β")
    return figure


@paper_style()
def gravity_figure(heavy: PressureRange, weightless: PressureRange, name: str) -> Figure:
    """Return radius, gripper length, object length against pressure, with and without gravity."""
    figure, axes_list = panels(3)
    titles = ("object radius", "gripper length needed", "object length needed")
    for data, style, color, label in (
        (heavy, "-", COLORS[0], "with gravity"),
        (weightless, "--", COLORS[2], "gravity zero"),
    ):
        figures = (data.radius, data.gripper_length, data.object_length)
        for axes, values in zip(axes_list, figures, strict=True):
            at = in_units(data.pressure, "Pa")
            axes.plot(at, in_units(values, "m"), style, color=color, label=label)
    for axes, title in zip(axes_list, titles, strict=True):
        axes.set(xlabel=axis_label("pressure", "Pa"), ylabel=axis_label(title, "m"))
        axes.set_ylim(bottom=0.0)
    set_title(figure, name)
    figure.legend(*axes_list[0].get_legend_handles_labels(), loc=BESIDE)
    return figure


@paper_style()
def feasibility_figure(result: FeasibilityMap) -> Figure:
    """Return the room on the nearest limit over angle and tube radius."""
    figure, (axes,) = panels(1)
    betas, radii = np.degrees(result.fiber_angles_beta), in_units(result.inner_radii, "m")
    percent = 100.0 * np.clip(result.room, -1.0, 1.0)
    bound = max(1.0, float(np.abs(percent).max()))
    norm = TwoSlopeNorm(0.0, -bound, bound)
    mesh = axes.pcolormesh(betas, radii, percent.T, cmap="RdBu", norm=norm, shading="nearest")
    figure.colorbar(mesh, ax=axes, label="room on the nearest limit [%]")
    if percent.min() < 0.0 < percent.max():
        axes.contour(betas, radii, percent.T, levels=[0.0], colors="black", linewidths=1.2)
        axes.plot([], [], color="black", label="limit of feasibility")
        axes.legend(loc="lower right", frameon=True, fontsize=6.5)
    axes.set_title("where designs exist: blue, all limits are met")
    axes.set(xlabel="fiber angle β [deg]", ylabel=axis_label("tube's bore radius", "m"))
    axes.grid(visible=False)
    return figure


@paper_style()
def pareto_figure(points: Sequence[Evaluation], best: Sequence[Evaluation]) -> Figure:
    """Return pressure against strain of the feasible designs; the larger a dot, the longer."""
    figure, (axes,) = panels(1)
    for chosen, color, label in (
        ([p for p in points if p.feasible], "#b8c4c8", "feasible"),
        (list(best), COLORS[2], "Pareto set"),
    ):
        pressures = in_units([point.pressure or 0.0 for point in chosen], "Pa")
        strains = [100.0 * (point.strain or 0.0) for point in chosen]
        sizes = [150.0 * (point.length or 0.0) for point in chosen]
        axes.scatter(strains, pressures, s=sizes, color=color, label=label, edgecolor="white")
    axes.set(xlabel="strain at the smallest object [%]", ylabel=axis_label("pressure there", "Pa"))
    axes.set_title(f"{len(best)} Pareto-optimal designs")
    figure.legend(loc=BESIDE, title="area: length")
    return figure


@paper_style()
def section_figure(actuator: Actuator, pressures: Sequence[float], name: str) -> Figure:
    """Return the tube's section at pressures [Pa], colored by how far the wall is stretched.

    Source: ``docs/derivations/section.md``; the straight fiber, which does not stretch, is a dot.

    Raises:
        ActuationLimitError: a pressure is past the actuator's limit.
    """
    figure, axes_list = panels(len(pressures))
    tube, actuation = actuator.tube, FreeActuation(actuator)
    path = section_path(actuator.fiber_set)
    rings = []
    for stretch in map(actuation.stretch_from_pressure, pressures):
        strain = np.array([path.strain_from_stretch(stretch)])
        rings.append(motion_at(path.fibers, strain).ring)
    top = float(max((1.0 + ring.stretch_change + np.abs(ring.bend)).max() for ring in rings))
    shades = Normalize(1.0, max(top, 1.0 + 1e-9))
    for axes, ring, pressure in zip(axes_list, rings, pressures, strict=True):
        _draw_section(axes, ring, tube, shades)
        axes.set_title(shown(pressure, "Pa"))
    figure.colorbar(
        ScalarMappable(shades, "viridis"), ax=axes_list, label="axial stretch", shrink=0.8
    )
    set_title(figure, f"{name}: the straight fiber is at the dot")
    return figure


def _draw_section(axes: Axes, ring: Ring, tube: Tube, shades: Normalize) -> None:
    """Draw a tube's wall, colored by its axial stretch."""
    angles = np.linspace(0.0, 2.0 * np.pi, SECTION_ANGLES)
    stretched = 1.0 + ring.stretch_change - ring.bend * np.cos(angles)
    sizes = np.array([tube.inner_radius, tube.outer_radius]) * float(np.ravel(ring.hoop)[0])
    radii = in_units(sizes, "m")
    y, z = radii[:, None] * np.cos(angles), radii[:, None] * np.sin(angles)
    colors = np.broadcast_to(np.ravel(stretched), y.shape)
    axes.pcolormesh(y, z, colors, shading="gouraud", cmap="viridis", norm=shades)
    axes.plot(radii[1], 0.0, "o", ms=4, color=COLORS[2])
    axes.set(xlabel=axis_label("y", "m"), ylabel=axis_label("z", "m"))
    axes.set_aspect("equal")
    axes.use_sticky_edges = False  # pcolormesh would touch the frame
    axes.margins(0.08)
    axes.grid(visible=False)
