# SPDX-License-Identifier: Apache-2.0
"""The actions of control_msgs for parallel grippers, as MoveIt and ros2_control clients know them.

control_msgs is optional: the actions are offered where it is installed. Each has a name of its own,
because one name cannot have two types within a process.
"""

from __future__ import annotations

import importlib
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import JointState

from spiral_gripper_ros.actions.gripper_command import goal_from_command
from spiral_gripper_ros.actions.server import GoalServer
from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome, GraspReport
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import filled, opening_joint
from spiral_gripper_ros.runtime.runtime import Runtime

PACKAGE = "control_msgs"


def gripper_command_servers(node: Node, runtime: Runtime) -> list[GoalServer]:
    """Return a server for each action of control_msgs that is installed; the log says which."""
    logger = node.get_logger()
    servers: list[GoalServer] = []
    try:
        actions = importlib.import_module(f"{PACKAGE}.action")
    except ImportError:
        logger.info(f"{PACKAGE} is not installed: gripper_cmd is not offered")
        return servers
    chosen = runtime.values.gripper_cmd.type
    names = {chosen: "gripper_cmd"}
    names.setdefault("ParallelGripperCommand", "parallel_gripper_cmd")  # one name for one action
    for type_name, name in names.items():
        action = getattr(actions, type_name, None)
        if action is None:
            logger.info(f"{PACKAGE} has no {type_name}: {name} is not offered")
            continue
        try:
            servers.append(GripperCommandServer(node, runtime, action, name))
        except Exception as error:  # built for another Python, say: the node does without
            logger.error(f"{PACKAGE} cannot be used, {name} is not offered: {error}")
        else:
            logger.info(f"{name} is offered as {PACKAGE}/action/{type_name}")
    return servers


class GripperCommandServer(GoalServer):
    """``GripperCommand`` and ``ParallelGripperCommand``, or any action of their shapes."""

    def goal(self, request: Any) -> GraspGoal | ReleaseGoal | Refusal:  # noqa: ANN401
        """Return the grasp or the release that a goal asks for, or why it cannot be done."""
        runtime, command = self.runtime, request.command
        if runtime.loaded is None:
            return Refusal(Reason.NOT_ACTIVE, runtime.not_configured)
        if not hasattr(command, "velocity"):
            positions, efforts = [command.position], [command.max_effort]
        else:
            positions, efforts = command.position, command.effort
            if len(command.velocity):
                self.node.get_logger().warning(
                    "parallel_gripper_cmd: velocity is not used; "
                    "pressure.rate_up and pressure.rate_down bound how fast the gripper moves"
                )
        planner, limits = runtime.loaded.planner, runtime.limits
        return goal_from_command(positions, efforts, self._opening, planner, limits)

    def told(self, message: Any, request: Any, report: GraspReport) -> Any:  # noqa: ANN401
        """Return the feedback on a goal, or its result.

        It never says that it is stalled: clients are free to take that for an object that is held.
        """
        position, effort = self._reading()
        joint = JointState(position=[position], effort=[effort])
        joint.header.stamp = self.node.get_clock().now().to_msg()
        own = opening_joint(self.runtime.values.frame_id)
        joint.name = list(getattr(request.command, "name", ()))[:1] or [own]
        reached = report.outcome is GraspOutcome.SUCCEEDED
        told = {"position": position, "effort": effort, "state": joint, "reached_goal": reached}
        return filled(message, **told)

    def _reading(self) -> tuple[float, float]:
        """Return the diameter that is wrapped [m] and the force on the object [N].

        The force is that where the object is seen, if known; 0 if none is held.
        """
        runtime, snapshot = self.runtime, self.runtime.control.snapshot()
        loaded, pressure, plan = runtime.loaded, snapshot.pressure, snapshot.plan
        force = 0.0
        if loaded is not None and plan is not None and snapshot.wrapped:
            grip, free = runtime.grip(pressure), loaded.planner.contact_force
            force = free(plan, pressure) if grip is None else grip.normal_force
        return runtime.diameter(), force

    @property
    def _opening(self) -> float:
        return self.runtime.values.gripper_cmd.open_position
