import math

import pytest

from spiral_core import InvalidInputError
from spiral_gripper_ros.limits import Limits, TimeoutPolicy
from spiral_gripper_ros.parameters import (
    GRAVITY_LIMIT,
    PARAMETERS,
    gravity_problem,
    limits_from_values,
    refusal_of_values,
)

DEFAULTS = {spec.name: spec.default for spec in PARAMETERS}
NUMBERS = [spec for spec in PARAMETERS if spec.low is not None]


def test_names_are_unique_and_every_parameter_is_described():
    assert len(DEFAULTS) == len(PARAMETERS)
    for spec in PARAMETERS:
        assert spec.description.endswith(".")
        assert (spec.low is None) == (spec.high is None)


def test_the_defaults_are_accepted():
    assert refusal_of_values(DEFAULTS, unconfigured=True) is None


@pytest.mark.parametrize("spec", NUMBERS, ids=lambda spec: spec.name)
def test_bounds_are_accepted_and_what_lies_outside_is_not(spec):
    assert refusal_of_values({spec.name: spec.low}, unconfigured=True) is None
    assert refusal_of_values({spec.name: spec.high}, unconfigured=True) is None
    for bad in (spec.low - 1.0, 2.0 * spec.high, math.nan, math.inf, -math.inf, True, "1"):
        refusal = refusal_of_values({spec.name: bad}, unconfigured=True)
        assert refusal is not None, bad
        assert spec.name in refusal


def test_a_choice_that_is_none_names_those_there_are():
    refusal = refusal_of_values({"radius_timeout_policy": "panic"}, unconfigured=True)
    for policy in TimeoutPolicy:
        assert policy.value in refusal


def test_the_gripper_is_chosen_only_while_unconfigured():
    assert refusal_of_values({"gripper": "prototype_p1"}, unconfigured=True) is None
    assert "clean it up" in refusal_of_values({"gripper": "prototype_p1"}, unconfigured=False)
    assert "not empty" in refusal_of_values({"gripper": ""}, unconfigured=True)


def test_parameters_of_others_are_none_of_its_business():
    assert refusal_of_values({"use_sim_time": True}, unconfigured=False) is None


@pytest.mark.parametrize(
    "gravity",
    [(1.0, 2.0), (1.0, 2.0, 3.0, 4.0), (math.nan, 0.0, 0.0), (0.0, 0.0, 1.01 * GRAVITY_LIMIT)],
)
def test_a_gravity_that_is_none_is_refused(gravity):
    assert gravity_problem(gravity) is not None
    assert refusal_of_values({"gravity": gravity}, unconfigured=False) is not None


def test_weightlessness_is_a_gravity():
    assert gravity_problem((0.0, 0.0, 0.0)) is None


@pytest.mark.parametrize(
    ("parameter", "expected"), [(0.0, 1.0e5), (6.0e4, 6.0e4), (1.0e5, 1.0e5), (9.0e5, 1.0e5)]
)
def test_no_parameter_raises_the_cap_above_the_grippers_limit(parameter, expected):
    values = {**DEFAULTS, "pressure_cap": parameter}
    assert limits_from_values(values, pressure_max=1.0e5).pressure_cap == expected


def test_every_limit_comes_from_its_parameter():
    values = {
        **DEFAULTS,
        "pressure_rate_up": 101.0,
        "pressure_rate_down": 102.0,
        "radius_timeout": 103.0,
        "radius_timeout_policy": "vent",
        "radius_rate_limit": 0.104,
        "radius_jump_limit": 0.105,
        "radius_hysteresis": 0.0106,
    }
    assert limits_from_values(values, pressure_max=1.0e5) == Limits(
        pressure_cap=1.0e5,
        pressure_rate_up=101.0,
        pressure_rate_down=102.0,
        radius_timeout=103.0,
        timeout_policy=TimeoutPolicy.VENT,
        radius_rate_limit=0.104,
        radius_jump_limit=0.105,
        radius_hysteresis=0.0106,
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
    ],
)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0])
def test_limits_refuse_what_is_no_limit(field, bad):
    with pytest.raises(InvalidInputError, match=field):
        Limits(**{"pressure_cap": 1.0e5, field: bad})


def test_a_policy_must_be_one():
    with pytest.raises(InvalidInputError, match="hold, vent, ramp_down"):
        Limits(pressure_cap=1.0e5, timeout_policy="vent")
