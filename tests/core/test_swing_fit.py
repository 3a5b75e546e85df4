# SPDX-License-Identifier: Apache-2.0
"""Damping from a free swing: data of the time stepper with known damping, and closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from core.contact_cases import gripper

from spiral_core import (
    Damping,
    InvalidInputError,
    SwingReading,
    fit_swing,
    inertia_of,
    solve_motion,
    vibrations,
)
from spiral_core.calibration.swing import SwingFit
from spiral_core.grip.setup import free_problem
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.motion.swing import Swing

pytestmark = pytest.mark.long

TRUE = Damping(0.022, 1.2)
ERROR = 5e-4
TIMES = np.arange(0.8, 8.0, 0.04)


@cache
def slowest() -> Swing:
    return vibrations(gripper(), 0.0, 1).swings[0]


@cache
def swung() -> np.ndarray:
    """Return the tip's displacements at TIMES, from the time stepper."""
    problem = free_problem(gripper(), 0.0)
    aside = replace(problem.load, tip_force=(0.0, 6e-3, 0.0))
    start = solve_contact(replace(problem, load=aside), elements=30)
    motion = solve_motion(
        lambda _: problem, inertia_of(gripper()), (0.0, *TIMES), start=start, damping=TRUE
    )
    return motion.positions[1:, -1, 1]


def noisy(values: np.ndarray, seed: int, times: np.ndarray = TIMES) -> list[SwingReading]:
    noise = ERROR * np.random.default_rng(seed).standard_normal(len(values))
    return [SwingReading(t, y, ERROR) for t, y in zip(times, values + noise, strict=True)]


def within(fit: SwingFit, name: str, value: float) -> bool:
    low, high = fit.interval(name)
    return low <= value <= high


def test_known_damping_is_recovered_within_the_interval() -> None:
    fits = [fit_swing(slowest(), noisy(swung(), seed)) for seed in range(20)]
    # 19 of 20 on average
    assert sum(within(fit, "retardation_time", TRUE.retardation_time) for fit in fits) >= 17
    assert sum(within(fit, "air", TRUE.air) for fit in fits) >= 17
    for fit in fits:
        low, high = fit.interval("retardation_time")
        assert high - low < 0.5 * TRUE.retardation_time
        assert 0.8 < fit.error_scale < 1.2
        assert fit.frequency == pytest.approx(slowest().frequency, rel=5e-3)


def test_held_air_leaves_a_narrower_interval() -> None:
    both = fit_swing(slowest(), noisy(swung(), 1))
    held = fit_swing(slowest(), noisy(swung(), 1), air=TRUE.air)
    assert held.names == ("retardation_time",)
    assert held.damping.air == TRUE.air
    widths = [np.ptp(fit.interval("retardation_time")) for fit in (both, held)]
    assert widths[1] < 0.3 * widths[0]
    assert held.values[0] == pytest.approx(TRUE.retardation_time, rel=0.03)


def exact(retardation_time: float, times: np.ndarray) -> np.ndarray:
    """Return a swing that only its material damps: a closed form."""
    swing = slowest()
    decay = 0.5 * swing.material * retardation_time
    return 2e-3 + 0.03 * np.exp(-decay * times) * np.cos(
        2.0 * math.pi * swing.frequency * times + 0.4
    )


def test_the_logarithmic_decrement_agrees() -> None:
    times = np.arange(0.0, 10.0, 0.01)
    values = exact(0.03, times) - 2e-3
    peaks = [i for i in range(1, 999) if values[i - 1] < values[i] >= values[i + 1]]
    decrement = math.log(values[peaks[0]] / values[peaks[-1]]) / (
        times[peaks[-1]] - times[peaks[0]]
    )
    by_hand = 2.0 * decrement / slowest().material
    assert by_hand == pytest.approx(0.03, rel=0.02)
    fit = fit_swing(slowest(), noisy(exact(0.03, times), 3, times), air=0.0)
    assert within(fit, "retardation_time", 0.03)
    assert fit.values[0] == pytest.approx(by_hand, rel=0.02)
    assert fit.amplitude == pytest.approx(0.03, rel=0.01)


