# SPDX-License-Identifier: Apache-2.0
import math
from dataclasses import replace

import pytest

from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.radius_gate import RadiusGate
from spiral_gripper_ros.control.states import Reason

RANGE = (0.01, 0.04)
LIMITS = Limits(pressure_cap=1.0e5, radius_rate_limit=0.05, radius_jump_limit=0.002)


def reason(gate, now, radius, limits=LIMITS):
    refusal = gate.refusal(now, radius, RANGE, limits)
    return Reason.NONE if refusal is None else refusal.reason


@pytest.mark.parametrize(
    ("radius", "expected"),
    [
        (math.nan, Reason.RADIUS_NOT_FINITE),
        (math.inf, Reason.RADIUS_NOT_FINITE),
        (-math.inf, Reason.RADIUS_NOT_FINITE),
        (0.0, Reason.RADIUS_NOT_POSITIVE),
        (-0.02, Reason.RADIUS_NOT_POSITIVE),
        (math.nextafter(0.01, 0.0), Reason.RADIUS_TOO_SMALL),
        (0.01, Reason.NONE),
        (0.04, Reason.NONE),
        (math.nextafter(0.04, 1.0), Reason.RADIUS_TOO_LARGE),
    ],
)
def test_impossible_radii_are_refused_by_their_reason(radius, expected):
    assert reason(RadiusGate(), 0.0, radius) is expected


def test_the_text_names_the_value_and_the_nearest_that_can_be_gripped():
    text = RadiusGate().refusal(0.0, 0.09, RANGE, LIMITS).text
    assert "0.09 m" in text
    assert "0.04 m" in text


def test_the_first_radius_is_believed_and_a_small_change_follows():
    gate = RadiusGate()
    assert reason(gate, 0.0, 0.02) is Reason.NONE
    assert reason(gate, 0.0, 0.0219) is Reason.NONE


def test_an_outlier_is_refused_and_does_not_spoil_what_follows():
    gate = RadiusGate()
    assert reason(gate, 0.0, 0.02) is Reason.NONE
    assert reason(gate, 0.02, 0.035) is Reason.RADIUS_JUMP
    assert reason(gate, 0.04, 0.02) is Reason.NONE


@pytest.mark.parametrize("period", [0.001, 0.01, 0.1])
def test_a_real_step_is_believed_after_the_same_time_at_any_message_rate(period):
    gate = RadiusGate()
    reason(gate, 0.0, 0.02)
    step, now = 0.012, 0.0
    expected = (step - LIMITS.radius_jump_limit) / LIMITS.radius_rate_limit
    while reason(gate, now, 0.02 + step) is Reason.RADIUS_JUMP:
        now += period
    assert expected - 1e-9 <= now <= expected + period + 1e-9


def test_impossible_radii_do_not_move_what_is_believed():
    gate = RadiusGate()
    reason(gate, 0.0, 0.02)
    for now in (0.5, 1.0, 1.5):
        assert reason(gate, now, 0.3) is Reason.RADIUS_TOO_LARGE
    assert reason(gate, 1.5, math.nan) is Reason.RADIUS_NOT_FINITE
    assert reason(gate, 1.5, 0.02) is Reason.NONE


def test_after_a_reset_the_next_radius_is_believed():
    gate = RadiusGate()
    reason(gate, 0.0, 0.011)
    gate.reset()
    assert reason(gate, 0.0, 0.039) is Reason.NONE


def test_time_that_runs_backwards_allows_nothing():
    gate = RadiusGate()
    reason(gate, 10.0, 0.02)
    assert reason(gate, 0.0, 0.03) is Reason.RADIUS_JUMP


def test_wider_limits_accept_more():
    gate = RadiusGate()
    wide = replace(LIMITS, radius_jump_limit=0.02)
    reason(gate, 0.0, 0.02)
    assert reason(gate, 0.0, 0.035, wide) is Reason.NONE
