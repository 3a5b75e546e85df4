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

from spiral_gripper_ros.actions.gripper_command import (
    GripperReading,
    OpeningCommand,
    command_from_joint,
    contact_force,
    goal_from_command,
    wrapped_diameter,
)
from spiral_gripper_ros.actions.server import GoalServer, Report
from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import opening_joint
from spiral_gripper_ros.planning.planner import AnyPlanner, WrapPlan
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
    names = {"gripper_cmd": chosen, "parallel_gripper_cmd": "ParallelGripperCommand"}
    if chosen == "ParallelGripperCommand":  # one name for one action
        del names["parallel_gripper_cmd"]
    for name, type_name in names.items():
        action = getattr(actions, type_name, None)
        if action is None:
            logger.info(f"{PACKAGE} has no {type_name}: {name} is not offered")
            continue
        try:
            servers.append(_SERVERS[type_name](node, runtime, action, name))
        except Exception as error:  # built for another Python, say: the node does without
            logger.error(f"{PACKAGE} cannot be used, {name} is not offered: {error}")
        else:
            logger.info(f"{name} is offered as {PACKAGE}/action/{type_name}")
    return servers


class _CommandServer(GoalServer):
    """The common part of the actions: commands and readings of an opening."""

    def _goal(self, command: OpeningCommand) -> GraspGoal | ReleaseGoal | Refusal:
        """Return what a command has the gripper do, or why it cannot."""
        runtime = self.runtime
        if runtime.loaded is None:
            return Refusal(Reason.NOT_ACTIVE, runtime.not_configured)
        planner = runtime.loaded.planner
        return goal_from_command(command, self._opening(), planner, runtime.limits)

    def _reading(self, report: Report) -> GripperReading:
        """Return the state of the gripper as a parallel gripper reports it.

        It never says that it is stalled: clients are free to take that for an object that is held.
        """
        loaded, snapshot = self.runtime.loaded, self.runtime.control.snapshot()
        planner = None if loaded is None else loaded.planner
        # Of a goal that was refused the gripper's own: it may hold what another goal made it hold.
        plan, pressure = report.plan or snapshot.plan, snapshot.pressure
        radius = snapshot.radius
        if plan is not None and radius is not None and snapshot.wrapped:
            return GripperReading(2.0 * radius, self._effort(plan, planner, pressure))
        return GripperReading(wrapped_diameter(pressure, self._opening(), planner), 0.0)

    def _effort(self, plan: WrapPlan, planner: AnyPlanner | None, pressure: float) -> float:
        """Return the force on the object [N]: of the grip where the object is seen, if known."""
        runtime = self.runtime
        if runtime.loaded is not None:
            radius, seen = plan.wrap.object_radius, runtime.seen_object()
            grip = runtime.loaded.grip(plan, radius, seen, pressure)
            if grip is not None:
                return grip.normal_force
        return contact_force(plan, planner, pressure)

    def _opening(self) -> float:
        return self.runtime.values.gripper_cmd.open_position


class GripperCommandServer(_CommandServer):
    """``GripperCommand``, or any action of that shape."""

    def goal(self, request: Any) -> GraspGoal | ReleaseGoal | Refusal:  # noqa: ANN401
        """Return the grasp or the release that a goal asks for."""
        command = request.command
        return self._goal(OpeningCommand(command.position, command.max_effort))

    def feedback(self, request: Any, report: Report) -> Any:  # noqa: ANN401
        """Return how a goal goes."""
        del request
        return self._filled(self.kind.Feedback(), report)

    def result(self, request: Any, report: Report) -> Any:  # noqa: ANN401
        """Return how a goal has ended."""
        del request
        return self._filled(self.kind.Result(), report)

    def _filled(self, message: Any, report: Report) -> Any:  # noqa: ANN401
        reading = self._reading(report)
        message.position, message.effort = reading.position, reading.effort
        message.reached_goal = report.outcome is GraspOutcome.SUCCEEDED
        return message


class ParallelGripperCommandServer(_CommandServer):
    """``ParallelGripperCommand``, or any action of that shape."""

    def goal(self, request: Any) -> GraspGoal | ReleaseGoal | Refusal:  # noqa: ANN401
        """Return the grasp or the release that a goal asks for."""
        if len(request.command.velocity):
            self.node.get_logger().warning(
                "parallel_gripper_cmd: velocity is not used; "
                "pressure.rate_up and pressure.rate_down bound how fast the gripper moves"
            )
        command = command_from_joint(request.command.position, request.command.effort)
        return command if isinstance(command, Refusal) else self._goal(command)

    def feedback(self, request: Any, report: Report) -> Any:  # noqa: ANN401
        """Return how a goal goes."""
        return self.kind.Feedback(state=self._state(request, report))

    def result(self, request: Any, report: Report) -> Any:  # noqa: ANN401
        """Return how a goal has ended."""
        reached = report.outcome is GraspOutcome.SUCCEEDED
        return self.kind.Result(state=self._state(request, report), reached_goal=reached)

    def _state(self, request: Any, report: Report) -> JointState:  # noqa: ANN401
        reading = self._reading(report)
        state = JointState(position=[reading.position], effort=[reading.effort])
        state.header.stamp = self.node.get_clock().now().to_msg()
        named = list(request.command.name)[:1]
        state.name = named or [opening_joint(self.runtime.values.frame_id)]
        return state


_SERVERS: dict[str, type[GoalServer]] = {
    "GripperCommand": GripperCommandServer,
    "ParallelGripperCommand": ParallelGripperCommandServer,
}
