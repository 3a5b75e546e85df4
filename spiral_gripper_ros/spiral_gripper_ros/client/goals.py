# SPDX-License-Identifier: Apache-2.0
"""Wraps as goals and results of the action `grasp`."""

from __future__ import annotations

from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.task import Future

from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_non_negative, require_positive
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.client.answers import WrapOutcome, WrapResult
from spiral_gripper_ros.control.limits import AbortPolicy
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.messages.conversions import known

_ABORT_POLICIES = {
    None: Grasp.Goal.ABORT_DEFAULT,
    AbortPolicy.VENT: Grasp.Goal.ABORT_VENT,
    AbortPolicy.HOLD: Grasp.Goal.ABORT_HOLD,
}
# A node that was started again; it sends an empty result.
UNKNOWN_GOAL = "the node no longer knows the goal"
_OUTCOMES = {
    GoalStatus.STATUS_SUCCEEDED: WrapOutcome.SUCCEEDED,
    GoalStatus.STATUS_CANCELED: WrapOutcome.CANCELED,
}


class LateCancel:
    """Cancels a goal that nobody waits for any more, as soon as its answer comes.

    Args:
        answer: of the node to the goal; None: there is no such goal.

    Attributes:
        is_over: whether there is nothing left to cancel.
    """

    def __init__(self, answer: Future | None = None) -> None:
        self.is_over = answer is None
        if answer is not None:
            answer.add_done_callback(self._on_answer)

    def _on_answer(self, answer: Future) -> None:
        handle = answer.result()
        if handle is not None and handle.accepted:
            handle.cancel_goal_async().add_done_callback(self._on_canceled)
        else:
            self.is_over = True

    def _on_canceled(self, _: Future) -> None:
        self.is_over = True


def goal_with(timeout: float | None, abort_policy: AbortPolicy | str | None) -> Grasp.Goal:
    """Return a goal with what every goal has.

    Raises:
        InvalidInputError: the time [s] is not positive, or there is no such policy.
    """
    try:
        policy = _ABORT_POLICIES[None if abort_policy is None else AbortPolicy(abort_policy)]
    except ValueError:
        requirement = '"vent", "hold" or None'
        raise InvalidInputError("abort_policy", abort_policy, requirement) from None
    limit = [] if timeout is None else [require_positive("timeout", timeout)]
    return Grasp.Goal(timeout=limit, abort_policy=policy)


def non_negative(name: str, value: float | None) -> list[float]:
    """Return a number that is not negative as a list of one, None as an empty one.

    Raises:
        InvalidInputError: it is no such number.
    """
    return [] if value is None else [require_non_negative(name, value)]


def result_of_wrap(response: Any) -> WrapResult:  # noqa: ANN401
    """Return the result that the action's server has sent."""
    result = response.result
    figures, grip = ((*part, None)[0] for part in (result.figures, result.grip))
    of_wrap = ("object_radius", "turns", "contact_length", "line_force")
    held = ("holding_force_away", "holding_force_towards")
    return WrapResult(
        outcome=_OUTCOMES.get(response.status, WrapOutcome.FAILED),
        reason=Reason(result.reason),
        message=result.message or UNKNOWN_GOAL,
        pressure_command=result.pressure_command,
        measured_pressure=known(result.measured_pressure),
        elapsed=result.elapsed,
        **{name: getattr(figures, name, None) for name in of_wrap},
        **{name: getattr(grip, name, None) for name in held},
    )
