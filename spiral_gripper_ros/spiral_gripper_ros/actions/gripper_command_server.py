# SPDX-License-Identifier: Apache-2.0
"""The actions of control_msgs for parallel grippers, as MoveIt and ros2_control clients know them.

control_msgs is optional: the actions are offered where it is installed. Each has a name of its own,
because one name cannot have two types within a process.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
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
from spiral_gripper_ros.actions.jobs import GraspJob, Job, ReleaseJob
from spiral_gripper_ros.actions.runner import GoalRunner, GoalUpdate
from spiral_gripper_ros.actions.server import ActionAdapter, GoalServer
from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import opening_joint
from spiral_gripper_ros.planning.planner import AnyPlanner, WrapPlan
from spiral_gripper_ros.runtime.runtime import Runtime

PACKAGE = "control_msgs"


def gripper_command_servers(node: Node, runtime: Runtime, runner: GoalRunner) -> list[GoalServer]:
    """Return a server for each action of control_msgs that is installed; the log says which."""
    logger = node.get_logger()
    servers: list[GoalServer] = []
    try:
        actions = importlib.import_module(f"{PACKAGE}.action")
    except ImportError:
        logger.info(f"{PACKAGE} is not installed: gripper_cmd is not offered")
        return servers
    chosen = runtime.values.gripper_cmd_type
    names = {"gripper_cmd": chosen, "parallel_gripper_cmd": "ParallelGripperCommand"}
    if chosen == "ParallelGripperCommand":  # one name for one action
        del names["parallel_gripper_cmd"]
    for name, type_name in names.items():
        adapter = _ADAPTERS[type_name]
        action = getattr(actions, type_name, None)
        if action is None:
            logger.info(f"{PACKAGE} has no {type_name}: {name} is not offered")
            continue
        try:
            servers.append(GoalServer(node, runner, (action, name), adapter(node, runtime, action)))
        except Exception as error:  # built for another Python, say: the node does without
            logger.error(f"{PACKAGE} cannot be used, {name} is not offered: {error}")
        else:
            logger.info(f"{name} is offered as {PACKAGE}/action/{type_name}")
    return servers


class _CommandAdapter:
    """The common part of the actions: commands and readings of an opening.

    Args:
        node: the ROS node that serves.
        runtime: the gripper that carries out the goals.
        action: the type of the action.
    """

    def __init__(self, node: Node, runtime: Runtime, action: Any) -> None:  # noqa: ANN401
        self._node = node
        self._runtime = runtime
        self._action = action

    def _job(self, command: OpeningCommand) -> Job | Refusal:
        """Return what a command has the gripper do, or why it cannot."""
        runtime = self._runtime
        if runtime.loaded is None:
            return Refusal(Reason.NOT_ACTIVE, runtime.not_configured)
        goal = goal_from_command(command, self._opening(), runtime.loaded.planner, runtime.limits)
        if isinstance(goal, Refusal):
            return goal
        if isinstance(goal, GraspGoal):
            return GraspJob(runtime.control, goal)
        return ReleaseJob(runtime.control, runtime.limits)

    def _reading(self, update: GoalUpdate) -> GripperReading:
        """Return the state of the gripper as a parallel gripper reports it.

        It never says that it is stalled: clients are free to take that for an object that is held.
        """
        planner = update.planner
        if planner is None and self._runtime.loaded is not None:
            planner = self._runtime.loaded.planner
        # Of a goal that was refused the gripper's own: it may hold what another goal made it hold.
        plan, pressure = update.report.plan or update.snapshot.plan, update.pressure
        radius = update.snapshot.radius
        if plan is not None and radius is not None and update.snapshot.wrapped:
            return GripperReading(2.0 * radius, self._effort(plan, planner, pressure))
        return GripperReading(wrapped_diameter(pressure, self._opening(), planner), 0.0)

    def _effort(self, plan: WrapPlan, planner: AnyPlanner | None, pressure: float) -> float:
        """Return the force on the object [N]: of the grip where the object is seen, if known."""
        runtime = self._runtime
        if runtime.loaded is not None:
            radius, seen = plan.wrap.object_radius, runtime.seen_object()
            grip = runtime.loaded.grip(plan, radius, seen, pressure)
            if grip is not None:
                return grip.normal_force
        return contact_force(plan, planner, pressure)

    def _opening(self) -> float:
        return self._runtime.values.gripper_command_open


class GripperCommandAdapter(_CommandAdapter):
    """The messages of ``GripperCommand``, or of any action of that shape."""

    def job(self, request: Any) -> Job | Refusal:  # noqa: ANN401
        """Return the grasp or the release that a goal asks for."""
        command = request.command
        return self._job(OpeningCommand(command.position, command.max_effort))

    def feedback(self, request: Any, update: GoalUpdate) -> Any:  # noqa: ANN401
        """Return how a goal goes."""
        del request
        return self._filled(self._action.Feedback(), update)

    def result(self, request: Any, update: GoalUpdate) -> Any:  # noqa: ANN401
        """Return how a goal has ended."""
        del request
        return self._filled(self._action.Result(), update)

    def _filled(self, message: Any, update: GoalUpdate) -> Any:  # noqa: ANN401
        reading = self._reading(update)
        message.position, message.effort = reading.position, reading.effort
        message.reached_goal = update.report.outcome is GraspOutcome.SUCCEEDED
        return message


class ParallelGripperCommandAdapter(_CommandAdapter):
    """The messages of ``ParallelGripperCommand``, or of any action of that shape."""

    def job(self, request: Any) -> Job | Refusal:  # noqa: ANN401
        """Return the grasp or the release that a goal asks for."""
        if len(request.command.velocity):
            self._node.get_logger().warning(
                "parallel_gripper_cmd: velocity is not used; "
                "pressure_rate_up and pressure_rate_down bound how fast the gripper moves"
            )
        command = command_from_joint(request.command.position, request.command.effort)
        return command if isinstance(command, Refusal) else self._job(command)

    def feedback(self, request: Any, update: GoalUpdate) -> Any:  # noqa: ANN401
        """Return how a goal goes."""
        return self._action.Feedback(state=self._state(request, update))

    def result(self, request: Any, update: GoalUpdate) -> Any:  # noqa: ANN401
        """Return how a goal has ended."""
        reached = update.report.outcome is GraspOutcome.SUCCEEDED
        return self._action.Result(state=self._state(request, update), reached_goal=reached)

    def _state(self, request: Any, update: GoalUpdate) -> JointState:  # noqa: ANN401
        reading = self._reading(update)
        state = JointState(position=[reading.position], effort=[reading.effort])
        state.header.stamp = self._node.get_clock().now().to_msg()
        named = list(request.command.name)[:1]
        state.name = named or [opening_joint(self._runtime.values.frame_id)]
        return state


_ADAPTERS: dict[str, Callable[[Node, Runtime, Any], ActionAdapter]] = {
    "GripperCommand": GripperCommandAdapter,
    "ParallelGripperCommand": ParallelGripperCommandAdapter,
}
