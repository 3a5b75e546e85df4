# SPDX-License-Identifier: Apache-2.0
"""How far an object is off the place where a wrap expects it."""

import math

import pytest

from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper_ros.planning.object_pose import (
    SeenObject,
    misplacement,
)


def test_the_misplacement_is_that_of_two_lines():
    seen = SeenObject((0.105, 0.2, 0.3), (0.0, -math.sin(3.0), math.cos(3.0)), 0.0)
    place = ObjectPlacement((0.1, 0.2, 0.3), (0.0, 0.0, 1.0), 0.02, 0.1, 0.0)
    assert misplacement(seen, place) == pytest.approx((0.005, math.pi - 3.0), rel=1e-9)
