# SPDX-License-Identifier: Apache-2.0
"""Grips that are computed on request."""

import pytest
from ros.harness import DESIGN_DEADLINE, all_finite

from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper_ros.messages.conversions import pose_along, vector_from_msg


@pytest.mark.slow
def test_plan_wrap_computes_the_grip_if_it_is_asked_for(active):
    def grip_of(**fields):
        """Ask patiently: the first may have to compile."""
        return active.plan_wrap(0.011, DESIGN_DEADLINE, compute_grip=True, **fields)

    laid = grip_of(overpressure=8.0e3)
    assert all_finite(laid)
    (grip,) = laid.grip
    assert grip.holding_force_away > grip.holding_force_towards > 0.0
    # Put where the free coil would wrap it, given as a pose, it is held alike.
    line = map(vector_from_msg, (laid.object_center[0], laid.object_axis[0]))
    pose = pose_along(ObjectPlacement(*line, 0.011, 0.1, 0.0))
    (placed,) = grip_of(overpressure=8.0e3, pose=[pose]).grip
    assert (grip.at_pose, placed.at_pose) == (False, True)
    assert placed.normal_force == pytest.approx(grip.normal_force, rel=0.2)
