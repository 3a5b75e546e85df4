# SPDX-License-Identifier: Apache-2.0
"""Grips that are computed on request."""

import math

import pytest
from ros.harness import DESIGN_DEADLINE, all_finite

from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.messages.conversions import pose_along, vector_from_msg


@pytest.mark.slow
def test_plan_wrap_computes_the_grip_if_it_is_asked_for(active):
    def grip_of(**fields):
        """Ask patiently: the first may have to compile."""
        asked = {"compute_grip": True, "overpressure": 8.0e3, "payload": 0.02}
        answer = active.plan_wrap(0.011, DESIGN_DEADLINE, **asked | fields)
        assert all_finite(answer)
        return answer

    laid = grip_of()
    (grip,) = laid.grip
    assert not grip.at_pose
    assert grip.friction_coefficient == 0.3
    assert grip.holding_force_away > grip.holding_force_towards > 0.0
    assert grip.payload_margin
    # Put where the free coil would wrap it, given as a pose, it is held alike.
    line = map(vector_from_msg, (laid.object_center[0], laid.object_axis[0]))
    pose = pose_along(ObjectPlacement(*line, 0.011, 0.1, 0.0))
    (placed,) = grip_of(pose=[pose]).grip
    assert placed.at_pose
    assert placed.normal_force == pytest.approx(grip.normal_force, rel=0.2)
    pose.position.x = math.nan
    assert grip_of(pose=[pose]).reason == Reason.INVALID_REQUEST
