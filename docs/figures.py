# SPDX-License-Identifier: Apache-2.0
"""Draw the README's picture: a gripper around a thin and a thick object, and its pressure curve.

Run by ``make figures``.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from spiral_core import Wrap, WrapCurve
from spiral_gripper import load_gripper

FIGURES = Path(__file__).parent / "figures"
GRIPPER = "paper_design_70"
OBJECT_RADII = (0.011, 0.030)  # the paper's tube light and PVC pipe [m]
TUBE_COLOR, FIBER_COLOR, OBJECT_COLOR = "#c8553d", "#40201a", "#7ba7b4"
SIDES, OBJECT_RINGS = 24, 120
LIGHT = np.array([0.35, -0.75, 0.56])
# Seen from the side, gravity down: base frame x (along the tube) points down on the page.
VIEW = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).T

Array = NDArray[np.float64]


def swept_quads(centers: Array, normals: Array, binormals: Array, radius: float) -> Array:
    """Return the quadrilaterals (n, m, 4, 3) of a tube of this radius around a line."""
    angles = np.linspace(0.0, 2.0 * np.pi, SIDES + 1)[None, :, None]
    ring = np.cos(angles) * normals[:, None] + np.sin(angles) * binormals[:, None]
    points = (centers[:, None] + radius * ring) @ VIEW.T
    corners = (points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:])
    return np.stack(corners, axis=2)


def shaded(quads: Array, color: str) -> Array:
    """Return a color (k, 4) for each quadrilateral (k, 4, 3), lit from above the viewer."""
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    light = 0.55 + 0.45 * np.clip(normals @ LIGHT, -0.6, 1.0)
    rgb = light[:, None] * np.array(mpl.colors.to_rgb(color))
    return np.column_stack((np.clip(rgb, 0.0, 1.0), np.ones(len(rgb))))


def rotation_columns(orientations: Array) -> tuple[Array, Array]:
    """Return the material y and z axes (n, 3) of scalar-last quaternions (n, 4)."""
    x, y, z, w = orientations.T
    second = np.column_stack((2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)))
    third = np.column_stack((2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)))
    return second, third


def object_quads(wrap: Wrap, outer_radius: float) -> Array:
    """Return the surface of the object next to the coils that hold it."""
    axis = np.array(wrap.coil.axis)
    inward, _ = rotation_columns(wrap.state.orientations[-1:])
    across = inward[0] - (inward[0] @ axis) * axis
    across *= (wrap.object_radius + outer_radius) / np.linalg.norm(across)
    center = wrap.state.tip_position + across
    reach = wrap.coil.advances - wrap.coil.advances[-1]
    along = np.linspace(0.62 * reach.min(), reach.max() + 0.04, OBJECT_RINGS)
    side = np.cross(axis, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    sides = (np.tile(v, (OBJECT_RINGS, 1)) for v in (side, np.cross(axis, side)))
    return swept_quads(center + along[:, None] * axis, *sides, wrap.object_radius)


def draw_wrap(axes: Axes, wrap: Wrap, outer_radius: float) -> None:
    """Draw a gripper, its straight fiber dark, and the object it wraps."""
    state = wrap.state
    tube = swept_quads(state.positions, *rotation_columns(state.orientations), outer_radius)
    colors = shaded(tube.reshape(-1, 4, 3), TUBE_COLOR).reshape(*tube.shape[:2], 4)
    colors[:, [0, -1], :3] = mpl.colors.to_rgb(FIBER_COLOR)
    thing = object_quads(wrap, outer_radius).reshape(-1, 4, 3)
    quads = np.concatenate((tube.reshape(-1, 4, 3), thing))
    faces = np.concatenate((colors.reshape(-1, 4), shaded(thing, OBJECT_COLOR)))
    axes.add_collection3d(
        Poly3DCollection(quads, facecolors=faces, edgecolors=faces, linewidths=0.2)
    )
    low, high = quads.min(axis=(0, 1)), quads.max(axis=(0, 1))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.view_init(elev=8, azim=-60)
    axes.set_title(
        f"object radius {wrap.object_radius * 1e3:.0f} mm: {wrap.pressure * 1e-3:.1f} kPa, "
        f"{wrap.turns:.1f} turns",
        fontsize=10,
    )


def draw_curve(axes: Axes, curve: WrapCurve, hanging: bool) -> None:
    """Draw pressure against object radius."""
    pressures = np.linspace(curve.pressure_min, curve.pressure_max, 60)
    radii = [curve.radius_from_pressure(float(p)) * 1e3 for p in pressures]
    label, style = ("hanging", "-") if hanging else ("without gravity", "--")
    axes.plot(radii, pressures * 1e-3, style, color=TUBE_COLOR, label=label)


def main() -> None:
    """Write docs/figures/wrap.png."""
    mpl.use("Agg")
    gripper = load_gripper(GRIPPER)
    curve = WrapCurve(gripper)
    figure = plt.figure(figsize=(11.0, 4.2), layout="constrained")
    for place, radius in enumerate(OBJECT_RADII, start=1):
        axes = figure.add_subplot(1, 3, place, projection="3d")
        draw_wrap(axes, curve.wrap_for_radius(radius), gripper.tube.outer_radius)
    plain = figure.add_subplot(1, 3, 3)
    draw_curve(plain, curve, hanging=True)
    draw_curve(plain, WrapCurve(gripper.with_mount((0.0, 0.0, 0.0), gripper.object_axis)), False)
    for radius in OBJECT_RADII:
        pressure = curve.pressure_from_radius(radius)
        plain.plot(radius * 1e3, pressure * 1e-3, "o", color=OBJECT_COLOR)
    plain.set_xlabel("object radius [mm]")
    plain.set_ylabel("pressure of the perfect wrap [kPa]")
    plain.set_xlim(left=0.0)
    plain.grid(alpha=0.3)
    plain.legend(frameon=False)
    FIGURES.mkdir(exist_ok=True)
    figure.savefig(FIGURES / "wrap.png", dpi=120)


if __name__ == "__main__":
    main()
