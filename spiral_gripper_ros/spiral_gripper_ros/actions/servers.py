# SPDX-License-Identifier: Apache-2.0
"""The actions of the node: `grasp`, `release`, `find_approach`, those of control_msgs."""

from __future__ import annotations

import time

from rclpy.node import Node

from spiral_gripper_msgs.action import Grasp, Release
from spiral_gripper_ros.actions.find_approach import ApproachServer
from spiral_gripper_ros.actions.grasp import GraspServer
from spiral_gripper_ros.actions.gripper_command_server import gripper_command_servers
from spiral_gripper_ros.actions.release import ReleaseServer
from spiral_gripper_ros.actions.server import GoalServer
from spiral_gripper_ros.process.guards import GuardedLoop
from spiral_gripper_ros.runtime.runtime import Runtime

# How long a node that is stopped goes on, so that its goals' results are sent [s]: some rounds of
# the executor and the way through the middleware, which take about a tenth of it.
END_TIME = 0.2


class GoalServers:
    """Serves `grasp`, `release`, `find_approach` and, where it is installed, those of control_msgs.

    They are served as long as the node exists.

    Args:
        node: the ROS node that serves.
        runtime: the gripper.
    """

    def __init__(self, node: Node, runtime: Runtime) -> None:
        runtime.on_published = self._tick
        self._servers: list[GoalServer] = [
            GraspServer(node, runtime, Grasp, "grasp"),
            ReleaseServer(node, runtime, Release, "release"),
            *gripper_command_servers(node, runtime),
        ]
        self._approaches = ApproachServer(node, runtime)

    def _tick(self) -> None:
        for server in self._servers:
            server.tick()

    def end(self, loop: GuardedLoop) -> bool:
        """Let the goals of a node that is stopped send their results; return whether any ran.

        Whatever else was waiting has then been called as well.

        Args:
            loop: of the node.
        """
        if not any(server.runs for server in self._servers):
            return False
        self._tick()
        deadline = time.monotonic() + END_TIME
        while time.monotonic() < deadline:
            loop.turn()
        return True

    def destroy(self) -> None:
        """Serve no longer."""
        self._approaches.destroy()
        for server in self._servers:
            server.destroy()
