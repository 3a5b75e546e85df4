"""Packing and unpacking of messages; nothing is decided here."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, PoseArray, Quaternion, Vector3

from spiral_core.rod import RodState, Vector
from spiral_core.wrap import WrapRegime
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.planner import CommandedShape, WrapPlan
from spiral_gripper_ros.supervisor import Snapshot

REGIMES = {
    None: GripStatus.REGIME_UNKNOWN,
    WrapRegime.OVERHANG: GripStatus.REGIME_OVERHANG,
    WrapRegime.PERFECT_WRAP: GripStatus.REGIME_PERFECT_WRAP,
    WrapRegime.CURLING: GripStatus.REGIME_CURLING,
}


def vector_from_msg(message: Vector3) -> Vector:
    """Return the components of a message."""
    return (message.x, message.y, message.z)


def vector_to_msg(vector: Sequence[float]) -> Vector3:
    """Return the message of three components."""
    x, y, z = vector
    return Vector3(x=x, y=y, z=z)


def backbone_to_msg(state: RodState, points: int, header: Any) -> PoseArray:  # noqa: ANN401
    """Return a rod's shape as poses from base to tip.

    Args:
        state: the shape; its material frame is the pose's frame as it is.
        points: largest number of poses, >= 2; nodes are picked evenly, the ends always.
        header: stamp and frame of the message.
    """
    last = len(state.positions) - 1
    picked = np.unique(np.linspace(0, last, min(points, last + 1)).round().astype(int))
    positions = state.positions[picked].tolist()
    orientations = state.orientations[picked].tolist()
    poses = [
        Pose(
            position=Point(x=p[0], y=p[1], z=p[2]),
            orientation=Quaternion(x=q[0], y=q[1], z=q[2], w=q[3]),
        )
        for p, q in zip(positions, orientations, strict=True)
    ]
    return PoseArray(header=header, poses=poses)


def status_to_msg(
    snapshot: Snapshot[WrapPlan],
    shape: CommandedShape | None,
    radius_range: tuple[float, float],
    pressure_cap: float,
    header: Any,  # noqa: ANN401
) -> GripStatus:
    """Return the status message; what is not known is 0, so that every number is finite."""
    message = GripStatus(
        header=header,
        state=int(snapshot.state),
        reason=int(snapshot.refusal.reason),
        reason_text=snapshot.refusal.text,
        radius_age=snapshot.radius_age or 0.0,
        pressure_target=snapshot.pressure_target,
        pressure_command=snapshot.pressure_command,
        radii_accepted=snapshot.accepted,
        radii_refused=snapshot.refused.total(),
    )
    if np.isfinite(radius_range[1]):
        message.radius_min, message.radius_max = radius_range
    if shape is not None:
        message.regime = REGIMES[shape.regime]
        message.tip.x, message.tip.y, message.tip.z = shape.state.tip_position.tolist()
    if snapshot.plan is not None and snapshot.radius is not None:
        _fill_plan(message, snapshot.plan, snapshot.radius)
        message.pressure_margin = pressure_cap - snapshot.plan.pressure
    return message


def _fill_plan(message: GripStatus, plan: WrapPlan, radius: float) -> None:
    """Write the figures of the wrap that is aimed for."""
    wrap = plan.wrap
    message.object_radius = radius
    message.valid = wrap.state.stable
    message.turns = wrap.turns
    message.contact_length = wrap.contact_length
    message.free_length_needed = wrap.free_length_needed or 0.0
    message.object_length_needed = wrap.object_length_needed or 0.0
    message.line_force = plan.line_force
    message.turns_margin = plan.turns_margin
    message.solve_time = plan.solve_time
    if message.radius_max > 0.0:
        message.radius_margin = min(radius - message.radius_min, message.radius_max - radius)
