# SPDX-License-Identifier: Apache-2.0
"""The gripper as it is: what a running node makes of `measured_pressure`."""

import math

import pytest
from rclpy.action import ActionClient
from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros.harness import DEADLINE, all_finite
from std_msgs.msg import Float64

from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import Reason, State

RADIUS = 0.02


def ideal(pressure):
    return pressure


def leaking(pressure):
    return 0.8 * pressure


def tip_of(backbone):
    point = backbone.poses[-1].position
    return point.x, point.y, point.z


def wait_for_fault(client, reason):
    client.wait_until(
        lambda: client.status is not None and client.status.fault == reason,
        f"the pressure fault {reason.name}",
    )
    return client.status


def wait_for_measured(client, pressure):
    client.wait_until(
        lambda: (
            client.status is not None
            and list(client.status.measured_pressure) == [pytest.approx(pressure)]
        ),
        f"a measured pressure of {pressure} Pa",
    )
    return client.status


def wait_for_level(client, level):
    client.diagnostics.clear()
    client.wait_until(
        lambda: client.diagnostics and client.diagnostics[-1].level == level, f"the level {level!r}"
    )
    return client.diagnostics[-1]


@pytest.fixture
def tolerant(active):
    """A node that takes no difference of the measured pressure for a fault."""
    assert active.set_parameter("pressure.tolerance", 5.0e4).successful
    return active


def test_without_measured_pressure_nothing_is_said_to_be_measured(active):
    status = active.wrap(RADIUS)
    assert not status.measured_pressure
    assert status.fault == Reason.NONE
    assert status.wrapped
    assert not active.measured_backbones


def test_the_measured_shape_is_that_at_the_measured_pressure(tolerant, curve):
    tolerant.regulator = leaking
    pressure = tolerant.wrap(RADIUS).pressure_command
    tolerant.wait_until(
        # Changes up to 50 Pa keep the shape.
        lambda: list(tolerant.status.measured_pressure) == [pytest.approx(0.8 * pressure, abs=1.0)],
        "the measured pressure",
    )
    tip = curve.state_at_pressure(0.8 * pressure).tip_position

    def measured_tip():
        return tip_of(tolerant.measured_backbones[-1])

    tolerant.wait_until(
        # 50 Pa move the tip by 0.35 mm.
        lambda: tolerant.measured_backbones and measured_tip() == pytest.approx(tip, abs=5e-4),
        "the measured shape",
    )
    assert math.dist(tip_of(tolerant.backbones[-1]), measured_tip()) > 0.01
    assert tolerant.status.regime == GripStatus.REGIME_OVERHANG
    assert not tolerant.status.wrapped
    assert tolerant.measured_backbones[-1].header.frame_id == "gripper_base"
    assert all_finite(*tolerant.statuses, *tolerant.measured_backbones)


def test_what_is_measured_to_be_wrapped_is_wrapped(active):
    active.regulator = ideal
    active.wrap(RADIUS)
    active.wait_until(lambda: active.status.wrapped, "the wrap")
    assert active.status.regime == GripStatus.REGIME_PERFECT_WRAP
    assert active.status.fault == Reason.NONE


@pytest.mark.parametrize("reliability", [ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT])
def test_reliable_and_best_effort_sensors_are_heard(active, reliability):
    sensor = active.create_publisher(
        Float64, "measured_pressure", QoSProfile(depth=5, reliability=reliability)
    )

    def send_and_see():
        sensor.publish(Float64(data=123.0))
        return active.status is not None and list(active.status.measured_pressure) == [123.0]

    active.wait_until(send_and_see, "a measured pressure")
    active.destroy_publisher(sensor)


def test_a_sensor_that_reads_a_little_below_zero_measures_a_vented_gripper(active, gripper):
    active.regulator = lambda pressure: pressure - 300.0
    active.wait_until(lambda: active.measured_backbones, "a shape")
    wait_for_measured(active, -300.0)
    straight = pytest.approx((gripper.tube.length, 0.0, 0.0))
    assert tip_of(active.measured_backbones[-1]) == straight


