# SPDX-License-Identifier: Apache-2.0
"""Parameters of the running node: refused, or in effect at once; another gripper among them."""

import math

import numpy as np
import pytest
import yaml
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import DescribeParameters, ListParameters, SetParameters
from rclpy.parameter import get_parameter_value
from ros.harness import NODE

from spiral_core import WrapCurve
from spiral_gripper import load_gripper
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.parameters.spec import may_be_unset
from spiral_gripper_ros.parameters.table import PARAMETERS

RADIUS = 0.02
OTHER = "prototype_p1"
LIMIT = "pressure_max: 16 psi"
UPRIGHT = (0.0, 0.0, -9.80665)


def test_every_parameter_is_declared_as_the_table_says(active):
    listed = active.call(ListParameters, f"{NODE}/list_parameters").result.names
    request = DescribeParameters.Request(names=listed)
    described = active.call(DescribeParameters, f"{NODE}/describe_parameters", request).descriptors
    found = {
        one.name: (one.description, one.read_only, [(r.from_value, r.to_value) for r in ranges])
        for one in described
        for ranges in [[*one.floating_point_range, *one.integer_range]]
        if "qos_overrides" not in one.name
    }
    for name in ("use_sim_time", "start_type_description_service"):
        del found[name]
    assert found == {
        spec.name: (
            spec.description,
            spec.read_only,
            [] if spec.low is None or may_be_unset(spec) else [(spec.low, spec.high)],
        )
        for spec in PARAMETERS
    }


def test_what_the_node_dumps_loads_and_the_grip_is_kept(active):
    """As `ros2 param load` does: each value as YAML, read again, set by itself."""
    active.change("radius.hysteresis", 1.0e-5)
    active.change("gravity.vector", [math.nan] * 3)
    held = active.wrap(RADIUS).pressure_command
    active.forget()
    values = active.get_parameters_of_node([spec.name for spec in PARAMETERS])
    assert None not in values  # one without a value would leave `ros2 param dump` without any
    dumped = {s.name: v for s, v in zip(PARAMETERS, values, strict=True) if not s.read_only}
    for name, value in yaml.safe_load(yaml.dump(dumped)).items():
        message = Parameter(name=name, value=get_parameter_value(str(value)))
        request = SetParameters.Request(parameters=[message])
        (result,) = active.call(SetParameters, f"{NODE}/set_parameters", request).results
        assert result.successful, (name, value, result.reason)
    active.hear_more()
    assert set(active.pressures) == {held}


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("radius.timeout", math.nan, "out of range"),
        ("publish.backbone_points", 1, "out of range"),
        ("radius.timeout_policy", "panic", "one of hold, vent, ramp_down"),
        ("gravity.vector", [0.0, 0.0, -981.0], "norm at most"),
        ("frame_id", "elsewhere", "read-only"),
    ],
)
def test_a_bad_value_is_refused_with_the_reason_and_changes_nothing(active, name, value, reason):
    before = active.get_parameter_of_node(name)
    result = active.set_parameter(name, value)
    assert not result.successful
    assert reason in result.reason
    after = active.get_parameter_of_node(name)
    assert before == after or np.array_equal(before, after, equal_nan=True)


# --- another gripper ---------------------------------------------------------------------------


@pytest.fixture
def describe(tmp_path):
    """Return what writes the other gripper's description, with a change, and returns its file."""
    file = tmp_path / "mine.yaml"

    def write(old=LIMIT, new=LIMIT):
        text = (GRIPPERS.path / f"{OTHER}.yaml").read_text()
        assert old in text
        file.write_text(text.replace(old, new, 1))
        return str(file)

    return write


@pytest.fixture(scope="module")
def other():
    return WrapCurve(load_gripper(OTHER))


def load(client, gripper, curve):
    """Set another gripper and wait until it is planned with."""
    client.change("gripper", gripper)
    wanted = pytest.approx([curve.radius_min, curve.radius_max])
    client.wait_until(
        lambda: client.wraps and list(client.wraps[-1].radius_range) == wanted, "the other gripper"
    )


def test_another_gripper_vents_is_loaded_and_followed_after_rearm(active, other):
    """Gravity that was told is kept."""
    active.wait_for_plan(RADIUS, active.wrap(RADIUS).pressure_target)
    active.send_gravity(UPRIGHT)
    before = active.wraps[-1].radius_range
    active.wait_until(lambda: active.wraps[-1].radius_range != before, "the gravity")
    upright = WrapCurve(other.gripper.with_mount(UPRIGHT, None))
    load(active, OTHER, upright)
    status = active.wait_for_state(State.RELEASED, Reason.RECONFIGURED)
    assert status.pressure_command == status.pressure_target == 0.0
    active.wait_for_vent()
    active.forget()
    for _ in range(5):
        active.send_radius(RADIUS)
        active.hear_more(1)
    assert set(active.pressures) == {0.0}
    assert active.rearm().success
    wanted = pytest.approx(upright.pressure_from_radius(RADIUS), rel=1e-9)
    assert active.wrap(RADIUS).pressure_command == wanted
    active.wait_until(
        lambda: active.diagnostics and active.diagnostics[-1].hardware_id == OTHER, "diagnostics"
    )


def test_a_gripper_that_is_none_is_refused_and_the_grip_is_kept(active, describe, tmp_path):
    pressure = active.wrap(RADIUS).pressure_command
    active.pressures.clear()
    secret = tmp_path / "passwd"
    secret.write_text("root:secret:0:0\n")
    for name, reason in (
        (describe("length:", "lenght:"), "lenght"),
        (str(secret), "holds none of a description's fields"),
    ):
        result = active.set_parameter("gripper", name)
        assert not result.successful
        assert reason in result.reason
        assert "root:" not in result.reason
    active.hear_more()
    assert set(active.pressures) == {pressure}


def test_a_gripper_that_cannot_coil_is_a_fault_until_a_good_one_is_loaded(active, describe):
    """Of the same file, which is read anew; its limit is the cap."""
    active.wrap(RADIUS)
    file = describe(new="pressure_max: 1 kPa")
    active.change("gripper", file)
    status = active.wait_for_state(State.FAULT, Reason.INTERNAL_ERROR)
    assert "cannot be used" in status.reason_text
    assert status.pressure_command == 0.0
    # Re-armed with it, it still grips nothing and says why.
    assert active.rearm().success
    active.send_radius(RADIUS)
    assert "turns" in active.wait_for_state(State.WAITING, Reason.NOT_CERTIFIED).reason_text
    describe(new="pressure_max: 60 kPa")
    load(active, file, WrapCurve(load_gripper(file)))
    active.rearm()
    target = active.wrap(RADIUS).pressure_target
    margin = active.wait_for_plan(RADIUS, target).plan[0].pressure_margin
    assert margin == pytest.approx(6.0e4 - target)
