# SPDX-License-Identifier: Apache-2.0
"""The action `release`: vent, and report when the pressure is gone."""

from __future__ import annotations

from typing import Any

from spiral_gripper_msgs.action import Release
from spiral_gripper_ros.actions.server import GoalServer, Report
from spiral_gripper_ros.control.grasp import GraspOutcome
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.messages.conversions import filled, known


class ReleaseServer(GoalServer):
    """The action `release`; every number in its messages is finite."""

    def goal(self, request: Any) -> ReleaseGoal:  # noqa: ANN401
        """Return the release that a goal asks for; it vents whatever its timeout is."""
        return ReleaseGoal(known(request.timeout))

    def feedback(self, request: Any, report: Report) -> Release.Feedback:  # noqa: ANN401
        """Return how a release goes."""
        del request
        return filled(Release.Feedback(), self.runtime.control.snapshot(), report)

    def result(self, request: Any, report: Report) -> Release.Result:  # noqa: ANN401
        """Return how a release has ended."""
        del request
        snapshot, success = (
            self.runtime.control.snapshot(),
            report.outcome is GraspOutcome.SUCCEEDED,
        )
        is_measured = snapshot.measured is not None
        how = "measured" if is_measured else "commanded (nothing measures the pressure)"
        done = f"vented, as {how}; call rearm to follow radii again"
        return filled(
            Release.Result(),
            snapshot,
            report,
            success=success,
            reason=report.refusal.reason,
            message=done if success else report.refusal.text,
        )
