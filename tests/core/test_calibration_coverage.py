# SPDX-License-Identifier: Apache-2.0
"""Whether 95 % intervals hold the true value in 93 to 97 % of repeated bench tests.

``benchmarks/calibration_coverage.py`` runs the same study with more laws and more tests.
"""

import numpy as np
import pytest
from core.calibration_cases import LAWS, PRESSURES, actuator, extensions

from spiral_core import (
    CalibrationModel,
    ExtensionReading,
    MooneyRivlin,
    NeoHookean,
    calibrate,
)

pytestmark = pytest.mark.long

TESTS = 500


def share_of_hits(truth, readings_of, tests):
    """Return for each parameter how many of the tests have it in their interval."""
    model = CalibrationModel(truth)
    expected = [getattr(truth.material, name) for name in model.names]
    hits = np.zeros(len(expected))
    for _ in range(tests):
        fit = calibrate(model, readings_of())
        intervals = [fit.interval(name) for name in fit.names]
        hits += [low <= true <= high for true, (low, high) in zip(expected, intervals, strict=True)]
    return hits / tests


@pytest.mark.slow
@pytest.mark.parametrize("law", [NeoHookean(c1=130.0e3), MooneyRivlin(c1=90.0e3, c2=40.0e3)])
def test_intervals_hold_the_truth_as_often_as_they_say(law):
    truth = actuator(law)
    noise = np.random.default_rng(20260101)
    shares = share_of_hits(truth, lambda: extensions(truth, PRESSURES, noise=noise), TESTS)
    assert ((shares >= 0.93) & (shares <= 0.97)).all(), shares


@pytest.mark.slow
def test_intervals_of_few_readings_with_noisy_pressures_are_right_too():
    truth = actuator(LAWS[0])
    noise = np.random.default_rng(20260102)

    def readings():
        return extensions(truth, PRESSURES[::3], noise=noise, pressure_noise=1.0e3)

    # Of 100 tests, 95 % +- 3 standard deviations of such a share.
    (share,) = share_of_hits(truth, readings, 100)
    assert 0.885 <= share <= 1.0


def test_a_level_of_one_or_zero_is_refused():
    truth = actuator(LAWS[0])
    fit = calibrate(CalibrationModel(truth), extensions(truth, PRESSURES))
    for level in (0.0, 1.0, 1.5, float("nan")):
        with pytest.raises(ValueError, match="level"):
            fit.interval("c1", level)
    with pytest.raises(ValueError, match="name must be one of c1"):
        fit.value("c2")


@pytest.mark.parametrize("robust", [False, True])
def test_exactly_met_readings_are_as_uncertain_as_stated(robust):
    truth = actuator(LAWS[0])
    readings = [ExtensionReading(0.0, 0.0, 0.1, 1e-4), *extensions(truth, PRESSURES)]
    fit = calibrate(CalibrationModel(truth), readings, robust=robust)
    low, high = fit.interval("c1")
    assert high - low == pytest.approx(2.0 * 1.959964 / np.linalg.norm(fit.jacobian), rel=1e-5)
