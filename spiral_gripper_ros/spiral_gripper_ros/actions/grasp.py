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
        for payload in request.payload:  # of at most one
            if not 0.0 <= payload <= LARGEST_PAYLOAD:
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
            grip = runtime.grip(snapshot.pressure_target)
            values = {"regime": REGIMES[regime], "settling_time": grip and grip.settling}
            return filled(message, snapshot, report, **values)
        success = report.outcome is GraspOutcome.SUCCEEDED
        how = "commanded" if snapshot.measured_pressure is None else "measured"
        does = "is" if plan is None else f"wraps {plan.wrap.object_radius:.4g} m"
        done = f"{does} at {pressure:.6g} Pa, as {how}"
        values["message"] = done if success else report.refusal.text
        if plan is not None and loaded is not None:
            cap = runtime.limits.pressure_cap
            # Else the object is not held any more.
            grip = runtime.grip(pressure) if snapshot.plan is plan else None
            aimed = min(plan.pressure + report.overpressure, cap)
            values["grip"] = runtime.grip_message(grip, known(request.payload))
            values["figures"] = [figures_to_msg(plan, aimed, loaded.planner, cap, grip)]
        reason = report.refusal.reason
        return filled(message, snapshot, report, success=success, reason=reason, **values)
