# SPDX-License-Identifier: Apache-2.0
"""The message of a grip."""

from __future__ import annotations

import math
from collections.abc import Sequence

from spiral_core.grip.curve import GripAnswer
from spiral_gripper_msgs.msg import Grip
from spiral_gripper_ros.messages.conversions import filled


def grip_to_msg(
    answer: GripAnswer | None, now: float, payload: float | None, gravity: Sequence[float]
) -> list[Grip]:
    """Return the message of a grip as a list of one; an empty one if it is not known.

    Args:
        answer: the grip, or None.
        now: time [s] of the clock that the grip's age is counted with.
        payload: mass of the object [kg]; None or NaN: it is not known.
        gravity: in the base frame [m/s^2].
    """
    if answer is None:
        return []
    strength = math.hypot(*gravity)
    down = answer.down if strength > 0.0 else None
    margin = None if down is None or payload is None else down - payload * strength
    message = filled(
        Grip(),
        answer,
        age=max(now - answer.computed_at, 0.0),
        friction_coefficient=answer.friction,
        holding_force_away=answer.away,
        holding_force_towards=answer.towards,
        holding_force_down=down,
        settling_time=answer.settling,
        payload_margin=margin,
    )
    return [message]
