# SPDX-License-Identifier: Apache-2.0
"""The simulated source of radii as a node: what a camera's node would publish."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float64

from spiral_gripper_ros.parameters.declared import DeclaredParameters
from spiral_gripper_ros.simulation.radius_estimator import RadiusEstimator, RadiusParameters

RADIUS_NODE = "radius_source"


class RadiusNode(Node):  # type: ignore[misc]
    """Publishes `object_radius` as an estimator with errors would.

    The caller advances its time with :meth:`step`.

    Args:
        middle_radius: what a radius that is not given stands for [m].
        options: passed on to rclpy's node.

    Raises:
        ValueError: a parameter given at start is bad; the message says why.
    """

    def __init__(self, middle_radius: float, **options: Any) -> None:  # noqa: ANN401
        super().__init__(RADIUS_NODE, **options)
        self._declared = DeclaredParameters(self, self._apply, RadiusParameters)
        self.estimator = RadiusEstimator(self._declared.values(), middle_radius)
        self._radii = self.create_publisher(Float64, "object_radius", qos_profile_sensor_data)

    def step(self, now: float) -> None:
        """Publish what falls due before a time of the simulation [s]."""
        for estimate in self.estimator.estimates(now):
            self._radii.publish(Float64(data=estimate))

    def _apply(self, names: set[str]) -> None:
        """Let parameters take effect at once."""
        del names
        self.estimator.values = self._declared.values()
