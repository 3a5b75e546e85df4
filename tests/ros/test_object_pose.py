# SPDX-License-Identifier: Apache-2.0
"""What ties the gripper to a robot: estimates with their time, joint, frames, the object's pose."""

import math
import sys
from dataclasses import replace
from types import ModuleType, SimpleNamespace

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import KeyValue
from geometry_msgs.msg import PoseStamped, Vector3, Vector3Stamped
from rclpy.parameter import Parameter
from ros.control_bench import rows
from ros.harness import deliver, tick
from std_msgs.msg import Float64, Header

from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper_msgs.msg import ObjectRadius
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.conversions import pose_along, vector_from_msg
from spiral_gripper_ros.planning.object_pose import (
    ObjectWatch,
    SeenObject,
    misplacement,
    object_line,
)

CENTER, UPRIGHT = (0.1, 0.2, 0.3), (0.0, 0.0, 0.0, 1.0)
RADIUS = 0.02


def offered(center=CENTER, quaternion=UPRIGHT, age=0.0):
    watch = ObjectWatch()
    watch.offer(*object_line(center, quaternion), 10.0, age, 1.0)
    return watch


NO_POSES = """
position 0 nan 0: position of object_pose
position 0 -1e4 0: position of object_pose
orientation 0 0 0 1.002: unit quaternion
orientation 0 0 0 0.998: unit quaternion
orientation 0 nan 0 1: unit quaternion
orientation 1e200 1e200 1e200 1e200: unit quaternion
"""


@pytest.mark.parametrize("row", rows(NO_POSES))
def test_a_pose_that_is_none_is_refused_and_the_last_one_stands(node, row):
    bad, problem = row.split(": ")
    part, *numbers = bad.split()
    node.runtime.objects.offer(CENTER, (0.0, 0.0, 1.0), node.runtime.now(), 0.0, 1.0)
    message = PoseStamped()
    for name, number in zip("xyzw", numbers, strict=False):
        setattr(getattr(message.pose, part), name, float(number))
    deliver(node, "object_pose", stamped(node, message))
    assert problem in node.runtime.objects.problem
    assert node.runtime.objects.refused == 1
    assert node.runtime.seen_object().center == CENTER


@pytest.mark.parametrize(
    ("age", "problem"),
    [(1.0001, "s old"), (-1.0001, "s ahead of this clock"), (math.nan, "object_pose.timeout")],
)
def test_a_pose_of_another_time_is_refused_and_the_last_one_stands(age, problem):
    watch = offered()
    watch.offer((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), seen_at=10.1, age=age, limit=1.0)
    assert problem in watch.problem
    assert (watch.refused, watch.seen(10.1, 1.0).center) == (1, CENTER)


def test_a_pose_grows_old():
    assert offered(age=1.0).problem == offered(age=-1.0).problem == ""
    assert offered().seen(11.001, 1.0) is None is not offered().seen(11.0, 1.0)


@pytest.mark.parametrize(
    ("center", "axis", "offset", "tilt"),
    [
        ((0.103, 0.004, -1.0), (0, 0, 1), 0.005, 0.0),
        ((0.1, 0.0, 0.0), (0.0, -math.sin(3.0), math.cos(3.0)), 0.0, math.pi - 3.0),
    ],
)
def test_the_misplacement_is_that_of_two_lines(center, axis, offset, tilt):
    expected = ObjectPlacement((0.1, 0.0, 0.0), (0.0, 0.0, 1.0), RADIUS, 0.1, 0.0)
    found = misplacement(SeenObject(center, axis, 0.0), expected)
    assert found == pytest.approx((offset, tilt), rel=1e-9, abs=1e-15)


# --- a node in this process --------------------------------------------------------------------

PLACE = ObjectPlacement(CENTER, (0.0, 0.0, 1.0), RADIUS, 0.1, 0.0)


