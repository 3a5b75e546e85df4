"""What the node publishes, with its qualities of service."""

from __future__ import annotations

import math
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, LifecyclePublisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64, Header

from spiral_gripper_msgs.msg import GripStatus

# The newest message is for latecomers too: a regulator or display that starts after the node.
LATEST = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
# How long a stopping node waits until everyone has acknowledged the vent [s].
ACKNOWLEDGE_TIMEOUT = 0.5


class Outputs:
    """The node's publishers.

    ``pressure_command`` and ``/diagnostics`` exist as long as the node, in every lifecycle state,
    so that a vent always gets out; ``status`` and ``backbone`` are lifecycle publishers.

    Args:
        node: the node that publishes.
        frame_id: frame of the stamped messages.
    """

    def __init__(self, node: LifecycleNode, frame_id: str) -> None:
        self._node = node
        self._frame_id = frame_id
        self._pressure = node.create_publisher(Float64, "pressure_command", LATEST)
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._status: LifecyclePublisher | None = None
        self._backbone: LifecyclePublisher | None = None

    def configure(self) -> None:
        """Create the lifecycle publishers."""
        self._status = self._node.create_lifecycle_publisher(GripStatus, "status", LATEST)
        self._backbone = self._node.create_lifecycle_publisher(PoseArray, "backbone", LATEST)

    def cleanup(self) -> None:
        """Destroy the lifecycle publishers."""
        for publisher in (self._status, self._backbone):
            if publisher is not None:
                self._node.destroy_lifecycle_publisher(publisher)
        self._status = self._backbone = None

    def header(self) -> Any:  # noqa: ANN401
        """Return a header with the present time and the gripper's frame."""
        return Header(stamp=self._node.get_clock().now().to_msg(), frame_id=self._frame_id)

    def publish_pressure(self, pressure: float) -> None:
        """Publish a gauge pressure [Pa]; anything that is not a finite number goes out as 0."""
        self._pressure.publish(Float64(data=pressure if math.isfinite(pressure) else 0.0))

    def publish_status(self, status: GripStatus) -> None:
        """Publish the status, if the node is active."""
        if self._status is not None:
            self._status.publish(status)

    def publish_backbone(self, backbone: PoseArray) -> None:
        """Publish the predicted shape, if the node is active."""
        if self._backbone is not None:
            self._backbone.publish(backbone)

    def publish_diagnostics(self, diagnostics: DiagnosticArray) -> None:
        """Publish the diagnostics."""
        self._diagnostics.publish(diagnostics)

    def flush(self) -> None:
        """Wait until the last pressure is acknowledged, or for ``ACKNOWLEDGE_TIMEOUT``."""
        self._pressure.wait_for_all_acked(Duration(seconds=ACKNOWLEDGE_TIMEOUT))
