# SPDX-License-Identifier: Apache-2.0
"""The 1 Hz message on /diagnostics (REP-107)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import Reason, State

_LEVELS = {
    State.INACTIVE: DiagnosticStatus.OK,
    State.WAITING: DiagnosticStatus.OK,
    State.TRACKING: DiagnosticStatus.OK,
    State.HOLDING: DiagnosticStatus.WARN,
    State.RAMPING_DOWN: DiagnosticStatus.WARN,
    State.VENTED: DiagnosticStatus.WARN,
    State.RELEASED: DiagnosticStatus.OK,
    State.FAULT: DiagnosticStatus.ERROR,
    State.GRASPING: DiagnosticStatus.OK,
    State.TAKEN_OVER: DiagnosticStatus.WARN,
}
CLOCK_STANDS_STILL = "the simulated clock stands still: the command is frozen"


@dataclass(frozen=True, slots=True)
class Health:
    """The state of the node, other than its commands.

    Args:
        name: full name of the node.
        hardware_id: name of the gripper; "" before one is loaded.
        internal_errors: exceptions caught since the node started.
        clock_stands_still: the node is active but its simulated clock has stopped.
        commanders: nodes that publish pressure_command, this one included.
        object_problem: why the newest object_pose is not used; empty: nothing is wrong with it.
        object_poses_refused: since activation.
        has_table: whether the table of grips applies at the present gravity.
    """

    name: str
    hardware_id: str
    internal_errors: int
    clock_stands_still: bool = False
    commanders: int = 1
    object_problem: str = ""
    object_poses_refused: int = 0
    has_table: bool = False


def diagnostics_to_msg(
    health: Health,
    snapshot: Snapshot,
    stamp: Any,  # noqa: ANN401
) -> DiagnosticArray:
    """Return the diagnostics of one gripper.

    Args:
        health: what is known of the node.
        snapshot: what is commanded, and why.
        stamp: time of the message.
    """
    fault, measured = snapshot.pressure_fault, snapshot.measured
    warnings = [snapshot.gravity_fault.text, health.object_problem]
    if health.clock_stands_still:
        warnings.append(CLOCK_STANDS_STILL)
    if health.commanders > 1:
        warnings.append(f"{health.commanders} nodes publish pressure_command")
    # The worst of what there is to tell; the levels are single bytes, in order.
    levels: list[bytes] = [_LEVELS[snapshot.state]]
    if fault.reason is not Reason.NONE:
        levels.append(DiagnosticStatus.ERROR)
    if any(warnings):
        levels.append(DiagnosticStatus.WARN)
    state = snapshot.refusal.text or snapshot.state.name.lower().replace("_", " ")
    text = "; ".join(text for text in (state, fault.text, *warnings) if text)
    values = {
        "state": snapshot.state.name,
        "reason": snapshot.refusal.reason.name,
        "grasping": snapshot.state is State.GRASPING,
        "wrapped": snapshot.wrapped,
        "object_radius [m]": snapshot.radius,
        "pressure_target [Pa]": snapshot.pressure_target,
        "pressure_command [Pa]": snapshot.pressure_command,
        "measured_pressure [Pa]": snapshot.measured_pressure,
        "measured_pressure age [s]": None if measured is None else measured.age,
        "gravity age [s]": snapshot.gravity_age,
        "pressure_command publishers": health.commanders,
        "pressure fault": fault.reason.name,
        "radii accepted": snapshot.accepted,
        "object poses refused": health.object_poses_refused,
        "table of grips applies": health.has_table,
        "internal errors": health.internal_errors,
    }
    for reason in Reason:
        if snapshot.refused[reason]:
            values[f"refused: {reason.name}"] = snapshot.refused[reason]
    return diagnostic_message(
        f"{health.name}: grip", health.hardware_id, (max(levels), text), values, stamp
    )


def diagnostic_message(
    name: str,
    hardware_id: str,
    status: tuple[bytes, str],
    values: Mapping[str, object],
    stamp: Any,  # noqa: ANN401
) -> DiagnosticArray:
    """Return the message of one status: its level with its text, and figures by their names.

    None is shown as an empty text.
    """
    level, text = status
    told = DiagnosticStatus(level=level, name=name, message=text, hardware_id=hardware_id)
    for key, value in values.items():
        shown = f"{value:.6g}" if isinstance(value, float) else str("" if value is None else value)
        told.values.append(KeyValue(key=key, value=shown))
    message = DiagnosticArray(status=[told])
    message.header.stamp = stamp
    return message
