# SPDX-License-Identifier: Apache-2.0
"""Gravity and poses from other frames of the robot: by a stand-in, for tf2_ros is not on PyPI."""

import math
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, TransformStamped
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from rclpy.time import Time
from ros.conftest import BARE
from ros.harness import deliver
from scipy.spatial.transform import Rotation

from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.node.gripper_node import GripperNode
from spiral_gripper_ros.node.inputs import GRAVITY_PERIOD

UP_FRAME, CAMERA = "world", "camera"


class UnknownError(Exception):
    """What tf2 raises, whatever the reason."""


@pytest.fixture
def frames(monkeypatch):
    """What the stand-in knows: the transform of each frame, and the times it was asked for."""
    known, module = SimpleNamespace(asked=[], listening=0), ModuleType("tf2_ros")

    class Buffer:
        def lookup_transform(self, target, source, time):
            known.asked.append(time)
            if (target, source) not in known.transforms:
                raise UnknownError(f'"{source}" does not exist')
            return known.transforms[target, source]

    class TransformListener:
        def __init__(self, buffer, node):
            known.listening += 1

        def unregister(self):
            known.listening -= 1

    known.transforms = {}
    module.Buffer, module.TransformListener = Buffer, TransformListener
    module.TransformException = UnknownError
    monkeypatch.setitem(sys.modules, "tf2_ros", module)
    return known


def transform(rotation, translation=(0.0, 0.0, 0.0), stamp=None):
    message = TransformStamped()
    turn, shift = message.transform.rotation, message.transform.translation
    turn.x, turn.y, turn.z, turn.w = map(float, rotation.as_quat())
    shift.x, shift.y, shift.z = map(float, translation)
    if stamp is not None:
        message.header.stamp = stamp
    return message


@pytest.fixture
def tilting(namespace, frames):  # noqa: ARG001  # before the node that looks for it
    """A node in this process that reads gravity from the frames of its robot."""
    bare = [Parameter(name, value=value) for name, value in BARE.items()]
    bare.append(Parameter("gravity.frame", value=UP_FRAME))
    node = GripperNode(namespace=namespace, parameter_overrides=bare)
    node.runtime.outputs.publish_pressure = lambda pressure: None
    yield node
    node.vent()
    node.destroy_node()


def look(node):
    """Have the node look for gravity, as its timer does."""
    (timer,) = [one for one in node.timers if one.timer_period_ns == round(1e9 * GRAVITY_PERIOD)]
    timer.callback()


def test_gravity_follows_the_frame_whose_z_axis_points_up(tilting, frames):
    turn = Rotation.from_euler("xyz", (20, -70, 130), degrees=True)
    frames.transforms["gripper_base", UP_FRAME] = transform(turn)
    assert tilting.start()
    assert tilting.runtime.gravity == pytest.approx(tuple(turn.apply((0, 0, -9.80665))), abs=1e-9)
    assert "gravity" not in {one.topic_name.rpartition("/")[2] for one in tilting.subscriptions}
    assert tilting.trigger_deactivate() == tilting.trigger_cleanup()
    assert frames.listening == 0


def test_gravity_is_as_old_as_its_transform_and_a_missing_one_is_a_refusal(tilting, frames):
    assert tilting.start()  # the robot's frames may come later
    look(tilting)
    refusal = tilting.runtime.control.snapshot().refusal
    assert refusal.reason is Reason.GRAVITY_INVALID
    assert "'world' to 'gripper_base'" in refusal.text
    old = (tilting.get_clock().now() - Duration(seconds=2)).to_msg()
    frames.transforms["gripper_base", UP_FRAME] = transform(Rotation.identity(), stamp=old)
    look(tilting)
    assert tilting.runtime.control.snapshot().gravity_age == pytest.approx(2.0, abs=1.0)
    before = tilting.runtime.gravity
    for bad in (math.nan, math.inf, 0.0, 1.01):
        broken = transform(Rotation.identity())
        broken.transform.rotation.w = bad
        frames.transforms["gripper_base", UP_FRAME] = broken
        look(tilting)
        assert tilting.runtime.gravity == before
        assert "no rigid motion" in tilting.runtime.control.snapshot().refusal.text


def test_a_pose_in_another_frame_is_taken_at_its_time(node, frames):
    turn, tilt = (
        Rotation.from_euler("xyz", a, degrees=True) for a in ((30, 40, 50), (-60, 20, 10))
    )
    message = PoseStamped()
    message.header.frame_id = CAMERA
    message.header.stamp = node.get_clock().now().to_msg()
    message.pose.position.x = 0.25
    q = message.pose.orientation
    q.x, q.y, q.z, q.w = map(float, tilt.as_quat())
    deliver(node, "object_pose", message)
    assert "no transform from 'camera'" in node.runtime.objects.problem
    assert node.runtime.seen_object() is None
    known = frames.transforms["gripper_base", CAMERA] = transform(turn, (0.1, 0.2, 0.3))
    expected = (
        *(turn.apply((0.25, 0, 0)) + np.array((0.1, 0.2, 0.3))),
        *(turn * tilt).apply((0, 0, 1)),
    )
    for scale in (1.0, 1.0009):  # as far off as a quaternion may be
        rotation = known.transform.rotation
        rotation.x, rotation.y, rotation.z, rotation.w = map(float, scale * turn.as_quat())
        deliver(node, "object_pose", message)
        seen = node.runtime.seen_object()
        assert (*seen.center, *seen.axis) == pytest.approx(expected, abs=1e-12)
    assert frames.asked[-1] == Time.from_msg(message.header.stamp)
    message.header.stamp.sec = -1
    deliver(node, "object_pose", message)
    assert "negative" in node.runtime.objects.problem
    assert node.runtime.errors.count == 0


def test_without_tf2_ros_such_a_node_is_not_configured(namespace, capfd):
    overrides = [Parameter("gravity.frame", value=UP_FRAME), Parameter("autostart", value=False)]
    node = GripperNode(namespace=namespace, parameter_overrides=overrides)
    assert not node.start()
    assert "other frames need tf2_ros, which cannot be used" in capfd.readouterr().err
    node.destroy_node()
