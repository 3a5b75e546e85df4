# SPDX-License-Identifier: Apache-2.0
"""The server of one action, whose goals the control logic executes."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from rclpy.task import Future

from spiral_gripper_ros.control.grasp import Grasp, GraspGoal, GraspOutcome, GraspReport
from spiral_gripper_ros.control.release import Release, ReleaseGoal
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.conversions import filled
from spiral_gripper_ros.messages.qos import REQUESTS
from spiral_gripper_ros.process.guards import ErrorLog, log_on_error
from spiral_gripper_ros.runtime.guards import report as report_exception
from spiral_gripper_ros.runtime.runtime import Runtime

# Feedback is for people and their displays: ten times a second, whatever publish.rate is [s].
FEEDBACK_PERIOD = 0.1
# How long the result of a goal is kept for a client that asks late [s]. rclpy's 15 minutes would
# let the list of goals, which is published at each change, grow to thousands.
RESULT_TIMEOUT = 60
_DESTROYED = Refusal(Reason.NOT_ACTIVE, "the node is destroyed")
_CANCELED_BEFORE = Refusal(Reason.GRASP_CANCELED, "canceled before it was started")


class GuardedServer(ActionServer):  # type: ignore[misc]
    """rclpy's server; what it raises at a request, or at a client that has gone, is logged."""

    def __init__(self, errors: ErrorLog, *arguments: Any, **options: Any) -> None:  # noqa: ANN401
        self._errors = errors
        for service in ("goal", "result", "cancel"):
            options[f"{service}_service_qos_profile"] = REQUESTS
        super().__init__(*arguments, result_timeout=RESULT_TIMEOUT, **options)

    async def execute(self, taken_data: Any) -> None:  # noqa: ANN401
        """Answer the requests that were taken."""
        try:
            await super().execute(taken_data)
        except Exception as error:
            self._errors.note_refused("a request to an action", error)


@dataclass(slots=True)
class _Run:
    """A goal of a client: what carries it out, and its report and result once it has ended."""

    handle: Any
    goal: Grasp | Release | None = None  # None: not started
    end: Future = field(default_factory=Future)
    told_at: float | None = None


