"""The 1 Hz message on /diagnostics (REP-107)."""

from __future__ import annotations

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from spiral_gripper_ros.planner import WrapPlan
from spiral_gripper_ros.states import Reason, State
from spiral_gripper_ros.supervisor import Snapshot

_LEVELS = {
    State.INACTIVE: DiagnosticStatus.OK,
    State.WAITING: DiagnosticStatus.OK,
    State.TRACKING: DiagnosticStatus.OK,
    State.HOLDING: DiagnosticStatus.WARN,
    State.RAMPING_DOWN: DiagnosticStatus.WARN,
    State.VENTED: DiagnosticStatus.WARN,
    State.RELEASED: DiagnosticStatus.OK,
    State.FAULT: DiagnosticStatus.ERROR,
}


def diagnostics_to_msg(
    name: str,
    hardware_id: str,
    snapshot: Snapshot[WrapPlan],
    internal_errors: int,
    stamp: Any,  # noqa: ANN401
) -> DiagnosticArray:
    """Return the diagnostics of one gripper.

    Args:
        name: full name of the node.
        hardware_id: name of the gripper; "" before one is loaded.
        snapshot: what the supervisor does.
        internal_errors: exceptions caught since the node started.
        stamp: time of the message.
    """
    status = DiagnosticStatus(
        level=_LEVELS[snapshot.state],
        name=f"{name}: grip",
        message=snapshot.refusal.text or snapshot.state.name.lower().replace("_", " "),
        hardware_id=hardware_id,
        values=[
            KeyValue(key=key, value=value) for key, value in _values(snapshot, internal_errors)
        ],
    )
    message = DiagnosticArray(status=[status])
    message.header.stamp = stamp
    return message


def _values(snapshot: Snapshot[WrapPlan], internal_errors: int) -> list[tuple[str, str]]:
    values = [
        ("state", snapshot.state.name),
        ("reason", snapshot.refusal.reason.name),
        ("object_radius [m]", "" if snapshot.radius is None else f"{snapshot.radius:.6g}"),
        ("pressure_target [Pa]", f"{snapshot.pressure_target:.6g}"),
        ("pressure_command [Pa]", f"{snapshot.pressure_command:.6g}"),
        ("radii accepted", str(snapshot.accepted)),
        ("internal errors", str(internal_errors)),
    ]
    refused = [
        (f"refused: {reason.name}", str(snapshot.refused[reason]))
        for reason in Reason
        if snapshot.refused[reason]
    ]
    return values + refused
