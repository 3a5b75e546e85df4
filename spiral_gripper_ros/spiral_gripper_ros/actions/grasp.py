# SPDX-License-Identifier: Apache-2.0
"""The action `grasp`: goals to grasps, their progress and their end to messages."""

from __future__ import annotations

from typing import Any

from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.actions.server import GoalServer
from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome, GraspReport
from spiral_gripper_ros.control.limits import AbortPolicy
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import (
    REGIMES,
    figures_to_msg,
    filled,
    known,
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

    def told(self, message: Any, request: Any, report: GraspReport) -> Any:  # noqa: ANN401
        """Return the feedback on a grasp, or its result with the figures of the wrap aimed for."""
        runtime, snapshot, plan = self.runtime, self.runtime.control.snapshot(), report.plan
        loaded, pressure, values = runtime.loaded, snapshot.pressure, dict[str, Any]()
        if isinstance(message, Grasp.Feedback):
            regime = None if loaded is None else loaded.shown_regime(snapshot)
            grip = runtime.grip_message(snapshot.pressure_target)
            values["settling_time"] = known(grip[0].settling_time) if grip else None
            return filled(message, snapshot, report, regime=REGIMES[regime], **values)
        success = report.outcome is GraspOutcome.SUCCEEDED
        how = "commanded" if snapshot.measured is None else "measured"
        does = "is" if report.radius is None else f"wraps {report.radius:.4g} m"
        done = f"{does} at {pressure:.6g} Pa, as {how}"
        values["message"] = done if success else report.refusal.text
        if plan is not None and report.radius is not None and loaded is not None:
            cap, grip, contact = runtime.limits.pressure_cap, [], None
            if snapshot.plan is plan:  # else the object is not held any more
                grip = runtime.grip_message(pressure, known(request.payload))
            if grip:
                contact = grip[0].contact_length
            aimed = min(plan.pressure + report.overpressure, cap)
            asked = (plan, report.radius, aimed, loaded.planner, cap, contact)
            values |= {"grip": grip, "figures": [figures_to_msg(*asked)]}
        reason = report.refusal.reason
        return filled(message, snapshot, report, success=success, reason=reason, **values)
