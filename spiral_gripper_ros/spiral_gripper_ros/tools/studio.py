# SPDX-License-Identifier: Apache-2.0
"""The subscriptions of ``spiral-gripper studio --ros``: status and markers of a node."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from visualization_msgs.msg import Marker, MarkerArray

from spiral_core.rod.types import Array
from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper.studio.live import NodeState
from spiral_gripper_msgs.msg import GripStatus, Wrap
from spiral_gripper_ros.client.listener import Listener
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.conversions import REGIME_NAMES, known, line_from_msg
from spiral_gripper_ros.messages.markers import MEASURED_TUBE, OBJECT, TUBE
from spiral_gripper_ros.messages.qos import LATEST
from spiral_gripper_ros.tools.node_text import node_text
from spiral_gripper_ros.tools.watcher import troubles_of


class StudioListener(Listener):
    """Subscribes to status and markers of a node.

    Args:
        namespace: of the node.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__(namespace)
        self.keep(GripStatus, "status", LATEST)
        self.keep(Wrap, "wrap", LATEST)
        self.keep(MarkerArray, "markers", LATEST)

    def heard(self) -> NodeState | None:
        """Return the newest state of the node; None before its first message."""
        status = self.newest("status")
        if status is None:
            return None
        planned, drawn = self.newest("wrap"), self.newest("markers")
        markers = {} if drawn is None else {one.ns: one for one in drawn.markers}
        tube = _added(markers, MEASURED_TUBE) or _added(markers, TUBE)
        return NodeState(
            age=time.monotonic() - self.received_at("status"),
            state=State(status.state).name.lower().replace("_", " "),
            command=status.pressure_command,
            target=status.pressure_target,
            measured=known(status.measured_pressure),
            object_radius=known(status.object_radius),
            regime=REGIME_NAMES[status.regime],
            held=planned.grip[0] if planned is not None and planned.grip else None,
            troubles=tuple(map(node_text, troubles_of(status).values())),
            tube=_points(tube),
            outer_radius=0.0 if tube is None else 0.5 * tube.scale.x,
            placement=_placement(_added(markers, OBJECT)),
        )


def _added(markers: dict[str, Any], name: str) -> Any:  # noqa: ANN401
    """Return the marker of a name if there is one to be drawn, else None."""
    marker = markers.get(name)
    return marker if marker is not None and marker.action == Marker.ADD else None


def _points(marker: Any) -> Array | None:  # noqa: ANN401
    """Return a line's points (n, 3) [m]; None where there is no line."""
    if marker is None or len(marker.points) < 2:
        return None
    return np.array([(p.x, p.y, p.z) for p in marker.points], dtype=np.float64)


def _placement(marker: Any) -> ObjectPlacement | None:  # noqa: ANN401
    """Return where a marker draws the object: a cylinder along its own z."""
    if marker is None:
        return None
    center, axis = line_from_msg(marker.pose)
    return ObjectPlacement(center, axis, 0.5 * marker.scale.x, marker.scale.z, largest_gap=0.0)
