# SPDX-License-Identifier: Apache-2.0
"""What the studio draws: the tube, the object, the base and gravity."""

from __future__ import annotations

import numpy as np
import trimesh
import viser
from matplotlib import colormaps

from spiral_core import Gripper, RodState
from spiral_core.rod.types import Array, Vector
from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper.reports.meshes import SIDES, Mesh, tube_mesh
from spiral_gripper.studio.settings import cone_ends

TUBE_COLOR = (200, 85, 61)
OBJECT_COLOR = (123, 167, 180)
# An object is drawn longer than its contact by this many of its radii at each end.
OVERHANG = 2.0
CLAMP = 0.015  # [m] length of the clamp that is drawn
ARROW = 0.06  # [m] gravity at 9.81 m/s^2
COLORINGS = ("plain", "contact force", "curvature", "strain", "bending moment")
GHOST_COLOR = (120, 120, 120)
OPAQUE = 0.75
# Of an object that the drawn coil does not feel.
FAINT = 0.25


class Scene:
    """The three-dimensional part of the page.

    Args:
        server: serves the page.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._scene.set_up_direction("-x")  # the tube hangs along +x
        self._scene.add_frame("/base", axes_length=0.02, axes_radius=0.0008)
        self._camera = server.initial_camera

    def look_at_gripper(self, length: float) -> None:
        """Begin with a view of a hanging gripper of this length [m], from its side."""
        self._camera.look_at = (0.4 * length, 0.0, 0.0)
        self._camera.position = (0.2 * length, -1.1 * length, 0.6 * length)

    def show_gripper(
        self, positions: Array | None, outer_radius: float, values: Array | None
    ) -> None:
        """Draw a tube around nodes (n, 3) [m], in one color or by values at them; or nothing."""
        if positions is None:
            self._scene.remove_by_name("/gripper")
        else:
            mesh = tube_mesh(positions, outer_radius)
            self._scene.add_mesh_trimesh("/gripper", _colored(mesh, values))

    def show_ghost(self, positions: Array | None, outer_radius: float) -> None:
        """Draw the free coil beside the one in contact, or nothing."""
        if positions is None:
            self._scene.remove_by_name("/free_coil")
        else:
            self._show("/free_coil", tube_mesh(positions, outer_radius), GHOST_COLOR, 0.25)

    def show_object(
        self,
        placement: ObjectPlacement | None,
        displacement: Array | None = None,
        opacity: float = OPAQUE,
        taper: float = 0.0,
    ) -> None:
        """Draw the object where it is wrapped, or moved from there [m]; or nothing.

        Args:
            placement: where it is wrapped.
            displacement: (3,) from there [m].
            opacity: 1 hides what is behind it.
            taper: its half-angle [rad].
        """
        if placement is None:
            for name in ("/object", "/object_frame"):
                self._scene.remove_by_name(name)
            return
        reach = 0.5 * placement.length + OVERHANG * placement.radius
        center, axis = np.asarray(placement.center), np.asarray(placement.axis)
        center = center if displacement is None else center + displacement
        heights = np.array(cone_ends(placement.radius, taper, reach))
        ends = center + heights[:, None] * axis
        mesh = tube_mesh(ends, placement.radius + np.tan(taper) * heights, 2 * SIDES)
        self._show("/object", mesh, OBJECT_COLOR, opacity)
        self._scene.add_frame(
            "/object_frame", axes_length=1.5 * placement.radius, axes_radius=0.0008,
            position=tuple(center.tolist()), wxyz=tuple(_turned_to(axis).tolist()),
        )  # fmt: skip

    def show_mount(self, outer_radius: float) -> None:
        """Draw the clamp of a tube of this outer radius [m]: it ends where the base frame is."""
        ends = np.array(((-CLAMP, 0.0, 0.0), (0.0, 0.0, 0.0)))
        self._show("/mount", tube_mesh(ends, 1.4 * outer_radius, 2 * SIDES), GHOST_COLOR)

    def _show(
        self, name: str, mesh: Mesh, color: tuple[int, int, int], opacity: float | None = None
    ) -> None:
        self._scene.add_mesh_simple(name, mesh.vertices, mesh.faces, color=color, opacity=opacity)

    def show_gravity(self, gravity: Vector) -> None:
        """Draw gravity [m/s^2] as an arrow beside the base."""
        tip = ARROW / 9.81 * np.asarray(gravity)
        start = np.array((0.0, -0.05, 0.0))
        points = np.array([[start, start + tip]], dtype=np.float32)
        self._scene.add_arrows(
            "/gravity", points, colors=(90, 90, 90),
            shaft_radius=0.001, head_radius=0.003, head_length=0.008,
        )  # fmt: skip


def _turned_to(axis: Array) -> Array:
    """Return the unit quaternion (w, x, y, z) that turns z to a unit vector the shortest way."""
    turn = np.array((1.0 + axis[2], -axis[1], axis[0], 0.0))
    size = float(np.linalg.norm(turn))
    return turn / size if size > 1e-6 else np.array((0.0, 1.0, 0.0, 0.0))


def node_values(gripper: Gripper, pressure: float, state: RodState, coloring: str) -> Array | None:
    """Return what colors the nodes (n,): one of :data:`COLORINGS`; None for one color.

    Args:
        gripper: whose shape it is.
        pressure: of the shape [Pa].
        state: the shape, free or in contact.
        coloring: contact force [N], curvature [1/m], largest strain of the wall (at the side away
            from the straight fiber, which does not stretch), bending moment [N m].
    """
    if coloring == "contact force":
        pressed: Array = state.normal_forces.sum(axis=0)
        return pressed
    moment: Array = np.linalg.norm(state.moments[:, 1:], axis=1)
    if coloring == "bending moment":
        return moment
    rest = gripper.unloaded_shape(pressure)
    change = np.linalg.solve(gripper.stiffness.matrix, state.moments.T)
    towards = rest.curvature + change[2]
    if coloring == "curvature":
        total: Array = np.hypot(change[1], towards)
        return total
    strain: Array = 2.0 * gripper.tube.outer_radius * np.abs(towards)
    return strain if coloring == "strain" else None


def _colored(mesh: Mesh, values: Array | None) -> trimesh.Trimesh:
    """Return a mesh whose sections have the colors of their values, low to high."""
    colors = np.tile(np.array((*TUBE_COLOR, 255), dtype=np.uint8), (len(mesh.vertices), 1))
    if values is not None:
        low, high = float(values.min()), float(values.max())
        share = (values - low) / (high - low) if high > low else np.zeros_like(values)
        colors = (255 * colormaps["viridis"](share)).astype(np.uint8)[mesh.rows]
    return trimesh.Trimesh(mesh.vertices, mesh.faces, vertex_colors=colors, process=False)
