# SPDX-License-Identifier: Apache-2.0
"""What ties the gripper to a robot: estimates with their time, joint, frames, the object's pose."""

import math
import sys
from dataclasses import replace
from types import ModuleType, SimpleNamespace

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import KeyValue
from geometry_msgs.msg import PoseStamped
from rclpy.parameter import Parameter
from ros.harness import deliver, tick, tick_until

from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper_msgs.msg import ObjectRadius
from spiral_gripper_ros.control.radius_gate import stale_estimate
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.conversions import pose_along, prefix_of
from spiral_gripper_ros.planning.object_pose import (
    ObjectWatch,
    SeenObject,
    misplacement,
    object_line,
)

CENTER, UPRIGHT = (0.1, 0.2, 0.3), (0.0, 0.0, 0.0, 1.0)
HALF = math.sqrt(0.5)
RADIUS = 0.02


def offered(center=CENTER, quaternion=UPRIGHT, age=0.0):
    watch = ObjectWatch()
    watch.offer(*object_line(center, quaternion), 10.0, age, 1.0)
    return watch


# The last one is of single precision.
@pytest.mark.parametrize(
    ("quaternion", "axis"),
    [
        ((0.0, 0.0, 0.0, -1.0), (0, 0, 1)),
        ((0.0, HALF, 0.0, HALF), (1, 0, 0)),
        ((HALF, 0.0, 0.0, HALF), (0, -1, 0)),
        ((0.0, 0.7071, 0.0, 0.7075), (1.0, 0.0, 5.65e-4)),
    ],
)
def test_the_z_axis_of_the_pose_is_the_axis_of_the_object(quaternion, axis):
    seen = offered(quaternion=quaternion).seen(10.0, 1.0).axis
    assert seen == pytest.approx(axis, abs=1e-6)
    assert math.hypot(*seen) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("bad", "problem"),
    [
        *(({"position": {"y": bad}}, "position of object_pose") for bad in (math.nan, -1.0e4)),
        *(
            ({"orientation": dict(zip("xyzw", quaternion, strict=True))}, "unit quaternion")
            for quaternion in (
                (0.0, 0.0, 0.0, 1.002),
                (0.0, 0.0, 0.0, 0.998),
                (0.0, 0.0, math.inf, 1.0),
                (0.0, math.nan, 0.0, 1.0),
                (1e200, 1e200, 1e200, 1e200),
            )
        ),
    ],
)
def test_a_pose_that_is_none_is_refused_and_the_last_one_stands(node, bad, problem):
    node.runtime.objects.offer(CENTER, (0.0, 0.0, 1.0), node.runtime.now(), 0.0, 1.0)
    message = PoseStamped()
    for part, components in bad.items():
        for name, value in components.items():
            setattr(getattr(message.pose, part), name, value)
    deliver(node, "object_pose", stamped(node, message))
    assert problem in node.runtime.objects.problem
    assert node.runtime.objects.refused == 1
    assert node.runtime.seen_object().center == CENTER


@pytest.mark.parametrize(
    ("age", "problem"),
    [(1.0001, "s old"), (-1.0001, "s ahead of this clock"), (math.nan, "object_pose.timeout")],
)
def test_a_pose_of_another_time_is_refused_and_the_last_one_stands(age, problem):
    watch, line = offered(), ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    watch.offer(*line, seen_at=10.1, age=age, limit=1.0)
    assert problem in watch.problem
    assert watch.refused == 1
    assert watch.seen(10.1, 1.0).center == CENTER
    watch.offer(*line, 10.2, 0.0, 1.0)
    assert (watch.problem, watch.refused) == ("", 1)
    assert watch.seen(10.2, 1.0).center == (0.0, 0.0, 0.0)


def test_a_pose_grows_old_and_may_be_as_old_as_the_limit_either_way():
    assert offered(age=1.0).problem == offered(age=-1.0).problem == ""
    watch = offered()
    assert watch.seen(11.0, 1.0) is not None
    assert watch.seen(11.001, 1.0) is None


