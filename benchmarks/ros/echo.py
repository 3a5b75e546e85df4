# SPDX-License-Identifier: Apache-2.0
"""A node that does nothing but send back what it receives: ``python -m benchmarks.ros.echo``.

With the types and qualities of service of the gripper's node, and rclpy as everybody uses it: what
ROS alone takes for the way there and back.
"""

from __future__ import annotations

from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Float64

from spiral_gripper_ros.messages.qos import COMMAND, NEWEST

MODULE = "benchmarks.ros.echo"


def main() -> None:
    """Echo until a stop signal."""
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.init()
        node = Node("echo")
        publisher = node.create_publisher(Float64, "pressure_command", COMMAND)
        node.create_subscription(Float64, "object_radius", publisher.publish, NEWEST)
        rclpy.spin(node)


if __name__ == "__main__":
    main()
