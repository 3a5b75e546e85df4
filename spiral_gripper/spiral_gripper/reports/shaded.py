# SPDX-License-Identifier: Apache-2.0
"""Surfaces as shaded pictures: parallel projection, near faces over far ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb

from spiral_core.rod.types import Array, Vector
from spiral_gripper.files.shown import in_units
from spiral_gripper.reports.meshes import SIDES, Mesh, tube_mesh

TUBE_COLOR, OBJECT_COLOR = "#c8553d", "#9dbfc9"
# Rings along an object: faces as short as the tube's, so that they are drawn in the right order.
OBJECT_RINGS = 90
# Light from above the viewer's left shoulder (right, up, towards the viewer).
LIGHT = np.array((-0.35, 0.55, 0.76))


class Surface(NamedTuple):
    """Triangles and their colors.

    Attributes:
        triangles: corners (k, 3, 3) in the base frame [m], counterclockwise from outside.
        colors: (k, 3) red, green, blue in [0, 1].
    """

    triangles: Array
    colors: Array


def tube_surface(positions: Array, radius: float) -> Surface:
    """Return a tube of this outer radius around points (n, 3) [m]."""
    return _surface(tube_mesh(positions, radius), TUBE_COLOR)


def turned_surface(ends: Array, radii: Array) -> Surface:
    """Return a body of revolution: radii (n,) at equal distances between two points (2, 3) [m]."""
    return _surface(
        tube_mesh(np.linspace(ends[0], ends[1], len(radii)), radii, sides=4 * SIDES), OBJECT_COLOR
    )


def draw_surfaces(
    axes: Axes, surfaces: list[Surface], right: Array | Vector, up: Array | Vector
) -> None:
    """Draw surfaces in the units shown, seen with these directions to the right and upwards.

    Args:
        axes: whose data are lengths to the right and upwards.
        surfaces: they may hide parts of each other.
        right: unit vector in the base frame.
        up: likewise, orthogonal to ``right``.
    """
    view = np.array((right, up, np.cross(right, up)))
    triangles = np.concatenate([surface.triangles for surface in surfaces]) @ view.T
    colors = np.concatenate([surface.colors for surface in surfaces])
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    seen = (normals[:, 2] > 0.0) & (lengths > 0.0)
    triangles, colors = triangles[seen], colors[seen]
    light = 0.5 + 0.5 * np.clip(normals[seen] @ LIGHT / lengths[seen], 0.0, 1.0)
    order = np.argsort(triangles[:, :, 2].mean(axis=1))
    faces = np.clip(light[:, None] * colors, 0.0, 1.0)[order]
    flat = in_units(triangles[order, :, :2], "m")
    # Edges of the face's own color hide the seams between faces.
    axes.add_collection(
        PolyCollection(list(flat), facecolors=faces, edgecolors=faces, linewidths=0.8)
    )
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    room = 0.04 * float((high - low).max())
    axes.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))
    axes.set_aspect("equal", adjustable="box")


def same_scale(views: Sequence[Axes]) -> None:
    """Let views side by side show as much to the right and upwards as the largest of them."""
    for limits in ("xlim", "ylim"):
        ends = [getattr(axes, f"get_{limits}")() for axes in views]
        half = 0.5 * max(high - low for low, high in ends)
        for axes, (low, high) in zip(views, ends, strict=True):
            middle = 0.5 * (low + high)
            axes.set(**{limits: (middle - half, middle + half)})


def _surface(mesh: Mesh, color: str) -> Surface:
    triangles = mesh.vertices[mesh.faces]
    return Surface(triangles, np.tile(to_rgb(color), (len(triangles), 1)))