def test_readings_without_noise_are_met() -> None:
    times = np.arange(0.0, 6.0, 0.03)
    readings = [SwingReading(t, y, ERROR) for t, y in zip(times, exact(0.01, times), strict=True)]
    fit = fit_swing(slowest(), readings[::-1], air=0.0)  # in any order
    assert fit.values[0] == pytest.approx(0.01, rel=1e-3)  # 200 steps between readings
    assert fit.error_scale < 1e-2
    low, high = fit.interval("retardation_time")
    assert low < 0.01 < high


@pytest.mark.parametrize("power", [4.0 / 3.0, 2.0], ids=["creeping", "inertial"])
def test_each_term_of_the_air_is_fitted(power: float) -> None:
    """With dA/dt = -c A^p, A^(1-p) grows evenly."""
    times, first, factor = np.arange(0.0, 20.0, 0.03), 0.03, 1.2
    creeping, inertial = (slowest().air_creeping, 0.0), (0.0, slowest().air_inertial)
    own = creeping if power < 2.0 else inertial
    swing = replace(slowest(), air_creeping=own[0], air_inertial=own[1])
    amplitudes = first ** (1.0 - power) + factor * sum(own) * (power - 1.0) * times
    decaying = amplitudes ** (1.0 / (1.0 - power))
    values = decaying * np.cos(2.0 * math.pi * swing.frequency * times + 0.4)
    fit = fit_swing(swing, [SwingReading(t, y, 1e-5) for t, y in zip(times, values, strict=True)])
    assert fit.damping.air == pytest.approx(factor, rel=2e-3)  # 200 steps between readings
    assert fit.damping.retardation_time < 1e-2 * TRUE.retardation_time


def test_the_air_of_the_time_stepper_is_met() -> None:
    readings = [SwingReading(t, y, ERROR) for t, y in zip(TIMES, swung(), strict=True)]
    fit = fit_swing(slowest(), readings)
    assert fit.damping.air == pytest.approx(TRUE.air, rel=0.08)  # its swing is large at first


def test_no_interval_goes_below_zero() -> None:
    times = np.arange(0.0, 6.0, 0.03)
    fit = fit_swing(slowest(), noisy(exact(0.02, times), 0, times))
    assert fit.interval("air").low == 0.0
    assert fit.interval("air").high > 0.0


def test_readings_without_a_swing_are_refused() -> None:
    times = np.arange(0.0, 8.0, 0.02)
    own = slowest().frequency  # a little of it, so that the frequency is found
    still = 3e-3 + 2e-4 * np.cos(2.0 * math.pi * own * times)
    with pytest.raises(InvalidInputError, match="swing of the tip") as refused:
        fit_swing(slowest(), noisy(still, 0, times))
    assert refused.value.field == "displacement"
    with pytest.raises(InvalidInputError):
        fit_swing(slowest(), noisy(0.0 * times, 0, times))


def test_a_swing_that_nothing_damps_ends_at_the_bound() -> None:
    times = np.arange(0.0, 6.0, 0.03)
    fit = fit_swing(slowest(), noisy(exact(-0.003, times), 0, times), air=0.0)
    assert fit.at_bound == ("retardation_time",)


@pytest.mark.parametrize(
    ("times", "field", "said"),
    [
        (np.arange(0.0, 1.5, 0.02), "time", "at least 3 swings"),
        (np.arange(0.0, 8.0, 0.02) / 60.0, "time", "unit of time"),
        (np.arange(0.0, 8.0, 0.3), "readings", "at least 6 in each swing"),
        (np.arange(0.0, 0.1, 0.01), "readings", "at least 12"),
    ],
    ids=["too short", "minutes for seconds", "too sparse", "too few"],
)
def test_readings_that_tell_nothing_are_refused(times, field, said) -> None:
    values = exact(0.02, times * (60.0 if said == "unit of time" else 1.0))
    with pytest.raises(InvalidInputError, match=said) as refused:
        fit_swing(slowest(), noisy(values, 0, times))
    assert refused.value.field == field


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: SwingReading(math.nan, 0.0, 1e-3), "time"),
        (lambda: SwingReading(0.0, math.inf, 1e-3), "displacement"),
        (lambda: SwingReading(0.0, 0.0, 0.0), "error"),
        (lambda: fit_swing(slowest(), noisy(swung(), 0), air=-1.0), "air"),
        (lambda: fit_swing(slowest(), noisy(swung(), 0)).interval("mass"), "name"),
    ],
)
def test_values_out_of_range_are_named(make, field: str) -> None:
    with pytest.raises(InvalidInputError) as refused:
        make()
    assert refused.value.field == field
