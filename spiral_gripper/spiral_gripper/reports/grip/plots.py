# SPDX-License-Identifier: Apache-2.0
"""Pictures of grips: force against pressure with the window, and the coil on its object."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from spiral_core.errors import InvalidInputError, SpiralError
from spiral_core.grip.grip import Grip, GripCase, GripOutcome, refine, solve_grip
from spiral_core.grip.holding import is_twist
from spiral_core.grip.setup import lay_into_coil
from spiral_core.grip.window import GripPoint
from spiral_gripper.files.shown import axis_label, in_units, shown, shown_message
from spiral_gripper.reports.grip.document import SolvedGrip
from spiral_gripper.reports.grip.rows import PULLS
from spiral_gripper.reports.shaded import (
    OBJECT_RINGS,
    Surface,
    tube_surface,
    turned_surface,
)
from spiral_gripper.reports.shape_plots import draw_sides, shape_figure
from spiral_gripper.reports.style import (
    COLORS,
    CURLING_COLOR,
    PERFECT_COLOR,
    panels,
    paper_style,
    set_title,
    style_axes,
)
from spiral_gripper.reports.wrap_document import SolvedProfile, SolvedWrap

# Side by side, legible at the width of a page.
MOST_PANELS = 3


@paper_style()
def grip_figure(grip: Grip, title: str, pressure: float | None = None) -> Figure:
    """Return force against pressure with the window shaded, and the coil on the object.

    The coil is drawn at a pressure [Pa], by default the recommended one. The caption states what
    twice the elements change.
    """
    figure = Figure(figsize=(7.6, 3.6), layout="constrained")
    figure.supxlabel(_accuracy(grip), fontsize=6.5)
    closing = grip.setup.closing.value
    set_title(figure, f"{title}; friction {grip.setup.obstacle.friction:g}, {closing}", 110)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.25, 1.0))
    left, right = (figure.add_subfigure(cell) for cell in (grid[0], grid[1]))
    axes = left.add_subplot()
    draw_forces(axes, grip)
    axes.legend(loc="upper left", fontsize=6.5)
    point = grip.window.at(grip.recommended_pressure() if pressure is None else pressure)
    draw_sides(right, coil_surfaces(point))
    right.suptitle(f"{shown(point.pressure, 'Pa')}: {point.regime.value}")
    return figure


def wrap_figure(free: SolvedWrap | SolvedProfile, closed: SolvedGrip | None, title: str) -> Figure:
    """Return the coil on its object from two sides, to scale; the free coil without ``closed``.

    Args:
        free: what the tip criterion says.
        closed: what contact says, or None.
        title: up to the pressure.
    """
    if closed is None:
        outer_radius = free.gripper.tube.outer_radius
        title = f"{title} {shown(free.wrap.pressure, 'Pa')}"
        if isinstance(free, SolvedWrap):
            return shape_figure(free.wrap.state.positions, outer_radius, title, free.placement)
        return shape_figure(free.state.positions, outer_radius, title)
    return _coil_figure(closed.point, f"{title} {shown(closed.point.pressure, 'Pa')}")


@paper_style()
def _coil_figure(point: GripPoint, title: str) -> Figure:
    """Return the coil on its object from two sides, to scale, as the gripper hangs."""
    figure = Figure(figsize=(3.5, 3.4), layout="constrained")
    set_title(figure, title)
    draw_sides(figure, coil_surfaces(point))
    return figure


def _accuracy(grip: Grip) -> str:
    """Return what twice the elements change, in words."""
    try:
        return str(refine(grip))
    except SpiralError as error:
        return f"twice the elements give no grip: {shown_message(error)}"


def draw_forces(axes: Axes, grip: Grip) -> None:
    """Draw holding forces and the normal force against pressure, the window behind them."""
    shade_window(axes, grip)
    pressures = in_units(grip.pressures, "Pa")
    straight = [pull for pull in grip.forces if not is_twist(pull)]
    for number, pull in enumerate(straight):
        axes.plot(
            pressures,
            in_units(grip.force(pull), "N"),
            "os^"[number % 3] + ("-", "--")[number > 1],
            ms=4 - number % 3,
            lw=1.8 - 0.4 * min(number, 2),
            color=COLORS[number],
            label=PULLS[pull],
        )
    for number, pull in enumerate(straight):
        least = [held.force if held.is_lower_bound else np.nan for held in grip.forces[pull]]
        axes.plot(pressures, in_units(least, "N"), "o", ms=2, mfc="white", mec=COLORS[number])
    if any(held.is_lower_bound for pull in straight for held in grip.forces[pull]):
        axes.plot([], [], "o", ms=3, mfc="white", mec="black", label="open: at least")
    window = grip.window
    axes.plot(
        in_units(window.pressures, "Pa"),
        in_units(window.normal_forces, "N"),
        ":",
        color="#888888",
        label="normal force, sum",
    )
    axes.set(xlabel=axis_label("pressure", "Pa"), ylabel=axis_label("force", "N"))
    axes.set_xlim(0.0, 1.02 * float(in_units(window.loss or window.top, "Pa")))
    axes.set_ylim(0.0, None)
    style_axes(axes)


def shade_window(axes: Axes, grip: Grip) -> None:
    """Shade overhang, perfect wrap and curling; mark the tip criterion's pressure and the loss."""
    window = grip.window
    end = window.loss or window.top
    curling = window.onset_curling or end
    for *ends, color, label in (
        (grip.onset_wrap, curling, PERFECT_COLOR, "wrapped"),
        (curling, end, CURLING_COLOR, "end curls"),
    ):
        low, high = in_units(ends, "Pa")
        if not low < high:
            continue
        axes.axvspan(low, high, color=color, alpha=0.2, lw=0.0, label=label)
    tip = grip.setup.tip_pressure
    if tip is not None:
        axes.axvline(
            float(in_units(tip, "Pa")), color=COLORS[0], ls="--", lw=0.8, label="tip criterion"
        )
    if window.loss is not None:
        axes.axvline(float(in_units(window.loss, "Pa")), color="black", lw=1.2, label="lost")


