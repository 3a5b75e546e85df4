# SPDX-License-Identifier: Apache-2.0
"""The action `grasp`: goals to grasps, their progress and their end to messages."""

from __future__ import annotations

import math
from typing import Any

from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.actions.jobs import GraspJob, Job
from spiral_gripper_ros.actions.runner import GoalUpdate
from spiral_gripper_ros.control.grasp import AbortPolicy, GraspGoal, GraspOutcome
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import REGIMES
from spiral_gripper_ros.messages.grip import UNKNOWN_TIME
from spiral_gripper_ros.runtime.runtime import Runtime

_ABORT_POLICIES = {
    Grasp.Goal.ABORT_DEFAULT: None,
    Grasp.Goal.ABORT_VENT: AbortPolicy.VENT,
    Grasp.Goal.ABORT_HOLD: AbortPolicy.HOLD,
}


class GraspAdapter:
    """The messages of `grasp`; every number in them is finite.

    Args:
        runtime: the gripper that carries out the goals.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime

    def job(self, request: Any) -> Job | Refusal:  # noqa: ANN401
        """Return the grasp that a goal asks for; 0 stands for the node's own."""
        if not (math.isfinite(request.payload) and request.payload >= 0.0):
            text = f"payload must be a non-negative finite number, got {request.payload:.6g} kg"
            return Refusal(Reason.INVALID_REQUEST, text)
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
        return GraspJob(self._runtime.control, goal)

    def feedback(self, request: Any, update: GoalUpdate) -> Grasp.Feedback:  # noqa: ANN401
        """Return how a grasp goes."""
        del request
        snapshot = update.snapshot
        measured = snapshot.measured
        grip = self._runtime.grip_message(snapshot.pressure_target)
        return Grasp.Feedback(
            state=int(snapshot.state),
            progress=update.report.progress,
            pressure_command=snapshot.pressure_command,
            pressure_target=snapshot.pressure_target,
            measured=measured is not None,
            measured_pressure=0.0 if measured is None else measured.pressure,
            regime=REGIMES[update.regime],
            settling_time=grip.settling_time if grip.known else UNKNOWN_TIME,
            elapsed=update.report.elapsed,
        )

    def result(self, request: Any, update: GoalUpdate) -> Grasp.Result:  # noqa: ANN401
        """Return how a grasp has ended, with the figures of the wrap that it aimed for."""
        report, snapshot = update.report, update.snapshot
        measured, plan = snapshot.measured, report.plan
        radius = report.radius or request.object_radius
        success = report.outcome is GraspOutcome.SUCCEEDED
        result = Grasp.Result(
            success=success,
            reason=int(report.refusal.reason),
            message=_success(update) if success else report.refusal.text,
            object_radius=radius if math.isfinite(radius) else 0.0,
            pressure_command=snapshot.pressure_command,
            measured=measured is not None,
            measured_pressure=0.0 if measured is None else measured.pressure,
            elapsed=report.elapsed,
        )
        if plan is not None:
            result.turns = plan.wrap.turns
            result.contact_length = plan.wrap.contact_length
            result.line_force = update.line_force(plan.pressure + report.overpressure)
            if snapshot.plan is plan:  # else the object is not held any more
                result.grip = self._runtime.grip_message(update.pressure, request.payload)
                if result.grip.known:
                    result.contact_length = result.grip.contact_length
        return result


def _success(update: GoalUpdate) -> str:
    how = "commanded" if update.snapshot.measured is None else "measured"
    return f"wraps {update.report.radius:.4g} m at {update.pressure:.6g} Pa, as {how}"
