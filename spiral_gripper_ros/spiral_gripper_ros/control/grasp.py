# SPDX-License-Identifier: Apache-2.0
"""A grasp, from its goal to its report: whether the wrap is reached in time."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

from spiral_gripper_ros.control.limits import AbortPolicy, Limits
from spiral_gripper_ros.control.plan import WrapPlan
from spiral_gripper_ros.control.pressure_monitor import PERSISTENCE
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal


class GraspOutcome(Enum):
    """The state of a grasp."""

    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELED = "canceled"


@dataclass(frozen=True, slots=True)
class GraspGoal:
    """The goal of a grasp; any float, checked when the grasp is started.

    Args:
        radius: of the object [m], or None for the radius that is being followed.
        pressure: to go to instead, whatever it wraps [Pa], >= 0; None: wrap the object.
        overpressure: held above the pressure of the perfect wrap [Pa], >= 0; None: that of
            ``grip_ratio``.
        timeout: longest time until the wrap is reached [s], > 0, or None for ``grasp_timeout``.
        abort_policy: what becomes of the pressure if it fails, or None for ``grasp_abort_policy``.
    """

    radius: float | None
    pressure: float | None = None
    overpressure: float | None = None
    timeout: float | None = None
    abort_policy: AbortPolicy | None = None


@dataclass(frozen=True, slots=True)
class GraspReport:
    """The report on a grasp or a release; final once it has an ``end``.

    Args:
        end: why it was refused, failed or was canceled; ``Reason.NONE``: it has succeeded; None: it
            has not ended.
        elapsed: time from its start to its end, or until now [s].
        progress: the command's part of the way to its target, 0 to 1.
        plan: the planned wrap, or None.
        overpressure: that it asks for above the wrap's pressure [Pa].
    """

    end: Refusal | None = None
    elapsed: float = 0.0
    progress: float = 0.0
    plan: WrapPlan | None = None
    overpressure: float = 0.0

    @property
    def outcome(self) -> GraspOutcome:
        """Its state."""
        if self.end is None:
            return GraspOutcome.RUNNING
        if not self.end:
            return GraspOutcome.SUCCEEDED
        is_canceled = self.end.reason is Reason.GRASP_CANCELED
        return GraspOutcome.CANCELED if is_canceled else GraspOutcome.FAILED

    @property
    def refusal(self) -> Refusal:
        """Why it was refused, failed or was canceled; ``Reason.NONE`` otherwise."""
        return self.end or NOT_REFUSED


class RunningGoal:
    """An accepted goal. The object is its identity: whoever has started it reads its report.

    Args:
        now: time of its acceptance [s].

    Attributes:
        report: what has become of it; final once it has ended.
    """

    def __init__(self, now: float) -> None:
        self._started = now
        self.report = GraspReport()

    def elapsed(self, now: float) -> float:
        """Return the time since its acceptance [s]."""
        return now - self._started

    def end(self, now: float, refusal: Refusal) -> None:
        """Make the report final, unless it is."""
        if self.report.end is None:
            self.report = replace(self.report, end=refusal, elapsed=self.elapsed(now))


class Grasp(RunningGoal):
    """A grasp: follows command and measured pressure on their way to the target.

    Args:
        goal: what was asked for.
        now: time of its acceptance [s].
        snapshot: what is commanded then.
        limits: what counts where the goal does not say.

    Attributes:
        timeout: longest time until it is settled [s].
        wraps: whether it is to wrap an object; else only to reach a pressure.
        abort_policy: what becomes of the pressure if it fails.
    """

    def __init__(self, goal: GraspGoal, now: float, snapshot: Snapshot, limits: Limits) -> None:
        super().__init__(now)
        self.timeout = limits.grasp_timeout if goal.timeout is None else goal.timeout
        self.wraps = goal.pressure is None
        self.abort_policy: AbortPolicy = goal.abort_policy or limits.grasp_abort_policy
        self._start_command = snapshot.pressure_command
        self._arrived: float | None = None  # since when the command is at its target
        self._near: tuple[float, float] | None = None  # first and last measurement that was there
        self.update(now, snapshot)

    def commanded(self, now: float, command: float, target: float) -> None:
        """Note a command and where it is heading [Pa]."""
        if command != target:
            self._arrived = self._near = None
        elif self._arrived is None:
            self._arrived = now

    def measured(self, now: float, pressure: float, target: float, limits: Limits) -> None:
        """Note a measured pressure, smoothed, and where it should get [Pa]."""
        if abs(pressure - target) <= limits.pressure_tolerance:
            self._near = (now if self._near is None else self._near[0], now)
        else:
            self._near = None

    def update(self, now: float, snapshot: Snapshot) -> None:
        """Bring the report up to date."""
        command, target = snapshot.pressure_command, snapshot.pressure_target
        way = target - self._start_command
        progress = float(command == target)
        if way != 0.0:
            progress = min(max((command - self._start_command) / way, 0.0), 1.0)
        self.report = GraspReport(
            elapsed=self.elapsed(now),
            progress=progress,
            plan=snapshot.plan,
            overpressure=snapshot.overpressure,
        )

    def is_settled(self, now: float, is_measured: bool, limits: Limits) -> bool:
        """Return whether the pressure is at its target to stay, as measured or as commanded."""
        if self._arrived is None:
            return False
        if is_measured:
            return self._near is not None and self._near[1] - self._near[0] >= PERSISTENCE
        return now - self._arrived >= limits.pressure_settle_time


def impossible_goal(goal: GraspGoal) -> Refusal | None:
    """Return why a goal's pressure, overpressure or time-out is refused, or None.

    Example:
        >>> impossible_goal(GraspGoal(radius=0.02, overpressure=-1.0)).text
        'overpressure must be a non-negative finite number, got -1 Pa'
    """
    for name, value in (("pressure", goal.pressure), ("overpressure", goal.overpressure)):
        if value is not None and not 0.0 <= value < math.inf:
            text = f"{name} must be a non-negative finite number, got {value:.6g} Pa"
            return Refusal(Reason.INVALID_REQUEST, text)
    if goal.pressure is not None and goal.overpressure is not None:
        return Refusal(Reason.INVALID_REQUEST, "overpressure is that of a wrap, not of a pressure")
    if goal.timeout is not None and not 0.0 < goal.timeout < math.inf:
        return Refusal(
            Reason.INVALID_REQUEST,
            f"timeout must be a positive finite number, got {goal.timeout:.6g} s",
        )
    return None
