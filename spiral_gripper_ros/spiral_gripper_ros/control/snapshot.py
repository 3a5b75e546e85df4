# SPDX-License-Identifier: Apache-2.0
"""The state of the control logic at one moment."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper_ros.control.plan import WrapPlan
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The state of the control logic at one moment: command, target and reasons.

    Args:
        state: what it does.
        refusal: why the newest input is not followed (``Reason.NONE`` if it is).
        radius: radius in use [m], or None.
        plan: the wrap that belongs to ``radius``, or None.
        pressure_target: where the command is heading [Pa].
        pressure_command: the command [Pa].
        accepted: radii accepted since activation.
        refused: refusals since activation, by reason.
        measured_pressure: gauge [Pa], smoothed, or None if none arrives or none is believed.
        measured_age: time since the newest message that is believed [s], or None.
        is_measured: whether any pressure has been measured since activation, believed or not.
        pressure_fault: what is wrong with it (``Reason.NONE`` if nothing is).
        wrapped: the object in use is held: at the measured pressure, else as commanded; not while
            ``PRESSURE_LOST``.
        overpressure: of the target, above the pressure of the bare wrap [Pa].
        gravity_age: time since the newest heard gravity [s], or None if none was heard.
        gravity_fault: that it is stale (``Reason.NONE`` if it is not).
    """

    state: State
    refusal: Refusal
    radius: float | None
    plan: WrapPlan | None
    pressure_target: float
    pressure_command: float
    accepted: int
    refused: Counter[Reason]
    measured_pressure: float | None = None
    measured_age: float | None = None
    is_measured: bool = False
    pressure_fault: Refusal = NOT_REFUSED
    wrapped: bool = False
    overpressure: float = 0.0
    gravity_age: float | None = None
    gravity_fault: Refusal = NOT_REFUSED

    @property
    def fault(self) -> Refusal:
        """The pressure's fault, else gravity's (``Reason.NONE`` if there is none)."""
        return self.pressure_fault or self.gravity_fault

    @property
    def placement(self) -> ObjectPlacement | None:
        """Where the plan's object lies in the free coil; None without a plan."""
        return None if self.plan is None else self.plan.placement

    @property
    def pressure(self) -> float:
        """Gauge pressure of the gripper [Pa]: measured if it is known, else as commanded."""
        return self.pressure_command if self.measured_pressure is None else self.measured_pressure
