# SPDX-License-Identifier: Apache-2.0
"""The action `release`: vent, and report when the pressure is gone."""

from __future__ import annotations

from typing import Any

from spiral_gripper_ros.actions.server import GoalServer
from spiral_gripper_ros.control.grasp import GraspOutcome, GraspReport
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.messages.conversions import filled, known


class ReleaseServer(GoalServer):
    """The action `release`; every number in its messages is finite."""

    def goal(self, request: Any) -> ReleaseGoal:  # noqa: ANN401
        """Return the release that a goal asks for; it vents whatever its timeout is."""
        return ReleaseGoal(known(request.timeout))

    def told(self, message: Any, request: Any, report: GraspReport) -> Any:  # noqa: ANN401
        """Return the feedback on a release, or its result."""
        del request
        snapshot = self.runtime.control.snapshot()
        success = report.outcome is GraspOutcome.SUCCEEDED
        is_measured = snapshot.measured_pressure is not None
        how = "measured" if is_measured else "commanded (nothing measures the pressure)"
        done = f"vented, as {how}; call rearm to follow radii again"
        text = done if success else report.refusal.text
        values = {"success": success, "reason": report.refusal.reason, "message": text}
        return filled(message, snapshot, report, **values)
