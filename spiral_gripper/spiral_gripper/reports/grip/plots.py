# SPDX-License-Identifier: Apache-2.0
"""Pictures of grips: force against pressure with the window, and the coil on its object."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from spiral_core.errors import InvalidInputError, SpiralError
from spiral_core.grip.approach import UPRIGHT, ApproachAnswer
from spiral_core.grip.capture import CaptureOutcome, CaptureRegion
from spiral_core.grip.grip import Grip, GripCase, GripOutcome, refine, solve_grip
from spiral_core.grip.holding import is_twist
from spiral_core.grip.setup import hanging_tube, lay_into_coil
from spiral_core.grip.window import GripPoint
from spiral_core.wrap.gripper import Gripper
from spiral_gripper.files.shown import axis_label, in_units, shown, shown_message
from spiral_gripper.reports.grip.capture import BEYOND, COMPONENTS, ball_text, limit_texts
from spiral_gripper.reports.grip.document import SolvedGrip
from spiral_gripper.reports.grip.rows import PULLS
from spiral_gripper.reports.shaded import (
    OBJECT_RINGS,
    Surface,
    draw_surfaces,
    same_scale,
    tube_surface,
    turned_surface,
)
from spiral_gripper.reports.shape_plots import draw_sides, shape_figure
from spiral_gripper.reports.style import (
    BELOW,
    BESIDE,
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
    set_title(figure, f"{title}; friction {grip.setup.obstacle.friction:g}, {closing}")
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
    if closed is not None:
        point = closed.point
        return shape_figure(coil_surfaces(point), f"{title} {shown(point.pressure, 'Pa')}")
    state, placement = (
        (free.wrap.state, free.placement) if isinstance(free, SolvedWrap) else (free.state, None)
    )
    tube = tube_surface(state.positions, free.gripper.tube.outer_radius)
    return shape_figure([tube], f"{title} {shown(free.wrap.pressure, 'Pa')}", placement)


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
            pressures, in_units(grip.force(pull), "N"),
            "os^"[number % 3] + ("-", "--")[number > 1], ms=4 - number % 3,
            lw=1.8 - 0.4 * min(number, 2), color=COLORS[number], label=PULLS[pull],
        )  # fmt: skip
    for number, pull in enumerate(straight):
        least = [held.force if held.is_lower_bound else np.nan for held in grip.forces[pull]]
        axes.plot(pressures, in_units(least, "N"), "o", ms=2, mfc="white", mec=COLORS[number])
    if any(held.is_lower_bound for pull in straight for held in grip.forces[pull]):
        axes.plot([], [], "o", ms=3, mfc="white", mec="black", label="open: at least")
    window = grip.window
    at, forces = in_units(window.pressures, "Pa"), in_units(window.normal_forces, "N")
    axes.plot(at, forces, ":", color="#888888", label="normal force, sum")
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
        if low < high:
            axes.axvspan(low, high, color=color, alpha=0.2, lw=0.0, label=label)
    for pressure, color, style, width, label in (
        (grip.setup.tip_pressure, COLORS[0], "--", 0.8, "tip criterion"),
        (window.loss, "black", "-", 1.2, "lost"),
    ):
        if pressure is not None:
            at = float(in_units(pressure, "Pa"))
            axes.axvline(at, color=color, ls=style, lw=width, label=label)


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
        InvalidInputError: no grip is held, or more than :data:`MOST_PANELS` panels would be needed.
    """
    groups: dict[tuple[Gripper, float], list[tuple[float, GripOutcome]]] = {}
    for case, outcome in zip(cases, outcomes, strict=True):
        groups.setdefault((case.gripper, case.friction), []).append((case.radius, outcome))
    if all(outcome.refusal for outcome in outcomes):
        raise InvalidInputError("plot", 0, "of at least one grip that is held")
    if len(groups) > MOST_PANELS:
        raise InvalidInputError("plot", f"{len(groups)} panels", f"at most {MOST_PANELS} panels")
    figure, axes_list = panels(len(groups))
    figure.supxlabel(caption, fontsize=6.5, parse_math=False)
    for axes, ((gripper, friction), found) in zip(axes_list, groups.items(), strict=True):
        _draw_windows(axes, sorted(found, key=lambda pair: pair[0]), gripper.pressure_max)
        mount = " ".join(f"{g:.3g}" for g in gripper.gravity)
        title = f"{gripper.name}\nfriction {friction:.3g}, gravity {mount}"
        axes.set_title(title, parse_math=False)
    handles, labels = axes_list[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc=BESIDE)
    return figure


