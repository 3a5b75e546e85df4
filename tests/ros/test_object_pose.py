# SPDX-License-Identifier: Apache-2.0
"""Where the object is, as somebody sees it: judged, shown, and never a reason to let go."""

import math

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from ros.harness import all_finite, deliver
from std_msgs.msg import Float64

from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper_msgs.msg import ObjectRadius
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.conversions import pose_along
from spiral_gripper_ros.planning.object_pose import ObjectWatch, SeenObject, misplacement

CENTER, UPRIGHT = (0.1, 0.2, 0.3), (0.0, 0.0, 0.0, 1.0)
HALF = math.sqrt(0.5)
RADIUS = 0.02


def offered(center=CENTER, quaternion=UPRIGHT, seen_at=10.0, age=0.0, limit=1.0):
    watch = ObjectWatch()
    watch.offer(center, quaternion, seen_at, age, limit)
    return watch


@pytest.mark.parametrize(
    ("quaternion", "axis"),
    [
        (UPRIGHT, (0, 0, 1)),
        ((0.0, 0.0, 0.0, -1.0), (0, 0, 1)),
        ((1.0, 0.0, 0.0, 0.0), (0, 0, -1)),
        ((0.0, HALF, 0.0, HALF), (1, 0, 0)),
        ((HALF, 0.0, 0.0, HALF), (0, -1, 0)),
        ((0.0, 0.0, HALF, HALF), (0, 0, 1)),
    ],
)
def test_the_z_axis_of_the_pose_is_the_axis_of_the_object(quaternion, axis):
    assert offered(quaternion=quaternion).seen(10.0, 1.0).axis == pytest.approx(axis, abs=1e-12)


def test_a_quaternion_of_single_precision_is_good_enough_and_gives_a_unit_axis():
    seen = offered(quaternion=(0.0, 0.7071, 0.0, 0.7075)).seen(10.0, 1.0)
    assert math.hypot(*seen.axis) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1.0e4])
@pytest.mark.parametrize("place", range(3))
def test_a_position_that_cannot_be_is_refused(bad, place):
    center = tuple(bad if i == place else 0.1 for i in range(3))
    watch = offered(center=center)
    assert watch.seen(10.0, 1.0) is None
    assert "position of object_pose" in watch.problem


@pytest.mark.parametrize(
    "bad",
    [
        (0.0, 0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0, 1.002),
        (0.0, 0.0, 0.0, 0.998),
        (math.nan, 0.0, 0.0, 1.0),
        (0.0, 0.0, math.inf, 1.0),
        (1e200, 1e200, 1e200, 1e200),
    ],
)
def test_an_orientation_that_is_none_is_refused_and_the_last_pose_stands(bad):
    watch = offered()
    watch.offer((0.0, 0.0, 0.0), bad, 10.1, 0.0, 1.0)
    assert "unit quaternion" in watch.problem
    assert watch.refused == 1
    assert watch.seen(10.1, 1.0).center == CENTER
    watch.offer((0.0, 0.0, 0.0), UPRIGHT, 10.2, 0.0, 1.0)
    assert (watch.problem, watch.refused) == ("", 1)
    assert watch.seen(10.2, 1.0).center == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("age", [1.0, -1.0, 0.0])
def test_a_pose_within_the_limit_is_young_enough(age):
    assert offered(age=age).problem == ""


@pytest.mark.parametrize(
    ("age", "how"), [(1.0001, "s old"), (-1.0001, "s ahead of this clock"), (math.nan, "")]
)
def test_any_other_age_is_refused(age, how):
    assert how in offered(age=age).problem
    assert "object_pose.timeout" in offered(age=age).problem


def test_a_pose_that_grows_old_is_not_known_any_more():
    watch = offered(seen_at=10.0)
    assert watch.seen(11.0, 1.0) is not None
    assert watch.seen(11.001, 1.0) is None
    watch.forget()
    assert watch.seen(10.0, 1.0) is None


@pytest.mark.parametrize(
    ("center", "axis", "offset", "tilt"),
    [
        ((0.1, 0.0, 0.0), (0, 0, 1), 0.0, 0.0),
        ((0.1, 0.0, 7.0), (0, 0, -1), 0.0, 0.0),
        ((0.103, 0.004, -1.0), (0, 0, 1), 0.005, 0.0),
        ((0.1, 0.0, 0.0), (1, 0, 0), 0.0, math.pi / 2),
        ((0.1, 0.0, 0.0), (0.0, math.sin(0.1), math.cos(0.1)), 0.0, 0.1),
        ((0.1, 0.0, 0.0), (0.0, -math.sin(3.0), math.cos(3.0)), 0.0, math.pi - 3.0),
        ((0.1, 0.0, 0.0), (0.0, 1e-9, 1.0), 0.0, 1e-9),
    ],
)
def test_the_misplacement_is_that_of_two_lines(center, axis, offset, tilt):
    expected = ObjectPlacement((0.1, 0.0, 0.0), (0.0, 0.0, 1.0), RADIUS, 0.1, 0.0)
    found = misplacement(SeenObject(center, axis, 0.0), expected)
    assert found == pytest.approx((offset, tilt), rel=1e-9, abs=1e-15)


