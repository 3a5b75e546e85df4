# SPDX-License-Identifier: Apache-2.0
"""The node as a process of its own: what a client sees of it."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Vector3, Vector3Stamped
from lifecycle_msgs.msg import State as LifecycleState
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros.harness import ALL_AND_LATCHED, RunningNode, all_finite

from spiral_core import WrapCurve
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper_msgs.msg import GripStatus, Wrap
from spiral_gripper_ros.control.states import Reason, State


def nodes_of(backbone):
    return np.array([(p.position.x, p.position.y, p.position.z) for p in backbone.poses])


def test_a_radius_becomes_the_pressure_of_its_wrap(active, curve):
    wrap = curve.wrap_for_radius(0.02)
    status = active.wrap(0.02)
    assert status.state == State.TRACKING
    assert status.reason == Reason.NONE
    assert active.pressures[-1] == pytest.approx(wrap.pressure, rel=1e-9)
    assert status.pressure_command == active.pressures[-1]
    assert status.regime == GripStatus.REGIME_PERFECT_WRAP
    told = active.wait_for_plan(0.02, status.pressure_target)
    plan = told.plan[0]
    assert plan.stable
    assert plan.turns == pytest.approx(wrap.turns, rel=1e-6)
    assert list(plan.gripper_length_needed) == pytest.approx([wrap.gripper_length_needed], rel=1e-6)
    assert list(plan.object_length_needed) == pytest.approx([wrap.object_length_needed], rel=1e-6)
    assert list(told.radius_range) == pytest.approx([curve.radius_min, curve.radius_max])
    assert list(plan.radius_margin) == pytest.approx([0.02 - curve.radius_min])
    assert plan.pressure_margin == pytest.approx(curve.gripper.pressure_max - wrap.pressure)
    for header in (status.header, told.header):
        assert header.frame_id == "gripper_base"
        assert header.stamp.sec > 0


def test_what_is_planned_is_told_when_it_changes_and_to_latecomers(active):
    pressure = active.wrap(0.02).pressure_target
    active.wait_for_plan(0.02, pressure)
    active.hear_more(2)
    active.wraps.clear()
    active.hear_more(20)
    assert not active.wraps
    latecomer = []
    subscription = active.create_subscription(Wrap, "wrap", latecomer.append, ALL_AND_LATCHED)
    active.wait_until(lambda: latecomer, "what is latched")
    assert latecomer[0].plan[0].object_radius == 0.02
    active.destroy_subscription(subscription)
    assert active.transition("deactivate")
    active.wraps.clear()
    assert active.transition("activate")
    active.wait_until(lambda: active.wraps and not active.wraps[-1].plan, "what is planned now")


def test_the_backbone_is_the_shape_at_the_commanded_pressure(active, curve):
    status = active.wrap(0.02)
    state = curve.wrap_for_radius(0.02).state
    active.wait_until(
        lambda: (
            active.backbones
            and nodes_of(active.backbones[-1])[-1] == pytest.approx(state.tip_position, abs=1e-6)
        ),
        "the backbone of the wrap",
    )
    poses = active.backbones[-1].poses
    assert len(poses) == 50
    assert active.backbones[-1].header.frame_id == status.header.frame_id
    picked = np.linspace(0, len(state.positions) - 1, 50).round().astype(int)
    # The wrap is found to 1e-10 of the radius; the shape moves with it by no more than 1e-6 m.
    assert nodes_of(active.backbones[-1]) == pytest.approx(state.positions[picked], abs=1e-6)
    first, last = poses[0].orientation, poses[-1].orientation
    assert (first.x, first.y, first.z, first.w) == pytest.approx((0.0, 0.0, 0.0, 1.0), abs=1e-6)
    given = np.array([last.x, last.y, last.z, last.w])
    assert abs(given @ state.orientations[-1]) == pytest.approx(1.0, abs=1e-6)


def test_the_command_rises_no_faster_than_its_rate(active):
    rate, publish_rate = 4.0e4, 50.0
    active.set_parameter("pressure.rate_up", rate)
    active.wrap(0.02)
    steps = np.diff([0.0, *active.pressures])
    assert steps.max() <= rate * 0.1 * (1.0 + 1e-9)
    # Most steps last one period; a busy machine stretches a few.
    assert np.median(steps[steps > 0.0]) <= 2.0 * rate / publish_rate


def test_the_regime_is_overhang_on_the_way_up(active):
    active.set_parameter("pressure.rate_up", 1.0e5)
    active.wrap(0.02)
    regimes = [s.regime for s in active.statuses if list(s.object_radius) == [0.02]]
    assert regimes[0] == GripStatus.REGIME_OVERHANG
    assert regimes[-1] == GripStatus.REGIME_PERFECT_WRAP


@pytest.mark.parametrize(
    ("radius", "reason"),
    [
        (math.nan, Reason.RADIUS_NOT_FINITE),
        (0.2, Reason.RADIUS_TOO_LARGE),
        (0.03, Reason.RADIUS_JUMP),
    ],
)
def test_a_bad_radius_is_refused_with_a_reason_and_not_followed(active, radius, reason):
    # So slow that the jump stays one however long the test takes.
    active.set_parameter("radius.rate_limit", 1.0e-4)
    before = active.wrap(0.02)
    active.pressures.clear()
    active.send_radius(radius)
    status = active.wait_for_state(State.HOLDING, reason)
    assert status.reason_text
    refused = f"refused: {reason.name}"
    active.wait_until(
        lambda: any(
            {v.key: v.value for v in d.values}.get(refused) == "1" for d in active.diagnostics
        ),
        "its count in the diagnostics",
    )
    active.hear_more()
    assert set(active.pressures) == {before.pressure_command}
    assert all_finite(*active.statuses, *active.backbones)
    active.send_radius(0.02)
    active.wait_for_state(State.TRACKING, Reason.NONE)


def test_the_refusal_names_the_nearest_radius_that_can_be_gripped(active, curve):
    active.send_radius(0.2)
    status = active.wait_for_state(State.WAITING, Reason.RADIUS_TOO_LARGE)
    assert f"{curve.radius_max:.6g} m" in status.reason_text


@pytest.mark.parametrize(
    ("policy", "state"),
    [("hold", State.HOLDING), ("vent", State.VENTED), ("ramp_down", State.VENTED)],
)
def test_when_the_stream_stops_the_policy_decides(active, policy, state):
    active.set_parameter("radius.timeout_policy", policy)
    active.set_parameter("radius.timeout", 0.2)
    active.set_parameter("pressure.rate_down", 2.0e5)
    held = active.wrap(0.02).pressure_command
    active.pressures.clear()
    status = active.wait_for_state(state, Reason.RADIUS_STALE)
    assert status.pressure_command == (held if policy == "hold" else 0.0)
    between = [p for p in active.pressures if 0.0 < p < held]
    assert bool(between) == (policy == "ramp_down")


def test_noise_within_the_hysteresis_does_not_move_the_command(active):
    active.set_parameter("radius.hysteresis", 0.001)
    pressure = active.wrap(0.02).pressure_command
    active.pressures.clear()
    noise = np.random.default_rng(1).uniform(-0.001, 0.001, 50)
    for deviation in noise:
        active.send_radius(0.02 + float(deviation))
        active.spin(0.005)
    active.hear_more()
    assert set(active.pressures) == {pressure}


def test_gravity_is_solved_anew_and_moves_the_pressure(active, gripper):
    hanging = active.wrap(0.02).pressure_command
    gravity = (0.0, 0.0, -9.80665)
    expected = WrapCurve(gripper.with_mount(gravity, None)).pressure_from_radius(0.02)
    assert abs(expected - hanging) > 100.0
    active.send_gravity(gravity)
    active.wait_until(
        lambda: active.wrap(0.02).pressure_command == pytest.approx(expected, rel=1e-9),
        "the pressure for the new gravity",
    )


# Where a subscription is incompatible, as the node's other one is, rclpy of Kilted calls a method
# of its own that is deprecated.
@pytest.mark.filterwarnings("ignore:Deprecated in favor of:DeprecationWarning")
def test_gravity_that_was_published_once_before_the_node_started_is_heard(client, namespace):
    gravity = Vector3Stamped()
    gravity.vector.z = -9.80665
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    client.create_publisher(Vector3Stamped, "gravity", latched).publish(gravity)
    with RunningNode(namespace):
        client.wait_until_active()
        client.wait_until(
            lambda: any(
                v.key == "gravity age [s]" and v.value for d in client.diagnostics for v in d.values
            ),
            "the gravity",
        )
        given = client.plan_wrap(0.02, gravity=[gravity.vector]).figures[0].pressure
        hanging = client.plan_wrap(0.02, gravity=[Vector3(x=9.80665)]).figures[0].pressure
        assert abs(given - hanging) > 100.0
        client.wait_until(
            lambda: client.plan_wrap(0.02).figures[0].pressure == pytest.approx(given, rel=1e-9),
            "its plan",
        )


@pytest.mark.parametrize(
    ("gravity", "frame_id"),
    [
        ((math.nan, 0.0, 0.0), ""),
        ((0.0, math.inf, 0.0), ""),
        ((0.0, 0.0, 1.0e3), ""),
        ((0.0, 0.0, -9.81), "camera"),
    ],
)
def test_a_bad_gravity_is_refused_with_a_reason(active, gravity, frame_id):
    before = active.wrap(0.02)
    active.send_gravity(gravity, frame_id)
    status = active.wait_for_state(State.HOLDING, Reason.GRAVITY_INVALID)
    assert "gravity" in status.reason_text
    assert status.pressure_command == before.pressure_command
    assert all_finite(*active.statuses)


def test_release_vents_until_rearmed(active):
    pressure = active.wrap(0.02).pressure_command
    assert active.release().success
    active.wait_for_state(State.RELEASED, Reason.RELEASED)
    active.wait_until(lambda: active.pressures[-1] == 0.0, "the vent")
    active.pressures.clear()
    for _ in range(5):
        active.send_radius(0.02)
        active.hear_more(1)
    assert set(active.pressures) == {0.0}
    assert active.rearm().success
    assert active.wrap(0.02).pressure_command == pressure


def test_release_is_safe_in_any_state(active):
    for transition in ("deactivate", "cleanup"):
        assert active.transition(transition)
        active.spin(0.1)
        active.pressures.clear()
        released = active.release()
        assert released.success
        assert released.message == "vented; the node is not active"
        active.wait_until(lambda: active.pressures, "the vent")
        assert not any(active.pressures)
        refused = active.rearm()
        assert not refused.success
        assert "active" in refused.message


def test_the_life_cycle_three_times(active):
    for _ in range(3):
        active.wrap(0.02)
        active.pressures.clear()
        assert active.transition("deactivate")
        active.wait_until(lambda: active.pressures and active.pressures[-1] == 0.0, "the vent")
        active.send_radius(0.02)
        active.spin(0.1)
        assert active.pressures[-1] == 0.0
        assert active.lifecycle_state() == LifecycleState.PRIMARY_STATE_INACTIVE
        assert active.transition("cleanup")
        assert active.lifecycle_state() == LifecycleState.PRIMARY_STATE_UNCONFIGURED
        assert active.transition("configure")
        assert active.transition("activate")
        active.wait_until_active()


def test_a_gripper_that_cannot_be_loaded_leaves_it_unconfigured_to_try_again(active, tmp_path):
    assert active.transition("deactivate")
    assert active.transition("cleanup")
    file = tmp_path / "mine.yaml"
    file.write_text((GRIPPERS.path / "prototype_p1.yaml").read_text())
    assert active.set_parameter("gripper", str(file)).successful
    file.unlink()
    assert not active.transition("configure")
    assert active.lifecycle_state() == LifecycleState.PRIMARY_STATE_UNCONFIGURED
    assert active.set_parameter("gripper", "prototype_p1").successful
    assert active.transition("configure")
    assert active.transition("activate")
    active.wait_until_active()


def test_diagnostics_tell_state_reason_and_counters(active):
    active.wrap(0.02)
    active.send_radius(math.nan)
    active.wait_for_state(State.HOLDING)
    active.wait_until(
        lambda: active.diagnostics and "nan" in active.diagnostics[-1].message, "diagnostics"
    )
    status = active.diagnostics[-1]
    values = {pair.key: pair.value for pair in status.values}
    assert status.hardware_id == "paper_design_70"
    assert status.level == status.WARN
    assert values["state"] == "HOLDING"
    assert values["reason"] == "RADIUS_NOT_FINITE"
    assert values["refused: RADIUS_NOT_FINITE"] == "1"
    assert values["internal errors"] == "0"


def test_a_transition_that_its_state_does_not_have_is_refused_and_the_grip_is_kept(active):
    held = active.wrap(0.02).pressure_command
    assert not active.transition("configure")
    assert not active.transition("cleanup")
    assert active.lifecycle_state() == LifecycleState.PRIMARY_STATE_ACTIVE
    assert active.wrap(0.02).pressure_command == held
    assert active.pressures[-1] == held
