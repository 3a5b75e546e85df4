# SPDX-License-Identifier: Apache-2.0
"""What ties the gripper to a robot: estimates with their time, the joint, the object's pose."""

import math
import sys
from types import ModuleType

import pytest
from geometry_msgs.msg import PoseStamped
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper_ros.control.radius_gate import stale_estimate
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.conversions import pose_along, prefix_of
from spiral_gripper_ros.node.robot_state import RobotState

RADIUS = 0.02


# --- estimates with their time -----------------------------------------------------------------


@pytest.mark.parametrize("age", [0.5, -0.5, 0.0, 5e-324])
def test_an_age_within_the_limit_is_young_enough(age):
    assert stale_estimate(age, 0.5) is None


@pytest.mark.parametrize("age", [0.5000001, -0.5000001, 1e9, math.nan, math.inf, -math.inf])
def test_any_other_age_is_refused(age):
    refusal = stale_estimate(age, 0.5)
    assert refusal.reason is Reason.RADIUS_STALE
    assert "radius.age_limit" in refusal.text


def test_a_fresh_estimate_is_followed(active):
    active.wait_until(
        lambda: (
            active.send_stamped_radius(RADIUS),
            list(active.status.object_radius) == [RADIUS] and active.status.state == State.TRACKING,
        )[1],
        "the radius",
    )


@pytest.mark.parametrize(("age", "how"), [(60.0, "s old"), (-60.0, "s ahead of this clock")])
def test_an_estimate_that_is_too_old_or_ahead_of_the_clock_is_refused(active, age, how):
    active.wrap(RADIUS)
    pressure = active.pressures[-1]
    active.wait_until(
        lambda: (
            active.send_stamped_radius(0.03, age),
            active.status.reason == Reason.RADIUS_STALE,
        )[1],
        "the refusal",
    )
    assert how in active.status.reason_text
    assert list(active.status.object_radius) == [RADIUS]
    assert active.pressures[-1] == pressure


# --- the rest of the robot ---------------------------------------------------------------------


@pytest.mark.parametrize(
    "axis",
    [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -1, 0), (0.6, 0.0, -0.8), (1e-9, 0, -1)],
)
def test_the_objects_z_is_its_axis(axis):
    size = math.hypot(*axis)
    pose = pose_along(
        ObjectPlacement((0.1, 0.2, 0.3), tuple(a / size for a in axis), RADIUS, 0.1, 0.0)
    )
    q = pose.orientation
    z = (2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x), 1 - 2 * (q.x**2 + q.y**2))
    assert z == pytest.approx(tuple(a / size for a in axis), abs=1e-6)
    assert math.hypot(q.x, q.y, q.z, q.w) == pytest.approx(1.0)
    assert (pose.position.x, pose.position.y, pose.position.z) == (0.1, 0.2, 0.3)


def test_joint_and_object_are_told_while_the_rate_is_above_0(active):
    joints, poses = [], []
    subscriptions = [
        active.create_subscription(JointState, "joint_states", joints.append, QoSProfile(depth=10)),
        active.create_subscription(
            PoseStamped, "wrapped_object_pose", poses.append, QoSProfile(depth=10)
        ),
    ]
    active.hear_more(5)
    assert not joints
    assert active.set_parameter("publish.robot_state_rate", 50.0).successful
    active.wait_until(lambda: joints, "the joint")
    assert list(joints[-1].name) == ["spiral_gripper_opening"]
    assert list(joints[-1].position) == [0.1]  # open
    assert not poses
    active.wrap(RADIUS)
    active.wait_until(
        lambda: poses and joints[-1].position[0] == pytest.approx(2 * RADIUS, rel=1e-3), "the wrap"
    )
    assert poses[-1].header.frame_id == "gripper_base"
    active.release()
    active.wait_until(lambda: joints[-1].position[0] == 0.1, "the opening")
    assert active.set_parameter("publish.robot_state_rate", 0.0).successful
    active.spin(0.3)
    joints.clear()
    active.hear_more(10)
    assert not joints
    for subscription in subscriptions:
        active.destroy_subscription(subscription)


def test_frames_of_tip_and_object_are_those_of_the_shape(node, monkeypatch):
    """tf2_msgs is not on PyPI: a stand-in, and publishers that keep what they are given."""
    module, sent = ModuleType("tf2_msgs.msg"), []

    class TFMessage:
        def __init__(self, transforms):
            self.transforms = transforms

    module.TFMessage = TFMessage
    monkeypatch.setitem(sys.modules, "tf2_msgs", ModuleType("tf2_msgs"))
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", module)

    class Publisher:
        publish = staticmethod(sent.append)

    monkeypatch.setattr(node, "create_publisher", lambda *arguments: Publisher)
    state = RobotState(node, node.runtime)
    node.runtime.control.offer_radius(node.runtime.now(), RADIUS, node.runtime.loaded.planner)
    node.runtime.publish()
    state._connect()
    state.tell()
    (message,) = [one for one in sent if isinstance(one, TFMessage)]
    frames = {one.child_frame_id: one for one in message.transforms}
    assert frames.keys() == {"gripper_tip", "gripper_object"}
    tip = frames["gripper_tip"]
    place = (tip.transform.translation.x, tip.transform.translation.y, tip.transform.translation.z)
    assert place == pytest.approx(tuple(node.runtime.loaded.shape.state.tip_position))
    assert tip.header.frame_id == "gripper_base"
    assert node.runtime.errors.count == 0


def test_what_goes_wrong_while_telling_does_not_vent(node, monkeypatch):
    state = RobotState(node, node.runtime)
    monkeypatch.setattr(state, "_publishers", {})  # a KeyError
    node.runtime.control.offer_radius(node.runtime.now(), RADIUS, node.runtime.loaded.planner)
    state.tell()
    assert node.runtime.errors.count == 1
    assert node.runtime.control.snapshot().state is State.TRACKING


def test_prefixes_are_those_of_the_links():
    assert prefix_of("left_gripper_base") == "left_"
    assert (prefix_of("gripper_base"), prefix_of("tool0")) == ("", "tool0_")
