# SPDX-License-Identifier: Apache-2.0
"""A release, from its goal to its report: whether the pressure is gone."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from spiral_gripper_ros.control.grasp import RunningGoal
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State

_SENSOR_FAULTS = (Reason.PRESSURE_LOST, Reason.PRESSURE_INVALID)
_REPLACED = Refusal(Reason.GRASP_REPLACED, "the gripper was told to grip again")
CANCELED = Refusal(Reason.GRASP_CANCELED, "canceled; the gripper stays released")


@dataclass(frozen=True, slots=True)
class ReleaseGoal:
    """The goal of a release.

    Args:
        timeout: longest time until the pressure is gone [s], any float, or None for
            ``grasp_timeout``.
    """

    timeout: float | None = None


class Release(RunningGoal):
    """An accepted release: waits for the evidence, a pressure close to 0 measured after it began.

    Where nothing has measured the pressure since activation it waits for a time instead. A failed
    sensor or link is no evidence: the release fails with that fault, though 0 Pa is commanded.
    Where the clock stands still, its time limit is one of real time.

    Args:
        goal: what was asked for.
        now: time of its acceptance [s].
        limits: its ``pressure_tolerance`` counts as vented, its ``pressure_settle_time`` is the
            while, its ``grasp_timeout`` bounds the wait unless the goal does.
    """

    def __init__(self, goal: ReleaseGoal, now: float, limits: Limits) -> None:
        super().__init__(now)
        self._timeout = limits.grasp_timeout if goal.timeout is None else goal.timeout
        self._limits = limits
        self._still_since: float | None = None  # real time at which its clock was found to stand
        self.report = replace(self.report, progress=1.0)
        if not 0.0 < self._timeout < math.inf:
            value = f"got {self._timeout:.6g} s; vented all the same"
            text = f"timeout must be a positive finite number, {value}"
            self.end(now, Refusal(Reason.INVALID_REQUEST, text))

    def stand_still(self, now: float, snapshot: Snapshot, real_time: float) -> None:
        """Bring the report up to date while the clock stands still: real time [s] ends it too."""
        if self._still_since is None:
            self._still_since = real_time
        self.update(now, snapshot, real_time - self._still_since)

    def update(self, now: float, snapshot: Snapshot, still: float | None = None) -> None:
        """Bring the report up to date, and make it final once the release has ended.

        Args:
            now: time [s].
            snapshot: what is commanded and measured then.
            still: real time since the clock was found to stand still [s]; None: it does not.
        """
        if still is None:
            self._still_since = None
        if self.report.end is not None:
            return
        limits, elapsed = self._limits, self.elapsed(now)
        self.report = replace(self.report, elapsed=elapsed)
        fault, age = snapshot.pressure_fault, snapshot.measured_age
        # An older measurement may be from before a ramp that was under way.
        new = snapshot.measured_pressure if age is not None and age <= elapsed else None
        waited, note = elapsed, ""
        if still is not None and still > self._timeout:
            waited, note = still, "; the clock stands still"
        # Once vented, a pressure is too low only where it is below 0, as of a failed sensor; one
        # that was too low for the grip, as of a leak, is on its way to 0.
        fails, refusal = fault.reason in _SENSOR_FAULTS, None
        if fault.reason is Reason.PRESSURE_LOW and new is not None:
            fails = new < -limits.pressure_tolerance
        if snapshot.state not in (State.RELEASED, State.FAULT):  # both are vented
            refusal = _REPLACED
        elif not snapshot.is_measured and not note:
            if elapsed >= limits.pressure_settle_time:
                refusal = NOT_REFUSED
        elif new is not None and abs(new) <= limits.pressure_tolerance:
            refusal = NOT_REFUSED
        elif fails:
            text = f"0 Pa is commanded, but nothing shows that the gripper is vented: {fault.text}"
            refusal = Refusal(fault.reason, text)
        elif waited > self._timeout and new is None:
            text = f"nothing was measured in the {waited:.3g} s since the release{note}"
            refusal = Refusal(Reason.PRESSURE_LOST, text)
        elif waited > self._timeout:
            text = f"still {new:.6g} Pa {waited:.3g} s after the release{note}"
            refusal = Refusal(Reason.PRESSURE_HIGH, text)
        if refusal is not None:
            self.end(now, refusal)
