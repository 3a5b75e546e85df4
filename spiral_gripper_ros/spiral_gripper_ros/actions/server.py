# SPDX-License-Identifier: Apache-2.0
"""The server of one action, whose goals the control logic executes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node

from spiral_gripper_ros.actions.jobs import Job
from spiral_gripper_ros.actions.runner import GoalRunner, GoalUpdate
from spiral_gripper_ros.control.grasp import GraspOutcome
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.messages.qos import REQUESTS
from spiral_gripper_ros.process.guards import ErrorLog

# How long the result of a goal is kept for a client that asks late [s]. rclpy's 15 minutes would
# let the list of goals, which is published at each change, grow to thousands.
RESULT_TIMEOUT = 60


class ActionAdapter(Protocol):
    """Translates between an action's messages and the goals of the control logic."""

    def job(self, request: Any) -> Job | Refusal:  # noqa: ANN401
        """Return what a goal has the control logic do, or why it cannot be done."""
        ...

    def feedback(self, request: Any, update: GoalUpdate) -> Any:  # noqa: ANN401
        """Return the message that tells how a goal goes."""
        ...

    def result(self, request: Any, update: GoalUpdate) -> Any:  # noqa: ANN401
        """Return the message that tells how a goal has ended."""
        ...


class _Server(ActionServer):  # type: ignore[misc]
    """rclpy's server; what it raises at a request, or at a client that has gone, is logged."""

    def __init__(self, errors: ErrorLog, *arguments: Any, **options: Any) -> None:  # noqa: ANN401
        self._errors = errors
        super().__init__(*arguments, **options)

    async def execute(self, taken_data: Any) -> None:  # noqa: ANN401
        """Answer the requests that were taken."""
        try:
            await super().execute(taken_data)
        except Exception as error:
            self._errors.note_refused("a request to an action", error)


class GoalServer:
    """One action; every goal is accepted: a refused one is aborted, so that its result says why.

    An exception while a goal is read or its result is filled is logged and answered; it does not
    vent a gripper that holds.

    Nothing here waits, and an executor with one thread suffices: a goal is a coroutine that is
    resumed when it has ended.

    Args:
        node: the ROS node that serves.
        runner: carries out the goals.
        action: type and name of the action.
        adapter: of its messages.
    """

    def __init__(
        self, node: Node, runner: GoalRunner, action: tuple[Any, str], adapter: ActionAdapter
    ) -> None:
        self._runner = runner
        self._adapter = adapter
        self._kind, self._name = action
        self._logger = node.get_logger()
        self._server = _Server(
            runner.errors,
            node,
            *action,
            self._execute,
            callback_group=MutuallyExclusiveCallbackGroup(),
            cancel_callback=self._cancel,
            goal_service_qos_profile=REQUESTS,
            result_service_qos_profile=REQUESTS,
            cancel_service_qos_profile=REQUESTS,
            result_timeout=RESULT_TIMEOUT,
        )

    def destroy(self) -> None:
        """Destroy the action server."""
        self._server.destroy()

    def _cancel(self, handle: Any) -> CancelResponse:  # noqa: ANN401
        """Cancel a goal at once; one that has ended but is not yet told of it stays as it is."""
        try:
            ended = self._runner.has_ended(_key(handle))
            if not ended:
                self._runner.cancel(_key(handle))
        except Exception as error:
            self._runner.failed(f"cancel of {self._name}", error)
            return CancelResponse.ACCEPT
        return CancelResponse.REJECT if ended else CancelResponse.ACCEPT

    async def _execute(self, handle: Any) -> Any:  # noqa: ANN401
        """Carry out a goal and return its result."""
        request = handle.request
        job = self._job(request)
        try:
            update = await self._carried_out(handle, job)
        except Exception as error:
            update = self._runner.failed(self._name, error)
        if update.report.outcome is GraspOutcome.FAILED:
            self._logger.warning(f"{self._name}: {update.report.refusal.text}")
        _finish(handle, update.report.outcome)
        return self._result(request, update)

    def _job(self, request: Any) -> Job | Refusal:  # noqa: ANN401
        """Return what a goal has the control logic do; one that cannot be read is refused."""
        try:
            return self._adapter.job(request)
        except Exception as error:
            self._runner.errors.note(f"a goal of {self._name}", error)
            return Refusal(Reason.INTERNAL_ERROR, f"the goal cannot be read: {error!r}")

    def _result(self, request: Any, update: GoalUpdate) -> Any:  # noqa: ANN401
        """Return the result of a goal; without its figures if they cannot be computed."""
        try:
            return self._adapter.result(request, update)
        except Exception as error:
            self._runner.errors.note(f"the result of {self._name}", error)
            result = self._kind.Result()
            told = update.report.refusal.text or f"no figures, internal error: {error!r}"
            outcome = update.report.outcome
            values = {
                "success": outcome is GraspOutcome.SUCCEEDED,
                "reached_goal": outcome is GraspOutcome.SUCCEEDED,
                "reason": int(update.report.refusal.reason),
                "message": told,
            }
            for name in values.keys() & result.get_fields_and_field_types().keys():
                setattr(result, name, values[name])
            return result

    async def _carried_out(self, handle: Any, job: Job | Refusal) -> GoalUpdate:  # noqa: ANN401
        if handle.is_cancel_requested:
            return self._runner.canceled()
        if isinstance(job, Refusal):
            return self._runner.refused(job)

        def notify(update: GoalUpdate) -> None:
            handle.publish_feedback(self._adapter.feedback(handle.request, update))

        return await self._runner.run(_key(handle), job, notify)


def _key(handle: Any) -> bytes:  # noqa: ANN401
    return bytes(handle.goal_id.uuid)


def _finish(handle: Any, outcome: GraspOutcome) -> None:  # noqa: ANN401
    """Give a goal the final state that belongs to its outcome."""
    ends: dict[GraspOutcome, Callable[[], None]] = {
        GraspOutcome.SUCCEEDED: handle.succeed,
        GraspOutcome.CANCELED: handle.canceled,
    }
    ends.get(outcome, handle.abort)()
