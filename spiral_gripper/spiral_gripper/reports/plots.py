# SPDX-License-Identifier: Apache-2.0
"""Charts as pictures, with matplotlib (the extra ``plot``); no window is ever opened."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from spiral_core.design.charts import DesignSpace, PressureRange, RegimeChart
from spiral_core.design.report import DesignReport
from spiral_core.design.sweep import FeasibilityMap, SweepPoint
from spiral_core.rod.types import Array, RodState
from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper.files.storage import write_file

# Dark to light, told apart in gray too.
COLORS = ("#1b3a4b", "#2f7f93", "#c8553d", "#e3a857", "#7d6b91", "#5b8c5a")
OVERHANG_COLOR, PERFECT_COLOR, CURLING_COLOR = "#7ba7b4", "#2f7f93", "#e3a857"
OBJECT_COLOR = "#f0d9a8"
DPI = 300
# Points on the rim of a drawn cylinder.
RIM_POINTS = 73
# Points drawn from one node of a rod to the next.
SUBDIVISIONS = 10
# Ratios above this are of no use to a designer and would flatten everything else.
LARGEST_RATIO = 20.0


def save_figure(figure: Figure, path: Path) -> None:
    """Write a picture; the suffix decides the format (png, svg, pdf). Equal data, equal file.

    Raises:
        FileError: it cannot be written.
    """
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    kind = path.suffix.lower().removeprefix(".")
    content = io.BytesIO()
    with paper_style():
        figure.savefig(content, format=kind, dpi=DPI, metadata=metadata.get(kind))
    write_file(path, content.getvalue())


@contextmanager
def paper_style() -> Iterator[None]:
    """Draw for a paper's columns while the block runs; text stays text in PDF and SVG."""
    with rc_context(
        {
            "font.size": 8.0,
            "axes.titlesize": 8.0,
            "figure.titlesize": 9.0,
            "legend.frameon": False,
            "lines.linewidth": 1.2,
            "pdf.fonttype": 42,  # TrueType, to be searched and edited
            "svg.fonttype": "none",  # letters, not outlines
            "svg.hashsalt": "spiral_gripper",
        }
    ):
        yield


@paper_style()
def design_figure(report: DesignReport) -> Figure:
    """Return the pressure-radius curve of a report's design, with what was required."""
    figure, (axes,) = _figure(1)
    if report.design is None:
        axes.set_axis_off()
        axes.text(0.5, 0.5, "nothing wraps the largest object", ha="center")
        return figure
    curve, wanted = report.design.curve, report.requirement
    axes.plot(
        [1e3 * point.radius for point in curve],
        [1e-3 * point.pressure for point in curve],
        color=PERFECT_COLOR,
        label="perfect wrap",
    )
    low, high = 1e3 * wanted.radius_min, 1e3 * wanted.radius_max
    axes.axvspan(low, high, color=CURLING_COLOR, alpha=0.18, lw=0.0, label="objects required")
    if wanted.pressure_max is not None:
        limit = 1e-3 * wanted.pressure_max
        axes.axhline(limit, color=COLORS[2], ls="--", label="pressure limit")
    axes.set(xlabel="object radius [mm]", ylabel="pressure [kPa]")
    axes.set_ylim(bottom=0.0)
    figure.suptitle(report.design.sentence)
    figure.legend(loc="outside right upper")
    return figure


@paper_style()
def regime_figure(chart: RegimeChart, name: str) -> Figure:
    """Return pressure against object radius with the three regimes as areas."""
    figure, (axes,) = _figure(1)
    radius, top = 1e3 * chart.radius, 1.15e-3 * float(chart.upper.max())
    lower, upper = 1e-3 * chart.lower, 1e-3 * chart.upper
    areas = (
        (np.zeros_like(lower), lower, OVERHANG_COLOR, "overhang"),
        (lower, upper, PERFECT_COLOR, "perfect wrap\n(within 2 % of\nthe radius)"),
        (upper, np.full_like(upper, top), CURLING_COLOR, "curling"),
    )
    for bottom, edge, color, label in areas:
        axes.fill_between(radius, bottom, edge, color=color, alpha=0.5, lw=0.0, label=label)
    axes.plot(radius, 1e-3 * chart.perfect, color=COLORS[0], lw=0.8)
    axes.set(xlabel="object radius [mm]", ylabel="pressure [kPa]")
    axes.set(xlim=(radius.min(), radius.max()), ylim=(0.0, top))
    axes.set_title(name)
    figure.legend(loc="outside right upper")
    return figure


