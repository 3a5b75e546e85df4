# SPDX-License-Identifier: Apache-2.0
"""Grips that are computed on request."""

import math

import pytest
from geometry_msgs.msg import Point, Pose, Quaternion
from ros.harness import DESIGN_DEADLINE, RunningNode, all_finite

from spiral_gripper_ros.control.states import Reason


def with_grip(client, **fields):
    """Ask for a plan with its grip, patiently: the first may have to compile."""
    return client.plan_wrap(0.011, DESIGN_DEADLINE, compute_grip=True, **fields)


@pytest.mark.slow
def test_plan_wrap_computes_the_grip_if_it_is_asked_for(client, namespace):
    with RunningNode(namespace) as node:
        client.wait_until_active()
        laid = with_grip(client, overpressure=8.0e3, payload=0.02)
        assert laid.success, laid.message
        assert all_finite(laid)
        (grip,) = laid.grip
        assert not grip.at_pose
        assert grip.friction_coefficient == 0.3
        assert grip.holding_force_away > grip.holding_force_towards > 0.0
        weight = 0.02 * 9.80665
        assert grip.payload_margin[0] == pytest.approx(grip.holding_force_down[0] - weight)
        # Put where the free coil would wrap it, given as a pose, it is held alike.
        axis, center = laid.object_axis[0], laid.object_center[0]
        w = math.sqrt(0.5 * (1.0 + axis.z))
        turn = Quaternion(x=-0.5 * axis.y / w, y=0.5 * axis.x / w, w=w)
        pose = Pose(position=Point(x=center.x, y=center.y, z=center.z), orientation=turn)
        placed = with_grip(client, overpressure=8.0e3, pose=[pose])
        assert placed.grip[0].at_pose
        assert placed.grip[0].normal_force == pytest.approx(grip.normal_force, rel=0.2)
        bad = with_grip(client, pose=[Pose(position=Point(x=math.nan))])
        assert bad.reason == Reason.INVALID_REQUEST
        assert node.stop() == 0
        assert "Traceback" not in node.log()
