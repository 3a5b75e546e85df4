# SPDX-License-Identifier: Apache-2.0
"""What ties the gripper to a robot: estimates with their time, joint, frames, the object's pose."""

import math
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import KeyValue
from geometry_msgs.msg import PoseStamped, Vector3, Vector3Stamped
from rclpy.parameter import Parameter
from ros.control_bench import rows, value
from ros.harness import deliver, tick

from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper_msgs.msg import ObjectRadius
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.conversions import pose_along, vector_from_msg
from spiral_gripper_ros.planning.object_pose import (
    SeenObject,
    misplacement,
)

CENTER = (0.1, 0.2, 0.3)
RADIUS = 0.02
PLACE = ObjectPlacement(CENTER, (0.0, 0.0, 1.0), RADIUS, 0.1, 0.0)


def test_the_misplacement_is_that_of_two_lines():
    seen = SeenObject((0.105, 0.2, 0.3), (0.0, -math.sin(3.0), math.cos(3.0)), 0.0)
    assert misplacement(seen, PLACE) == pytest.approx((0.005, math.pi - 3.0), rel=1e-9)


def send(node, topic, message, age=0.0, frame_id=""):
    """Deliver a message with this stamp, and let the node look at it."""
    now = node.get_clock().now().nanoseconds - round(1e9 * age)
    message.header.stamp = Time(sec=now // 10**9, nanosec=now % 10**9)
    message.header.frame_id = frame_id
    deliver(node, topic, message)
    tick(node)


REFUSED = """
radius 0.2: RADIUS_TOO_LARGE nearest
radius 0.0201 60: RADIUS_STALE s old
radius 0.0201 -60: RADIUS_STALE s ahead of this clock
radius 0.0201 1.9e9: RADIUS_STALE s old
gravity inf: GRAVITY_INVALID inf
gravity 9.8 0 camera: GRAVITY_INVALID 'camera'
"""


@pytest.mark.parametrize("row", rows(REFUSED))
def test_what_is_refused_is_told_with_its_reason_and_counted(node, told, curve, row, capfd):
    given, _, expected = row.partition(": ")
    (what, number, *stamp), (reason, words) = map(value, given.split()), expected.split(" ", 1)
    before, topic = node.runtime.gravity, "object_radius_stamped"
    message = ObjectRadius(radius=number)
    if what == "gravity":
        topic, message = what, Vector3Stamped(vector=Vector3(y=number))
    send(node, topic, message, *stamp)
    status = told["status"]
    assert status.state == State.HOLDING
    assert status.reason == Reason[reason]
    assert list(status.object_radius) == [RADIUS]
    words = words.replace("nearest", f"{curve.radius_max:.6g} m")
    assert words in status.reason_text
    assert words in capfd.readouterr().err  # the operator's log
    counted = KeyValue(key=f"refused: {reason}", value="1")
    assert counted in told["diagnostics"].status[0].values
    assert node.runtime.gravity == before


def test_it_is_told_and_drawn_where_the_object_is(node, told):
    placement = node.runtime.loaded.placement(node.runtime.control.snapshot().plan)
    x, y, _ = placement.axis
    shift = 0.004 * np.array((y, -x, 0.0)) / math.hypot(x, y)
    shifted = replace(placement, center=tuple((placement.center + shift).tolist()))
    send(node, "object_pose", PoseStamped(pose=pose_along(shifted)), 0.1, "gripper_base")
    wrap = told["wrap"]
    assert (*wrap.object_offset, *wrap.object_tilt) == pytest.approx((0.004, 0.0), abs=1e-6)
    assert 0.1 <= wrap.object_pose_age[0] < 1.0
    (drawn,) = (marker for marker in told["markers"].markers if marker.ns == "object")
    assert vector_from_msg(drawn.pose.position) == pytest.approx(shifted.center)
    assert node.trigger_deactivate() == node.trigger_activate()
    assert node.runtime.seen_object() is None  # nor does another activation remember it


NO_POSES = """
position.y nan: position of object_pose
position.y -1e4: position of object_pose
orientation.w 1.002: unit quaternion
orientation.w 0.998: unit quaternion
orientation.y nan: unit quaternion
orientation.w 1e200: unit quaternion
stamp.age 60: s old
stamp.age -60: s ahead of this clock
stamp.age 1.9e9: s old
stamp.frame_id camera: frame
"""


def test_a_pose_that_cannot_be_used_is_told_in_diagnostics_and_changes_nothing(node, told):
    send(node, "object_pose", PoseStamped(pose=pose_along(PLACE)))
    for count, row in enumerate(rows(NO_POSES), start=1):
        bad, words = row.split(": ")
        where, what = bad.split()
        part, name = where.split(".")
        message, stamp = PoseStamped(pose=pose_along(PLACE)), {name: value(what)}
        if part != "stamp":
            setattr(getattr(message.pose, part), *stamp.popitem())
        send(node, "object_pose", message, **stamp)
        (status,) = told["diagnostics"].status
        assert words in status.message
        assert KeyValue(key="object poses refused", value=str(count)) in status.values
    assert node.runtime.seen_object().center == CENTER  # the last one stands
    seen = node.runtime.control.snapshot()
    assert seen.state is State.TRACKING
    assert node.published[-1] == seen.pressure_target


def test_joint_object_and_frames_are_told_while_the_rate_is_above_0(node, told, monkeypatch):
    """tf2_msgs is not on PyPI: a stand-in, and publishers that keep what they are given."""
    for name in ("tf2_msgs", "tf2_msgs.msg"):
        monkeypatch.setitem(sys.modules, name, SimpleNamespace(TFMessage=SimpleNamespace))

    def keep(_, topic, __):
        return SimpleNamespace(publish=lambda message: told.update({topic: message}))

    def tell(rate):
        node.set_parameters([Parameter("publish.robot_state_rate", value=rate)])
        tick(node)
        return [told.pop(topic, None) for topic in ("joint_states", "wrapped_object_pose", "/tf")]

    monkeypatch.setattr(node, "create_publisher", keep)
    joint, pose, frames = tell(10.0)
    assert list(joint.name) == ["spiral_gripper_opening"]
    assert list(joint.position) == pytest.approx([2 * RADIUS], rel=1e-3)
    assert pose.header.frame_id == "gripper_base"
    tip, held = frames.transforms
    assert tip.child_frame_id == "gripper_tip"
    assert held.child_frame_id == "gripper_object"
    expected = node.runtime.loaded.commanded.shape.state.tip_position
    assert vector_from_msg(tip.transform.translation) == pytest.approx(tuple(expected))
    node.runtime.control.release()
    joint, pose, _ = tell(10.0)
    assert list(joint.position) == [0.1]  # open
    assert pose is None
    assert tell(0.0) == [None] * 3
