# SPDX-License-Identifier: Apache-2.0
"""The public values of a grasp: its goal and its report."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Generic

from spiral_gripper_ros.control.snapshot import PlanT
from spiral_gripper_ros.control.states import NOT_REFUSED, Refusal


class AbortPolicy(Enum):
    """What happens to the pressure when a grasp is canceled or fails."""

    VENT = "vent"  # 0 Pa at once, until re-armed or the next goal
    HOLD = "hold"  # the command at that moment stands


class GraspOutcome(Enum):
    """The state of a grasp."""

    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELED = "canceled"


@dataclass(frozen=True, slots=True)
class GraspGoal:
    """The goal of a grasp; any float, checked when the grasp is started.

    Args:
        radius: of the object [m], or None for the radius that is being followed.
        pressure: to go to instead, whatever it wraps [Pa], >= 0; None: wrap the object.
        overpressure: held above the pressure of the perfect wrap [Pa], >= 0; None: that of
            ``grip_ratio``.
        timeout: longest time until the wrap is reached [s], > 0, or None for ``grasp_timeout``.
        abort_policy: what becomes of the pressure if it fails, or None for ``grasp_abort_policy``.
    """

    radius: float | None
    pressure: float | None = None
    overpressure: float | None = None
    timeout: float | None = None
    abort_policy: AbortPolicy | None = None


@dataclass(frozen=True, slots=True)
class GraspReport(Generic[PlanT]):
    """The report on a grasp or a release; final once ``outcome`` is not ``RUNNING``.

    Args:
        outcome: its state.
        refusal: why it was refused, failed or was canceled; ``Reason.NONE`` otherwise.
        elapsed: time from its start to its end, or until now [s].
        progress: the command's part of the way to its target, 0 to 1.
        radius: of the object [m], or None.
        plan: the planned wrap, or None.
        overpressure: that it asks for above the wrap's pressure [Pa].
    """

    outcome: GraspOutcome
    refusal: Refusal = NOT_REFUSED
    elapsed: float = 0.0
    progress: float = 0.0
    radius: float | None = None
    plan: PlanT | None = None
    overpressure: float = 0.0
