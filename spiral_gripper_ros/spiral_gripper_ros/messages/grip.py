# SPDX-License-Identifier: Apache-2.0
"""The message of a grip."""

from __future__ import annotations

import math

from spiral_core.rod.types import Vector
from spiral_gripper_msgs.msg import Grip
from spiral_gripper_ros.planning.grip_table import GripAnswer


def grip_to_msg(
    answer: GripAnswer | None, now: float, payload: float | None, gravity: Vector
) -> list[Grip]:
    """Return the message of a grip as a list of one; an empty one if it is not known.

    Args:
        answer: the grip, or None.
        now: time [s] of the clock that the grip's age is counted with.
        payload: mass of the object [kg], or None if it is not known.
        gravity: in the base frame [m/s^2].
    """
    if answer is None:
        return []
    strength = math.hypot(*gravity)
    down = [answer.down] if strength > 0.0 else []
    message = Grip(
        at_pose=answer.at_pose,
        age=max(now - answer.computed_at, 0.0),
        friction_coefficient=answer.friction,
        onset_wrap=answer.onset_wrap,
        onset_curling=_finite(answer.onset_curling),
        loss=_finite(answer.loss),
        contact_length=answer.contact_length,
        normal_force=answer.normal_force,
        holding_force_away=answer.away,
        holding_force_towards=answer.towards,
        holding_force_down=down,
        settling_time=_finite(answer.settling),
        payload_margin=[] if payload is None else [held - payload * strength for held in down],
    )
    return [message]


def _finite(value: float) -> list[float]:
    return [value] if math.isfinite(value) else []
