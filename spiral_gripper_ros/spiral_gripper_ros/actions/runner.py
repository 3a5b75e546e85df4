# SPDX-License-Identifier: Apache-2.0
"""Execution of the goals of all actions: start, feedback, end."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from rclpy.executors import Executor
from rclpy.task import Future

from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper_ros.actions.jobs import GoalReport, Job
from spiral_gripper_ros.control.grasp import GraspOutcome, GraspReport
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import shown_regime
from spiral_gripper_ros.planning.planner import AnyPlanner, WrapPlan
from spiral_gripper_ros.process.guards import log_on_error
from spiral_gripper_ros.runtime.guards import report as report_exception
from spiral_gripper_ros.runtime.runtime import Runtime

# Feedback is for people and their displays: ten times a second, whatever publish_rate is [s].
FEEDBACK_PERIOD = 0.1
# How long a node that is stopped goes on, so that its goals' results are sent [s]: some rounds of
# the executor and the way through the middleware, which take about a tenth of it.
END_TIME = 0.2
_DESTROYED = Refusal(Reason.NOT_ACTIVE, "the node is destroyed")
_CANCELED_BEFORE = Refusal(Reason.GRASP_CANCELED, "canceled before it was started")


@dataclass(frozen=True, slots=True)
class GoalUpdate:
    """The progress of a goal and the state of the gripper, for feedback and results.

    Args:
        report: how far the goal is.
        snapshot: what the gripper is commanded, and what is measured.
        regime: how the gripper holds the object in use.
        planner: for the gripper that the goal was started with, or None.
    """

    report: GoalReport
    snapshot: Snapshot[WrapPlan]
    regime: WrapRegime | None
    planner: AnyPlanner | None

    @property
    def pressure(self) -> float:
        """Gauge pressure of the gripper [Pa]: measured if it is known, else as commanded."""
        return self.snapshot.pressure


@dataclass(slots=True)
class _Run:
    """A goal that is being carried out."""

    job: Job
    planner: AnyPlanner
    notify: Callable[[GoalUpdate], None]
    end: Future
    told_at: float | None = None


class GoalRunner:
    """Executes goals without waiting: :meth:`tick` advances all of them.

    Args:
        runtime: the gripper that does what they ask for.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self.errors = runtime.errors
        self._runs: dict[bytes, _Run] = {}
        self._ticking = False

    async def run(self, key: bytes, job: Job, notify: Callable[[GoalUpdate], None]) -> GoalUpdate:
        """Carry out a goal and return how it ended; the pressure is commanded at once.

        Args:
            key: names the goal.
            job: what it has the control logic do.
            notify: called with the update, now and then while it runs.
        """
        loaded = self._runtime.loaded
        if loaded is None:
            return self.refused(Refusal(Reason.NOT_ACTIVE, self._runtime.not_configured))
        planner = loaded.planner
        refusal = job.start(self._runtime.now(), planner)
        if refusal is not None:
            return self.refused(refusal)
        run = self._runs[key] = _Run(
            job, planner, log_on_error(self._runtime.errors, notify), Future()
        )
        try:
            self._runtime.publish()
            self.tick()
            update: GoalUpdate = await run.end
        finally:
            del self._runs[key]
        return update

    def has_ended(self, key: bytes) -> bool:
        """Return whether a goal has ended, though its end may not have been told yet."""
        run = self._runs.get(key)
        return run is not None and run.end.done()

    def cancel(self, key: bytes) -> None:
        """Cancel a goal if it runs; the pressure is commanded at once."""
        run = self._runs.get(key)
        if run is not None and not run.end.done():
            run.job.cancel(self._runtime.now())
            self._runtime.publish()
            self.tick()

    def tick(self) -> None:
        """Send feedback, and end the finished goals; never raises, never publishes a command."""
        if self._ticking:  # the node fails because of what is reported below
            return
        self._ticking = True
        try:
            for run in list(self._runs.values()):
                if not run.end.done():
                    self._move_on(run)
        finally:
            self._ticking = False

    def end(self, executor: Executor) -> bool:
        """Let the goals that still run end as they are, and send their results.

        Args:
            executor: of the node; it must not be spinning.

        Returns:
            Whether there were any; whatever else was waiting has then been served as well.
        """
        if not self._runs:
            return False
        self.tick()
        deadline = time.monotonic() + END_TIME
        while time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.1 * END_TIME)
        return True

    def destroy(self) -> None:
        """End the goals that still run, without feedback."""
        for run in self._runs.values():
            if not run.end.done():
                run.end.set_result(self.refused(_DESTROYED))

    def refused(self, refusal: Refusal) -> GoalUpdate:
        """Return the update of a goal that is not carried out, and why."""
        return self._update(GraspReport(GraspOutcome.FAILED, refusal), None)

    def canceled(self) -> GoalUpdate:
        """Return the update of a goal that was canceled before it was started."""
        return self._update(GraspReport(GraspOutcome.CANCELED, _CANCELED_BEFORE), None)

    def failed(self, where: str, error: Exception) -> GoalUpdate:
        """Log an exception, vent, and return the update of the goal that it ends."""
        report_exception(self._runtime, where, error)
        text = f"internal error in {where}: {type(error).__name__}: {error}"
        return self.refused(Refusal(Reason.INTERNAL_ERROR, text))

    def _move_on(self, run: _Run) -> None:
        try:
            report = run.job.report(self._runtime.now())
            if report.outcome is not GraspOutcome.RUNNING:
                run.end.set_result(self._update(report, run.planner))
            elif run.told_at is None or report.elapsed - run.told_at >= FEEDBACK_PERIOD:
                run.told_at = report.elapsed
                run.notify(self._update(report, run.planner))
        except Exception as error:
            run.end.set_result(self.failed("a goal", error))

    def _update(self, report: GoalReport, planner: AnyPlanner | None) -> GoalUpdate:
        loaded = self._runtime.loaded
        snapshot = self._runtime.control.snapshot()
        regime = None
        if loaded is not None:
            regime = shown_regime(snapshot, loaded, loaded.regime(snapshot.pressure))
        return GoalUpdate(report, snapshot, regime, planner)
