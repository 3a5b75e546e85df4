# SPDX-License-Identifier: Apache-2.0
"""The message of a grip."""

from __future__ import annotations

import math

from spiral_core.rod.types import Vector
from spiral_gripper_msgs.msg import Grip
from spiral_gripper_ros.planning.grip_table import GripAnswer

# Grip.settling_time and that of a grasp's feedback where it is not known.
UNKNOWN_TIME = -1.0


def grip_to_msg(answer: GripAnswer | None, now: float, payload: float, gravity: Vector) -> Grip:
    """Return the message of a grip; all zeros if it is not known.

    Args:
        answer: the grip, or None.
        now: time [s] of the clock that the grip's age is counted with.
        payload: mass of the object [kg]; 0: not known.
        gravity: in the base frame [m/s^2].
    """
    if answer is None:
        return Grip()
    weight = payload * math.hypot(*gravity)
    return Grip(
        known=True,
        at_pose=answer.at_pose,
        age=max(now - answer.computed_at, 0.0),
        friction_coefficient=answer.friction,
        onset_wrap=answer.onset_wrap,
        onset_curling=_or_zero(answer.onset_curling),
        loss=_or_zero(answer.loss),
        contact_length=answer.contact_length,
        normal_force=answer.normal_force,
        holding_force_away=answer.away,
        holding_force_towards=answer.towards,
        holding_force_down=answer.down,
        settling_time=answer.settling if math.isfinite(answer.settling) else UNKNOWN_TIME,
        payload_margin=answer.down - weight if payload > 0.0 else 0.0,
    )


def _or_zero(pressure: float) -> float:
    return pressure if math.isfinite(pressure) else 0.0