def test_a_leak_is_reported_and_the_grip_is_kept(active):
    active.regulator = leaking
    pressure = active.wrap(RADIUS).pressure_command
    status = wait_for_fault(active, Reason.PRESSURE_LOW)
    assert "leak" in status.fault_text
    assert status.state == State.TRACKING
    assert status.pressure_command == pressure
    found = wait_for_level(active, b"\x02")
    values = {pair.key: pair.value for pair in found.values}
    assert "leak" in found.message
    assert values["pressure fault"] == "PRESSURE_LOW"
    assert float(values["measured_pressure [Pa]"]) == pytest.approx(0.8 * pressure, abs=1.0)
    assert float(values["measured_pressure age [s]"]) < 5.0
    active.regulator = ideal
    wait_for_fault(active, Reason.NONE)
    wait_for_level(active, b"\x00")


def test_a_leak_vents_if_that_is_the_policy(active):
    assert active.set_parameter("pressure.fault_policy", "vent").successful
    active.regulator = ideal
    active.wrap(RADIUS)
    active.regulator = leaking
    active.wait_for_state(State.FAULT, Reason.PRESSURE_LOW)
    active.wait_until(lambda: active.pressures[-1] == 0.0, "the vent")
    active.regulator = ideal
    wait_for_fault(active, Reason.NONE)
    assert active.status.state == State.FAULT
    assert active.rearm().success
    active.wrap(RADIUS)


def test_measured_pressure_that_stops_is_lost_and_the_command_counts_again(active):
    assert active.set_parameter("measured_pressure.timeout", 0.3).successful
    active.regulator = ideal
    active.wrap(RADIUS)
    active.wait_until(lambda: active.status.wrapped, "the wrap")
    active.regulator = None
    status = wait_for_fault(active, Reason.PRESSURE_LOST)
    assert not status.measured_pressure
    assert status.regime == GripStatus.REGIME_PERFECT_WRAP
    active.regulator = ideal
    wait_for_fault(active, Reason.NONE)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, -2.0e5, 1.0e9])
def test_a_measured_pressure_that_cannot_be_is_reported_and_never_passed_on(active, bad):
    active.wrap(RADIUS)
    active.regulator = lambda pressure: bad
    status = wait_for_fault(active, Reason.PRESSURE_INVALID)
    assert "measured_pressure" in status.fault_text
    assert status.state == State.TRACKING
    assert not status.measured_pressure
    assert all_finite(*active.statuses, *active.measured_backbones)


def test_an_absolute_pressure_is_told_apart(active):
    active.regulator = lambda pressure: pressure + 101325.0
    status = wait_for_fault(active, Reason.PRESSURE_HIGH)
    assert "absolute" in status.fault_text


def test_a_pressure_beyond_the_description_has_no_shape(active, gripper):
    beyond = gripper.pressure_max + 5.0e4
    active.wrap(RADIUS)
    active.regulator = lambda pressure: beyond
    wait_for_fault(active, Reason.PRESSURE_HIGH)
    status = wait_for_measured(active, beyond)
    assert status.regime == GripStatus.REGIME_UNKNOWN
    assert not status.wrapped
    assert all_finite(*active.statuses)


def test_a_wrap_that_the_measured_pressure_does_not_make_fails(tolerant):
    assert tolerant.set_parameter("grasp.timeout", 4.0).successful
    tolerant.regulator = leaking
    client = ActionClient(tolerant, Grasp, "grasp")
    assert client.wait_for_server(DEADLINE)
    sent = client.send_goal_async(Grasp.Goal(object_radius=RADIUS))
    tolerant.wait_until(sent.done, "the goal's acceptance")
    ended = sent.result().get_result_async()
    tolerant.wait_until(ended.done, "the goal's end")
    result = ended.result().result
    assert not result.success
    assert Reason(result.reason) is Reason.WRAP_FAILED
    assert result.measured_pressure
    assert all_finite(result)
    tolerant.wait_for_state(State.RELEASED, Reason.WRAP_FAILED)
    client.destroy()
