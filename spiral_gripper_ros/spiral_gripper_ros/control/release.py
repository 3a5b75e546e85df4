# SPDX-License-Identifier: Apache-2.0
"""A release, from its goal to its report: whether the pressure is gone."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Generic

from spiral_gripper_ros.control.grasp import GraspOutcome, GraspReport
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.snapshot import MeasuredPressure, PlanT, Snapshot
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State

# Faults of sensor or link, which a gripper that is still full does not have.
_NO_EVIDENCE = (Reason.PRESSURE_LOST, Reason.PRESSURE_INVALID, Reason.PRESSURE_LOW)
_REPLACED = Refusal(Reason.GRASP_REPLACED, "the gripper was told to grip again")
_CANCELED = Refusal(Reason.GRASP_CANCELED, "canceled; the gripper stays released")


@dataclass(frozen=True, slots=True)
class ReleaseGoal:
    """The goal of a release.

    Args:
        timeout: longest time until the pressure is gone [s], any float, or None for
            ``grasp_timeout``.
    """

    timeout: float | None = None


class Release(Generic[PlanT]):
    """An accepted release: waits for the evidence, a believed pressure close to 0.

    Where nothing has measured the pressure since activation it waits for a time instead. A failed
    sensor or link is no evidence: the release fails with that fault, though 0 Pa is commanded.

    Args:
        goal: what was asked for.
        now: time of its acceptance [s].
        limits: its ``pressure_tolerance`` counts as vented, its ``pressure_settle_time`` is the
            while, its ``grasp_timeout`` bounds the wait unless the goal does.

    Attributes:
        report: what has become of it; final once it has ended.
    """

    def __init__(self, goal: ReleaseGoal, now: float, limits: Limits) -> None:
        self._timeout = limits.grasp_timeout if goal.timeout is None else goal.timeout
        self._started = now
        self._limits = limits
        self.report: GraspReport[PlanT] = GraspReport(GraspOutcome.RUNNING, progress=1.0)
        if not (math.isfinite(self._timeout) and self._timeout > 0.0):
            value = f"got {self._timeout:.6g} s; vented all the same"
            text = f"timeout must be a positive finite number, {value}"
            self._end(GraspOutcome.FAILED, Refusal(Reason.INVALID_REQUEST, text))

    def cancel(self, now: float) -> None:
        """Stop waiting, if it has not ended; what is vented stays vented."""
        if self.report.outcome is GraspOutcome.RUNNING:
            self.report = replace(self.report, elapsed=now - self._started)
            self._end(GraspOutcome.CANCELED, _CANCELED)

    def update(self, now: float, snapshot: Snapshot[PlanT]) -> None:
        """Bring the report up to date, and make it final once the release has ended."""
        if self.report.outcome is not GraspOutcome.RUNNING:
            return
        limits, elapsed = self._limits, now - self._started
        self.report = replace(self.report, elapsed=elapsed)
        measured, fault = snapshot.measured, snapshot.pressure_fault
        if snapshot.state is State.INACTIVE:
            self._end(GraspOutcome.FAILED, snapshot.refusal)
        elif snapshot.state not in (State.RELEASED, State.FAULT):  # both are vented
            self._end(GraspOutcome.FAILED, _REPLACED)
        elif not snapshot.is_measured:
            if elapsed >= limits.pressure_settle_time:
                self._end(GraspOutcome.SUCCEEDED, NOT_REFUSED)
        elif self._shows_vented(measured, elapsed):
            self._end(GraspOutcome.SUCCEEDED, NOT_REFUSED)
        elif fault.reason in _NO_EVIDENCE:
            text = f"0 Pa is commanded, but nothing shows that the gripper is vented: {fault.text}"
            self._end(GraspOutcome.FAILED, Refusal(fault.reason, text))
        elif elapsed > self._timeout:
            seen = "no believed pressure" if measured is None else f"{measured.pressure:.6g} Pa"
            text = f"still {seen} {elapsed:.3g} s after the release"
            self._end(GraspOutcome.FAILED, Refusal(Reason.PRESSURE_HIGH, text))

    def _shows_vented(self, measured: MeasuredPressure | None, elapsed: float) -> bool:
        """Return whether what is measured since the release began is close to 0.

        An older measurement may be from before a ramp that was under way.
        """
        if measured is None or measured.age > elapsed:
            return False
        return abs(measured.pressure) <= self._limits.pressure_tolerance

    def _end(self, outcome: GraspOutcome, refusal: Refusal) -> None:
        self.report = replace(self.report, outcome=outcome, refusal=refusal)
