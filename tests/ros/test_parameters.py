# SPDX-License-Identifier: Apache-2.0
import math
from operator import attrgetter

import pytest

from spiral_core import InvalidInputError
from spiral_gripper_ros.control.limits import AbortPolicy, FaultPolicy, Limits, TimeoutPolicy
from spiral_gripper_ros.parameters.spec import (
    GRAVITY_LIMIT,
    gravity_problem,
    may_be_unset,
)
from spiral_gripper_ros.parameters.table import (
    PARAMETERS,
    GripperParameters,
)

DEFAULTS = {spec.name: spec.default for spec in PARAMETERS}
NUMBERS = [spec for spec in PARAMETERS if spec.low is not None]


def test_names_are_unique_and_every_parameter_is_described():
    assert len(DEFAULTS) == len(PARAMETERS)
    for spec in PARAMETERS:
        assert spec.description.endswith(".")
        assert (spec.low is None) == (spec.high is None)


def test_a_name_is_the_path_of_its_value():
    values = GripperParameters()
    for spec in PARAMETERS:
        value = attrgetter(spec.name)(values)
        assert value == spec.default or value != value, spec.name


def test_the_defaults_are_accepted():
    assert GripperParameters.refusal(DEFAULTS) is None


@pytest.mark.parametrize("spec", NUMBERS, ids=lambda spec: spec.name)
def test_bounds_are_accepted_and_what_lies_outside_is_not(spec):
    assert GripperParameters.refusal({spec.name: spec.low}) is None
    assert GripperParameters.refusal({spec.name: spec.high}) is None
    unset = () if may_be_unset(spec) else (math.nan,)
    for bad in (spec.low - 1.0, 2.0 * spec.high, *unset, math.inf, -math.inf, True, "1"):
        refusal = GripperParameters.refusal({spec.name: bad})
        assert refusal is not None, bad
        assert spec.name in refusal


@pytest.mark.parametrize(
    ("name", "policies"),
    [
        ("radius.timeout_policy", TimeoutPolicy),
        ("grasp.abort_policy", AbortPolicy),
        ("pressure.fault_policy", FaultPolicy),
    ],
)
def test_a_choice_that_is_none_names_those_there_are(name, policies):
    refusal = GripperParameters.refusal({name: "panic"})
    for policy in policies:
        assert policy.value in refusal
        assert GripperParameters.refusal({name: policy.value}) is None


def test_a_gripper_has_a_name():
    assert GripperParameters.refusal({"gripper": "prototype_p1"}) is None
    assert "not empty" in GripperParameters.refusal({"gripper": ""})


def test_parameters_of_others_are_none_of_its_business():
    assert GripperParameters.refusal({"use_sim_time": True}) is None


@pytest.mark.parametrize(
    "gravity",
    [(1.0, 2.0), (1.0, 2.0, 3.0, 4.0), (math.nan, 0.0, 0.0), (0.0, 0.0, 1.01 * GRAVITY_LIMIT)],
)
def test_a_gravity_that_is_none_is_refused(gravity):
    assert gravity_problem(gravity) is not None
    assert GripperParameters.refusal({"gravity.vector": gravity}) is not None


def test_weightlessness_is_a_gravity():
    assert gravity_problem((0.0, 0.0, 0.0)) is None


@pytest.mark.parametrize(
    ("parameter", "expected"),
    [(math.nan, 1.0e5), (0.0, 0.0), (6.0e4, 6.0e4), (1.0e5, 1.0e5), (9.0e5, 1.0e5)],
)
def test_no_parameter_raises_the_cap_above_the_grippers_limit(parameter, expected):
    values = GripperParameters.from_names({"pressure.cap": parameter})
    assert values.limits(pressure_max=1.0e5).pressure_cap == expected


def test_every_limit_comes_from_its_parameter():
    values = GripperParameters.from_names(
        {
            "pressure.rate_up": 101.0,
            "pressure.rate_down": 102.0,
            "radius.timeout": 103.0,
            "radius.timeout_policy": "vent",
            "radius.rate_limit": 0.104,
            "radius.jump_limit": 0.105,
            "radius.hysteresis": 0.0106,
            "grasp.timeout": 107.0,
            "grasp.abort_policy": "hold",
            "measured_pressure.timeout": 108.0,
            "pressure.settle_time": 10.9,
            "pressure.tolerance": 110.0,
            "pressure.fault_policy": "vent",
            "grip.ratio": 1.15,
            "keep_alive.timeout": 116.0,
            "gravity.timeout": 117.0,
            "gravity.timeout_policy": "vent",
        }
    )
    assert values.limits(pressure_max=1.0e5) == Limits(
        pressure_cap=1.0e5,
        pressure_rate_up=101.0,
        pressure_rate_down=102.0,
        radius_timeout=103.0,
        radius_timeout_policy=TimeoutPolicy.VENT,
        radius_rate_limit=0.104,
        radius_jump_limit=0.105,
        radius_hysteresis=0.0106,
        grasp_timeout=107.0,
        grasp_abort_policy=AbortPolicy.HOLD,
        measured_pressure_timeout=108.0,
        pressure_settle_time=10.9,
        pressure_tolerance=110.0,
        pressure_fault_policy=FaultPolicy.VENT,
        grip_ratio=1.15,
        keep_alive_timeout=116.0,
        gravity_timeout=117.0,
        gravity_timeout_policy=FaultPolicy.VENT,
    )


def test_the_defaults_of_the_table_are_those_of_the_limits():
    assert GripperParameters().limits(pressure_max=1.0e5) == Limits(
        pressure_cap=1.0e5, grip_ratio=None
    )


@pytest.mark.parametrize(
    "field",
    [
        "pressure_cap",
        "pressure_rate_up",
        "pressure_rate_down",
        "radius_timeout",
        "radius_rate_limit",
        "radius_jump_limit",
        "radius_hysteresis",
        "grasp_timeout",
        "measured_pressure_timeout",
        "pressure_settle_time",
        "pressure_tolerance",
    ],
)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0])
def test_limits_refuse_what_is_no_limit(field, bad):
    with pytest.raises(InvalidInputError, match=field):
        Limits(**{"pressure_cap": 1.0e5, field: bad})


@pytest.mark.parametrize(
    ("field", "names"),
    [
        ("radius_timeout_policy", "hold, vent, ramp_down"),
        ("grasp_abort_policy", "vent, hold"),
        ("pressure_fault_policy", "report, vent"),
    ],
)
def test_a_policy_must_be_one(field, names):
    with pytest.raises(InvalidInputError, match=f"{field} must be one of {names}"):
        Limits(**{"pressure_cap": 1.0e5, field: "vent"})


def test_no_number_is_too_large_to_be_refused():
    assert "publish.rate must be" in GripperParameters.refusal({"publish.rate": 10**400})
