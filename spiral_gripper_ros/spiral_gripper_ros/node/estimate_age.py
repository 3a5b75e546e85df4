# SPDX-License-Identifier: Apache-2.0
"""The check of the age of an ``object_radius_stamped``. No ROS."""

from __future__ import annotations

import math
from typing import Final

from spiral_gripper_ros.control.states import Reason, Refusal

STAMPED_RADIUS: Final = "object_radius_stamped"


def stale_estimate(age: float, limit: float) -> Refusal | None:
    """Return why an estimate of an age [s] is not followed, or None if it is young enough.

    Example:
        >>> stale_estimate(0.7, 0.5).text
        'object_radius_stamped is 0.7 s old, more than radius_age_limit = 0.5 s'
        >>> stale_estimate(0.1, 0.5) is None
        True
    """
    if math.isfinite(age) and abs(age) <= limit:
        return None
    how = f"{age:.3g} s old" if age > 0.0 else f"{-age:.3g} s ahead of this clock"
    text = f"{STAMPED_RADIUS} is {how}, more than radius_age_limit = {limit:g} s"
    return Refusal(Reason.RADIUS_STALE, text)
