# SPDX-License-Identifier: Apache-2.0
"""Packing and unpacking of messages; nothing is decided here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, PoseArray, Quaternion, Vector3
from numpy.typing import NDArray
from rclpy.clock import Clock

from spiral_core.grip.curve import GripAnswer, TubeShape
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Vector
from spiral_core.wrap.placement import ObjectPlacement
from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper_msgs.msg import GripStatus, Wrap, WrapFigures
from spiral_gripper_ros.control.plan import WrapPlan
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.planning.object_pose import Quaternion as Turn
from spiral_gripper_ros.planning.object_pose import SeenObject, misplacement, object_line
from spiral_gripper_ros.planning.planner import GripperPlanner

REGIMES = {
    None: GripStatus.REGIME_UNKNOWN,
    WrapRegime.OVERHANG: GripStatus.REGIME_OVERHANG,
    WrapRegime.PERFECT_WRAP: GripStatus.REGIME_PERFECT_WRAP,
    WrapRegime.CURLING: GripStatus.REGIME_CURLING,
}
# Names of a message's regimes, for people.
REGIME_NAMES = {
    number: "-" if regime is None else regime.value for regime, number in REGIMES.items()
}

BASE = "gripper_base"
# What rosidl calls a list of at most one number.
OPTIONAL_NUMBER = "sequence<double, 1>"
_MISSING: Any = object()


def prefix_of(frame_id: str) -> str:
    """Return the prefix of a gripper's links and joints, as in ``urdf/spiral_gripper.xacro``.

    Example:
        >>> prefix_of("left_gripper_base"), prefix_of("gripper_base"), prefix_of("tool0")
        ('left_', '', 'tool0_')
    """
    return frame_id.removesuffix(BASE) if frame_id.endswith(BASE) else f"{frame_id}_"


def opening_joint(frame_id: str) -> str:
    """Return the name of the joint whose position is the diameter that is wrapped."""
    return f"{prefix_of(frame_id)}spiral_gripper_opening"


def vector_from_msg(message: Vector3 | Point) -> Vector:
    """Return the components of a message."""
    return (message.x, message.y, message.z)


def quaternion_from_msg(message: Any) -> Turn:  # noqa: ANN401
    """Return the components of a message."""
    return (message.x, message.y, message.z, message.w)


def line_from_msg(pose: Pose) -> tuple[Vector, Vector]:
    """Return a point of the z axis of a pose [m], and its direction.

    Raises:
        InvalidInputError: it is no pose.
    """
    return object_line(vector_from_msg(pose.position), quaternion_from_msg(pose.orientation))


def stamp_age(stamp: Any, clock: Clock) -> float:  # noqa: ANN401
    """Return the time since a stamp [s]; negative: it is ahead of the clock."""
    # A stamp may be negative, which is no time of rclpy's.
    return 1.0e-9 * float(int(clock.now().nanoseconds) - 10**9 * stamp.sec - stamp.nanosec)


def vector_to_msg(vector: Sequence[float], kind: Any = Vector3) -> Any:  # noqa: ANN401
    """Return the message of three components."""
    x, y, z = vector
    return kind(x=x, y=y, z=z)


def picked_nodes(state: RodState | TubeShape, points: int) -> NDArray[np.intp]:
    """Return the indices of at most ``points`` >= 2 nodes, evenly spread, the ends always."""
    last = len(state.positions) - 1
    return np.linspace(0, last, min(points, last + 1)).round().astype(np.intp)


def backbone_to_msg(state: RodState | TubeShape, points: int, header: Any) -> PoseArray:  # noqa: ANN401
    """Return a rod's shape as poses from base to tip.

    Args:
        state: the shape; its material frame is the pose's frame as it is.
        points: largest number of poses, >= 2; nodes are picked evenly, the ends always.
        header: stamp and frame of the message.
    """
    picked = picked_nodes(state, points)
    positions, orientations = state.positions[picked], state.orientations[picked]
    poses = map(pose_of, positions.tolist(), orientations.tolist())
    return PoseArray(header=header, poses=list(poses))


def pose_of(position: Sequence[float], quaternion: Sequence[float]) -> Pose:
    """Return the pose of a position and an orientation, scalar last."""
    x, y, z, w = quaternion
    return Pose(position=vector_to_msg(position, Point), orientation=Quaternion(x=x, y=y, z=z, w=w))


def pose_along(placement: ObjectPlacement) -> Pose:
    """Return the pose of an object: its center, z along its axis."""
    ax, ay, az = placement.axis
    # The shortest turn from z to the axis; half a turn about x if it points the other way.
    quaternion = np.array((-ay, ax, 0.0, 1.0 + az))
    size = float(np.linalg.norm(quaternion))
    turn = (quaternion / size).tolist() if size > 1e-9 else (1.0, 0.0, 0.0, 0.0)
    return pose_of(placement.center, turn)


def known(values: Sequence[float]) -> float | None:
    """Return the number of a list of at most one, or None.

    Example:
        >>> known([0.02]), known([])
        (0.02, None)
    """
    return values[0] if len(values) else None


def optional(value: float | None) -> list[float]:
    """Return the list of at most one number that tells of a value in a message of this node.

    What is no finite number is not known. A request is not made so: what was asked for with it
    would count as not given, where it is to be refused.

    Example:
        >>> optional(0.02), optional(None), optional(math.inf)
        ([0.02], [], [])
    """
    return [] if value is None or not math.isfinite(value) else [value]


def filled(message: Any, /, *sources: Any, **values: Any) -> Any:  # noqa: ANN401
    """Return a message with values in its fields, or what a source has by a field's name.

    The first source that has it counts; a field that nobody has stays as it is. Fields of at most
    one number are made by :func:`optional`.

    Example:
        >>> filled(Point(y=1.0), Vector3(x=2.0, y=3.0), y=4.0)
        geometry_msgs.msg.Point(x=2.0, y=4.0, z=0.0)
    """
    for name, kind in message.get_fields_and_field_types().items():
        value = values.get(name, _MISSING)
        for source in sources:
            value = getattr(source, name, _MISSING) if value is _MISSING else value
        if value is not _MISSING:
            setattr(message, name, optional(value) if kind == OPTIONAL_NUMBER else value)
    return message


def status_to_msg(
    snapshot: Snapshot,
    loaded: LoadedGripper,
    header: Any,  # noqa: ANN401
) -> GripStatus:
    """Return the status message.

    Args:
        snapshot: what is commanded, and why.
        loaded: the gripper, with its shapes up to date.
        header: stamp and frame of the message.
    """
    return filled(
        GripStatus(),
        snapshot,
        header=header,
        reason=snapshot.refusal.reason,
        reason_text=snapshot.refusal.text,
        fault=snapshot.fault.reason,
        fault_text=snapshot.fault.text,
        object_radius=snapshot.radius,
        regime=REGIMES[loaded.shown_regime(snapshot)],
    )


def wrap_to_msg(
    snapshot: Snapshot,
    loaded: LoadedGripper,
    pressure_cap: float,
    grip: GripAnswer | None,
    seen: SeenObject | None,
    now: float,
    header: Any,  # noqa: ANN401
) -> Wrap:
    """Return what is planned; the grip is still to be filled in.

    Args:
        snapshot: what is commanded, and why.
        loaded: the gripper.
        pressure_cap: largest pressure that is ever commanded [Pa].
        grip: of the object; None: it is not known.
        seen: where the object is, if it is seen.
        now: time of the clock that it was seen by [s].
        header: stamp and frame of the message.
    """
    message = Wrap(header=header, regime_from_contact=loaded.is_regime_from_contact)
    if seen is not None:
        message.object_pose_age, expected = [now - seen.seen_at], snapshot.placement
        if expected is not None:
            offset, tilt = misplacement(seen, expected)
            message.object_offset, message.object_tilt = [offset], [tilt]
    lowest, highest = loaded.planner.held_range
    if math.isfinite(highest):
        message.radius_range = [lowest, highest]
    plan, target = snapshot.plan, snapshot.pressure_target
    # On the way down, or where a lower pressure is held, the wrap is not aimed for any more.
    if plan is not None and target >= plan.pressure:
        message.plan = [figures_to_msg(plan, target, loaded.planner, pressure_cap, grip)]
    return message


def figures_to_msg(
    plan: WrapPlan,
    pressure: float,
    planner: GripperPlanner,
    pressure_cap: float,
    grip: GripAnswer | None,
) -> WrapFigures:
    """Return the figures of a planned wrap at a pressure.

    Args:
        plan: the wrap.
        pressure: at which it is held [Pa].
        planner: for the gripper.
        pressure_cap: largest pressure that is ever commanded [Pa].
        grip: what holds it; None: it is not known.
    """
    (lowest, highest), radius = planner.held_range, plan.wrap.object_radius
    contact = (plan.wrap if grip is None else grip).contact_length
    return filled(
        WrapFigures(),
        plan,
        plan.wrap,
        pressure=pressure,
        overpressure=pressure - plan.pressure,
        contact_length=contact,
        line_force=plan.line_force(pressure),
        stable=plan.wrap.state.stable,
        radius_margin=min(radius - lowest, highest - radius),
        pressure_margin=pressure_cap - pressure,
    )
