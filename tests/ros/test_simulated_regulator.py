# SPDX-License-Identifier: Apache-2.0
"""The simulated regulator: commands, reports, its watchdog, and what can be wrong with it."""

import math
from dataclasses import replace

import numpy as np
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
ANY_FLOAT = st.floats(allow_nan=True, allow_infinity=True)


def regulator_at(pressure, model=MODEL, seed=0):
    """A regulator that has settled at a pressure and has heard the command for it just now."""
    regulator = SimulatedRegulator(replace(model, watchdog_timeout=60.0, seed=seed))
    regulator.command(pressure)
    regulator.step(50.0)
    regulator.command(pressure)
    regulator.model = model
    return regulator


@given(
    start=st.floats(0.0, 3.0e5),
    target=st.floats(0.0, 3.0e5),
    fault=st.sampled_from([Fault.NONE, Fault.LEAK]),
    duration=st.floats(0.0, 0.5),
)
def test_it_solves_the_documented_equation(start, target, fault, duration):
    regulator = regulator_at(start)
    regulator.fault = fault
    regulator.command(target)
    regulator.step(duration)
    leak_rate = 1.0 / MODEL.leak_time if fault is Fault.LEAK else 0.0
    solved = solve_ivp(
        lambda _, p: (target - p) / MODEL.time_constant - leak_rate * p,
        (0.0, duration),
        [start],
        rtol=1e-10,
        atol=1e-6,
    )
    # What rounding and the integrator leave of at most 3e5 Pa.
    assert regulator.pressure == pytest.approx(solved.y[0, -1], rel=1e-6, abs=1e-3)


@given(st.lists(st.floats(0.0, 0.4), min_size=1, max_size=30))
def test_how_the_time_is_cut_makes_no_difference_even_across_the_watchdog(steps):
    fine, coarse = regulator_at(6.0e4), regulator_at(6.0e4)
    for step in steps:
        fine.step(step)
    coarse.step(math.fsum(steps))
    assert fine.pressure == pytest.approx(coarse.pressure, rel=1e-9, abs=1e-6)


@given(
    events=st.lists(
        st.tuples(st.floats(0.0, 1.0), ANY_FLOAT | st.floats(0.0, 3.0e5), st.sampled_from(Fault)),
        max_size=20,
    )
)
def test_whatever_happens_the_pressure_is_between_empty_and_the_supply(events):
    regulator = SimulatedRegulator(replace(MODEL, pressure_noise=1.0e4, pressure_resolution=70.0))
    for duration, command, fault in events:
        regulator.fault = fault
        regulator.command(command)
        regulator.step(duration)
        assert 0.0 <= regulator.pressure <= MODEL.supply_pressure
        report = regulator.report()
        assert report is None or 0.0 <= report <= MODEL.supply_pressure


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0])
def test_a_model_or_a_time_that_cannot_be_is_refused(bad):
    for field in (spec.name for spec in MODEL.specs() if spec.low is not None):
        with pytest.raises(InvalidInputError, match=field):
            replace(MODEL, **{field: bad})
    with pytest.raises(InvalidInputError, match="duration"):
        SimulatedRegulator(MODEL).step(bad)


def test_a_gripper_is_empty_so_long_after_the_last_command():
    # docs/simulation.md: from 57 kPa to 1 kPa in 0.90 s, with the default parameters.
    regulator = regulator_at(5.7e4)
    regulator.step(0.5 - 1e-9)
    assert (regulator.target, regulator.watchdog_vented) == (5.7e4, False)
    regulator.step(2e-9)
    assert (regulator.target, regulator.watchdog_vented) == (0.0, True)
    regulator.step(0.4)
    assert regulator.pressure > 1000.0
    regulator.step(0.01)
    assert regulator.pressure < 1000.0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0, 3.0e5 + 1.0, None])
def test_a_command_that_cannot_be_or_is_not_heard_feeds_no_watchdog_and_only_nothing_ends_its_vent(
    bad,
):
    regulator = regulator_at(6.0e4)
    regulator.fault = Fault.LOST_LINK if bad is None else Fault.NONE
    for _ in range(20):
        assert not regulator.command(6.0e4 if bad is None else bad)
        regulator.step(0.1)
        assert (regulator.report() is None) is (bad is None)
    assert regulator.refused == (0 if bad is None else 20)
    regulator.fault = Fault.NONE
    assert not regulator.command(2.0e4)
    assert (regulator.target, regulator.watchdog_vented) == (0.0, True)
    assert regulator.pressure < 1.0
    assert regulator.command(0.0)
    assert regulator.command(2.0e4)
    assert (regulator.target, regulator.watchdog_vented) == (2.0e4, False)


def test_reports_have_the_noise_of_their_seed_and_the_resolution_that_they_should():
    model = replace(MODEL, pressure_noise=200.0)
    first, again, other = (
        [noisy.report() for _ in range(4000)]
        for noisy in (regulator_at(6.0e4, model, seed) for seed in (1, 1, 2))
    )
    assert first == again != other
    # The mean and the deviation of 4000 samples scatter by 1.6 % and 1.1 % of the deviation.
    assert np.mean(first) == pytest.approx(6.0e4, abs=20.0)
    assert np.std(first) == pytest.approx(200.0, rel=0.06)
    full = regulator_at(3.0e5, model)
    assert max(full.report() for _ in range(20)) == MODEL.supply_pressure
    coarse = regulator_at(6.01234e4, replace(MODEL, pressure_resolution=250.0))
    assert coarse.report() == 60000.0
