# SPDX-License-Identifier: Apache-2.0
"""The action `release`: vent, and report when the pressure is gone."""

from __future__ import annotations

from typing import Any

from spiral_gripper_msgs.action import Release
from spiral_gripper_ros.actions.server import GoalServer, Report
from spiral_gripper_ros.control.grasp import GraspOutcome
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.messages.conversions import known, optional


class ReleaseServer(GoalServer):
    """The action `release`; every number in its messages is finite."""

    def goal(self, request: Any) -> ReleaseGoal:  # noqa: ANN401
        """Return the release that a goal asks for; it vents whatever its timeout is."""
        return ReleaseGoal(known(request.timeout))

    def feedback(self, request: Any, report: Report) -> Release.Feedback:  # noqa: ANN401
        """Return how a release goes."""
        del request
        return self._filled(Release.Feedback(), report)

    def result(self, request: Any, report: Report) -> Release.Result:  # noqa: ANN401
        """Return how a release has ended."""
        del request
        result = self._filled(Release.Result(), report)
        result.success = report.outcome is GraspOutcome.SUCCEEDED
        result.reason = int(report.refusal.reason)
        how = (
            "measured" if result.measured_pressure else "commanded (nothing measures the pressure)"
        )
        done = f"vented, as {how}; call rearm to follow radii again"
        result.message = done if result.success else report.refusal.text
        return result

    def _filled(self, message: Any, report: Report) -> Any:  # noqa: ANN401
        snapshot = self.runtime.control.snapshot()
        message.measured_pressure = optional(snapshot.measured_pressure)
        message.elapsed = report.elapsed
        return message
