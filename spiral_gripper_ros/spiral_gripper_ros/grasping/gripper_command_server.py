# SPDX-License-Identifier: Apache-2.0
"""The actions of control_msgs for parallel grippers, as MoveIt and ros2_control clients know them.

control_msgs is optional: the actions are offered where it is installed. Each has a name of its own,
because one name cannot have two types within a process.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from sensor_msgs.msg import JointState

from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.grasping.goal_jobs import GraspJob, Job, ReleaseJob
from spiral_gripper_ros.grasping.goal_runner import GoalRunner, Moment
from spiral_gripper_ros.grasping.goal_server import Dialect, GoalServer
from spiral_gripper_ros.grasping.gripper_command import (
    GripperReading,
    OpeningCommand,
    command_from_joint,
    contact_force,
    goal_from_command,
    wrapped_diameter,
)
from spiral_gripper_ros.node.parameters import number

if TYPE_CHECKING:
    from spiral_gripper_ros.node.gripper_node import GripperNode

PACKAGE = "control_msgs"


def gripper_command_servers(node: GripperNode, runner: GoalRunner) -> list[GoalServer]:
    """Return a server for each action of control_msgs that is installed; the log says which."""
    logger = node.get_logger()
    servers: list[GoalServer] = []
    try:
        actions = importlib.import_module(f"{PACKAGE}.action")
    except ImportError:
        logger.info(f"{PACKAGE} is not installed: gripper_cmd is not offered")
        return servers
    chosen = str(node.values["gripper_cmd_type"])
    names = {"gripper_cmd": chosen, "parallel_gripper_cmd": "ParallelGripperCommand"}
    if chosen == "ParallelGripperCommand":  # one name for one action
        del names["parallel_gripper_cmd"]
    for name, type_name in names.items():
        dialect = _DIALECTS[type_name]
        action = getattr(actions, type_name, None)
        if action is None:
            logger.info(f"{PACKAGE} has no {type_name}: {name} is not offered")
            continue
        try:
            servers.append(GoalServer(node, runner, (action, name), dialect(node, action)))
        except Exception as error:  # built for another Python, say: the node does without
            logger.error(f"{PACKAGE} cannot be used, {name} is not offered: {error}")
        else:
            logger.info(f"{name} is offered as {PACKAGE}/action/{type_name}")
    return servers


class _CommandDialect:
    """What the actions have in common: commands of an opening, readings of one.

    Args:
        node: whose control logic carries out the goals.
        action: the type of the action.
    """

    def __init__(self, node: GripperNode, action: Any) -> None:  # noqa: ANN401
        self._node = node
        self._action = action

    def _job(self, command: OpeningCommand) -> Job | Refusal:
        """Return what a command has the gripper do, or why it cannot."""
        node = self._node
        if node.loaded is None:
            return Refusal(Reason.NOT_ACTIVE, node.not_configured)
        goal = goal_from_command(command, self._opening(), node.loaded.planner, node.limits)
        if isinstance(goal, Refusal):
            return goal
        if isinstance(goal, GraspGoal):
            return GraspJob(node.control, goal)
        return ReleaseJob(node.control, node.limits)

    def _reading(self, moment: Moment) -> GripperReading:
        """Return what a parallel gripper would say of itself.

        It never says that it is stalled: clients are free to take that for an object that is held.
        """
        planner = moment.planner
        if planner is None and self._node.loaded is not None:
            planner = self._node.loaded.planner
        # Of a goal that was refused the gripper's own: it may hold what another goal made it hold.
        plan, pressure = moment.report.plan or moment.snapshot.plan, moment.pressure
        radius = moment.snapshot.radius
        if plan is not None and radius is not None and moment.snapshot.wrapped:
            return GripperReading(2.0 * radius, contact_force(plan, planner, pressure))
        return GripperReading(wrapped_diameter(pressure, self._opening(), planner), 0.0)

    def _opening(self) -> float:
        return number(self._node.values, "gripper_command_open")


class GripperCommandDialect(_CommandDialect):
    """The messages of ``GripperCommand``, or of any action of that shape."""

    def job(self, request: Any) -> Job | Refusal:  # noqa: ANN401
        """Return the grasp or the release that a goal asks for."""
        command = request.command
        return self._job(OpeningCommand(command.position, command.max_effort))

    def feedback(self, request: Any, moment: Moment) -> Any:  # noqa: ANN401
        """Return how a goal goes."""
        del request
        return self._filled(self._action.Feedback(), moment)

    def result(self, request: Any, moment: Moment) -> Any:  # noqa: ANN401
        """Return how a goal has ended."""
        del request
        return self._filled(self._action.Result(), moment)

    def _filled(self, message: Any, moment: Moment) -> Any:  # noqa: ANN401
        reading = self._reading(moment)
        message.position, message.effort = reading.position, reading.effort
        message.reached_goal = moment.report.outcome is GraspOutcome.SUCCEEDED
        return message


class ParallelGripperCommandDialect(_CommandDialect):
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

    def feedback(self, request: Any, moment: Moment) -> Any:  # noqa: ANN401
        """Return how a goal goes."""
        return self._action.Feedback(state=self._state(request, moment))

    def result(self, request: Any, moment: Moment) -> Any:  # noqa: ANN401
        """Return how a goal has ended."""
        reached = moment.report.outcome is GraspOutcome.SUCCEEDED
        return self._action.Result(state=self._state(request, moment), reached_goal=reached)

    def _state(self, request: Any, moment: Moment) -> JointState:  # noqa: ANN401
        reading = self._reading(moment)
        state = JointState(position=[reading.position], effort=[reading.effort])
        state.header.stamp = self._node.get_clock().now().to_msg()
        state.name = list(request.command.name)[:1]
        return state


_DIALECTS: dict[str, Callable[[GripperNode, Any], Dialect]] = {
    "GripperCommand": GripperCommandDialect,
    "ParallelGripperCommand": ParallelGripperCommandDialect,
}
