# SPDX-License-Identifier: Apache-2.0
"""The publishers of the node."""

from __future__ import annotations

import math
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, LifecyclePublisher
from std_msgs.msg import Float64, Header
from visualization_msgs.msg import MarkerArray

from spiral_gripper_msgs.msg import GripStatus, Wrap
from spiral_gripper_ros.messages.conversions import backbone_to_msg
from spiral_gripper_ros.messages.qos import COMMAND, LATEST
from spiral_gripper_ros.planning.planner import GripShape

# How long a stopping node waits until everyone has acknowledged the vent [s].
ACKNOWLEDGE_TIMEOUT = 0.5

_MANAGED = {
    "status": GripStatus,
    "wrap": Wrap,
    "backbone": PoseArray,
    "measured_backbone": PoseArray,
    "markers": MarkerArray,
}


class Outputs:
    """The node's publishers.

    ``pressure_command`` and ``/diagnostics`` exist as long as the node, in every lifecycle state,
    so that a vent always gets out; the others are lifecycle publishers.

    Args:
        node: the node that publishes.
        frame_id: frame of the stamped messages.
    """

    def __init__(self, node: LifecycleNode, frame_id: str) -> None:
        self._node = node
        self._frame_id = frame_id
        self._pressure = node.create_publisher(Float64, "pressure_command", COMMAND)
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._managed: dict[str, LifecyclePublisher] = {}

    def configure(self) -> None:
        """Create the lifecycle publishers."""
        for name, kind in _MANAGED.items():
            self._managed[name] = self._node.create_lifecycle_publisher(kind, name, LATEST)

    def cleanup(self) -> None:
        """Destroy the lifecycle publishers."""
        for publisher in self._managed.values():
            self._node.destroy_lifecycle_publisher(publisher)
        self._managed.clear()

    def header(self) -> Any:  # noqa: ANN401
        """Return a header with the present time and the gripper's frame."""
        return Header(stamp=self._node.get_clock().now().to_msg(), frame_id=self._frame_id)

    def publish_pressure(self, pressure: float) -> None:
        """Publish a gauge pressure [Pa]; anything that is not a finite number goes out as 0."""
        self._pressure.publish(Float64(data=pressure if math.isfinite(pressure) else 0.0))

    def publish(self, name: str, message: Any) -> None:  # noqa: ANN401
        """Publish status, markers or a shape on the topic of this name, if the node is active."""
        publisher = self._managed.get(name)
        if publisher is not None:
            publisher.publish(message)

    def publish_shape(self, name: str, shape: GripShape | None, points: int, header: Any) -> None:  # noqa: ANN401
        """Publish a shape, if there is one and the node is active."""
        if shape is not None:
            self.publish(name, backbone_to_msg(shape.state, points, header))

    @property
    def markers_are_wanted(self) -> bool:
        """Whether anybody subscribes to ``markers``."""
        publisher = self._managed.get("markers")
        return publisher is not None and publisher.get_subscription_count() > 0

    def publish_diagnostics(self, diagnostics: DiagnosticArray) -> None:
        """Publish the diagnostics."""
        self._diagnostics.publish(diagnostics)

    def flush(self) -> None:
        """Wait until the last pressure is acknowledged, or for ``ACKNOWLEDGE_TIMEOUT``."""
        self._pressure.wait_for_all_acked(Duration(seconds=ACKNOWLEDGE_TIMEOUT))
