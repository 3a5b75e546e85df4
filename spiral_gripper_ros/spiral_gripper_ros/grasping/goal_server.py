# SPDX-License-Identifier: Apache-2.0
"""Serves an action whose goals the control logic carries out, in the language of its messages."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

from spiral_gripper_ros.control.grasp import GraspOutcome
from spiral_gripper_ros.control.states import Refusal
from spiral_gripper_ros.grasping.goal_jobs import Job
from spiral_gripper_ros.grasping.goal_runner import GoalRunner, Moment

if TYPE_CHECKING:
    from spiral_gripper_ros.node.gripper_node import GripperNode

# How long the result of a goal is kept for a client that asks late [s]. rclpy's 15 minutes would
# let the list of goals, which is published at each change, grow to thousands.
RESULT_TIMEOUT = 60


class Dialect(Protocol):
    """Translates between an action's messages and the goals of the control logic."""

    def job(self, request: Any) -> Job | Refusal:  # noqa: ANN401
        """Return what a goal has the control logic do, or why it cannot be done."""
        ...

    def feedback(self, request: Any, moment: Moment) -> Any:  # noqa: ANN401
        """Return the message that tells how a goal goes."""
        ...

    def result(self, request: Any, moment: Moment) -> Any:  # noqa: ANN401
        """Return the message that tells how a goal has ended."""
        ...


class GoalServer:
    """One action; every goal is accepted: a refused one is aborted, so that its result says why.

    Nothing here waits, and an executor with one thread suffices: a goal is a coroutine that is
    resumed when it has ended.

    Args:
        node: the node that serves.
        runner: carries out the goals.
        action: type and name of the action.
        dialect: of its messages.
    """

    def __init__(
        self, node: GripperNode, runner: GoalRunner, action: tuple[Any, str], dialect: Dialect
    ) -> None:
        self._runner = runner
        self._dialect = dialect
        self._name = action[1]
        self._logger = node.get_logger()
        self._server = ActionServer(
            node,
            *action,
            self._execute,
            callback_group=MutuallyExclusiveCallbackGroup(),
            cancel_callback=self._cancel,
            result_timeout=RESULT_TIMEOUT,
        )

    def destroy(self) -> None:
        """Serve no longer."""
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
        try:
            moment = await self._carried_out(handle)
            result = self._dialect.result(request, moment)
        except Exception as error:
            moment = self._runner.failed(self._name, error)
            result = self._dialect.result(request, moment)
        if moment.report.outcome is GraspOutcome.FAILED:
            self._logger.warning(f"{self._name}: {moment.report.refusal.text}")
        _finish(handle, moment.report.outcome)
        return result

    async def _carried_out(self, handle: Any) -> Moment:  # noqa: ANN401
        if handle.is_cancel_requested:
            return self._runner.canceled()
        job = self._dialect.job(handle.request)
        if isinstance(job, Refusal):
            return self._runner.refused(job)

        def notify(moment: Moment) -> None:
            handle.publish_feedback(self._dialect.feedback(handle.request, moment))

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
