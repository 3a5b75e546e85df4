# SPDX-License-Identifier: Apache-2.0
"""What stands in front of the simulated gripper, and how it is estimated."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import InvalidInputError
from spiral_gripper_ros.simulation.radius_estimator import EstimatorErrors, RadiusEstimator
from spiral_gripper_ros.simulation.radius_source import ProfileSource, Shape

STEADY = ProfileSource(Shape.CONSTANT, radius=0.02, variation=0.0, period=1.0, rate=20.0)


def take(source, end, step):
    estimator = RadiusEstimator(source, EstimatorErrors())
    taken = []
    for number in range(1, round(end / step) + 1):
        taken += estimator.estimates(number * step)
    return taken


def test_a_constant_is_looked_at_at_its_rate():
    assert STEADY.samples(0.0, 10.0) == [0.02] * 200


def test_a_step_is_up_for_half_of_its_period():
    source = replace(STEADY, shape=Shape.STEP, variation=-0.25, period=4.0)
    assert [source.true_radius(t) for t in (0.0, 1.9, 2.0, 3.9, 4.0)] == [
        0.02, 0.02, 0.015, 0.015, 0.02
    ]  # fmt: skip


def test_a_sine_goes_up_and_down_by_its_variation():
    source = replace(STEADY, shape=Shape.SINE, variation=0.5, period=4.0)
    radii = [source.true_radius(t) for t in (0.0, 1.0, 2.0, 3.0)]
    assert radii == pytest.approx([0.02, 0.03, 0.02, 0.01], rel=1e-12)


@given(st.integers(1, 60), st.floats(0.01, 0.9))
def test_how_the_time_is_cut_makes_no_difference(numbers, step):
    end = numbers * step
    source = replace(STEADY, shape=Shape.SINE)
    assert take(source, end, step) == source.samples(0.0, end)


def test_without_a_source_there_is_no_object_and_no_estimate():
    estimator = RadiusEstimator(None, EstimatorErrors(bias=0.01))
    assert estimator.estimates(10.0) == []
    assert estimator.true_radius() is None


def test_noise_and_bias_are_what_they_should_be():
    made = np.array(_many(EstimatorErrors(noise=1e-4, bias=2e-3)))
    # The mean and the deviation of 4000 samples scatter by 1.6 % and 1.1 % of the deviation.
    assert made.mean() == pytest.approx(0.022, abs=1e-5)
    assert made.std() == pytest.approx(1e-4, rel=0.06)


@pytest.mark.parametrize(
    ("errors", "seen"),
    [
        (EstimatorErrors(nan_probability=0.1), lambda made: np.isnan(made).sum()),
        (EstimatorErrors(dropout_probability=0.1), lambda made: 4000 - made.size),
        (
            EstimatorErrors(outlier_probability=0.1, outlier_size=0.015),
            lambda made: (np.isclose(made, 0.035) | np.isclose(made, 0.005)).sum(),
        ),
    ],
)
def test_each_error_comes_as_often_as_it_should(errors, seen):
    # 4000 tries at 10 %: 400 with a deviation of 19.
    assert seen(np.array(_many(errors))) == pytest.approx(400, abs=80)


def test_one_seed_is_one_stream_and_errors_leave_each_other_alone():
    noisy = EstimatorErrors(noise=1e-4)
    made = _many(noisy, seed=1)
    assert made == _many(noisy, seed=1) != _many(noisy, seed=2)
    with_nans = _many(replace(noisy, nan_probability=0.5), seed=1)
    assert all(math.isnan(b) or a == b for a, b in zip(made, with_nans, strict=True))


def test_what_fell_due_during_a_long_pause_is_lost():
    estimator = RadiusEstimator(STEADY, EstimatorErrors())
    assert len(estimator.estimates(3600.0)) == 20
    assert estimator.estimates(3600.0) == []
    assert estimator.estimates(10.0) == []
    assert estimator.estimates(3600.0) == []


@pytest.mark.parametrize("bad", [math.nan, math.inf, -2.0])
def test_figures_that_cannot_be_are_refused(bad):
    for field in ("radius", "variation", "period", "rate"):
        with pytest.raises(InvalidInputError, match=field):
            replace(STEADY, **{field: bad})
    probabilities = ("outlier_probability", "nan_probability", "dropout_probability")
    for field in ("noise", "outlier_size", *probabilities):
        with pytest.raises(InvalidInputError, match=field):
            EstimatorErrors(**{field: bad})


def _many(errors, seed=0):
    """4000 looks at the steady object."""
    estimator = RadiusEstimator(STEADY, errors, seed)
    return [radius for second in range(1, 201) for radius in estimator.estimates(float(second))]
