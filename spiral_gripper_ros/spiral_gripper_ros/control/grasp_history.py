# SPDX-License-Identifier: Apache-2.0
"""The grasp that is running, and what has become of the last ones."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import Generic

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.control.grasp import GraspOutcome, GraspReport
from spiral_gripper_ros.control.grasp_attempt import GraspAttempt
from spiral_gripper_ros.control.snapshot import PlanT, Snapshot
from spiral_gripper_ros.control.states import Refusal

# The reports of so many grasps that have ended are kept.
KEPT_REPORTS = 16


class GraspHistory(Generic[PlanT]):
    """Numbers the grasps, and keeps a report of each until it is long past."""

    def __init__(self) -> None:
        self._tickets = 0
        self._attempt: GraspAttempt | None = None
        self._report: GraspReport[PlanT] | None = None
        self._ended: deque[tuple[int, GraspReport[PlanT]]] = deque(maxlen=KEPT_REPORTS)

    @property
    def running(self) -> GraspAttempt | None:
        """The grasp that has not ended yet."""
        return self._attempt

    def is_running(self, ticket: int) -> bool:
        """Return whether this is the number of the grasp that has not ended yet."""
        return self._attempt is not None and ticket == self._tickets

    def start(self, attempt: GraspAttempt, snapshot: Snapshot[PlanT]) -> int:
        """Take a grasp up and return its number."""
        self._tickets += 1
        self._attempt = attempt
        self.update(attempt.started, snapshot)
        return self._tickets

    def update(self, now: float, snapshot: Snapshot[PlanT]) -> None:
        """Bring the report of the running grasp up to date."""
        attempt = self._attempt
        if attempt is None or snapshot.radius is None or snapshot.plan is None:
            return
        self._report = GraspReport(
            outcome=GraspOutcome.RUNNING,
            elapsed=attempt.elapsed(now),
            progress=attempt.progress(snapshot.pressure_command, snapshot.pressure_target),
            radius=snapshot.radius,
            plan=snapshot.plan,
            overpressure=snapshot.overpressure,
        )

    def end(self, now: float, outcome: GraspOutcome, refusal: Refusal) -> None:
        """Make the report of the running grasp final, if one is running."""
        if self._attempt is not None and self._report is not None:
            elapsed = self._attempt.elapsed(now)
            final = replace(self._report, outcome=outcome, refusal=refusal, elapsed=elapsed)
            self._ended.append((self._tickets, final))
        self._attempt = self._report = None

    def report(self, ticket: int) -> GraspReport[PlanT]:
        """Return what has become of the grasp that is running or of one of the last that ended.

        Raises:
            InvalidInputError: there was no such grasp, or it is too long ago.
        """
        if self._report is not None and ticket == self._tickets:
            return self._report
        for number, report in self._ended:
            if number == ticket:
                return report
        raise InvalidInputError("ticket", ticket, "that of a recent grasp")
