# SPDX-License-Identifier: Apache-2.0
"""Wraps as goals and results of the action `grasp`."""

from __future__ import annotations

from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.task import Future

from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_non_negative, require_positive
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.client.answers import WrapOutcome, WrapResult
from spiral_gripper_ros.control.grasp import AbortPolicy
from spiral_gripper_ros.control.states import Reason

_ABORT_POLICIES = {
    None: Grasp.Goal.ABORT_DEFAULT,
    AbortPolicy.VENT: Grasp.Goal.ABORT_VENT,
    AbortPolicy.HOLD: Grasp.Goal.ABORT_HOLD,
}
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


def goal_of_wrap(
    radius: float | None,
    overpressure: float,
    timeout: float | None,
    abort_policy: AbortPolicy | str | None,
) -> Grasp.Goal:
    """Return the goal for a wrap; arguments as in :meth:`SpiralGripper.wrap`.

    Raises:
        InvalidInputError: a figure is not possible.
    """
    return Grasp.Goal(
        object_radius=0.0 if radius is None else require_positive("radius", radius),
        overpressure=require_non_negative("overpressure", overpressure),
        timeout=0.0 if timeout is None else require_positive("timeout", timeout),
        abort_policy=_abort_policy(abort_policy),
    )


def request_of_plan(
    radius: float, overpressure: float, payload: float, friction: float
) -> PlanWrap.Request:
    """Return the request for a plan; arguments as in :meth:`SpiralGripper.plan`.

    Raises:
        InvalidInputError: a figure is not possible.
    """
    return PlanWrap.Request(
        object_radius=require_positive("radius", radius),
        overpressure=require_non_negative("overpressure", overpressure),
        payload=require_non_negative("payload", payload),
        friction_coefficient=require_non_negative("friction", friction),
    )


def _abort_policy(policy: AbortPolicy | str | None) -> int:
    """Return the goal's field for an abort policy."""
    try:
        return int(_ABORT_POLICIES[None if policy is None else AbortPolicy(policy)])
    except ValueError:
        raise InvalidInputError("abort_policy", policy, '"vent", "hold" or None') from None


def result_of_wrap(response: Any) -> WrapResult:  # noqa: ANN401
    """Return the result that the action's server has sent."""
    result = response.result
    grip = result.grip
    return WrapResult(
        outcome=_OUTCOMES.get(response.status, WrapOutcome.FAILED),
        reason=Reason(result.reason),
        message=result.message or "the node no longer knows the goal",
        object_radius=result.object_radius,
        pressure_command=result.pressure_command,
        measured_pressure=result.measured_pressure if result.measured else None,
        turns=result.turns,
        contact_length=result.contact_length,
        line_force=result.line_force,
        holding_force_away=grip.holding_force_away if grip.known else None,
        holding_force_towards=grip.holding_force_towards if grip.known else None,
        elapsed=result.elapsed,
    )