def _draw_windows(axes: Axes, found: Sequence[tuple[float, GripOutcome]], limit: float) -> None:
    """Draw where the wrap begins, the end curls, and the grip is lost or the limit [Pa] reached."""
    radii = in_units([radius for radius, _ in found], "m")
    names = ("onset_wrap", "onset_curling", "loss", "tip_criterion", "pressure")
    # Missing ones are NaN.
    known = np.array([[getattr(one, name) for _, one in found] for name in names], np.float64)
    wrapped, curling, loss, tip, recommended = in_units(known, "Pa")
    top = np.where(np.isnan(loss), in_units(limit, "Pa"), loss)
    curling = np.where(np.isnan(curling), top, curling)
    for low, high, color, label in (
        (wrapped, curling, PERFECT_COLOR, "wrapped"),
        (curling, top, CURLING_COLOR, "end curls"),
    ):
        axes.fill_between(radii, low, high, color=color, alpha=0.35, lw=0.0, label=label)
    axes.plot(radii, loss, "_", color="black", ms=9, mew=1.5, label="lost")
    axes.plot(radii, recommended, "o-", color=COLORS[0], ms=3, label="recommended")
    axes.plot(radii, tip, "--", color=COLORS[4], lw=0.9, label="tip criterion")
    axes.set(xlabel=axis_label("object radius", "m"), ylabel=axis_label("pressure", "Pa"))
    axes.set_ylim(bottom=0.0)


TUBE_COLOR = "#c9b8a8"
# Colors of what limits a region of capture.
LIMIT_COLORS = {
    CaptureOutcome.HOLDS: "#999999",
    CaptureOutcome.TOO_WEAK: COLORS[3],
    CaptureOutcome.PASSES_BY: COLORS[2],
    CaptureOutcome.IN_THE_WAY: COLORS[0],
    CaptureOutcome.NOT_ANSWERED: COLORS[4],
}


@paper_style()
def capture_figure(region: CaptureRegion, title: str) -> Figure:
    """Return a region of capture in the planes of the shifts and of the tilts, and its limits.

    In the plane of the shifts the object in its place and the tube without pressure are drawn to
    scale, seen along the object.

    Raises:
        InvalidInputError: the object is not held in its place.
    """
    if not region.axes:
        raise InvalidInputError("plot", region.center.value, "an object that is held in its place")
    figure = Figure(figsize=(7.6, 4.6), layout="constrained")
    payload = "" if region.payload is None else f" carrying {shown(region.payload, 'kg')}"
    friction = f"friction {region.setup.obstacle.friction:g}"
    set_title(figure, f"{title},{payload} at {shown(region.pressure, 'Pa')}; {friction}")
    grid = figure.add_gridspec(2, 2, height_ratios=(1.0, 0.26))
    shifts, tilts, numbers = (figure.add_subplot(at) for at in (grid[0, 0], grid[0, 1], grid[1, :]))
    _draw_tube(shifts, region)
    planes = ((shifts, region.shifts, (1, 0), "m"), (tilts, region.tilts, (3, 2), "rad"))
    for axes, boundaries, (across, up), unit in planes:
        corners = in_units(region.outline(boundaries)[:, [across, up]], unit)
        axes.fill(*corners.T, color=PERFECT_COLOR, alpha=0.25, lw=0.0)
        axes.plot(*np.vstack((corners, corners[:1])).T, color=PERFECT_COLOR, lw=0.8)
        for corner, boundary in zip(corners, boundaries, strict=True):
            axes.plot(*corner, "o", ms=3.5, color=LIMIT_COLORS[boundary.beyond])
        axes.plot(0.0, 0.0, "+", color="black", ms=7)
        angles = np.linspace(0.0, 2.0 * np.pi, 181)
        size = in_units(region.semi_axes[[across, up]], unit)
        axes.plot(size[0] * np.cos(angles), size[1] * np.sin(angles), "--", color="black", lw=0.8)
        axes.set_xlabel(axis_label(COMPONENTS[across][1], unit))
        axes.set_ylabel(axis_label(COMPONENTS[up][1], unit))
        axes.set_aspect("equal")
        style_axes(axes)
    for outcome in dict.fromkeys(each.beyond for each in (*region.shifts, *region.tilts)):
        tilts.plot([], [], "o", ms=3.5, color=LIMIT_COLORS[outcome], label=BEYOND[outcome])
    tilts.plot([], [], "--", color="black", lw=0.8, label="all errors at once")
    figure.legend(loc=BELOW, ncols=6, fontsize=7)
    numbers.axis("off")
    names = "\n".join((*(name for _, name, _ in COMPONENTS), "all at once"))
    numbers.text(0.3, 0.5, names, ha="right", va="center", fontsize=7)
    texts = "\n".join((*limit_texts(region), ball_text(region)))
    numbers.text(0.32, 0.5, texts, va="center", fontsize=7)
    return figure


