# SPDX-License-Identifier: Apache-2.0
"""Collision model of a gripper for a robot's URDF."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import numpy as np

from spiral_core.grip.grip import Grip
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Array
from spiral_gripper.reports.wrap_document import solve_shape

# Shapes without an object, from 0 Pa to the grip's pressure, that the swept volume holds.
SWEPT_SHAPES = 17
# Distance of spheres as a fraction of the tube's outer radius: they protrude by about an eighth.
SPHERE_SPACING = 1.0


@dataclass(frozen=True, slots=True)
class RobotModel:
    """Geometry of a gripper for a robot description, in the gripper's base frame [m].

    Args:
        name: of the gripper.
        tube_radius: outer radius of the tube.
        length: of the tube, unpressurized.
        object_radius: of the object that is wrapped.
        pressure: recommended gauge pressure [Pa].
        tip: of the wrapped shape.
        swept_low, swept_high: corners of the box that holds every shape on the way to that
            pressure, with the object and without.
        spheres: center and radius (n, 4) of spheres that cover the wrapped tube.
    """

    name: str
    tube_radius: float
    length: float
    object_radius: float
    pressure: float
    tip: Array
    swept_low: Array
    swept_high: Array
    spheres: Array


def model_of(grip: Grip, radius: float) -> RobotModel:
    """Return the model of a gripper on its object at the recommended pressure.

    Args:
        grip: its forces do not matter.
        radius: of the object, where that varies in the middle of what is wrapped [m].

    Raises:
        SolverError: a shape could not be certified.
    """
    gripper, pressure = grip.setup.gripper, grip.recommended_pressure()
    outer, wrapped = gripper.tube.outer_radius, grip.window.at(pressure).state
    shapes = [point.state for point in grip.window.points if point.pressure < pressure]
    free = np.linspace(0.0, pressure, SWEPT_SHAPES).tolist()
    shapes += [solve_shape(gripper, each).state for each in free]
    swept = np.concatenate([each.positions for each in (*shapes, wrapped)])
    return RobotModel(
        name=gripper.name,
        tube_radius=outer,
        length=gripper.tube.length,
        object_radius=radius,
        pressure=pressure,
        tip=wrapped.tip_position,
        swept_low=swept.min(axis=0) - outer,
        swept_high=swept.max(axis=0) + outer,
        spheres=covering_spheres(wrapped, outer),
    )


def covering_spheres(state: RodState, outer_radius: float) -> Array:
    r"""Return spheres (n, 4), center and radius [m], that cover a tube.

    They stand at equal distances :math:`d` along the backbone. Between two of them the surface of
    a tube of outer radius :math:`r_o` and curvature :math:`\kappa` is, on the outside of the bend,

    .. math:: \sqrt{r_o^2 + (1 + \kappa r_o)(d/2)^2} + \kappa h^2 / 8

    from the nearer center at most; the last term is for the straight line between nodes at the
    distance :math:`h`.

    Args:
        state: the tube's shape.
        outer_radius: r_o [m], > 0.
    """
    steps = np.diff(state.positions, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    along = np.concatenate(([0.0], np.cumsum(lengths)))
    count = 1 + math.ceil(along[-1] / (SPHERE_SPACING * outer_radius))
    places = np.linspace(0.0, along[-1], count)
    centers = np.stack([np.interp(places, along, x) for x in state.positions.T], axis=1)
    directions = steps / lengths[:, None]
    turning = np.linalg.norm(np.diff(directions, axis=0), axis=1)
    curvature = float(np.max(turning / np.minimum(lengths[1:], lengths[:-1]), initial=0.0))
    spacing = along[-1] / (count - 1)
    outside = math.sqrt(1.0 + curvature * outer_radius) * 0.5 * spacing
    chord = curvature * float(lengths.max()) ** 2 / 8.0
    radius = math.hypot(outer_radius, outside) + chord
    return np.column_stack((centers, np.full(count, radius)))


def model_as_urdf(model: RobotModel) -> str:
    """Return a URDF of one link: the wrapped tube as spheres, to look at and to keep clear of."""
    spheres = "".join(
        f'    <{kind}><origin xyz="{x:.5f} {y:.5f} {z:.5f}"/>'
        f'<geometry><sphere radius="{radius:.5f}"/></geometry></{kind}>\n'
        for kind in ("visual", "collision")
        for x, y, z, radius in model.spheres.tolist()
    )
    return (
        '<?xml version="1.0"?>\n'
        f"<!-- Around an object of {1e3 * model.object_radius:g} mm, {model.pressure:.0f} Pa; base"
        f" frame, x along the tube. -->\n"
        f"<robot name={quoteattr(model.name)}>\n"
        f'  <link name="gripper_base">\n{spheres}  </link>\n'
        "</robot>\n"
    )


def model_as_yaml(model: RobotModel) -> str:
    """Return the file that ``urdf/spiral_gripper.urdf.xacro`` reads: meters, pascals."""

    def row(values: Array) -> str:
        return f"[{', '.join(f'{value:.5f}' for value in values.tolist())}]"

    lines = [
        "# A gripper for urdf/spiral_gripper.urdf.xacro, in its base frame; meters, pascals.",
        f"# Written by `spiral-gripper model`, for an object of {1e3 * model.object_radius:g} mm.",
        f"name: {json.dumps(model.name, ensure_ascii=False)}",
        f"tube_radius: {model.tube_radius:.5f}",
        f"length: {model.length:.5f}",
        f"object_radius: {model.object_radius:.5f}",
        f"pressure: {model.pressure:.1f}",
        f"tip: {row(model.tip)}",
        f"swept_center: {row(0.5 * (model.swept_low + model.swept_high))}",
        f"swept_size: {row(model.swept_high - model.swept_low)}",
        "spheres:  # x, y, z, radius",
        *(f"  - {row(sphere)}" for sphere in model.spheres),
    ]
    return "\n".join(lines) + "\n"
