# SPDX-License-Identifier: Apache-2.0
"""The action `release`: vent, and report when the pressure is gone."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from spiral_gripper_msgs.action import Release
from spiral_gripper_ros.actions.jobs import Job, ReleaseJob
from spiral_gripper_ros.actions.runner import GoalUpdate
from spiral_gripper_ros.control.grasp import GraspOutcome
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import known, optional
from spiral_gripper_ros.runtime.runtime import Runtime


class ReleaseAdapter:
    """The messages of `release`; every number in them is finite.

    Args:
        runtime: the gripper that carries out the goals.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime

    def job(self, request: Any) -> Job | Refusal:  # noqa: ANN401
        """Return the release that a goal asks for; it vents whatever its timeout is."""
        limits, timeout = self._runtime.limits, known(request.timeout)
        if timeout is None:
            return ReleaseJob(self._runtime.control, limits)
        if math.isfinite(timeout) and timeout > 0.0:
            return ReleaseJob(self._runtime.control, replace(limits, grasp_timeout=timeout))
        text = f"timeout must be a positive finite number, got {timeout:.6g} s; vented all the same"
        self._runtime.control.release()
        self._runtime.publish()
        return Refusal(Reason.INVALID_REQUEST, text)

    def feedback(self, request: Any, update: GoalUpdate) -> Release.Feedback:  # noqa: ANN401
        """Return how a release goes."""
        del request
        return _filled(Release.Feedback(), update)

    def result(self, request: Any, update: GoalUpdate) -> Release.Result:  # noqa: ANN401
        """Return how a release has ended."""
        del request
        result = _filled(Release.Result(), update)
        result.success = update.report.outcome is GraspOutcome.SUCCEEDED
        result.reason = int(update.report.refusal.reason)
        how = (
            "measured" if result.measured_pressure else "commanded (nothing measures the pressure)"
        )
        done = f"vented, as {how}; call rearm to follow radii again"
        result.message = done if result.success else update.report.refusal.text
        return result


def _filled(message: Any, update: GoalUpdate) -> Any:  # noqa: ANN401
    message.measured_pressure = optional(update.snapshot.measured_pressure)
    message.elapsed = update.report.elapsed
    return message
