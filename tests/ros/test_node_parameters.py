# SPDX-License-Identifier: Apache-2.0
"""Parameters of the running node: what is refused, and that good values act at once."""

import math

import numpy as np
import pytest
import yaml
from rcl_interfaces.msg import Parameter, ParameterType
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import get_parameter_value
from ros.harness import NODE

from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.parameters.spec import may_be_unset
from spiral_gripper_ros.parameters.table import PARAMETERS


def test_every_parameter_is_declared_as_the_table_says(active):
    described = {d.name: d for d in active.describe_parameters()}
    for spec in PARAMETERS:
        descriptor = described[spec.name]
        assert descriptor.description == spec.description
        assert descriptor.read_only == spec.read_only
        ranges = [*descriptor.floating_point_range, *descriptor.integer_range]
        bounds = [(r.from_value, r.to_value) for r in ranges]
        has_range = spec.low is not None and not may_be_unset(spec)
        assert bounds == ([(spec.low, spec.high)] if has_range else [])
    own = {spec.name for spec in PARAMETERS}
    others = {"use_sim_time", "start_type_description_service"}
    assert {name for name in described if "qos_overrides" not in name} - others == own


def test_what_the_node_dumps_loads_and_the_grip_is_kept(active):
    """As `ros2 param load` does: each value as YAML, read again, set by itself."""
    assert active.set_parameter("radius.hysteresis", 1.0e-5).successful
    assert active.set_parameter("gravity.vector", [math.nan] * 3).successful
    names = [spec.name for spec in PARAMETERS if not spec.read_only]
    held = active.wrap(0.02).pressure_command
    active.forget()
    dumped = zip(names, active.get_parameters_of_node(names), strict=True)
    values = yaml.safe_load(yaml.dump(dict(dumped)))
    for name, value in values.items():
        message = Parameter(name=name, value=get_parameter_value(str(value)))
        request = SetParameters.Request(parameters=[message])
        (result,) = active.call(SetParameters, f"{NODE}/set_parameters", request).results
        assert result.successful, (name, value, result.reason)
    active.hear_more()
    assert set(active.pressures) == {held}


def test_nothing_is_quoted_of_a_file_that_is_no_description(active, tmp_path):
    file = tmp_path / "passwd"
    file.write_text("root:secret:0:0\n")
    refused = active.set_parameter("gripper", str(file))
    assert not refused.successful
    assert "holds none of a description's fields" in refused.reason
    assert "secret" not in refused.reason


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("radius.timeout", -1.0, "out of range"),
        ("radius.timeout", math.nan, "out of range"),
        ("radius.timeout", math.inf, "out of range"),
        ("pressure.cap", -1.0, "from 0 to 1e+06"),
        ("pressure.rate_up", 0.0, "out of range"),
        ("publish.backbone_points", 1, "out of range"),
        ("radius.timeout_policy", "panic", "one of hold, vent, ramp_down"),
        ("gravity.vector", [0.0, 0.0], "3 finite numbers"),
        ("gravity.vector", [0.0, 0.0, math.nan], "3 finite numbers"),
        ("gravity.vector", [0.0, 0.0, -981.0], "norm at most"),
        ("radius.timeout", "long", "type"),
        ("frame_id", "elsewhere", "read-only"),
        ("autostart", False, "read-only"),
        ("gripper", "no_such_gripper", "no gripper has this name"),
        ("gripper", "", "not empty"),
        ("gripper", "/dev/zero", "not a plain file"),
        ("pressure.fault_policy", "panic", "one of report, vent"),
        ("publish.marker_rate", -1.0, "out of range"),
    ],
)
def test_a_bad_value_is_refused_with_the_reason_and_changes_nothing(active, name, value, reason):
    before = active.get_parameter_of_node(name)
    result = active.set_parameter(name, value)
    assert not result.successful
    assert reason in result.reason
    after = active.get_parameter_of_node(name)
    assert before == after or np.array_equal(before, after, equal_nan=True)


def test_the_cap_acts_at_once_and_cannot_exceed_the_grippers_limit(active, gripper):
    assert active.wrap(0.011).pressure_command > 6.0e4
    assert active.set_parameter("pressure.cap", 6.0e4).successful
    status = active.wait_for_state(State.HOLDING, Reason.PRESSURE_CAP)
    active.wait_until(lambda: active.pressures[-1] == 6.0e4, "the command at the cap")
    assert status.pressure_command <= 6.0e4
    assert active.set_parameter("pressure.cap", 9.0e5).successful
    # A status that was under way may still tell of the lower cap.
    active.wait_until(lambda: active.wrap(0.011).pressure_target > 6.0e4, "the wrap above it")
    target = active.status.pressure_target
    told = active.wait_for_plan(0.011, target)
    margin = gripper.pressure_max - target
    assert told.plan[0].pressure_margin == pytest.approx(margin)


def test_the_publish_rate_acts_at_once(active):
    assert active.set_parameter("publish.rate", 200.0).successful
    active.hear_more()
    active.statuses.clear()

    def median_period():
        stamps = [message.header.stamp for message in active.statuses[-100:]]
        return np.median(np.diff([stamp.sec + 1e-9 * stamp.nanosec for stamp in stamps]))

    # A busy machine is late for a while; at the default rate it is never below 0.02 s.
    active.wait_until(
        lambda: len(active.statuses) > 100 and median_period() < 0.01, "statuses at 200 Hz"
    )


def test_the_number_of_poses_acts_with_the_next_shape(active):
    assert active.set_parameter("publish.backbone_points", 7).successful
    active.wrap(0.02)
    active.wait_until(
        lambda: active.backbones and len(active.backbones[-1].poses) == 7, "a backbone of 7 poses"
    )


def test_the_gravity_parameter_acts_at_once(active):
    before = active.wrap(0.02).pressure_command
    assert active.set_parameter("gravity.vector", [0.0, 0.0, -9.80665]).successful
    active.wait_until(
        lambda: abs(active.wrap(0.02).pressure_command - before) > 100.0, "another pressure"
    )


def test_every_parameter_has_a_value_to_dump(active):
    # One without would leave `ros2 param dump` without any.
    request = GetParameters.Request(names=[spec.name for spec in PARAMETERS])
    answer = active.call(GetParameters, f"{NODE}/get_parameters", request)
    assert len(answer.values) == len(PARAMETERS)
    assert all(value.type != ParameterType.PARAMETER_NOT_SET for value in answer.values)


def test_gravity_can_be_unset(active):
    before = active.wrap(0.02).pressure_command
    assert active.set_parameter("gravity.vector", [0.0, 0.0, -9.80665]).successful
    active.wait_until(lambda: active.wrap(0.02).pressure_command != before, "another pressure")
    assert active.set_parameter("gravity.vector", [math.nan] * 3).successful
    active.wait_until(lambda: active.wrap(0.02).pressure_command == before, "the first pressure")


def test_the_radius_limits_act_at_once(active):
    active.set_parameter("radius.rate_limit", 1.0e-4)
    active.wrap(0.02)
    active.send_radius(0.03)
    active.wait_for_state(State.HOLDING, Reason.RADIUS_JUMP)
    assert active.set_parameter("radius.jump_limit", 0.02).successful
    active.wrap(0.03)


def test_the_table_is_what_the_node_answers_to_its_name(active):
    assert active.count_services(f"{active.get_namespace()}/{NODE}/set_parameters") == 1
