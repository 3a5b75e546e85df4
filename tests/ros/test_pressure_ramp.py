# SPDX-License-Identifier: Apache-2.0
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.target import LONGEST_STEP, capped_pressure, ramped_pressure

LIMITS = Limits(pressure_cap=1.0e5, pressure_rate_up=5.0e4, pressure_rate_down=2.0e5)
ANY_FLOAT = st.floats(allow_nan=True, allow_infinity=True)


def test_the_ramp_rises_and_falls_at_its_rates():
    assert ramped_pressure(1.0e4, 9.0e4, 0.02, LIMITS) == pytest.approx(1.0e4 + 5.0e4 * 0.02)
    assert ramped_pressure(9.0e4, 0.0, 0.02, LIMITS) == pytest.approx(9.0e4 - 2.0e5 * 0.02)


def test_the_ramp_ends_exactly_at_the_goal():
    assert ramped_pressure(4.9999e4, 5.0e4, 0.02, LIMITS) == 5.0e4
    assert ramped_pressure(5.0001e4, 5.0e4, 0.02, LIMITS) == 5.0e4


def test_a_stalled_process_does_not_jump():
    step = ramped_pressure(0.0, 1.0e5, 100.0, LIMITS)
    assert step == pytest.approx(LIMITS.pressure_rate_up * 0.1)


def test_time_that_runs_backwards_moves_nothing():
    assert ramped_pressure(3.0e4, 9.0e4, -1.0, LIMITS) == 3.0e4


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("position", [0, 1, 2])
def test_a_number_that_is_not_finite_vents(bad, position):
    arguments = [3.0e4, 9.0e4, 0.02]
    arguments[position] = bad
    assert ramped_pressure(*arguments, LIMITS) == 0.0


@given(previous=ANY_FLOAT, goal=ANY_FLOAT, elapsed=ANY_FLOAT)
def test_whatever_comes_in_the_cap_and_the_rates_hold(previous, goal, elapsed):
    command = ramped_pressure(previous, goal, elapsed, LIMITS)
    assert 0.0 <= command <= LIMITS.pressure_cap
    if 0.0 <= previous <= LIMITS.pressure_cap and command > 0.0:
        assert command - previous <= LIMITS.pressure_rate_up * LONGEST_STEP * (1.0 + 1e-12)
        assert previous - command <= LIMITS.pressure_rate_down * LONGEST_STEP * (1.0 + 1e-12)


@given(pressure=ANY_FLOAT, cap=ANY_FLOAT)
def test_the_cap_is_safe_for_any_float(pressure, cap):
    command = capped_pressure(pressure, cap)
    assert command == 0.0 or 0.0 < command <= cap
    assert math.isfinite(command)


def test_the_cap_passes_what_is_below_it():
    assert capped_pressure(3.0e4, 1.0e5) == 3.0e4
    assert capped_pressure(3.0e5, 1.0e5) == 1.0e5
    assert capped_pressure(-1.0, 1.0e5) == 0.0
