# SPDX-License-Identifier: Apache-2.0
"""The node's states and reasons: one name each, shared by control logic and ``GripStatus``.

The numbers are those of ``spiral_gripper_msgs/msg/GripStatus.msg``; a test compares them.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from spiral_core.errors import (
    ActuationLimitError,
    InvalidInputError,
    NotGrippableError,
    SpiralError,
)


class State(IntEnum):
    """The states of the control logic; ``docs/node.md`` has the transitions."""

    INACTIVE = 0
    WAITING = 1
    TRACKING = 2
    HOLDING = 3
    RAMPING_DOWN = 4
    VENTED = 5
    RELEASED = 6
    FAULT = 7
    GRASPING = 8
    TAKEN_OVER = 9

    @property
    def is_latched(self) -> bool:
        """Whether it ends only with rearm, a grasp goal or the next activation."""
        return self in (State.INACTIVE, State.RELEASED, State.FAULT)

    @property
    def is_gripping(self) -> bool:
        """Whether the command heads for the target."""
        return self in (State.TRACKING, State.HOLDING, State.GRASPING, State.TAKEN_OVER)

    @property
    def is_vented(self) -> bool:
        """Whether 0 Pa is commanded: no object can be held."""
        return not self.is_gripping and self is not State.RAMPING_DOWN


class Reason(IntEnum):
    """Why an input is not followed, a request refused or a goal ended.

    Below 100: what was given; from 100: what somebody does, and how a goal goes; from 200: faults.
    """

    NONE = 0
    NO_RADIUS = 1
    RADIUS_NOT_FINITE = 2
    RADIUS_NOT_POSITIVE = 3
    RADIUS_TOO_SMALL = 4
    RADIUS_TOO_LARGE = 5
    RADIUS_JUMP = 6
    RADIUS_STALE = 7
    OBJECT_TOO_SHORT = 8
    PRESSURE_CAP = 9
    NOT_CERTIFIED = 10
    GRAVITY_INVALID = 11
    INVALID_REQUEST = 12
    NOT_ACTIVE = 100
    RELEASED = 101
    RECONFIGURED = 102
    TAKEN_OVER = 103
    GRASP_CANCELED = 104
    GRASP_REPLACED = 105
    GRASP_TIMEOUT = 106
    WRAP_FAILED = 107
    INTERNAL_ERROR = 200
    PRESSURE_LOW = 201
    PRESSURE_HIGH = 202
    PRESSURE_LOST = 203
    PRESSURE_INVALID = 204
    GRAVITY_STALE = 205
    CLIENT_LOST = 206


@dataclass(frozen=True, slots=True)
class Refusal:
    """The reason of a refusal: a code for programs and one line for people.

    Example:
        >>> Refusal(Reason.RADIUS_NOT_FINITE, "object_radius nan is not a finite number").reason
        <Reason.RADIUS_NOT_FINITE: 2>
    """

    reason: Reason
    text: str


NOT_REFUSED = Refusal(Reason.NONE, "")


def refusal_from_error(error: SpiralError) -> Refusal:
    """Return the refusal that stands for an error of the core.

    A radius outside the grippable range is too small or too large, depending on the nearest
    grippable radius. Any error that concerns neither radius, pressure nor an argument means that no
    certified shape was found.

    Example:
        >>> error = NotGrippableError(0.09, "too large for one turn", -0.05, 0.04)
        >>> refusal_from_error(error).reason
        <Reason.RADIUS_TOO_LARGE: 5>
    """
    reason = Reason.NOT_CERTIFIED
    if isinstance(error, NotGrippableError) and error.nearest_radius is not None:
        too_small = error.radius < error.nearest_radius
        reason = Reason.RADIUS_TOO_SMALL if too_small else Reason.RADIUS_TOO_LARGE
    elif isinstance(error, ActuationLimitError):
        reason = Reason.PRESSURE_CAP
    elif isinstance(error, InvalidInputError):
        reason = Reason.INVALID_REQUEST
    return Refusal(reason, str(error))