@paper_style()
def design_space_figure(curves: Sequence[DesignSpace], name: str) -> Figure:
    """Return the paper's three charts side by side, one curve per angle."""
    figure, panels = _figure(3)
    for number, curve in enumerate(curves):
        label = f"{math.degrees(curve.fiber_angle_beta):.4g}°"
        ratios = (curve.radius_ratio, curve.object_length_ratio, curve.length_ratio)
        for axes, ratio in zip(panels, ratios, strict=True):
            useful = curve.radius_ratio > 0.0
            axes.plot(curve.stretch[useful], ratio[useful], color=_color(number), label=label)
    titles = ("object radius / r", "object length / r", "gripper length / r")
    for axes, title in zip(panels, titles, strict=True):
        axes.set(xlabel="stretch λ₁", ylabel=title)
        axes.set_ylim(0.0, _useful_top(axes))
    panels[0].set_ylim(0.0, LARGEST_RATIO)
    figure.suptitle(f"tube of {name}, helix model")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", title="β")
    return figure


@paper_style()
def gravity_figure(heavy: PressureRange, weightless: PressureRange, name: str) -> Figure:
    """Return radius, gripper length, object length against pressure, with and without gravity."""
    figure, panels = _figure(3)
    fields = ("radius", "free_length", "object_length")
    titles = ("object radius [mm]", "gripper length needed [mm]", "object length needed [mm]")
    curves = ((heavy, "with gravity"), (weightless, "gravity zero"))
    for axes, field, title in zip(panels, fields, titles, strict=True):
        for number, (data, label) in enumerate(curves):
            style = "-" if number == 0 else "--"
            values = 1e3 * getattr(data, field)
            axes.plot(1e-3 * data.pressure, values, style, color=_color(2 * number), label=label)
        axes.set(xlabel="pressure [kPa]", ylabel=title)
        axes.set_ylim(bottom=0.0)
    figure.suptitle(name)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper")
    return figure


@paper_style()
def feasibility_figure(result: FeasibilityMap) -> Figure:
    """Return the room on the nearest limit over angle and tube radius."""
    figure, (axes,) = _figure(1)
    betas, radii = np.degrees(result.fiber_angles_beta), 1e3 * result.inner_radii
    percent = 100.0 * np.clip(result.room, -1.0, 1.0)
    bound = max(1.0, float(np.abs(percent).max()))
    mesh = axes.pcolormesh(
        betas,
        radii,
        percent.T,
        cmap="RdBu",
        norm=TwoSlopeNorm(0.0, -bound, bound),
        shading="nearest",
    )
    figure.colorbar(mesh, ax=axes, label="room on the nearest limit [%]")
    if percent.min() < 0.0 < percent.max():
        axes.contour(betas, radii, percent.T, levels=[0.0], colors="black", linewidths=1.2)
    axes.set(xlabel="fiber angle β [deg]", ylabel="tube's bore radius [mm]")
    axes.grid(visible=False)
    return figure


@paper_style()
def pareto_figure(points: Sequence[SweepPoint], best: Sequence[SweepPoint]) -> Figure:
    """Return pressure against strain of the feasible designs; the larger a dot, the longer."""
    figure, (axes,) = _figure(1)
    for chosen, color, label in (
        ([p for p in points if p.feasible], "#b8c4c8", "feasible"),
        (list(best), COLORS[2], "Pareto set"),
    ):
        pressures = [1e-3 * (point.pressure or 0.0) for point in chosen]
        strains = [100.0 * (point.strain or 0.0) for point in chosen]
        sizes = [150.0 * (point.length or 0.0) for point in chosen]
        axes.scatter(strains, pressures, s=sizes, color=color, label=label, edgecolor="white")
    axes.set(xlabel="strain at the smallest object [%]", ylabel="pressure there [kPa]")
    figure.legend(loc="outside right upper", title="area: length")
    return figure


