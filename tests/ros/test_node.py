# SPDX-License-Identifier: Apache-2.0
"""The node as a process of its own: what a client sees of its topics, services and life cycle."""

import pytest
from geometry_msgs.msg import Vector3, Vector3Stamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros.harness import RunningNode

from spiral_core import WrapCurve
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.messages.conversions import vector_from_msg

RADIUS = 0.02
UPRIGHT = (0.0, 0.0, -9.80665)


def test_a_radius_becomes_the_pressure_and_the_shape_of_its_wrap(active, curve):
    wrap = curve.wrap_for_radius(RADIUS)
    status = active.wrap(RADIUS)
    assert status.pressure_command == pytest.approx(wrap.pressure, rel=1e-9)
    assert status.regime == GripStatus.REGIME_PERFECT_WRAP
    told = active.wait_for_plan(RADIUS, status.pressure_target)
    assert told.plan[0].stable
    tip = pytest.approx(wrap.state.tip_position, abs=1e-6)
    active.wait_until(
        lambda: (
            active.backbones and vector_from_msg(active.backbones[-1].poses[-1].position) == tip
        ),
        "the backbone of the wrap",
    )
    assert len(active.backbones[-1].poses) == 50
    for header in (status.header, told.header, active.backbones[-1].header):
        assert header.frame_id == "gripper_base"
        assert header.stamp.sec > 0
    active.wraps.clear()
    active.hear_more(20)
    assert not active.wraps  # it is told when it changes


def test_gravity_is_solved_anew_and_moves_the_pressure(active, gripper):
    hanging = active.wrap(RADIUS).pressure_command
    expected = WrapCurve(gripper.with_mount(UPRIGHT, None)).pressure_from_radius(RADIUS)
    assert abs(expected - hanging) > 100.0

    def wait_for(pressure):
        wanted = pytest.approx(pressure, rel=1e-9)
        active.wait_until(lambda: active.wrap(RADIUS).pressure_command == wanted, "its pressure")

    active.send_gravity(UPRIGHT)
    wait_for(expected)
    active.change("gravity.vector", [9.80665, 0.0, 0.0])
    wait_for(hanging)


# Where a subscription is incompatible, as the node's other one is, rclpy of Kilted calls a method
# of its own that is deprecated.
@pytest.mark.filterwarnings("ignore:Deprecated in favor of:DeprecationWarning")
def test_gravity_that_was_published_once_before_the_node_started_is_heard(client, namespace):
    gravity = Vector3Stamped(vector=Vector3(z=-9.80665))
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    client.create_publisher(Vector3Stamped, "gravity", latched).publish(gravity)
    with RunningNode(namespace):
        client.wait_until_active()

        def pressure(*given):
            return client.plan_wrap(RADIUS, gravity=given).figures[0].pressure

        expected = pressure(gravity.vector)
        assert abs(expected - pressure(Vector3(x=9.80665))) > 100.0
        wanted = pytest.approx(expected, rel=1e-9)
        client.wait_until(lambda: pressure() == wanted, "its plan")
