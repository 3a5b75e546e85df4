# SPDX-License-Identifier: Apache-2.0
"""The action `release`: vent, and say when the pressure is gone."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from spiral_gripper_msgs.action import Release
from spiral_gripper_ros.control.grasp import GraspOutcome
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.grasping.goal_jobs import Job, ReleaseJob
from spiral_gripper_ros.grasping.goal_runner import Moment

if TYPE_CHECKING:
    from spiral_gripper_ros.node.gripper_node import GripperNode


class ReleaseDialect:
    """The messages of `release`; every number in them is finite.

    Args:
        node: whose control logic carries out the goals.
    """

    def __init__(self, node: GripperNode) -> None:
        self._node = node

    def job(self, request: Any) -> Job | Refusal:  # noqa: ANN401
        """Return the release that a goal asks for; it vents whatever its timeout is."""
        limits, timeout = self._node.limits, request.timeout
        if timeout == 0.0:
            return ReleaseJob(self._node.control, limits)
        if math.isfinite(timeout) and timeout > 0.0:
            return ReleaseJob(self._node.control, replace(limits, grasp_timeout=timeout))
        text = f"timeout must be a positive finite number, got {timeout:.6g} s; vented all the same"
        self._node.control.release()
        self._node.publish()
        return Refusal(Reason.INVALID_REQUEST, text)

    def feedback(self, request: Any, moment: Moment) -> Release.Feedback:  # noqa: ANN401
        """Return how a release goes."""
        del request
        return _filled(Release.Feedback(), moment)

    def result(self, request: Any, moment: Moment) -> Release.Result:  # noqa: ANN401
        """Return how a release has ended."""
        del request
        result = _filled(Release.Result(), moment)
        result.success = moment.report.outcome is GraspOutcome.SUCCEEDED
        result.reason = int(moment.report.refusal.reason)
        how = "measured" if result.measured else "commanded"
        done = f"vented, as {how}; call rearm to follow radii again"
        result.message = done if result.success else moment.report.refusal.text
        return result


def _filled(message: Any, moment: Moment) -> Any:  # noqa: ANN401
    measured = moment.snapshot.measured
    message.measured = measured is not None
    message.measured_pressure = 0.0 if measured is None else measured.pressure
    message.elapsed = moment.report.elapsed
    return message