def study_accuracy(cases: Sequence[GripCase], outcomes: Sequence[GripOutcome]) -> str:
    """Return what twice the elements change of a study's middle grip, in words; takes seconds."""
    held = [case for case, outcome in zip(cases, outcomes, strict=True) if not outcome.refusal]
    if not held:
        return ""
    case = held[len(held) // 2]
    setup = lay_into_coil(case.gripper, case.radius, friction=case.friction, closing=case.closing)
    accuracy = _accuracy(solve_grip(setup, (), pressures=()))
    what = f"{case.gripper.name} on {shown(case.radius, 'm')}, friction {case.friction:.3g}"
    return f"{what}: {accuracy}"


@paper_style()
def window_figure(
    cases: Sequence[GripCase], outcomes: Sequence[GripOutcome], caption: str = ""
) -> Figure:
    """Return the window of pressures against the object's radius, a panel for each gripper.

    Panels are told apart by gripper, friction and mount; grips that are refused leave a gap. The
    caption is :func:`study_accuracy`'s.

    Raises:
        InvalidInputError: more than :data:`MOST_PANELS` panels would be needed.
    """
    groups: dict[str, list[tuple[float, GripOutcome]]] = {}
    for case, outcome in zip(cases, outcomes, strict=True):
        mount = " ".join(f"{g:.3g}" for g in case.gripper.gravity)
        title = f"{case.gripper.name}\nfriction {case.friction:.3g}, gravity {mount}"
        groups.setdefault(title, []).append((case.radius, outcome))
    if len(groups) > MOST_PANELS:
        raise InvalidInputError("plot", f"{len(groups)} panels", f"at most {MOST_PANELS} panels")
    figure, axes_list = panels(len(groups))
    figure.supxlabel(caption, fontsize=6.5)
    for axes, (title, found) in zip(axes_list, groups.items(), strict=True):
        _draw_windows(axes, sorted(found, key=lambda pair: pair[0]))
        axes.set_title(title, parse_math=False)
    handles, labels = axes_list[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper")
    return figure


def _draw_windows(axes: Axes, found: Sequence[tuple[float, GripOutcome]]) -> None:
    """Draw where the wrap begins, the end curls and the grip is lost, over the radius."""
    radii = in_units([radius for radius, _ in found], "m")
    edges = {
        name: in_units([_or_nan(getattr(outcome, name)) for _, outcome in found], "Pa")
        for name in ("onset_wrap", "onset_curling", "loss", "tip_criterion", "pressure")
    }
    top = np.where(np.isnan(edges["loss"]), np.nanmax([*edges.values()]), edges["loss"])
    curling = np.where(np.isnan(edges["onset_curling"]), top, edges["onset_curling"])
    for low, high, color, label in (
        (edges["onset_wrap"], curling, PERFECT_COLOR, "wrapped"),
        (curling, top, CURLING_COLOR, "end curls"),
    ):
        axes.fill_between(radii, low, high, color=color, alpha=0.35, lw=0.0, label=label)
    axes.plot(radii, edges["loss"], "_", color="black", ms=9, mew=1.5, label="lost")
    axes.plot(radii, edges["pressure"], "o-", color=COLORS[0], ms=3, label="recommended")
    axes.plot(radii, edges["tip_criterion"], "--", color=COLORS[4], lw=0.9, label="tip criterion")
    axes.set(xlabel=axis_label("object radius", "m"), ylabel=axis_label("pressure", "Pa"))
    axes.set_ylim(bottom=0.0)


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else value


def coil_surfaces(point: GripPoint, reach: tuple[float, float] | None = None) -> list[Surface]:
    """Return a tube on its object.

    ``reach`` is where the object ends, along its axis [m]; None takes it as far as the tube goes.
    """
    tube = tube_surface(point.state.positions, point.outer_radius)
    return [tube, object_surface(point, reach)]


def object_surface(point: GripPoint, reach: tuple[float, float] | None = None) -> Surface:
    """Return the object's surface as far as the tube reaches, or to ``reach``, and a bit beyond."""
    setup = point.setup
    axis, center = setup.axis, np.asarray(setup.obstacle.position)
    heights = (point.state.positions - center) @ axis
    margin = 4.0 * point.outer_radius
    first, last = (float(heights.min()), float(heights.max())) if reach is None else reach
    low, high = first - margin, last + margin
    radii = [surface_radius(point, height) for height in np.linspace(low, high, OBJECT_RINGS)]
    return turned_surface(np.stack((center + low * axis, center + high * axis)), np.array(radii))


def surface_radius(point: GripPoint, height: float) -> float:
    """Return the object's radius at a height along its axis [m], from its signed distance."""
    shape = point.setup.obstacle.shape
    radius = float(shape.feature_radius)
    for _ in range(20):
        gap, _, _ = shape.distance(np.array([[radius, 0.0, height]]))
        radius = max(radius - float(gap[0]), 0.0)
    return radius
