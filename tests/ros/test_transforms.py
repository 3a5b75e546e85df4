# SPDX-License-Identifier: Apache-2.0
"""Gravity and poses from other frames of the robot: by a stand-in, for tf2_ros is not on PyPI."""

import math
import sys
from unittest.mock import Mock

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, TransformStamped, Vector3
from rclpy.duration import Duration
from rclpy.time import Time
from ros.harness import deliver, tick
from ros.local_nodes import change, offer, parameters
from scipy.spatial.transform import Rotation

from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.control.timing import LONGEST_DISCOVERY
from spiral_gripper_ros.node.gripper_node import GripperNode
from spiral_gripper_ros.node.inputs import GRAVITY_PERIOD

TURN, TILT = Rotation.from_euler("xyz", [(20, -70, 130), (-60, 20, 10)], degrees=True)


@pytest.fixture
def frames(monkeypatch):
    """The stand-in, and the transforms that it knows by source and target."""
    tf2 = Mock(TransformException=KeyError, known={})
    tf2.Buffer().lookup_transform.side_effect = lambda *pair_and_time: tf2.known[pair_and_time[:2]]
    monkeypatch.setitem(sys.modules, "tf2_ros", tf2)
    return tf2


def turned(message, rotation):
    """Write a rotation, scaled if it is a quaternion, into a message."""
    quaternion = rotation.as_quat() if isinstance(rotation, Rotation) else rotation
    message.x, message.y, message.z, message.w = map(float, quaternion)


def transform(rotation):
    message = TransformStamped()
    turned(message.transform.rotation, rotation)
    return message


@pytest.fixture
def tilting(namespace):
    """A node in this process that reads gravity from the frames of its robot."""
    given = parameters(gravity__frame="world", grip__ratio=1.0, grip__contact=False)
    node = GripperNode(namespace=namespace, parameter_overrides=given)
    node.runtime.outputs.publish_pressure = lambda pressure: None
    yield node
    node.vent()
    node.destroy_node()


def test_gravity_is_as_old_as_its_transform_and_a_missing_one_is_a_refusal(frames, tilting):
    assert tilting.start()  # the robot's frames may come later
    assert not any(one.topic_name.endswith("/gravity") for one in tilting.subscriptions)

    def look():
        """Have the node look for gravity, as its timer does; return what it sees."""
        period = round(1e9 * GRAVITY_PERIOD)
        (timer,) = [one for one in tilting.timers if one.timer_period_ns == period]
        timer.callback()
        return tilting.runtime.control.snapshot()

    refusal = look().refusal
    assert refusal.reason is Reason.GRAVITY_INVALID
    assert "'world' to 'gripper_base'" in refusal.text
    old = frames.known["gripper_base", "world"] = transform(TURN)
    old.header.stamp = (tilting.get_clock().now() - Duration(seconds=2)).to_msg()
    assert look().gravity_age == pytest.approx(2.0, abs=1.0)
    up = pytest.approx(tuple(TURN.apply((0, 0, -9.80665))), abs=1e-9)  # its z axis
    for bad in (math.nan, math.inf, 0.0, 1.01):
        frames.known["gripper_base", "world"] = transform((0.0, 0.0, 0.0, bad))
        assert "no rigid motion" in look().refusal.text
        assert tilting.runtime.gravity == up
    # Where the base is does not matter: it may be on a map, far from its origin.
    frames.known["gripper_base", "world"] = transform(TILT)
    frames.known["gripper_base", "world"].transform.translation.y = 5.4e6
    look()
    tilted = tuple(TILT.apply((0, 0, -9.80665)))
    assert tilting.runtime.gravity == pytest.approx(tilted, abs=1e-9)
    assert tilting.trigger_deactivate() == tilting.trigger_cleanup()
    frames.TransformListener().unregister.assert_called_once_with()


def test_a_frame_that_no_transform_ever_leads_to_is_a_fault(frames, tilting):
    change(tilting, gravity__timeout=1.0, gravity__timeout_policy="vent", radius__timeout=600.0)
    time = 100.0
    tilting.runtime.now = lambda: time
    assert tilting.start()

    def wait(duration):
        """Follow a radius for a while, and return what is seen then."""
        nonlocal time
        for _ in range(round(duration / 0.1)):
            time += 0.1
            offer(tilting)
            tick(tilting)
        return tilting.runtime.control.snapshot()

    for activation in range(2):
        if activation:
            assert tilting.trigger_deactivate() == tilting.trigger_activate()
        seen = wait(LONGEST_DISCOVERY - 0.2)  # a transform that is there may be found so late
        assert seen.gravity_fault.reason is Reason.NONE
        assert seen.pressure_command > 0.0
        seen = wait(0.4)
        assert seen.gravity_fault.reason is seen.refusal.reason is Reason.GRAVITY_STALE
        assert "since the activation" in seen.gravity_fault.text
        assert seen.gravity_age is None
        assert (seen.state, seen.pressure_command) == (State.FAULT, 0.0)
        time += 3600.0
    frames.known["gripper_base", "world"] = transform(TURN)
    assert wait(0.2).gravity_fault.reason is Reason.NONE
    change(tilting, gravity__vector=[0.0, 0.0, -9.8])
    frames.known.clear()
    assert wait(10.0).gravity_fault.reason is Reason.NONE  # it is that of the parameter


def test_a_pose_in_another_frame_is_taken_at_its_time(frames, node):
    message = PoseStamped()
    message.header.frame_id = "camera"
    message.header.stamp = node.get_clock().now().to_msg()
    message.pose.position.x = 0.25
    turned(message.pose.orientation, TILT)
    deliver(node, "object_pose", message)
    assert "no transform from 'camera'" in node.runtime.objects.problem
    assert node.runtime.seen_object() is None
    center = TURN.apply((0.25, 0, 0)) + np.array((0.1, 0.2, 0.3))
    expected = pytest.approx((*center, *(TURN * TILT).apply((0, 0, 1))), abs=1e-12)
    # As far off as a quaternion may be.
    known = frames.known["gripper_base", "camera"] = transform(1.0009 * TURN.as_quat())
    known.transform.translation = Vector3(x=0.1, y=0.2, z=0.3)
    deliver(node, "object_pose", message)
    seen = node.runtime.seen_object()
    assert (*seen.center, *seen.axis) == expected
    asked_for = frames.Buffer().lookup_transform.call_args.args[2]
    assert asked_for == Time.from_msg(message.header.stamp)
    message.header.stamp.sec = -1
    deliver(node, "object_pose", message)
    assert "negative" in node.runtime.objects.problem
    assert node.runtime.errors.count == 0


def test_without_tf2_ros_such_a_node_is_not_configured(tilting, capfd):
    assert not tilting.start()
    assert not [*tilting.subscriptions]  # none is left behind
    assert "other frames need tf2_ros, which cannot be used" in capfd.readouterr().err
