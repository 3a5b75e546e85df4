# SPDX-License-Identifier: Apache-2.0
"""The simulated regulator: commands, reports, its watchdog, and what can be wrong with it."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from spiral_core import InvalidInputError
from spiral_gripper_ros.simulation.regulator import (
    Fault,
    SimulatedRegulator,
    SimulatedRegulatorParameters,
)

MODEL = SimulatedRegulatorParameters(pressure_noise=0.0, pressure_resolution=0.0)
SUPPLY = MODEL.supply_pressure
PRESSURES = st.floats(0.0, SUPPLY)


def regulator_at(pressure, **model):
    """A regulator that has settled at a pressure and has heard the command for it just now."""
    regulator = SimulatedRegulator(replace(MODEL, watchdog_timeout=60.0, **model))
    regulator.command(pressure)
    regulator.step(50.0)
    regulator.command(pressure)
    regulator.model = replace(MODEL, **model)
    return regulator


@given(PRESSURES, PRESSURES, st.sampled_from(Fault), st.lists(st.floats(0.0, 0.4), max_size=9))
def test_it_solves_the_documented_equation_however_the_time_is_cut(start, target, fault, steps):
    regulator = regulator_at(start)
    regulator.command(target)
    regulator.fault = fault
    for step in steps:
        regulator.step(step)
    leak_rate = 1.0 / MODEL.leak_time if fault is Fault.LEAK else 0.0
    total, pressure = math.fsum(steps), start
    for duration, goal in ((min(total, 0.5), target), (max(total - 0.5, 0.0), 0.0)):
        solved = solve_ivp(
            lambda _, p, goal=goal: (goal - p) / MODEL.time_constant - leak_rate * p,
            (0.0, duration),
            [pressure],
            rtol=1e-10,
            atol=1e-6,
        )
        pressure = start if fault is Fault.STUCK_VALVE else solved.y[0, -1]
    # What rounding and the integrator leave of at most 3e5 Pa.
    assert regulator.pressure == pytest.approx(pressure, rel=1e-6, abs=1e-3)


@given(st.lists(st.tuples(st.floats(0.0, 1.0), st.floats() | PRESSURES, st.sampled_from(Fault))))
def test_whatever_happens_the_pressure_is_between_empty_and_the_supply(events):
    regulator = SimulatedRegulator(replace(MODEL, pressure_noise=1.0e4, pressure_resolution=70.0))
    for duration, command, regulator.fault in events:
        regulator.command(command)
        regulator.step(duration)
        assert 0.0 <= regulator.pressure <= SUPPLY
        assert 0.0 <= (regulator.report() or 0.0) <= SUPPLY


def test_a_gripper_is_empty_so_long_after_the_last_command():
    # docs/simulation.md: from 57 kPa to 1 kPa in 0.90 s, with the default parameters.
    regulator = regulator_at(5.7e4)
    regulator.step(0.9)
    assert regulator.pressure > 1000.0
    regulator.step(0.01)
    assert regulator.pressure < 1000.0
    with pytest.raises(InvalidInputError, match="duration"):
        regulator.step(math.nan)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0, SUPPLY + 1.0, None])
def test_what_is_no_command_feeds_no_watchdog_and_only_a_command_of_nothing_ends_its_vent(bad):
    regulator = regulator_at(6.0e4)
    regulator.fault = Fault.LOST_LINK if bad is None else Fault.NONE
    for _ in range(20):
        assert not regulator.command(6.0e4 if bad is None else bad)
        regulator.step(0.1)
        assert (regulator.report() is None) is (bad is None)
    assert regulator.refused == (0 if bad is None else 20)
    regulator.fault, regulator.model = Fault.NONE, replace(MODEL, watchdog_timeout=60.0)
    assert not regulator.command(2.0e4)
    assert (regulator.target, regulator.pressure < 1.0) == (0.0, True)
    assert regulator.command(0.0)
    assert regulator.command(2.0e4)
    assert (regulator.target, regulator.watchdog_vented) == (2.0e4, False)