@pytest.mark.parametrize(
    ("center", "axis", "offset", "tilt"),
    [
        ((0.103, 0.004, -1.0), (0, 0, 1), 0.005, 0.0),
        ((0.1, 0.0, 0.0), (0.0, -math.sin(3.0), math.cos(3.0)), 0.0, math.pi - 3.0),
        ((0.1, 0.0, 0.0), (0.0, 1e-9, 1.0), 0.0, 1e-9),
    ],
)
def test_the_misplacement_is_that_of_two_lines(center, axis, offset, tilt):
    expected = ObjectPlacement((0.1, 0.0, 0.0), (0.0, 0.0, 1.0), RADIUS, 0.1, 0.0)
    found = misplacement(SeenObject(center, axis, 0.0), expected)
    assert found == pytest.approx((offset, tilt), rel=1e-9, abs=1e-15)


def test_an_age_within_the_limit_is_young_enough_and_any_other_is_refused():
    assert stale_estimate(0.5, 0.5) is stale_estimate(-0.5, 0.5) is None
    for age in (0.5000001, -0.5000001, math.nan, math.inf, -math.inf):
        refusal = stale_estimate(age, 0.5)
        assert refusal.reason is Reason.RADIUS_STALE
        assert "radius.age_limit" in refusal.text


def test_prefixes_are_those_of_the_links():
    names = ("left_gripper_base", "gripper_base", "tool0")
    assert [prefix_of(name) for name in names] == ["left_", "", "tool0_"]


# --- a node in this process --------------------------------------------------------------------

PLACE = ObjectPlacement(CENTER, (0.0, 0.0, 1.0), RADIUS, 0.1, 0.0)


def stamped(node, message, age=0.0, frame_id=""):
    now = node.get_clock().now().nanoseconds - round(1e9 * age)
    message.header.stamp = Time(sec=now // 10**9, nanosec=now % 10**9)
    message.header.frame_id = frame_id
    return message


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
    node.set_parameters([Parameter("object_pose.timeout", value=0.01)])
    tick_until(node, lambda: not told["wrap"].object_pose_age)
    assert not told["wrap"].object_offset
    # Nor does another activation remember it.
    node.set_parameters([Parameter("object_pose.timeout", value=60.0)])
    assert node.runtime.seen_object() is not None
    assert node.trigger_deactivate() == node.trigger_activate()
    assert node.runtime.seen_object() is None


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
    assert node.runtime.errors.count == 0


def test_joint_object_and_frames_are_told_while_the_rate_is_above_0(node, told, monkeypatch):
    """tf2_msgs is not on PyPI: a stand-in, and publishers that keep what they are given."""
    module = ModuleType("tf2_msgs.msg")
    module.TFMessage = SimpleNamespace
    monkeypatch.setitem(sys.modules, "tf2_msgs", ModuleType("tf2_msgs"))
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", module)

    def keep(_, topic, __):
        return SimpleNamespace(publish=lambda message: told.update({topic: message}))

    def tell():
        tick(node)
        return [told.pop(topic, None) for topic in ("joint_states", "wrapped_object_pose", "/tf")]

    monkeypatch.setattr(node, "create_publisher", keep)
    node.set_parameters([Parameter("publish.robot_state_rate", value=10.0)])
    joint, pose, frames = tell()
    assert list(joint.name) == ["spiral_gripper_opening"]
    assert list(joint.position) == pytest.approx([2 * RADIUS], rel=1e-3)
    assert pose.header.frame_id == "gripper_base"
    tip, held = frames.transforms
    assert (tip.child_frame_id, held.child_frame_id) == ("gripper_tip", "gripper_object")
    at = tip.transform.translation
    expected = node.runtime.loaded.commanded.shape.state.tip_position
    assert (at.x, at.y, at.z) == pytest.approx(tuple(expected))
    node.runtime.control.release()
    joint, pose, _ = tell()
    assert (list(joint.position), pose) == ([0.1], None)  # open
    node.set_parameters([Parameter("publish.robot_state_rate", value=0.0)])
    assert tell() == [None, None, None]
    assert node.runtime.errors.count == 0
