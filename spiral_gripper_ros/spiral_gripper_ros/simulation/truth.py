# SPDX-License-Identifier: Apache-2.0
"""The true state of the simulation as topics below `simulated/`, for displays, plots, tests."""

from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import PoseArray
from rclpy.node import Node
from std_msgs.msg import Float64, String

from spiral_core.rod.state import RodState
from spiral_gripper_ros.messages.conversions import backbone_to_msg
from spiral_gripper_ros.messages.qos import MEASUREMENTS
from spiral_gripper_ros.simulation.simulated_gripper import Grip, SimulatedGripper

BACKBONE_POINTS = 50
# What the pressure must change by for the shape to be solved anew [Pa]: its tip moves by some
# micrometers then.
FINEST = 1.0


class Truth:
    """Publishes the real pressure, the real object, and how the real gripper holds it.

    Args:
        node: whose topics these are.
        gripper: the gripper as it really is.
    """

    def __init__(self, node: Node, gripper: SimulatedGripper) -> None:
        self._gripper = gripper
        self._solved_pressure, self._solved_grip = math.nan, Grip.UNKNOWN
        self._solved_radius: float | None = None
        self._solved_shape: RodState | None = None
        self._pressure = node.create_publisher(Float64, "simulated/pressure", MEASUREMENTS)
        self._radius = node.create_publisher(Float64, "simulated/object_radius", MEASUREMENTS)
        self._grip = node.create_publisher(String, "simulated/grip", MEASUREMENTS)
        self._backbone = node.create_publisher(PoseArray, "simulated/backbone", MEASUREMENTS)

    def publish(self, pressure: float, radius: float | None, header: Any) -> None:  # noqa: ANN401
        """Publish the present state.

        Args:
            pressure: in the gripper [Pa].
            radius: of the object [m]; None: there is none, published as 0.
            header: of the stamped messages.
        """
        self._pressure.publish(Float64(data=pressure))
        self._radius.publish(Float64(data=radius or 0.0))
        if radius != self._solved_radius or not abs(pressure - self._solved_pressure) < FINEST:
            self._solved_pressure, self._solved_radius = pressure, radius
            self._solved_shape = self._gripper.shape(pressure)
            self._solved_grip = self._gripper.grip(pressure, radius, self._solved_shape)
        self._grip.publish(String(data=self._solved_grip.value))
        if self._solved_shape is not None:
            self._backbone.publish(backbone_to_msg(self._solved_shape, BACKBONE_POINTS, header))
