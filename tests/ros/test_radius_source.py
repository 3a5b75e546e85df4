# SPDX-License-Identifier: Apache-2.0
"""What stands in front of the simulated gripper, and how it is estimated."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import InvalidInputError
from spiral_gripper_ros.simulation.radius_estimator import RadiusEstimator, RadiusParameters

STEADY = RadiusParameters(radius=0.02, estimate_noise=0.0)


def true_radii(values, times):
    estimator = RadiusEstimator(values, middle_radius=0.03)
    radii = []
    for time in times:
        estimator.estimates(time)
        radii.append(estimator.true_radius())
    return radii


def test_a_constant_is_looked_at_at_its_rate():
    assert RadiusEstimator(STEADY, 0.03).estimates(1.0) == [0.02] * 20


def test_a_radius_that_is_not_given_is_the_middle_one():
    assert RadiusEstimator(replace(STEADY, radius=0.0), 0.03).estimates(0.05) == [0.03]


def test_a_step_is_up_for_half_of_its_period():
    step = replace(STEADY, profile="step", radius_variation=-0.25, radius_period=4.0)
    assert true_radii(step, (0.0, 1.9, 2.0, 3.9, 4.0)) == [0.02, 0.02, 0.015, 0.015, 0.02]


def test_a_sine_goes_up_and_down_by_its_variation():
    sine = replace(STEADY, profile="sine", radius_variation=0.5, radius_period=4.0)
    expected = pytest.approx([0.02, 0.03, 0.02, 0.01], rel=1e-12)
    assert true_radii(sine, (0.0, 1.0, 2.0, 3.0)) == expected


@given(st.integers(1, 60), st.floats(0.01, 0.9))
def test_how_the_time_is_cut_makes_no_difference(numbers, step):
    sine = RadiusEstimator(replace(STEADY, profile="sine"), 0.03)
    taken = [r for number in range(1, numbers + 1) for r in sine.estimates(number * step)]
    assert taken == true_radii(
        sine.values, [n / 20.0 for n in range(math.ceil(numbers * step * 20.0))]
    )


def test_without_a_source_there_is_no_object_and_no_estimate():
    estimator = RadiusEstimator(replace(STEADY, profile="none", estimate_bias=0.01), 0.03)
    assert estimator.estimates(10.0) == []
    assert estimator.true_radius() is None


def test_noise_and_bias_are_what_they_should_be():
    made = np.array(_many(replace(STEADY, estimate_noise=1e-4, estimate_bias=2e-3)))
    # The mean and the deviation of 4000 samples scatter by 1.6 % and 1.1 % of the deviation.
    assert made.mean() == pytest.approx(0.022, abs=1e-5)
    assert made.std() == pytest.approx(1e-4, rel=0.06)


@pytest.mark.parametrize(
    ("values", "seen"),
    [
        (replace(STEADY, nan_probability=0.1), lambda made: np.isnan(made).sum()),
        (replace(STEADY, dropout_probability=0.1), lambda made: 4000 - made.size),
        (
            replace(STEADY, outlier_probability=0.1, outlier_size=0.015),
            lambda made: (np.isclose(made, 0.035) | np.isclose(made, 0.005)).sum(),
        ),
    ],
)
def test_each_error_comes_as_often_as_it_should(values, seen):
    # 4000 tries at 10 %: 400 with a deviation of 19.
    assert seen(np.array(_many(values))) == pytest.approx(400, abs=80)


def test_one_seed_is_one_stream_and_errors_leave_each_other_alone():
    noisy = replace(STEADY, estimate_noise=1e-4)
    made = _many(noisy, seed=1)
    assert made == _many(noisy, seed=1) != _many(noisy, seed=2)
    with_nans = _many(replace(noisy, nan_probability=0.5), seed=1)
    assert all(math.isnan(b) or a == b for a, b in zip(made, with_nans, strict=True))


def test_what_fell_due_during_a_long_pause_is_lost():
    estimator = RadiusEstimator(STEADY, 0.03)
    assert len(estimator.estimates(3600.0)) == 20
    assert estimator.estimates(3600.0) == []
    assert estimator.estimates(10.0) == []
    assert estimator.estimates(3600.0) == []


@pytest.mark.parametrize("bad", [math.nan, math.inf, -2.0])
def test_figures_that_cannot_be_are_refused(bad):
    for field in (spec.name for spec in STEADY.specs() if spec.low is not None):
        with pytest.raises(InvalidInputError, match=field):
            replace(STEADY, **{field: bad})


def _many(values, seed=0):
    """4000 looks at the steady object."""
    estimator = RadiusEstimator(replace(values, seed=seed), 0.03)
    return [radius for second in range(1, 201) for radius in estimator.estimates(float(second))]