class GoalServer:
    """One action; every goal is accepted: a refused one is aborted, so that its result says why.

    An exception while a goal is read or its result is filled is logged and answered; it does not
    vent a gripper that holds. Nothing here waits, and an executor with one thread suffices: a goal
    is a coroutine that is resumed when it has ended.

    Args:
        node: the ROS node that serves.
        runtime: the gripper that carries out the goals.
        kind: type of the action.
        name: of the action.

    Attributes:
        node: the ROS node that serves.
        runtime: the gripper that carries out the goals.
        kind: type of the action.
        runs: the goals that run, or whose results are not sent yet.
    """

    def __init__(self, node: Node, runtime: Runtime, kind: Any, name: str) -> None:  # noqa: ANN401
        self.node = node
        self.runtime = runtime
        self.kind, self._name = kind, name
        self.runs: dict[int, _Run] = {}
        self._send_feedback = log_on_error(runtime.errors, self._feedback)
        self._server = GuardedServer(
            runtime.errors,
            node,
            kind,
            name,
            self._execute,
            callback_group=MutuallyExclusiveCallbackGroup(),
            cancel_callback=self._cancel,
        )

    # --- messages of the action ----------------------------------------------------------------

    def goal(self, request: Any) -> GraspGoal | ReleaseGoal | Refusal:  # noqa: ANN401
        """Return what a goal has the control logic do, or why it cannot be done."""
        raise NotImplementedError

    def told(self, message: Any, request: Any, report: GraspReport) -> Any:  # noqa: ANN401
        """Return a message of feedback or of a result, filled with how a goal goes or has ended."""
        raise NotImplementedError

    # --- a goal, from its start to its end -----------------------------------------------------

    async def _execute(self, handle: Any) -> Any:  # noqa: ANN401
        """Carry out a goal and return its result."""
        run = self.runs[id(handle)] = _Run(handle)
        try:
            self._start(run)
        except Exception as error:
            self._end(run, self._failed(self._name, error))
        try:
            report, result = await run.end
        finally:
            del self.runs[id(handle)]
        if report.outcome is GraspOutcome.SUCCEEDED:
            handle.succeed()
        elif report.outcome is GraspOutcome.CANCELED and handle.is_cancel_requested:
            handle.canceled()
        else:  # it may be refused because an earlier goal was canceled
            self.node.get_logger().warning(f"{self._name}: {report.refusal.text}")
            handle.abort()
        return result

    def _start(self, run: _Run) -> None:
        """Start a goal; the pressure is commanded at once, and feedback follows with each tick.

        A goal that cannot be read is refused. A grasp that was canceled before is not started; a
        release vents whenever it is canceled.
        """
        runtime, is_canceled = self.runtime, run.handle.is_cancel_requested
        try:
            goal = self.goal(run.handle.request)
        except Exception as error:
            runtime.errors.note(f"a goal of {self._name}", error)
            goal = Refusal(Reason.INTERNAL_ERROR, f"the goal cannot be read: {error!r}")
        if is_canceled and not isinstance(goal, ReleaseGoal):
            goal = _CANCELED_BEFORE
        now = runtime.now()
        started: Grasp | Release | Refusal
        if isinstance(goal, Refusal):
            started = goal
        elif runtime.loaded is None:
            started = Refusal(Reason.NOT_ACTIVE, runtime.not_configured)
        elif isinstance(goal, ReleaseGoal):
            started = runtime.control.start_release(now, goal)
        else:
            started = runtime.control.start_grasp(now, goal, runtime.loaded.planner)
        if isinstance(started, Refusal):
            self._end(run, GraspReport(started))
            return
        run.goal = started
        if is_canceled:
            runtime.control.cancel(now, started)
        runtime.publish()

    def tick(self) -> None:
        """Send feedback, and end the finished goals; never raises, never publishes a command."""
        for run in list(self.runs.values()):
            if run.goal is None or run.end.done():
                continue
            report = run.goal.report
            if report.end is not None:
                self._end(run, report)
            elif run.told_at is None or time.monotonic() - run.told_at >= FEEDBACK_PERIOD:
                run.told_at = time.monotonic()
                self._send_feedback(run.handle, report)

    def _feedback(self, handle: Any, report: GraspReport) -> None:  # noqa: ANN401
        handle.publish_feedback(self.told(self.kind.Feedback(), handle.request, report))

    def _cancel(self, handle: Any) -> CancelResponse:  # noqa: ANN401
        """Cancel a goal at once; one that has ended but is not yet told of it stays as it is."""
        run = self.runs.get(id(handle))
        if run is not None and run.end.done():
            return CancelResponse.REJECT
        if run is not None and run.goal is not None:
            try:
                self.runtime.control.cancel(self.runtime.now(), run.goal)
                self.runtime.publish()
            except Exception as error:
                self._failed(f"cancel of {self._name}", error)
        return CancelResponse.ACCEPT

    def _end(self, run: _Run, report: GraspReport) -> None:
        """End a goal that has not ended; its result tells of this moment."""
        if not run.end.done():
            run.end.set_result((report, self._result(run.handle.request, report)))

    def _result(self, request: Any, report: GraspReport) -> Any:  # noqa: ANN401
        """Return the result of a goal; without its figures if they cannot be computed."""
        try:
            return self.told(self.kind.Result(), request, report)
        except Exception as error:
            self.runtime.errors.note(f"the result of {self._name}", error)
            success = report.outcome is GraspOutcome.SUCCEEDED
            text = report.refusal.text or f"no figures, internal error: {error!r}"
            return filled(
                self.kind.Result(),
                success=success,
                reached_goal=success,
                reason=report.refusal.reason,
                message=text,
            )

    def _failed(self, where: str, error: Exception) -> GraspReport:
        """Log an exception, vent, and return the report of the goal that it ends."""
        text = report_exception(self.runtime, where, error)
        return GraspReport(Refusal(Reason.INTERNAL_ERROR, text))

    # --- end -----------------------------------------------------------------------------------

    def destroy(self) -> None:
        """End the goals that still run, without feedback, and destroy the action server."""
        for run in self.runs.values():
            self._end(run, GraspReport(_DESTROYED))
        self._server.destroy()
