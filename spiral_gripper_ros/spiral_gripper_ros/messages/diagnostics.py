# SPDX-License-Identifier: Apache-2.0
"""The 1 Hz message on /diagnostics (REP-107)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import Reason, State

_WARNINGS = (State.HOLDING, State.RAMPING_DOWN, State.VENTED, State.TAKEN_OVER)
CLOCK_STANDS_STILL = "the simulated clock stands still: the command is frozen"


def diagnostics_to_msg(
    snapshot: Snapshot,
    stamp: Any,  # noqa: ANN401
    name: str,
    hardware_id: str,
    internal_errors: int,
    *,
    clock_stands_still: bool = False,
    commanders: int = 1,
    object_problem: str = "",
    object_poses_refused: int = 0,
    has_table: bool = False,
) -> DiagnosticArray:
    """Return the diagnostics of one gripper.

    Args:
        snapshot: what is commanded, and why.
        stamp: time of the message.
        name: full name of the node.
        hardware_id: name of the gripper; "" before one is loaded.
        internal_errors: exceptions caught since the node started.
        clock_stands_still: the node is active but its simulated clock has stopped.
        commanders: nodes that publish pressure_command, this one included.
        object_problem: why the newest object_pose is not used; empty: nothing is wrong with it.
        object_poses_refused: since activation.
        has_table: whether the table of grips applies at the present gravity.
    """
    fault, state = snapshot.pressure_fault, snapshot.state
    warnings = [snapshot.gravity_fault.text, object_problem]
    if clock_stands_still:
        warnings.append(CLOCK_STANDS_STILL)
    if commanders > 1:
        warnings.append(f"{commanders} nodes publish pressure_command")
    level: bytes = DiagnosticStatus.OK
    if state is State.FAULT or fault:
        level = DiagnosticStatus.ERROR
    elif state in _WARNINGS or any(warnings):
        level = DiagnosticStatus.WARN
    told = snapshot.refusal.text or state.name.lower().replace("_", " ")
    text = "; ".join(filter(None, (told, fault.text, *warnings)))
    values = {
        "state": state.name,
        "reason": snapshot.refusal.reason.name,
        "grasping": state is State.GRASPING,
        "wrapped": snapshot.wrapped,
        "object_radius [m]": snapshot.radius,
        "pressure_target [Pa]": snapshot.pressure_target,
        "pressure_command [Pa]": snapshot.pressure_command,
        "measured_pressure [Pa]": snapshot.measured_pressure,
        "measured_pressure age [s]": snapshot.measured_age,
        "gravity age [s]": snapshot.gravity_age,
        "pressure_command publishers": commanders,
        "pressure fault": fault.reason.name,
        "radii accepted": snapshot.accepted,
        "object poses refused": object_poses_refused,
        "table of grips applies": has_table,
        "internal errors": internal_errors,
    }
    for reason in Reason:
        if snapshot.refused[reason]:
            values[f"refused: {reason.name}"] = snapshot.refused[reason]
    return diagnostic_message(f"{name}: grip", hardware_id, (level, text), values, stamp)


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
