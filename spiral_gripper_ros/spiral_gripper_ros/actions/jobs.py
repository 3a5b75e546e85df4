# SPDX-License-Identifier: Apache-2.0
"""The two jobs of action goals: wrap an object, or release it."""

from __future__ import annotations

from typing import Protocol, TypeAlias

from spiral_gripper_ros.control.grasp import Grasp, GraspGoal, GraspOutcome, GraspReport
from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State
from spiral_gripper_ros.planning.planner import AnyPlanner, WrapPlan

Control: TypeAlias = GripControl[WrapPlan]
GoalReport: TypeAlias = GraspReport[WrapPlan]

# Faults of sensor or link, which a gripper that is still full does not have.
_NO_EVIDENCE = (Reason.PRESSURE_LOST, Reason.PRESSURE_INVALID, Reason.PRESSURE_LOW)
_RELEASE_REPLACED = Refusal(Reason.GRASP_REPLACED, "the gripper was told to grip again")
_RELEASE_CANCELED = Refusal(Reason.GRASP_CANCELED, "canceled; the gripper stays released")


class Job(Protocol):
    """One goal, from its start to its end."""

    def start(self, now: float, planner: AnyPlanner) -> Refusal | None:
        """Start at a time [s]; return why not, and then change nothing."""
        ...

    def cancel(self, now: float) -> None:
        """Stop; the next report says that it is canceled."""
        ...

    def report(self, now: float) -> GoalReport:
        """Return how far it is."""
        ...


class GraspJob:
    """Wraps an object, or goes to a pressure.

    Args:
        control: what does it.
        goal: what is asked for.
    """

    def __init__(self, control: Control, goal: GraspGoal) -> None:
        self._control = control
        self._goal = goal
        self._grasp: Grasp[WrapPlan] | None = None

    def start(self, now: float, planner: AnyPlanner) -> Refusal | None:
        """Start the grasp, unless the control logic refuses it."""
        answer = self._control.start_grasp(now, self._goal, planner)
        if isinstance(answer, Refusal):
            return answer
        self._grasp = answer
        return None

    def cancel(self, now: float) -> None:
        """Cancel the grasp; its policy says what becomes of the pressure."""
        self._control.cancel_grasp(now, self._grasp)

    def report(self, now: float) -> GoalReport:
        """Return what has become of the grasp."""
        del now
        if self._grasp is None:
            raise RuntimeError("the grasp has not been started")
        return self._grasp.report


class ReleaseJob:
    """Vents, and waits for the evidence: a believed pressure within ``pressure_tolerance`` of 0.

    Where nothing has measured the pressure since activation it waits for a time instead. A failed
    sensor or link is no evidence: the release fails with that fault, though 0 Pa is commanded.

    Args:
        control: what does it.
        limits: its ``pressure_tolerance`` counts as vented, its ``pressure_settle_time`` is the
            while, its ``grasp_timeout`` bounds the wait.
    """

    def __init__(self, control: Control, limits: Limits) -> None:
        self._control = control
        self._limits = limits
        self._started_at = 0.0
        self._canceled = False

    def start(self, now: float, planner: AnyPlanner) -> Refusal | None:
        """Vent, unless the node is not active."""
        del planner
        if self._control.snapshot().state is State.INACTIVE:
            return self._control.snapshot().refusal
        self._control.release()
        self._started_at = now
        return None

    def cancel(self, now: float) -> None:
        """Stop waiting; what is vented stays vented."""
        del now
        self._canceled = True

    def report(self, now: float) -> GoalReport:
        """Return whether the pressure is gone."""
        elapsed = max(now - self._started_at, 0.0)
        end = self._end(elapsed)
        outcome, refusal = (GraspOutcome.RUNNING, NOT_REFUSED) if end is None else end
        return GraspReport(outcome, refusal, elapsed=elapsed, progress=1.0)

    def _end(self, elapsed: float) -> tuple[GraspOutcome, Refusal] | None:
        """Return how it has ended, or None if it has not."""
        if self._canceled:
            return GraspOutcome.CANCELED, _RELEASE_CANCELED
        snapshot, limits = self._control.snapshot(), self._limits
        if snapshot.state is State.INACTIVE:
            return GraspOutcome.FAILED, snapshot.refusal
        if snapshot.state not in (State.RELEASED, State.FAULT):  # both are vented
            return GraspOutcome.FAILED, _RELEASE_REPLACED
        if not snapshot.is_measured:
            gone = elapsed >= limits.pressure_settle_time
            return (GraspOutcome.SUCCEEDED, NOT_REFUSED) if gone else None
        measured, fault = snapshot.measured, snapshot.pressure_fault
        if measured is not None and abs(measured.pressure) <= limits.pressure_tolerance:
            return GraspOutcome.SUCCEEDED, NOT_REFUSED
        if fault.reason in _NO_EVIDENCE:
            text = f"0 Pa is commanded, but nothing shows that the gripper is vented: {fault.text}"
            return GraspOutcome.FAILED, Refusal(fault.reason, text)
        if elapsed <= limits.grasp_timeout:
            return None
        seen = "no believed pressure" if measured is None else f"{measured.pressure:.6g} Pa"
        text = f"still {seen} {elapsed:.3g} s after the release"
        return GraspOutcome.FAILED, Refusal(Reason.PRESSURE_HIGH, text)
