# SPDX-License-Identifier: Apache-2.0
"""The pressure's law, against closed forms, a numerical integration, and itself in other steps."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from spiral_core import InvalidInputError, Orifice, Supply, enclosed_volume
from spiral_gripper.files.description import load_description
from spiral_gripper_ros.simulation.parameters import REGULATOR_PARAMETERS, regulator_model
from spiral_gripper_ros.simulation.valve import Valve, flow_rows

VALVE = Valve(time_constant=0.1, fill_rate=2.0e5, vent_rate=4.0e5)
FREE = Valve(time_constant=0.1, fill_rate=1.0e9, vent_rate=1.0e9)

SUPPLY = Supply(Orifice(1e-9), 3.0e5)
ORIFICE = Valve(0.1, 2.0e5, 4.0e5, flow=flow_rows(SUPPLY, lambda _: 2.6e-5, SUPPLY.pressure))

pressures = st.floats(0.0, 3.0e5)
durations = st.floats(0.0, 2.0)
leaks = st.sampled_from([0.0, 0.1, 5.0, 50.0])


def documented_slope(valve, pressure, target, leak_rate):
    """The equation of the module's docstring."""
    fill, vent = valve.fill_rate, valve.vent_rate
    if valve.flow:
        sites, rises, falls = zip(*valve.flow, strict=True)
        fill, vent = (float(np.interp(pressure, sites, rates)) for rates in (rises, falls))
    rate = (target - pressure) / valve.time_constant
    return min(max(rate, -vent), fill) - leak_rate * pressure


def test_a_small_step_is_the_exponential_of_its_time_constant():
    expected = 4.0e4 * (1.0 - math.exp(-2.5))
    assert FREE.pressure_after(0.25, 0.0, 4.0e4) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("start", "target", "rate"), [(0.0, 3e5, 2e5), (3e5, 0.0, -4e5)])
def test_a_large_step_goes_at_the_limit_of_the_flow(start, target, rate):
    after = VALVE.pressure_after(0.5, start, target)
    assert after == pytest.approx(start + rate * 0.5, rel=1e-12)


@pytest.mark.parametrize(
    ("target", "leak_rate", "expected"),
    [
        (4.0e4, 5.0, 4.0e4 / 1.5),
        (4.0e4, 0.0, 4.0e4),
        (3.0e5, 10.0, 2.0e4),  # the fill valve is wide open and does not keep up
    ],
)
@pytest.mark.parametrize("start", [0.0, 2.5e5])
def test_it_settles_where_the_documentation_says(start, target, leak_rate, expected):
    after = VALVE.pressure_after(100.0, start, target, leak_rate)
    assert after == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("valve", [VALVE, ORIFICE], ids=["rates", "orifice"])
@given(pressure=pressures, target=pressures, leak_rate=leaks, duration=durations)
def test_it_solves_the_documented_equation(valve, pressure, target, leak_rate, duration):
    solved = solve_ivp(
        lambda _, p: [documented_slope(valve, p[0], target, leak_rate)],
        (0.0, duration),
        [pressure],
        rtol=1e-8,
        atol=1e-4,
        max_step=0.002,
    )
    after = valve.pressure_after(duration, pressure, target, leak_rate)
    # The integrator is the coarser of the two: it steps across the kinks of the law.
    assert after == pytest.approx(solved.y[0, -1], rel=1e-5, abs=1.0)


@given(
    pressure=pressures,
    target=pressures,
    leak_rate=leaks,
    steps=st.lists(st.floats(0.0, 0.3), min_size=1, max_size=20),
)
def test_how_the_time_is_cut_makes_no_difference(pressure, target, leak_rate, steps):
    now = pressure
    for step in steps:
        now = VALVE.pressure_after(step, now, target, leak_rate)
    whole = VALVE.pressure_after(math.fsum(steps), pressure, target, leak_rate)
    assert now == pytest.approx(whole, rel=1e-9, abs=1e-6)


@given(pressure=pressures, target=pressures, leak_rate=leaks, duration=durations)
def test_it_stays_between_empty_and_the_higher_end(pressure, target, leak_rate, duration):
    after = VALVE.pressure_after(duration, pressure, target, leak_rate)
    rounding = 1e-12 * max(pressure, target)
    assert -rounding <= after <= max(pressure, target) + rounding


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0])
def test_a_number_that_cannot_be_is_refused(bad):
    with pytest.raises(InvalidInputError):
        VALVE.pressure_after(bad, 0.0, 0.0)
    with pytest.raises(InvalidInputError):
        VALVE.pressure_after(0.1, bad, 0.0)
    with pytest.raises(InvalidInputError):
        VALVE.pressure_after(0.1, 0.0, bad)
    with pytest.raises(InvalidInputError):
        VALVE.pressure_after(0.1, 0.0, 0.0, bad)
    with pytest.raises(InvalidInputError, match="fill_rate"):
        Valve(0.1, bad, 4.0e5)


@pytest.mark.parametrize(("start", "end"), [(0.0, 2.0e5), (0.0, 2.9e5), (3.0e5, 1.0e4)])
def test_a_wide_open_orifice_takes_the_time_of_iso_6358(start, end):
    time = SUPPLY.time_to_fill(lambda _: 2.6e-5, start, end)
    # the loop's target is far beyond, so that the valve stays wide open
    target = 1.0e9 if end > start else -0.0
    quick = Valve(1e-6, 1.0, 1.0, flow=ORIFICE.flow)
    after = quick.pressure_after(time, start, target)
    assert after == pytest.approx(end, rel=5e-3, abs=500.0)  # 41 rows


def test_the_simulator_fills_the_volume_of_its_gripper():
    values = {spec.name: spec.default for spec in REGULATOR_PARAMETERS}
    assert regulator_model(values).valve.flow == ()
    valve = regulator_model(values | {"conductance": 1e-9}).valve
    gripper = load_description(str(values["gripper"])).gripper
    pressure, rise, fall = valve.flow[7]
    expected = SUPPLY.rates(lambda p: enclosed_volume(gripper, p), pressure)
    assert (rise, fall) == pytest.approx(expected, rel=1e-9)
    beyond = valve.flow[-1][0]
    assert beyond == pytest.approx(values["supply_pressure"])
    assert valve.flow[-1][1] == pytest.approx(0.0, abs=10.0)


@pytest.mark.parametrize("flow", [((0.0, 1.0, -1.0),), ((0.0, 1.0, 1.0), (0.0, 1.0, 1.0))])
def test_a_table_that_cannot_be_is_refused(flow):
    with pytest.raises(InvalidInputError, match="flow"):
        Valve(0.1, 2.0e5, 4.0e5, flow=flow)
