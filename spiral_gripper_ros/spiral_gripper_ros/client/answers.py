# SPDX-License-Identifier: Apache-2.0
"""Results and errors of the Python client. No ROS."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from spiral_core.errors import SpiralError
from spiral_gripper_ros.control.states import Reason


class WrapOutcome(Enum):
    """How a wrap has ended."""

    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELED = "canceled"


@dataclass(frozen=True, slots=True)
class WrapResult:
    """How a wrap has ended, and the figures that go with it.

    Args:
        outcome: how.
        reason: why it failed or was canceled; ``Reason.NONE`` otherwise.
        message: one line for people.
        object_radius: [m]; None, as the next three, without a wrap: the goal was refused, or was a
            pressure.
        pressure_command: gauge pressure commanded at the end [Pa].
        measured_pressure: gauge pressure [Pa], or None if it is not measured: the wrap is then
            reached as commanded.
        turns: about the object's axis, at the wrap's pressure.
        contact_length: length of gripper that touches [m].
        line_force: normal force on the object per length of gripper [N/m].
        holding_force_away: force that holds the object against moving along its axis, away from the
            gripper's base, from contact and friction [N]; None: not known (yet).
        holding_force_towards: the same towards the base [N].
        elapsed: time from the goal's acceptance to its end [s].
    """

    outcome: WrapOutcome
    reason: Reason
    message: str
    object_radius: float | None
    pressure_command: float
    measured_pressure: float | None
    turns: float | None
    contact_length: float | None
    line_force: float | None
    holding_force_away: float | None
    holding_force_towards: float | None
    elapsed: float


class NoAnswerError(SpiralError, TimeoutError):
    """An answer or message did not come in time.

    Attributes:
        missing: what it is, and how to get it.
        timeout: how long it was waited for [s].

    Example:
        >>> print(NoAnswerError("release does not answer", 10.0))
        release does not answer (waited 10 s)
    """

    def __init__(self, missing: str, timeout: float) -> None:
        super().__init__(missing, timeout)
        self.missing = missing
        self.timeout = timeout

    def __str__(self) -> str:
        return f"{self.missing} (waited {self.timeout:.3g} s)"


class RequestRefusedError(SpiralError):
    """The gripper refuses a request.

    Attributes:
        request: what.
        message: why not.

    Example:
        >>> print(RequestRefusedError("rearm", "the node is not active"))
        rearm is refused: the node is not active
    """

    def __init__(self, request: str, message: str) -> None:
        super().__init__(request, message)
        self.request = request
        self.message = message

    def __str__(self) -> str:
        return f"{self.request} is refused: {self.message}"


def no_node_in(namespace: str) -> str:
    """Return the message that no gripper's node answers, and how to start one."""
    return (
        f"no gripper's node answers in the namespace {namespace}: start one with "
        f"`spiral_gripper_node --ros-args -r __ns:={namespace}`, and compare ROS_DOMAIN_ID"
    )
