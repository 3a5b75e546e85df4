# SPDX-License-Identifier: Apache-2.0
"""The actions that end in a grasp or a release: `grasp`, `release`, those of control_msgs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from rclpy.executors import Executor

from spiral_gripper_msgs.action import Grasp, Release
from spiral_gripper_ros.control.grasp import AbortPolicy, GraspGoal, GraspOutcome
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.grasping.goal_jobs import GraspJob, Job
from spiral_gripper_ros.grasping.goal_runner import GoalRunner, Moment
from spiral_gripper_ros.grasping.goal_server import GoalServer
from spiral_gripper_ros.grasping.gripper_command_server import gripper_command_servers
from spiral_gripper_ros.grasping.release_server import ReleaseDialect
from spiral_gripper_ros.node.conversions import REGIMES

if TYPE_CHECKING:
    from spiral_gripper_ros.node.gripper_node import GripperNode

_ABORT_POLICIES = {
    Grasp.Goal.ABORT_DEFAULT: None,
    Grasp.Goal.ABORT_VENT: AbortPolicy.VENT,
    Grasp.Goal.ABORT_HOLD: AbortPolicy.HOLD,
}


class GraspServer:
    """Serves `grasp`, `release` and, where they are installed, the actions of control_msgs.

    They are served as long as the node exists.

    Args:
        node: the node that serves.
    """

    def __init__(self, node: GripperNode) -> None:
        self._node = node
        self._runner = GoalRunner(node)
        dialect = GraspDialect(node)
        self._servers = [
            GoalServer(node, self._runner, (Grasp, "grasp"), dialect),
            GoalServer(node, self._runner, (Release, "release"), ReleaseDialect(node)),
        ]
        self._servers += gripper_command_servers(node, self._runner)

    def tick(self) -> None:
        """Tell how the goals go, and end those that are done; never raises, never publishes."""
        self._runner.tick()

    def end(self, executor: Executor) -> None:
        """Let the goals of a node that is stopped send their results.

        Args:
            executor: of the node; it must not be spinning.
        """
        if self._runner.end(executor):
            self._node.vent()  # whatever else has been called meanwhile

    def destroy(self) -> None:
        """Serve no longer."""
        self._runner.destroy()
        for server in self._servers:
            server.destroy()


class GraspDialect:
    """The messages of `grasp`; every number in them is finite.

    Args:
        node: whose control logic carries out the goals.
    """

    def __init__(self, node: GripperNode) -> None:
        self._node = node

    def job(self, request: Any) -> Job | Refusal:  # noqa: ANN401
        """Return the grasp that a goal asks for; 0 stands for the node's own."""
        if request.abort_policy not in _ABORT_POLICIES:
            known = f"one of {sorted(_ABORT_POLICIES)}"
            text = f"abort_policy must be {known}, got {request.abort_policy}"
            return Refusal(Reason.INVALID_REQUEST, text)
        goal = GraspGoal(
            radius=None if request.object_radius == 0.0 else request.object_radius,
            overpressure=request.overpressure,
            timeout=None if request.timeout == 0.0 else request.timeout,
            abort_policy=_ABORT_POLICIES[request.abort_policy],
        )
        return GraspJob(self._node.control, goal)

    def feedback(self, request: Any, moment: Moment) -> Grasp.Feedback:  # noqa: ANN401
        """Return how a grasp goes."""
        del request
        snapshot = moment.snapshot
        measured = snapshot.measured
        return Grasp.Feedback(
            state=int(snapshot.state),
            progress=moment.report.progress,
            pressure_command=snapshot.pressure_command,
            pressure_target=snapshot.pressure_target,
            measured=measured is not None,
            measured_pressure=0.0 if measured is None else measured.pressure,
            regime=REGIMES[moment.regime],
            elapsed=moment.report.elapsed,
        )

    def result(self, request: Any, moment: Moment) -> Grasp.Result:  # noqa: ANN401
        """Return how a grasp has ended, with the figures of the wrap that it aimed for."""
        report, snapshot = moment.report, moment.snapshot
        measured, plan = snapshot.measured, report.plan
        radius = report.radius or request.object_radius
        success = report.outcome is GraspOutcome.SUCCEEDED
        result = Grasp.Result(
            success=success,
            reason=int(report.refusal.reason),
            message=_success(moment) if success else report.refusal.text,
            object_radius=radius if math.isfinite(radius) else 0.0,
            pressure_command=snapshot.pressure_command,
            measured=measured is not None,
            measured_pressure=0.0 if measured is None else measured.pressure,
            elapsed=report.elapsed,
        )
        if plan is not None:
            result.turns = plan.wrap.turns
            result.contact_length = plan.wrap.contact_length
            result.line_force = moment.line_force(plan.pressure + report.overpressure)
        return result


def _success(moment: Moment) -> str:
    how = "commanded" if moment.snapshot.measured is None else "measured"
    return f"wraps {moment.report.radius:.4g} m at {moment.pressure:.6g} Pa, as {how}"
