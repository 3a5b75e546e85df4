# SPDX-License-Identifier: Apache-2.0
"""The parts of the control logic: the ramp, the gate of radii, and the course of a grasp."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ros.control_bench import rows

from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.radius_gate import RadiusGate
from spiral_gripper_ros.control.target import LONGEST_STEP, capped_pressure, ramped_pressure

LIMITS = Limits(
    pressure_cap=1.0e5,
    pressure_rate_up=5.0e4,
    pressure_rate_down=2.0e5,
    radius_rate_limit=0.05,
    radius_jump_limit=0.002,
)


# Previous command, goal, elapsed time: the command. A stalled process does not jump, nor does time
# that runs backwards; what is no number vents.
RAMPS = """
1e4 9e4 0.02 1.1e4
9e4 0 0.02 8.6e4
0 1e5 100 5e3
3e4 9e4 -1 3e4
inf 9e4 0.02 0
3e4 nan 0.02 0
3e4 9e4 inf 0
"""


@pytest.mark.parametrize("row", rows(RAMPS))
def test_the_ramp_keeps_its_rates_and_ends_exactly(row):
    *given, command = map(float, row.split())
    assert ramped_pressure(*given, LIMITS) == pytest.approx(command, rel=1e-15)


@given(st.floats(), st.floats(), st.floats())
def test_whatever_comes_in_the_cap_and_the_rates_hold(previous, goal, elapsed):
    command = ramped_pressure(previous, goal, elapsed, LIMITS)
    assert 0.0 <= command <= LIMITS.pressure_cap
    if 0.0 <= previous <= LIMITS.pressure_cap and command > 0.0:
        rise = (command - previous) / (LONGEST_STEP * (1.0 + 1e-12))
        assert -LIMITS.pressure_rate_down <= rise <= LIMITS.pressure_rate_up


@given(st.floats(), st.floats())
def test_the_cap_is_safe_for_any_float_and_passes_what_is_below_it(pressure, cap):
    is_number = math.isfinite(pressure) and math.isfinite(cap)
    expected = max(min(pressure, cap), 0.0) if is_number else 0.0
    assert capped_pressure(pressure, cap) == expected


def judge(gate, now, radius, limits=LIMITS):
    refusal = gate.refusal(now, radius, (0.01, 0.04), limits)
    return refusal and refusal.reason.name


def test_a_jump_is_refused_and_spoils_nothing_that_follows():
    gate = RadiusGate()
    assert judge(gate, 10.0, 0.02) is judge(gate, 10.0, 0.0219) is None
    assert judge(gate, 10.02, 0.035) == "RADIUS_JUMP"
    assert judge(gate, 10.04, 0.02) is None
    assert judge(gate, 0.0, 0.03) == "RADIUS_JUMP"  # time that runs backwards allows nothing
    assert judge(gate, 0.0, 0.03, replace(LIMITS, radius_jump_limit=0.02)) is None
    gate.reset()
    assert judge(gate, 0.0, 0.039) is None


@pytest.mark.parametrize("period", [0.001, 0.01, 0.1])
def test_a_real_step_is_believed_after_the_same_time_at_any_message_rate(period):
    gate, step, now = RadiusGate(), 0.012, 0.0
    judge(gate, now, 0.02)
    expected = (step - LIMITS.radius_jump_limit) / LIMITS.radius_rate_limit
    while judge(gate, now, 0.02 + step):
        now += period
    assert expected - 1e-9 <= now <= expected + period + 1e-9
