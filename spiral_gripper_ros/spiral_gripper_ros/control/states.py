# SPDX-License-Identifier: Apache-2.0
"""The node's states, the transitions between them, and the reasons.

The numbers are those of ``GripStatus.msg`` and ``Reason.msg``; a test compares them.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Final

from spiral_core.errors import (
    ActuationLimitError,
    InvalidInputError,
    NotGrippableError,
    SpiralError,
)


class State(IntEnum):
    """The states of the control logic."""

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


class Event(Enum):
    """What changes the state; anything else that happens changes only reason, target or command."""

    ACTIVATE = "activation"
    DEACTIVATE = "deactivation"
    RADIUS = "usable radius"
    REFUSED = "refused input"
    STALE_HOLD = "no usable radius (policy `hold`)"
    STALE_RAMP_DOWN = "no usable radius (policy `ramp_down`)"
    STALE_VENT = "no usable radius (policy `vent`)"
    EMPTY = "ramp at 0 Pa"
    AGREED = "measured pressure to take over"
    GOAL = "grasp goal"
    ABORT_HOLD = "aborted grasp (policy `hold`)"
    RELEASE = "release, another gripper, lost client, aborted grasp (policy `vent`)"
    WATCHDOG = "vent by the regulator's watchdog"
    FAULT = "internal error; pressure fault or stale gravity (policy `vent`)"
    REARM = "rearm"


class CommandRule(Enum):
    """What is commanded from a transition on."""

    VENT = "0 Pa at once"
    TARGET = "ramp to the target"
    KEEP = "as it is"
    RAMP_DOWN = "ramp to 0 Pa"


def _transitions() -> dict[tuple[State, Event], tuple[State, CommandRule]]:
    active = set(State) - {State.INACTIVE}
    stream = {State.TRACKING, State.HOLDING}
    listening = active - {State.RELEASED, State.FAULT, State.GRASPING}
    vent, target, keep = CommandRule.VENT, CommandRule.TARGET, CommandRule.KEEP
    rows = (
        (Event.ACTIVATE, {State.INACTIVE}, State.WAITING, vent),
        (Event.DEACTIVATE, set(State), State.INACTIVE, vent),
        (Event.RADIUS, listening, State.TRACKING, target),
        (Event.REFUSED, {State.TRACKING}, State.HOLDING, target),
        (Event.STALE_HOLD, stream, State.HOLDING, target),
        (Event.STALE_RAMP_DOWN, stream, State.RAMPING_DOWN, CommandRule.RAMP_DOWN),
        (Event.STALE_VENT, stream, State.VENTED, vent),
        (Event.EMPTY, {State.RAMPING_DOWN}, State.VENTED, vent),
        (Event.AGREED, {State.WAITING}, State.TAKEN_OVER, keep),
        (Event.GOAL, active - {State.FAULT}, State.GRASPING, target),
        (Event.ABORT_HOLD, {State.GRASPING}, State.GRASPING, keep),
        (Event.RELEASE, active - {State.FAULT}, State.RELEASED, vent),
        (Event.WATCHDOG, stream | {State.RAMPING_DOWN}, State.WAITING, vent),
        (Event.WATCHDOG, {State.GRASPING, State.TAKEN_OVER}, State.RELEASED, vent),
        (Event.FAULT, active, State.FAULT, vent),
        (Event.FAULT, {State.INACTIVE}, State.INACTIVE, vent),
        (Event.REARM, {State.RELEASED, State.FAULT}, State.WAITING, vent),
    )
    return {(state, event): (new, rule) for event, states, new, rule in rows for state in states}


# An event without a row of its state changes no state.
TRANSITIONS: Final = _transitions()


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

    It is true but for ``Reason.NONE``: nothing is refused.

    Example:
        >>> Refusal(Reason.RADIUS_NOT_FINITE, "object_radius nan is not a finite number").reason
        <Reason.RADIUS_NOT_FINITE: 2>
    """

    reason: Reason
    text: str

    def __bool__(self) -> bool:
        return self.reason is not Reason.NONE


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
        >>> from spiral_core.errors import ActuationLimit
        >>> error = ActuationLimitError(ActuationLimit.LIMIT_POINT, "pressure", 2.0, 1.0)
        >>> refusal_from_error(error) == Refusal(Reason.PRESSURE_CAP, str(error))
        True
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