def stamped(node, message, age=0.0, frame_id=""):
    now = node.get_clock().now().nanoseconds - round(1e9 * age)
    message.header.stamp = Time(sec=now // 10**9, nanosec=now % 10**9)
    message.header.frame_id = frame_id
    return message


def gravity_of(frame_id="", **components):
    return Vector3Stamped(header=Header(frame_id=frame_id), vector=Vector3(**components))


def send_pose(node, placement=PLACE, **header):
    deliver(node, "object_pose", stamped(node, PoseStamped(pose=pose_along(placement)), **header))
    tick(node)


# The last is before the epoch.
STAMPS = ((60.0, "s old"), (-60.0, "s ahead of this clock"), (1.9e9, "s old"))


def test_an_estimate_that_is_too_old_or_ahead_of_the_clock_is_refused(node):
    for age, how in STAMPS:
        for radius, old in ((RADIUS, 0.1), (0.0201, age)):
            message = stamped(node, ObjectRadius(radius=radius), old)
            deliver(node, "object_radius_stamped", message)
        seen = node.runtime.control.snapshot()
        assert (seen.state, seen.refusal.reason) == (State.HOLDING, Reason.RADIUS_STALE)
        assert how in seen.refusal.text
        assert seen.radius == RADIUS


@pytest.mark.parametrize(
    ("topic", "message", "reason", "words"),
    [
        ("object_radius", Float64(data=0.2), Reason.RADIUS_TOO_LARGE, "nearest"),
        ("gravity", gravity_of(y=math.inf), Reason.GRAVITY_INVALID, "inf"),
        ("gravity", gravity_of("camera", x=9.8), Reason.GRAVITY_INVALID, "'camera'"),
    ],
)
def test_what_is_refused_is_told_with_its_reason_and_counted(
    node, told, curve, topic, message, reason, words, capfd
):
    before = node.runtime.gravity
    deliver(node, topic, message)
    tick(node)
    status = told["status"]
    assert (status.state, status.reason) == (State.HOLDING, reason)
    words = f"{curve.radius_max:.6g} m" if words == "nearest" else words
    assert words in status.reason_text
    assert words in capfd.readouterr().err  # the operator's log
    counted = KeyValue(key=f"refused: {reason.name}", value="1")
    assert counted in told["diagnostics"].status[0].values
    assert node.runtime.gravity == before


def test_it_is_told_and_drawn_where_the_object_is(node, told):
    placement = node.runtime.loaded.placement(node.runtime.control.snapshot().plan)
    (ax, ay, _), (x, y, z) = placement.axis, placement.center
    size = math.hypot(ax, ay)
    shifted = (x + 0.004 * ay / size, y - 0.004 * ax / size, z)
    send_pose(node, replace(placement, center=shifted), age=0.1, frame_id="gripper_base")
    wrap = told["wrap"]
    assert (*wrap.object_offset, *wrap.object_tilt) == pytest.approx((0.004, 0.0), abs=1e-6)
    assert 0.1 <= wrap.object_pose_age[0] < 1.0
    at = {marker.ns: marker for marker in told["markers"].markers}["object"].pose.position
    assert (at.x, at.y, at.z) == pytest.approx(shifted)
    assert node.trigger_deactivate() == node.trigger_activate()
    assert node.runtime.seen_object() is None  # nor does another activation remember it


def test_a_pose_that_cannot_be_used_is_told_in_diagnostics_and_changes_nothing(node, told):
    headers = [({"age": age}, how) for age, how in STAMPS]
    for count, (header, words) in enumerate([*headers, ({"frame_id": "camera"}, "frame")], start=1):
        send_pose(node, **header)
        (status,) = told["diagnostics"].status
        assert words in status.message
        assert KeyValue(key="object poses refused", value=str(count)) in status.values
    assert not told["wrap"].object_pose_age
    seen = node.runtime.control.snapshot()
    assert (seen.state, node.published[-1]) == (State.TRACKING, seen.pressure_target)


def test_joint_object_and_frames_are_told_while_the_rate_is_above_0(node, told, monkeypatch):
    """tf2_msgs is not on PyPI: a stand-in, and publishers that keep what they are given."""
    module = ModuleType("tf2_msgs.msg")
    module.TFMessage = SimpleNamespace
    monkeypatch.setitem(sys.modules, "tf2_msgs", ModuleType("tf2_msgs"))
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", module)

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
    assert (tip.child_frame_id, held.child_frame_id) == ("gripper_tip", "gripper_object")
    expected = node.runtime.loaded.commanded.shape.state.tip_position
    assert vector_from_msg(tip.transform.translation) == pytest.approx(tuple(expected))
    node.runtime.control.release()
    joint, pose, _ = tell(10.0)
    assert (list(joint.position), pose) == ([0.1], None)  # open
    assert tell(0.0) == [None, None, None]
