# SPDX-License-Identifier: Apache-2.0
"""Shapes as pictures, to scale, with the object that the gripper holds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.patches import Polygon

from spiral_core.rod.types import Array, Vector
from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper.files.shown import axis_label, in_units
from spiral_gripper.reports.shaded import Surface, draw_surfaces, same_scale
from spiral_gripper.reports.style import BELOW, COLORS, paper_style, set_title

# Points on the rim of a drawn cylinder.
RIM_POINTS = 73
# An object is drawn longer than its contact by this many of its radii at each end.
OVERHANG = 1.5
# Around the outline of an object [m].
ROOM = 0.002
# Seen from two sides: the axis to the right of each; x, along the tube, points down.
ACROSS: Mapping[str, Vector] = {"y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
UP = (-1.0, 0.0, 0.0)


@paper_style()
def shape_figure(
    surfaces: list[Surface], title: str, placement: ObjectPlacement | None = None
) -> Figure:
    """Return a shape from two sides, to scale: the base's x points down, as a gripper hangs.

    Args:
        surfaces: of the tube, and of an object that it touches.
        title: the gripper's name and the pressure.
        placement: of an object that a free coil must lie on: a dashed outline; or None.
    """
    figure = Figure(figsize=(3.5, 3.4), layout="constrained")
    set_title(figure, title, 50)
    draw_sides(figure, surfaces, placement)
    if placement is not None:
        figure.legend(loc=BELOW)
    return figure


def draw_sides(
    figure: FigureBase, surfaces: list[Surface], placement: ObjectPlacement | None = None
) -> list[Axes]:
    """Draw surfaces from two sides, to scale, and the outline of an object; return both views."""
    views = [figure.add_subplot(1, 2, number) for number in (1, 2)]
    label = "object (contact not solved)"
    for axes, (name, right) in zip(views, ACROSS.items(), strict=True):
        draw_surfaces(axes, surfaces, right, UP)
        axes.set(xlabel=axis_label(name, "m"), ylabel=axis_label("x", "m"))
        axes.yaxis.set_major_formatter(lambda value, _: f"{0.0 - value:g}")
        if placement is not None:
            rims = in_units(_rims(placement) @ np.array((right, UP)).T, "m")
            _draw_outline(axes, rims, label)
            label = ""
    same_scale(views)
    return views


def _rims(cylinder: ObjectPlacement) -> Array:
    """Return points on both end circles of the drawn object (2, m, 3) [m]."""
    axis = np.asarray(cylinder.axis)
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    angle = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS)[:, None]
    circle = cylinder.radius * (np.cos(angle) * across + np.sin(angle) * np.cross(axis, across))
    half = (0.5 * cylinder.length + OVERHANG * cylinder.radius) * axis
    rims: Array = np.asarray(cylinder.center) + np.stack((-half, half))[:, None] + circle
    return rims


def _draw_outline(axes: Axes, rims: Array, label: str) -> None:
    """Draw the outline of a cylinder whose end circles are seen as (2, m, 2), dashed."""
    along = rims[1, 0] - rims[0, 0]
    sides = rims @ np.array((-along[1], along[0]))
    first, last = np.argmin(sides[0]), np.argmax(sides[0])
    body = np.stack((rims[0, first], rims[1, first], rims[1, last], rims[0, last]))
    for outline in (body, rims[0], rims[1]):
        axes.add_patch(
            Polygon(outline, fill=False, edgecolor=COLORS[0], ls=(0, (4, 3)), lw=0.8, label=label)
        )
        label = ""
    low, high = rims.min(axis=(0, 1)), rims.max(axis=(0, 1))
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    (x, y), (x_end, y_end) = low - in_units(ROOM, "m"), high + in_units(ROOM, "m")
    axes.set(xlim=(min(left, x), max(right, x_end)), ylim=(min(bottom, y), max(top, y_end)))