# --- the node ----------------------------------------------------------------------------------


def pose_message(client, placement=None, frame_id="", age=0.0):
    message = PoseStamped()
    message.header.frame_id = frame_id
    now = client.get_clock().now().nanoseconds - round(1e9 * age)
    message.header.stamp = Time(sec=now // 10**9, nanosec=now % 10**9)
    if placement is not None:
        message.pose = pose_along(placement)
    else:
        message.pose.orientation.w = 1.0
    return message


def test_it_is_told_where_the_object_is_and_how_far_from_the_coil(active):
    publisher = active.create_publisher(PoseStamped, "object_pose", 1)
    active.wrap(RADIUS)
    plan = active.plan_wrap(RADIUS)
    (along,), (center,) = plan.object_axis, plan.object_center
    axis = (along.x, along.y, along.z)
    x, y, z = center.x, center.y, center.z
    across = (axis[1] / math.hypot(*axis[:2]), -axis[0] / math.hypot(*axis[:2]), 0.0)
    shifted = (x + 0.004 * across[0], y + 0.004 * across[1], z)
    place = ObjectPlacement(shifted, axis, RADIUS, 0.1, 0.0)

    def send_and_see():
        publisher.publish(pose_message(active, place, "gripper_base", age=0.1))
        return active.wraps and len(active.wraps[-1].object_offset)

    active.wait_until(send_and_see, "the object")
    told = active.wraps[-1]
    assert list(told.object_offset) == pytest.approx([0.004], rel=1e-3)
    assert list(told.object_tilt) == pytest.approx([0.0], abs=1e-4)
    assert 0.1 <= told.object_pose_age[0] < 1.0
    active.wait_until(lambda: not active.wraps[-1].object_pose_age, "the end of the pose")
    assert not active.wraps[-1].object_offset
    assert not active.wraps[-1].object_tilt
    active.destroy_publisher(publisher)


@pytest.mark.parametrize(
    ("frame_id", "age", "words"),
    [("camera", 0.0, "frame"), ("", 5.0, "s old"), ("", -5.0, "ahead"), ("", 1e9, "s old")],
)
def test_a_pose_that_cannot_be_used_is_told_in_diagnostics_and_changes_nothing(
    active, frame_id, age, words
):
    publisher = active.create_publisher(PoseStamped, "object_pose", 1)
    pressure = active.wrap(RADIUS).pressure_command

    def send_and_see():
        publisher.publish(pose_message(active, frame_id=frame_id, age=age))
        return any("object_pose" in one.message for one in active.diagnostics)

    active.wait_until(send_and_see, "the refusal")
    told = next(one for one in active.diagnostics if "object_pose" in one.message)
    assert words in told.message
    assert int({v.key: v.value for v in told.values}["object poses refused"]) > 0
    assert not any(told.object_pose_age for told in active.wraps)
    assert active.status.state == State.TRACKING
    assert active.pressures[-1] == pressure
    assert all_finite(*active.statuses)
    active.destroy_publisher(publisher)


def test_a_stamp_before_the_epoch_is_old_and_lets_go_of_nothing(node):
    deliver(node, "object_radius", Float64(data=RADIUS))
    message = PoseStamped()
    message.header.stamp = Time(sec=-1, nanosec=0)
    message.pose.orientation.w = 1.0
    deliver(node, "object_pose", message)
    assert "s old" in node.runtime.objects.problem
    radius = ObjectRadius(radius=0.021)
    radius.header.stamp = Time(sec=-1, nanosec=0)
    deliver(node, "object_radius_stamped", radius)
    assert node.runtime.control.snapshot().state is State.HOLDING
    assert node.runtime.errors.count == 0


def test_an_exception_while_a_pose_is_judged_is_logged_and_the_grip_is_kept(node):
    deliver(node, "object_radius", Float64(data=RADIUS))
    node.runtime.objects = None
    deliver(node, "object_pose", PoseStamped())
    assert node.runtime.errors.count == 1
    assert node.runtime.control.snapshot().state is State.TRACKING


def test_the_object_is_drawn_where_it_is_seen(node):
    deliver(node, "object_radius", Float64(data=RADIUS))
    node.runtime.publish()
    snapshot = node.runtime.control.snapshot()
    expected = node._display._scene(node.runtime.loaded, snapshot).placement
    place = ObjectPlacement(CENTER, (0.0, 0.0, 1.0), RADIUS, 0.1, 0.0)
    deliver(node, "object_pose", pose_message(node, place))
    seen = node._display._scene(node.runtime.loaded, snapshot).placement
    assert (seen.center, seen.radius, seen.length) == (CENTER, expected.radius, expected.length)
    assert seen.axis == pytest.approx((0.0, 0.0, 1.0))


def test_another_activation_remembers_no_pose(node):
    deliver(node, "object_pose", pose_message(node))
    assert node.runtime.seen_object() is not None
    node.set_parameters([Parameter("object_pose.timeout", value=0.01)])
    assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
    assert node.trigger_activate() == TransitionCallbackReturn.SUCCESS
    node.set_parameters([Parameter("object_pose.timeout", value=60.0)])
    assert node.runtime.seen_object() is None