@paper_style()
def shape_figure(
    state: RodState, outer_radius: float, title: str, placement: ObjectPlacement | None = None
) -> Figure:
    """Return a shape from three sides, to scale: the base's x points down, as a gripper hangs.

    Args:
        state: the shape.
        outer_radius: of the tube [m].
        title: the gripper's name and the pressure.
        placement: of the object that the coil holds, drawn behind it.
    """
    figure = Figure(figsize=(7.0, 3.4), layout="constrained")
    figure.suptitle(title)
    positions = 1e3 * _smooth_centerline(state)
    rims = None if placement is None else 1e3 * _rims(placement)
    for number, (across, along) in enumerate(((1, 0), (2, 0), (1, 2)), start=1):
        axes = figure.add_subplot(1, 3, number)
        if rims is not None:
            _draw_cylinder(axes, rims[..., [across, along]])
        _draw_tube(axes, positions[:, across], positions[:, along], 1e3 * outer_radius)
        axes.set(xlabel=f"{'xyz'[across]} [mm]", ylabel=f"{'xyz'[along]} [mm]")
        axes.set_aspect("equal", adjustable="datalim")
        if number < 3:
            axes.invert_yaxis()
        _style(axes)
    return figure


def _rims(cylinder: ObjectPlacement) -> Array:
    """Return points on both end circles of a cylinder (2, m, 3) [m]."""
    axis = np.asarray(cylinder.axis)
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    angle = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS)[:, None]
    circle = cylinder.radius * (np.cos(angle) * across + np.sin(angle) * np.cross(axis, across))
    half = 0.5 * cylinder.length * axis
    rims: Array = np.asarray(cylinder.center) + np.stack((circle - half, circle + half))
    return rims


def _draw_cylinder(axes: Axes, rims: Array) -> None:
    """Draw the outline of a cylinder whose end circles are seen as (2, m, 2), filled."""
    along = rims[1, 0] - rims[0, 0]
    sides = rims @ np.array((-along[1], along[0]))
    first, last = np.argmin(sides[0]), np.argmax(sides[0])
    body = np.stack((rims[0, first], rims[1, first], rims[1, last], rims[0, last]))
    for outline in (body, rims[0], rims[1]):
        axes.add_patch(Polygon(outline, closed=True, facecolor=OBJECT_COLOR, edgecolor="none"))


def _smooth_centerline(state: RodState) -> Array:
    """Return the centerline (m, 3) between the nodes too: cubics with the nodes' tangents."""
    steps = np.diff(state.arc_lengths)[:, None, None]
    t = np.linspace(0.0, 1.0, SUBDIVISIONS, endpoint=False)[None, :, None]
    start, end = state.positions[:-1, None], state.positions[1:, None]
    out, into = steps * state.tangents[:-1, None], steps * state.tangents[1:, None]
    dense = (
        (1.0 + 2.0 * t) * (1.0 - t) ** 2 * start
        + t * (1.0 - t) ** 2 * out
        + t**2 * (3.0 - 2.0 * t) * end
        - t**2 * (1.0 - t) * into
    )
    line: Array = np.concatenate((dense.reshape(-1, 3), state.positions[-1:]))
    return line


def _draw_tube(axes: Axes, first: Array, second: Array, radius: float) -> None:
    """Draw a centerline as wide as its tube, in data units."""
    for x, y in zip(first, second, strict=True):
        axes.add_patch(Circle((x, y), radius, color=OVERHANG_COLOR, lw=0.0))
    axes.plot(first, second, color=COLORS[0], lw=1.0)
    axes.plot(first[:1], second[:1], "s", color=COLORS[0], ms=4)


def _figure(count: int) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels side by side."""
    figure = Figure(figsize=(7.0 if count > 1 else 4.6, 2.6), layout="constrained")
    panels = [figure.add_subplot(1, count, number) for number in range(1, count + 1)]
    for axes in panels:
        _style(axes)
    return figure, panels


def _style(axes: Axes) -> None:
    axes.grid(visible=True, color="#dddddd", lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _color(number: int) -> str:
    return COLORS[number % len(COLORS)]


def _useful_top(axes: Axes) -> float:
    """Return the top of an axis that shows the curves away from rest, where they are infinite."""
    values = [np.asarray(line.get_ydata(), dtype=np.float64) for line in axes.get_lines()]
    return float(1.1 * max(np.interp(0.15 * len(v), np.arange(len(v)), v) for v in values))
