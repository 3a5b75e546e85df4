# SPDX-License-Identifier: Apache-2.0
"""Markers for RViz: the tube as commanded and as measured, its straight fiber, object, text."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from spiral_core.grip.curve import TubeShape
from spiral_core.rod.state import RodState
from spiral_core.wrap.placement import ObjectPlacement
from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper_ros.messages.conversions import picked_nodes, pose_along

# One marker in each namespace, with id 0.
TUBE, MEASURED_TUBE, FIBER, OBJECT, TEXT = NAMESPACES = (
    "tube",
    "measured_tube",
    "straight_fiber",
    "object",
    "state",
)

BLUE = (0.30, 0.55, 0.90, 1.0)
PALE_BLUE = (0.30, 0.55, 0.90, 0.35)
VIOLET = (0.60, 0.30, 0.75, 1.0)
BLACK = (0.10, 0.10, 0.10, 1.0)
WHITE = (1.0, 1.0, 1.0, 1.0)
# Of the object: how it is held.
REGIME_COLORS = {
    None: (0.60, 0.60, 0.60, 0.6),
    WrapRegime.OVERHANG: (0.95, 0.75, 0.10, 0.8),
    WrapRegime.PERFECT_WRAP: (0.20, 0.70, 0.30, 0.8),
    WrapRegime.CURLING: (0.85, 0.25, 0.20, 0.8),
}
# The fiber's width and the text's height, as fractions of the tube's diameter.
FIBER_WIDTH = 0.15
TEXT_HEIGHT = 1.0


def scene_to_msg(
    commanded: RodState | TubeShape | None,
    measured: RodState | TubeShape | None,
    placement: ObjectPlacement | None,
    regime: WrapRegime | None,
    text: str,
    outer_radius: float,
    *,
    points: int,
    lifetime: float,
    header: Any,  # noqa: ANN401
) -> MarkerArray:
    """Return the markers of a scene; what is None is not drawn.

    Every message stands alone: it adds what there is and deletes what there is not, so that a
    display that misses some is right again with the next.

    Args:
        commanded: shape at the commanded pressure.
        measured: shape at the measured pressure.
        placement: where the object in use is.
        regime: how it is held, as far as is known.
        text: state and pressure, for people.
        outer_radius: of the tube [m].
        points: largest number of points of a line, >= 2.
        lifetime: time [s] after which a display forgets them, should the node be gone.
        header: stamp and frame of the markers.
    """
    diameter, shown = 2.0 * outer_radius, measured or commanded
    blue = BLUE if measured is None else PALE_BLUE
    markers = {
        TUBE: _line(commanded, points, diameter, blue),
        MEASURED_TUBE: _line(measured, points, diameter, VIOLET),
        FIBER: _line(shown, points, FIBER_WIDTH * diameter, BLACK, outer_radius),
        OBJECT: _object(placement, REGIME_COLORS[regime]),
        TEXT: _text(text, diameter),
    }
    fraction, whole = math.modf(lifetime)
    for marker in filter(None, markers.values()):
        marker.lifetime = Duration(sec=int(whole), nanosec=int(fraction * 1e9))
        marker.frame_locked = True
    return _array(markers, header)


def no_markers(header: Any) -> MarkerArray:  # noqa: ANN401
    """Return the message that deletes every marker."""
    return _array(dict.fromkeys(NAMESPACES), header)


def _array(markers: Mapping[str, Marker | None], header: Any) -> MarkerArray:  # noqa: ANN401
    """Return the message of markers by their namespaces; None becomes a deletion."""
    message = MarkerArray()
    for namespace, marker in markers.items():
        told = Marker(action=Marker.DELETE) if marker is None else marker
        told.header, told.ns = header, namespace
        message.markers.append(told)
    return message


def _line(
    state: RodState | TubeShape | None,
    points: int,
    width: float,
    color: tuple[float, ...],
    outside: float = 0.0,
) -> Marker | None:
    """Return a line along a tube, or so far outside of its middle on the fiber's side [m]."""
    if state is None:
        return None
    picked = picked_nodes(state, points)
    x, y, z, w = state.orientations[picked].T
    y_axes = 2.0 * np.stack((x * y - z * w, 0.5 - x * x - z * z, y * z + x * w), axis=1)
    nodes = state.positions[picked] + outside * y_axes
    return Marker(
        type=Marker.LINE_STRIP,
        pose=Pose(orientation=Quaternion(w=1.0)),
        scale=Vector3(x=width),
        color=_color(color),
        points=[Point(x=x, y=y, z=z) for x, y, z in nodes.tolist()],
    )


def _object(placement: ObjectPlacement | None, color: tuple[float, ...]) -> Marker | None:
    if placement is None:
        return None
    diameter = 2.0 * placement.radius
    return Marker(
        type=Marker.CYLINDER,
        pose=pose_along(placement),
        scale=Vector3(x=diameter, y=diameter, z=placement.length),
        color=_color(color),
    )


def _text(text: str, diameter: float) -> Marker | None:
    """Return the text, before the clamped end where no shape hides it."""
    if not text:
        return None
    return Marker(
        type=Marker.TEXT_VIEW_FACING,
        pose=Pose(position=Point(x=-3.0 * diameter), orientation=Quaternion(w=1.0)),
        scale=Vector3(z=TEXT_HEIGHT * diameter),
        color=_color(WHITE),
        text=text,
    )


def _color(components: tuple[float, ...]) -> ColorRGBA:
    return ColorRGBA(**dict(zip("rgba", components, strict=True)))
