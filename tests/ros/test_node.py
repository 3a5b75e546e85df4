# SPDX-License-Identifier: Apache-2.0
"""The node as a process of its own: what a client sees of its topics, services and life cycle."""

import math

import numpy as np
import pytest
from diagnostic_msgs.msg import KeyValue
from geometry_msgs.msg import Vector3, Vector3Stamped
from lifecycle_msgs.msg import State as LifecycleState
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros.harness import RunningNode, all_finite
from visualization_msgs.msg import MarkerArray

from spiral_core import WrapCurve
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import Reason, State

RADIUS = 0.02
UPRIGHT = (0.0, 0.0, -9.80665)


def test_a_radius_becomes_the_pressure_and_the_shape_of_its_wrap(active, curve):
    wrap = curve.wrap_for_radius(RADIUS)
    status = active.wrap(RADIUS)
    assert (status.state, status.reason) == (State.TRACKING, Reason.NONE)
    assert status.pressure_command == pytest.approx(wrap.pressure, rel=1e-9)
    assert status.regime == GripStatus.REGIME_PERFECT_WRAP
    assert status.wrapped
    told = active.wait_for_plan(RADIUS, status.pressure_target)
    (plan,) = told.plan
    assert plan.stable
    assert list(told.radius_range) == pytest.approx([curve.radius_min, curve.radius_max])
    tip = pytest.approx(wrap.state.tip_position, abs=1e-6)

    def is_shown():
        at = active.backbones[-1].poses[-1].position
        return (at.x, at.y, at.z) == tip

    active.wait_until(lambda: active.backbones and is_shown(), "the backbone of the wrap")
    assert len(active.backbones[-1].poses) == 50
    for header in (status.header, told.header, active.backbones[-1].header):
        assert header.frame_id == "gripper_base"
        assert header.stamp.sec > 0
    active.wraps.clear()
    drawn = []
    display = active.create_subscription(MarkerArray, "markers", drawn.append, 10)
    active.wait_until(lambda: drawn, "markers")
    active.hear_more(20)
    assert not active.wraps  # it is told when it changes
    active.destroy_subscription(display)


def test_the_command_rises_no_faster_than_its_rate(active):
    rate, publish_rate = 4.0e4, 50.0
    active.set_parameter("pressure.rate_up", rate)
    active.wrap(RADIUS)
    steps = np.diff([0.0, *active.pressures])
    assert steps.max() <= rate * 0.1 * (1.0 + 1e-9)
    # Most steps last one period; a busy machine stretches a few.
    assert np.median(steps[steps > 0.0]) <= 2.0 * rate / publish_rate


@pytest.mark.parametrize(
    ("send", "reason", "words"),
    [
        (lambda client: client.send_radius(math.nan), Reason.RADIUS_NOT_FINITE, "nan"),
        (lambda client: client.send_radius(0.2), Reason.RADIUS_TOO_LARGE, "nearest"),
        (lambda client: client.send_radius(0.03), Reason.RADIUS_JUMP, ""),
        (lambda client: client.send_gravity((0.0, math.inf, 0.0)), Reason.GRAVITY_INVALID, "inf"),
        (lambda client: client.send_gravity(UPRIGHT, "camera"), Reason.GRAVITY_INVALID, "camera"),
    ],
)
def test_a_bad_message_is_refused_with_a_reason_and_not_followed(
    active, curve, send, reason, words
):
    # So slow that the jump stays one however long the test takes.
    active.set_parameter("radius.rate_limit", 1.0e-4)
    held = active.wrap(RADIUS).pressure_command
    active.pressures.clear()
    send(active)
    told = active.wait_for_state(State.HOLDING, reason).reason_text
    assert (f"{curve.radius_max:.6g} m" if words == "nearest" else words) in told
    count = KeyValue(key=f"refused: {reason.name}", value="1")
    active.wait_until(lambda: any(count in d.values for d in active.diagnostics), "its count")
    active.hear_more()
    assert set(active.pressures) == {held}
    assert all_finite(*active.statuses, *active.backbones)
    active.send_radius(RADIUS)
    active.wait_for_state(State.TRACKING, Reason.NONE)


@pytest.mark.parametrize("way", ["topic", "parameter"])
def test_gravity_is_solved_anew_and_moves_the_pressure(active, gripper, way):
    hanging = active.wrap(RADIUS).pressure_command
    expected = WrapCurve(gripper.with_mount(UPRIGHT, None)).pressure_from_radius(RADIUS)
    assert abs(expected - hanging) > 100.0

    def wait_for(pressure):
        wanted = pytest.approx(pressure, rel=1e-9)
        active.wait_until(lambda: active.wrap(RADIUS).pressure_command == wanted, "its pressure")

    if way == "topic":
        active.send_gravity(UPRIGHT)
    else:
        active.change("gravity.vector", list(UPRIGHT))
    wait_for(expected)
    if way == "parameter":
        active.change("gravity.vector", [math.nan] * 3)
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


def test_vent_and_the_life_cycle(active):
    pressure = active.wrap(RADIUS).pressure_command
    assert active.release().success
    active.wait_for_state(State.RELEASED, Reason.RELEASED)
    active.wait_for_vent()
    active.pressures.clear()
    for _ in range(5):
        active.send_radius(RADIUS)
        active.hear_more(1)
    assert set(active.pressures) == {0.0}
    assert active.rearm().success
    assert active.wrap(RADIUS).pressure_command == pressure
    states = LifecycleState.PRIMARY_STATE_INACTIVE, LifecycleState.PRIMARY_STATE_UNCONFIGURED
    for transition, state in zip(("deactivate", "cleanup"), states, strict=True):
        assert active.transition(transition)
        active.wait_for_vent()
        assert active.lifecycle_state() == state
        active.send_radius(RADIUS)
        released = active.release()
        assert (released.success, released.message) == (True, "vented; the node is not active")
        assert active.pressures[-1] == 0.0
        refused = active.rearm()
        assert not refused.success
        assert "active" in refused.message
