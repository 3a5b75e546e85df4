# SPDX-License-Identifier: Apache-2.0
"""What stands in front of the simulated gripper, how it is estimated, and how time passes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import InvalidInputError
from spiral_gripper_ros.simulation.pacing import LONGEST_STEP, Pacing
from spiral_gripper_ros.simulation.radius_estimator import RadiusEstimator, RadiusParameters

STEADY = RadiusParameters(radius=0.02, estimate_noise=0.0)
SINE = replace(STEADY, profile="sine", radius_variation=0.5, radius_period=4.0)
STEP = replace(STEADY, profile="step", radius_variation=-0.25, radius_period=4.0)


def true_radii(values, times):
    estimator = RadiusEstimator(values, middle_radius=0.03)
    return [(estimator.estimates(time), estimator.true_radius())[1] for time in times]


@pytest.mark.parametrize(
    ("values", "times", "radii"),
    [
        (STEP, (0.0, 1.9, 2.0, 3.9, 4.0), [0.02, 0.02, 0.015, 0.015, 0.02]),
        (SINE, (0.0, 1.0, 2.0, 3.0), [0.02, 0.03, 0.02, 0.01]),
        (replace(STEADY, radius=0.0), (9.0,), [0.03]),  # not given: the middle one
        (replace(STEADY, profile="none"), (9.0,), [None]),
    ],
)
def test_the_true_radius_follows_its_profile(values, times, radii):
    assert true_radii(values, times) == [r and pytest.approx(r, rel=1e-12) for r in radii]


@given(st.integers(1, 60), st.floats(0.01, 0.9))
def test_how_the_time_is_cut_makes_no_difference(numbers, step):
    sine = RadiusEstimator(SINE, 0.03)
    taken = [r for number in range(1, numbers + 1) for r in sine.estimates(number * step)]
    looks = [look / 20.0 for look in range(math.ceil(numbers * step * 20.0))]
    assert taken == true_radii(SINE, looks)


def looks(**values):
    """4000 looks at the steady object."""
    estimator = RadiusEstimator(replace(STEADY, **values), 0.03)
    return np.array([r for second in range(1, 201) for r in estimator.estimates(float(second))])


def test_noise_bias_and_each_error_are_what_they_should_be():
    made, again = (looks(estimate_noise=1e-4, estimate_bias=2e-3) for _ in range(2))
    assert (made == again).all()
    # The mean and the deviation of 4000 samples scatter by 1.6 % and 1.1 % of the deviation.
    assert made.mean() == pytest.approx(0.022, abs=1e-5)
    assert made.std() == pytest.approx(1e-4, rel=0.06)
    made = looks(outlier_probability=0.1, outlier_size=0.015)
    assert made.mean() == pytest.approx(0.02, abs=4e-4)  # to both sides: five deviations
    # 4000 tries at 10 %: 400 with a deviation of 19.
    for count in (
        np.isnan(looks(nan_probability=0.1)).sum(),
        4000 - looks(dropout_probability=0.1).size,
        (np.isclose(made, 0.035) | np.isclose(made, 0.005)).sum(),
    ):
        assert count == pytest.approx(400, abs=80)


def test_what_fell_due_during_a_long_pause_is_lost():
    estimator = RadiusEstimator(STEADY, 0.03)
    found = [estimator.estimates(time) for time in (3600.0, 10.0, 3600.0)]
    assert found == [[0.02] * 20, [], []]


def test_time_never_runs_backwards_and_a_simulator_that_is_held_up_loses_it():
    pacing = Pacing(publishes_clock=False)
    passed = [pacing.step(reading) for reading in (100.0, 50.0, 50.1, 3600.0, 3600.1)]
    assert passed == pytest.approx([0.0, 0.0, 0.1, LONGEST_STEP, 0.1], abs=1e-9)
    assert pacing.now == sum(passed)
    with pytest.raises(InvalidInputError):
        pacing.step(math.nan)
