# SPDX-License-Identifier: Apache-2.0
"""The action `grasp`: goals to grasps, their progress and their end to messages."""

from __future__ import annotations

from typing import Any

from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.actions.jobs import GraspJob, Job
from spiral_gripper_ros.actions.runner import GoalUpdate
from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome
from spiral_gripper_ros.control.limits import AbortPolicy
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import REGIMES, figures_to_msg, known, optional
from spiral_gripper_ros.parameters.spec import LARGEST_PAYLOAD
from spiral_gripper_ros.runtime.runtime import Runtime

_MODES = (Grasp.Goal.MODE_RADIUS, Grasp.Goal.MODE_PRESSURE, Grasp.Goal.MODE_FOLLOWED)
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
        """Return the grasp that a goal asks for."""
        payload = known(request.payload)
        if payload is not None and not 0.0 <= payload <= LARGEST_PAYLOAD:
            text = f"payload must be from 0 to {LARGEST_PAYLOAD:g} kg, got {payload:.6g} kg"
            return Refusal(Reason.INVALID_REQUEST, text)
        for name, values in (("mode", _MODES), ("abort_policy", _ABORT_POLICIES)):
            if getattr(request, name) not in values:
                text = f"{name} must be one of {sorted(values)}, got {getattr(request, name)}"
                return Refusal(Reason.INVALID_REQUEST, text)
        goal = GraspGoal(
            radius=request.object_radius if request.mode == Grasp.Goal.MODE_RADIUS else None,
            pressure=request.pressure if request.mode == Grasp.Goal.MODE_PRESSURE else None,
            overpressure=known(request.overpressure),
            timeout=known(request.timeout),
            abort_policy=_ABORT_POLICIES[request.abort_policy],
        )
        return GraspJob(self._runtime.control, goal)

    def feedback(self, request: Any, update: GoalUpdate) -> Grasp.Feedback:  # noqa: ANN401
        """Return how a grasp goes."""
        del request
        snapshot = update.snapshot
        grip = self._runtime.grip_message(snapshot.pressure_target)
        return Grasp.Feedback(
            state=int(snapshot.state),
            progress=update.report.progress,
            pressure_command=snapshot.pressure_command,
            pressure_target=snapshot.pressure_target,
            measured_pressure=optional(snapshot.measured_pressure),
            regime=REGIMES[update.regime],
            settling_time=grip[0].settling_time if grip else [],
            elapsed=update.report.elapsed,
        )

    def result(self, request: Any, update: GoalUpdate) -> Grasp.Result:  # noqa: ANN401
        """Return how a grasp has ended, with the figures of the wrap that it aimed for."""
        report, snapshot, plan = update.report, update.snapshot, update.report.plan
        success = report.outcome is GraspOutcome.SUCCEEDED
        result = Grasp.Result(
            success=success,
            reason=int(report.refusal.reason),
            message=_success(update) if success else report.refusal.text,
            pressure_command=snapshot.pressure_command,
            measured_pressure=optional(snapshot.measured_pressure),
            elapsed=report.elapsed,
        )
        if plan is not None and report.radius is not None and update.planner is not None:
            cap = self._runtime.limits.pressure_cap
            if snapshot.plan is plan:  # else the object is not held any more
                result.grip = self._runtime.grip_message(update.pressure, known(request.payload))
            contact = result.grip[0].contact_length if result.grip else None
            aimed = min(plan.pressure + report.overpressure, cap)
            result.figures = [
                figures_to_msg(plan, report.radius, aimed, update.planner, cap, contact)
            ]
        return result


def _success(update: GoalUpdate) -> str:
    how = "commanded" if update.snapshot.measured is None else "measured"
    radius = update.report.radius
    does = "is" if radius is None else f"wraps {radius:.4g} m"
    return f"{does} at {update.pressure:.6g} Pa, as {how}"
