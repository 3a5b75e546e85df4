# SPDX-License-Identifier: Apache-2.0
"""The action `grasp`: goals to grasps, their progress and their end to messages."""

from __future__ import annotations

from typing import Any

from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.actions.server import GoalServer, Report
from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome
from spiral_gripper_ros.control.limits import AbortPolicy
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import (
    REGIMES,
    figures_to_msg,
    filled,
    known,
    shown_regime,
)
from spiral_gripper_ros.parameters.spec import LARGEST_PAYLOAD

_MODES = (Grasp.Goal.MODE_RADIUS, Grasp.Goal.MODE_PRESSURE, Grasp.Goal.MODE_FOLLOWED)
_ABORT_POLICIES = {
    Grasp.Goal.ABORT_DEFAULT: None,
    Grasp.Goal.ABORT_VENT: AbortPolicy.VENT,
    Grasp.Goal.ABORT_HOLD: AbortPolicy.HOLD,
}


class GraspServer(GoalServer):
    """The action `grasp`; every number in its messages is finite."""

    def goal(self, request: Any) -> GraspGoal | Refusal:  # noqa: ANN401
        """Return the grasp that a goal asks for."""
        payload = known(request.payload)
        if payload is not None and not 0.0 <= payload <= LARGEST_PAYLOAD:
            text = f"payload must be from 0 to {LARGEST_PAYLOAD:g} kg, got {payload:.6g} kg"
            return Refusal(Reason.INVALID_REQUEST, text)
        for name, values in (("mode", _MODES), ("abort_policy", _ABORT_POLICIES)):
            if getattr(request, name) not in values:
                text = f"{name} must be one of {sorted(values)}, got {getattr(request, name)}"
                return Refusal(Reason.INVALID_REQUEST, text)
        return GraspGoal(
            radius=request.object_radius if request.mode == Grasp.Goal.MODE_RADIUS else None,
            pressure=request.pressure if request.mode == Grasp.Goal.MODE_PRESSURE else None,
            overpressure=known(request.overpressure),
            timeout=known(request.timeout),
            abort_policy=_ABORT_POLICIES[request.abort_policy],
        )

    def feedback(self, request: Any, report: Report) -> Grasp.Feedback:  # noqa: ANN401
        """Return how a grasp goes."""
        del request
        runtime, snapshot = self.runtime, self.runtime.control.snapshot()
        grip = runtime.grip_message(snapshot.pressure_target)
        regime = None
        if runtime.loaded is not None:
            regime = runtime.loaded.regime(snapshot.pressure)
            regime = shown_regime(snapshot, runtime.loaded, regime)
        feedback = filled(Grasp.Feedback(), snapshot, report, regime=REGIMES[regime])
        feedback.settling_time = grip[0].settling_time if grip else []
        return feedback

    def result(self, request: Any, report: Report) -> Grasp.Result:  # noqa: ANN401
        """Return how a grasp has ended, with the figures of the wrap that it aimed for."""
        runtime, snapshot, plan = self.runtime, self.runtime.control.snapshot(), report.plan
        success = report.outcome is GraspOutcome.SUCCEEDED
        how = "commanded" if snapshot.measured is None else "measured"
        does = "is" if report.radius is None else f"wraps {report.radius:.4g} m"
        done = f"{does} at {snapshot.pressure:.6g} Pa, as {how}"
        result = filled(
            Grasp.Result(),
            snapshot,
            report,
            success=success,
            reason=report.refusal.reason,
            message=done if success else report.refusal.text,
        )
        if plan is not None and report.radius is not None and runtime.loaded is not None:
            cap, planner = runtime.limits.pressure_cap, runtime.loaded.planner
            if snapshot.plan is plan:  # else the object is not held any more
                result.grip = runtime.grip_message(snapshot.pressure, known(request.payload))
            contact = result.grip[0].contact_length if result.grip else None
            aimed = min(plan.pressure + report.overpressure, cap)
            result.figures = [figures_to_msg(plan, report.radius, aimed, planner, cap, contact)]
        return result
