# SPDX-License-Identifier: Apache-2.0
"""The 1 Hz message on /diagnostics (REP-107)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.planning.planner import WrapPlan

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
    """

    name: str
    hardware_id: str
    internal_errors: int
    clock_stands_still: bool = False
    commanders: int = 1
    object_problem: str = ""
    object_poses_refused: int = 0


def diagnostics_to_msg(
    health: Health,
    snapshot: Snapshot[WrapPlan],
    stamp: Any,  # noqa: ANN401
) -> DiagnosticArray:
    """Return the diagnostics of one gripper.

    Args:
        health: what is known of the node.
        snapshot: what is commanded, and why.
        stamp: time of the message.
    """
    status = (_level(health, snapshot), _summary(health, snapshot))
    values = dict(_values(health, snapshot))
    return diagnostic_message(f"{health.name}: grip", health.hardware_id, status, values, stamp)


def diagnostic_message(
    name: str,
    hardware_id: str,
    status: tuple[bytes, str],
    values: Mapping[str, str],
    stamp: Any,  # noqa: ANN401
) -> DiagnosticArray:
    """Return the message of one status: its level with its text, and figures by their names."""
    level, text = status
    pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
    told = DiagnosticStatus(
        level=level, name=name, message=text, hardware_id=hardware_id, values=pairs
    )
    message = DiagnosticArray(status=[told])
    message.header.stamp = stamp
    return message


def _level(health: Health, snapshot: Snapshot[WrapPlan]) -> bytes:
    """Return the worst of what there is to tell; the levels are single bytes, in order."""
    levels: list[bytes] = [_LEVELS[snapshot.state]]
    if snapshot.pressure_fault.reason is not Reason.NONE:
        levels.append(DiagnosticStatus.ERROR)
    if _warnings(health, snapshot):
        levels.append(DiagnosticStatus.WARN)
    return max(levels)


def _summary(health: Health, snapshot: Snapshot[WrapPlan]) -> str:
    texts = [
        snapshot.refusal.text or snapshot.state.name.lower().replace("_", " "),
        snapshot.pressure_fault.text,
        *_warnings(health, snapshot),
    ]
    return "; ".join(text for text in texts if text)


def _warnings(health: Health, snapshot: Snapshot[WrapPlan]) -> list[str]:
    texts = [snapshot.gravity_fault.text, health.object_problem]
    if health.clock_stands_still:
        texts.append(CLOCK_STANDS_STILL)
    if health.commanders > 1:
        texts.append(f"{health.commanders} nodes publish pressure_command")
    return [text for text in texts if text]


def _values(health: Health, snapshot: Snapshot[WrapPlan]) -> list[tuple[str, str]]:
    measured = snapshot.measured
    values = [
        ("state", snapshot.state.name),
        ("reason", snapshot.refusal.reason.name),
        ("grasping", str(snapshot.state is State.GRASPING)),
        ("wrapped", str(snapshot.wrapped)),
        ("object_radius [m]", _figure(snapshot.radius)),
        ("pressure_target [Pa]", _figure(snapshot.pressure_target)),
        ("pressure_command [Pa]", _figure(snapshot.pressure_command)),
        ("measured_pressure [Pa]", _figure(None if measured is None else measured.pressure)),
        ("measured_pressure age [s]", _figure(None if measured is None else measured.age)),
        ("gravity age [s]", _figure(snapshot.gravity_age)),
        ("pressure_command publishers", str(health.commanders)),
        ("pressure fault", snapshot.pressure_fault.reason.name),
        ("radii accepted", str(snapshot.accepted)),
        ("object poses refused", str(health.object_poses_refused)),
        ("internal errors", str(health.internal_errors)),
    ]
    refused = [
        (f"refused: {reason.name}", str(snapshot.refused[reason]))
        for reason in Reason
        if snapshot.refused[reason]
    ]
    return values + refused


def _figure(value: float | None) -> str:
    """Return a number for people; "" if it is not known."""
    return "" if value is None else f"{value:.6g}"
