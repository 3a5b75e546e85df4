# SPDX-License-Identifier: Apache-2.0
"""Damping from a free swing: data of the time stepper with known damping, and closed forms."""

from dataclasses import replace
from functools import cache
from math import pi

import numpy as np
import pytest
from core.contact_cases import gripper
from core.recorded import recorded, said
from numpy.testing import assert_allclose

from spiral_core import Damping, SwingReading, fit_swing, inertia_of, solve_motion, vibrations
from spiral_core.grip.setup import free_problem
from spiral_core.rod.contact.solve import solve_contact

pytestmark = pytest.mark.long

TRUE = Damping(0.022, 1.2)
ERROR = 5e-4
TIMES = np.arange(0.8, 8.0, 0.04)


@cache
def slowest():
    return vibrations(gripper(), 0.0, 1).swings[0]


@cache
def swung():
    """Return the tip's displacements at TIMES, from the time stepper."""
    problem = free_problem(gripper(), 0.0)
    aside = replace(problem.load, tip_force=(0.0, 6e-3, 0.0))
    start = solve_contact(replace(problem, load=aside), elements=30)
    motion = solve_motion(
        lambda _: problem, inertia_of(gripper()), (0.0, *TIMES), start=start, damping=TRUE
    )
    return motion.positions[1:, -1, 1]


def cosine(times):
    return np.cos(2.0 * pi * slowest().frequency * times + 0.4)


def exact(retardation_time, times):
    """Return a swing that only its material damps: a closed form."""
    decay = 0.5 * slowest().material * retardation_time
    return 2e-3 + 0.03 * np.exp(-decay * times) * cosine(times)


def fitted(times, values, seed=None, swing=None, error=ERROR, **held):
    """Return the fit to readings, with random errors if there is a seed."""
    noise = 0.0 if seed is None else np.random.default_rng(seed).standard_normal(len(times))
    rows = zip(times, values + error * noise, strict=True)
    return fit_swing(swing or slowest(), [SwingReading(t, y, error) for t, y in rows], **held)


def test_known_damping_is_recovered_within_the_interval():
    fits = [fitted(TIMES, swung(), seed) for seed in range(20)]
    for name in ("retardation_time", "air"):
        intervals = [fit.interval(name) for fit in fits]
        # 19 of 20 on average
        assert sum(low <= getattr(TRUE, name) <= high for low, high in intervals) >= 17
    for fit in fits:
        assert np.ptp(fit.interval("retardation_time")) < 0.5 * TRUE.retardation_time
        assert 0.8 < fit.error_scale < 1.2
        assert_allclose(fit.frequency, slowest().frequency, 5e-3)


def test_readings_without_noise_are_met_in_any_order():
    times = np.arange(6.0, 0.0, -0.03)
    fit = fitted(times, exact(0.01, times), air=0.0)
    assert_allclose(fit.values[0], 0.01, 1e-3)  # 200 steps between readings
    assert fit.error_scale < 1e-2
    assert (fit.names, fit.damping.air) == (("retardation_time",), 0.0)
    assert_allclose(fit.amplitude, 0.03, 0.01)


def test_each_term_of_the_air_is_fitted():
    """With dA/dt = -c A^p, A^(1-p) grows evenly."""
    for power in [4.0 / 3.0, 2.0]:
        times, factor = np.arange(0.0, 20.0, 0.03), 1.2
        term, other = ("air_creeping", "air_inertial")[:: 1 if power < 2.0 else -1]
        swing = replace(slowest(), **{other: 0.0})
        rate = factor * getattr(swing, term) * (power - 1.0)
        amplitudes = (0.03 ** (1.0 - power) + rate * times) ** (1.0 / (1.0 - power))
        fit = fitted(times, amplitudes * cosine(times), swing=swing, error=1e-5)
        assert_allclose(fit.damping.air, factor, 2e-3)  # 200 steps between readings
        assert fit.damping.retardation_time < 1e-2 * TRUE.retardation_time


def test_no_value_goes_below_zero():
    times = np.arange(0.0, 6.0, 0.03)
    low, high = fitted(times, exact(0.02, times), 0).interval("air")
    assert low == 0.0 < high
    undamped = fitted(times, exact(-0.003, times), 0, air=0.0)
    assert undamped.at_bound == ("retardation_time",)


def test_readings_that_tell_nothing_are_refused():
    found = [
        said(fitted, times, size * cosine(times), 0)
        for times, size in (
            (np.arange(0.0, 1.5, 0.02), 0.03),
            (np.arange(0.0, 8.0, 0.3), 0.03),
            (np.arange(0.0, 0.1, 0.01), 0.03),
            # A little of a swing, so that the frequency is found.
            (np.arange(0.0, 8.0, 0.02), 2e-4),
        )
    ]
    dead = np.arange(0.0, 8.0, 0.02)
    found += [said(fitted, dead, np.full(len(dead), place)) for place in (0.0, 5e-3)]
    recorded("calibration/swing", found)
