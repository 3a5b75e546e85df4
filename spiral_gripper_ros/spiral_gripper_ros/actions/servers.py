# SPDX-License-Identifier: Apache-2.0
"""The actions of the node: `grasp`, `release`, those of control_msgs."""

from __future__ import annotations

from rclpy.executors import Executor
from rclpy.node import Node

from spiral_gripper_msgs.action import Grasp, Release
from spiral_gripper_ros.actions.grasp import GraspAdapter
from spiral_gripper_ros.actions.gripper_command_server import gripper_command_servers
from spiral_gripper_ros.actions.release import ReleaseAdapter
from spiral_gripper_ros.actions.runner import GoalRunner
from spiral_gripper_ros.actions.server import GoalServer
from spiral_gripper_ros.runtime.runtime import Runtime


class GoalServers:
    """Serves `grasp`, `release` and, where they are installed, the actions of control_msgs.

    They are served as long as the node exists.

    Args:
        node: the ROS node that serves.
        runtime: the gripper.
    """

    def __init__(self, node: Node, runtime: Runtime) -> None:
        self._runner = GoalRunner(runtime)
        runtime.on_published = self._runner.tick
        self._servers = [
            GoalServer(node, self._runner, (Grasp, "grasp"), GraspAdapter(runtime)),
            GoalServer(node, self._runner, (Release, "release"), ReleaseAdapter(runtime)),
        ]
        self._servers += gripper_command_servers(node, runtime, self._runner)

    def end(self, executor: Executor) -> bool:
        """Let the goals of a node that is stopped send their results; return whether any ran.

        Whatever else was waiting has then been called as well.

        Args:
            executor: of the node; it must not be spinning.
        """
        return self._runner.end(executor)

    def destroy(self) -> None:
        """Serve no longer."""
        self._runner.destroy()
        for server in self._servers:
            server.destroy()
