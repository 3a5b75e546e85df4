"""What is commanded and why, at one moment."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Generic

from spiral_gripper_ros.control.plan_protocol import PlanT
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State


@dataclass(frozen=True, slots=True)
class MeasuredPressure:
    """The measured pressure, as far as it is believed.

    Args:
        pressure: gauge pressure [Pa], smoothed.
        age: time since the newest believed message [s].
    """

    pressure: float
    age: float


@dataclass(frozen=True, slots=True)
class Snapshot(Generic[PlanT]):
    """What the control logic commands and why, at one moment.

    Args:
        state: what it does.
        refusal: why the newest input is not followed (``Reason.NONE`` if it is).
        radius: radius in use [m], or None.
        plan: the wrap that belongs to ``radius``, or None.
        radius_age: time since the last usable radius [s], or None before the first.
        pressure_target: where the command is heading [Pa].
        pressure_command: the command [Pa].
        accepted: radii accepted since activation.
        refused: refusals since activation, by reason.
        measured: the measured pressure, or None if none arrives or none is believed.
        pressure_fault: what is wrong with it (``Reason.NONE`` if nothing is).
        wrapped: the object in use is held: at the measured pressure, else as commanded; not while
            ``PRESSURE_LOST``.
    """

    state: State
    refusal: Refusal
    radius: float | None
    plan: PlanT | None
    radius_age: float | None
    pressure_target: float
    pressure_command: float
    accepted: int
    refused: Counter[Reason]
    measured: MeasuredPressure | None = None
    pressure_fault: Refusal = NOT_REFUSED
    wrapped: bool = False