def _draw_tube(axes: Axes, region: CaptureRegion) -> None:
    """Draw the object in its place and the hanging tube, to scale, seen along the object."""
    setup = region.setup
    center = np.asarray(setup.obstacle.position)
    tube = (hanging_tube(setup).positions - center) @ setup.frame[[2, 1]].T
    outer, radius = setup.gripper.tube.outer_radius, float(setup.obstacle.shape.feature_radius)
    spheres = [Circle(tuple(place), float(in_units(outer, "m"))) for place in in_units(tube, "m")]
    axes.add_collection(PatchCollection(spheres, color=TUBE_COLOR, lw=0.0))
    body = Circle((0.0, 0.0), float(in_units(radius, "m")), fc="none", ec="#555555", lw=1.0)
    axes.add_patch(body).set_label("object")
    axes.fill([], [], color=TUBE_COLOR, label="tube without pressure")
    shown_places = np.vstack((region.outline(region.shifts)[:, [1, 0]], tube[:1]))
    low, high = in_units(
        [shown_places.min(axis=0) - radius, shown_places.max(axis=0) + radius], "m"
    )
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


@paper_style()
def approach_figure(answer: ApproachAnswer, title: str) -> Figure:
    """Return each approach from the side, to scale: gravity points down."""
    figure = Figure(figsize=(7.6, 3.6), layout="constrained")
    set_title(figure, title)
    views = [figure.add_subplot(1, MOST_PANELS, 1 + at) for at in range(len(answer.approaches))]
    for number, (axes, approach) in enumerate(zip(views, answer.approaches, strict=True), start=1):
        point, down = approach.point, np.array(approach.pose.gravity)
        # Of what lies across gravity, the object if it leans, else the way to its middle.
        leans = answer.task.sine > UPRIGHT
        seen = np.array(approach.pose.axis if leans else point.setup.obstacle.position)
        right = seen - (seen @ down) * down
        right /= np.linalg.norm(right)
        outer = point.outer_radius
        ends = np.array(((-6.0 * outer, 0.0, 0.0), (0.0, 0.0, 0.0)))
        flange = turned_surface(ends, np.full(OBJECT_RINGS, 1.5 * outer))
        flange = flange._replace(colors=0.6 * flange.colors)
        draw_surfaces(axes, [*coil_surfaces(point), flange], right, -down)
        x, y = in_units(ends.mean(axis=0) @ np.stack((right, -down)).T, "m")
        axes.text(x, y, "arm", ha="center", va="center", color="white", fontsize=6)
        axes.annotate(
            "gravity",
            (0.15, 0.03),
            (0.15, 0.2),
            xycoords="axes fraction",
            ha="center",
            arrowprops={"arrowstyle": "->"},
        )
        errors = "" if approach.region is None else f", errors {shown(approach.found.size, 'm', 2)}"
        pressure, force = shown(point.pressure, "Pa", 3), shown(approach.found.force, "N", 2)
        axes.set_title(f"{number}: {pressure}, {force}{errors}")
        axes.set(xlabel=axis_label("level", "m"), ylabel=axis_label("up", "m"))
    same_scale(views)
    return figure


def coil_surfaces(point: GripPoint, reach: tuple[float, float] | None = None) -> list[Surface]:
    """Return a tube on its object.

    ``reach`` is where the object ends, along its axis [m]; None takes it as far as the tube goes.
    """
    return [
        tube_surface(point.state.positions, point.outer_radius),
        object_surface(point, reach),
    ]


def object_surface(point: GripPoint, reach: tuple[float, float] | None = None) -> Surface:
    """Return the object's surface as far as the tube reaches, or to ``reach``, and a bit beyond."""
    setup = point.setup
    axis, center = setup.axis, np.asarray(setup.obstacle.position)
    heights = (point.state.positions - center) @ axis
    margin = 4.0 * point.outer_radius
    first, last = reach or (float(heights.min()), float(heights.max()))
    low, high = first - margin, last + margin
    # The radius at each height, from the object's signed distance.
    shape, places = setup.obstacle.shape, np.zeros((OBJECT_RINGS, 3))
    places[:, 0], places[:, 2] = shape.feature_radius, np.linspace(low, high, OBJECT_RINGS)
    for _ in range(20):
        places[:, 0] = np.maximum(places[:, 0] - shape.distance(places)[0], 0.0)
    return turned_surface(np.stack((center + low * axis, center + high * axis)), places[:, 0])
