# SPDX-License-Identifier: Apache-2.0
"""What a calibration says about itself: identifiability, choice of law, leave-one-out, units."""

import math
from dataclasses import replace

import numpy as np
import pytest
from core.calibration_cases import (
    LAWS,
    PRESSURES,
    actuator,
    bends,
    extensions,
    fitted,
    noisy,
    refused,
    spiral,
    twists,
)
from numpy.linalg import norm

from spiral_core import (
    ExtensionReading,
    FittedQuantity,
    Gent,
    MooneyRivlin,
    NeoHookean,
    SpiralError,
    Yeoh,
    choose_law,
    leave_one_out,
    weak_directions,
)
from spiral_core.calibration.fit import CONDITION_MAX
from spiral_core.calibration.model import predict
from spiral_core.calibration.regression import outliers

TRUTH = actuator(LAWS[0])


def test_constants_of_a_spiral_cannot_be_told_apart():
    truth = spiral(LAWS[1])
    fit = fitted(truth, noisy(truth))
    (weak,) = weak_directions(fit)
    columns = fit.jacobian / norm(fit.jacobian, axis=0)
    assert weak.condition == pytest.approx(np.linalg.cond(columns), rel=1e-6)
    assert weak.condition > CONDITION_MAX
    assert str(weak).startswith("c1 and c2 cannot be told apart")
    assert "farther from 90 degrees" in str(weak)
    # Their sum is well known all the same: the modulus is six times it.
    assert fit.covariance.sum() ** 0.5 < 0.1 * fit.standard_errors.min()
    assert weak_directions(fitted(TRUTH, noisy(TRUTH))) == ()


def test_readings_that_tell_too_little_are_refused():
    with refused("depend on bending_stiffness") as why:
        fitted(TRUTH, noisy(TRUTH), quantities=(FittedQuantity.BENDING_STIFFNESS,))
    assert "only a shape that gravity bends depends on EI and GJ" in str(why.value)
    for law, pressures in ((LAWS[0], [0.0]), (LAWS[1], [0.0, 4.0e4])):
        truth, repeats = actuator(law), 3 * pressures
        with refused("different pressures above 0 at least"):
            fitted(truth, extensions(truth, repeats))
        assert fitted(truth, extensions(truth, [*repeats, 6.0e4])).value("c1") > 0.0


@pytest.mark.parametrize(
    ("quantity", "measure"), [("extension", noisy), ("twist", twists), ("bend_angle", bends)]
)
def test_readings_that_go_the_wrong_way_are_refused(quantity, measure):
    truth = spiral(LAWS[0])
    right = measure(truth, pressures=PRESSURES)
    wrong = [replace(r, **{quantity: -getattr(r, quantity)}) for r in right]
    with refused("for these fibers") as caught:
        fitted(truth, wrong)
    assert caught.value.field == quantity
    # Noise about zero may go either way; one reading far below it may not.
    fitted(truth, [*right, *(replace(r, **{quantity: -0.1 * r.error}, error=10.0) for r in right)])
    one = [*right[:4], wrong[4], *right[5:]]
    with refused("check the sign"):
        fitted(truth, one)
    assert fitted(truth, one, robust=True).excluded == (4,)


def test_readings_at_one_pressure_that_are_far_apart_are_refused():
    readings = noisy(TRUTH)
    near, far = (
        [*readings, replace(readings[5], extension=readings[5].extension + apart)]
        for apart in (2.0e-3, 3.5e-3)
    )
    fitted(TRUTH, near)
    with refused("at one pressure they are"):
        fitted(TRUTH, far)
    assert 12 in fitted(TRUTH, far, robust=True).outliers


@pytest.mark.parametrize(
    ("off", "robust"),
    [
        ({}, False),
        ({7: 6.0}, False),
        ({3: -9.0, 8: -9.0}, True),
    ],
)
def test_readings_that_chance_does_not_explain_are_named(off, robust):
    clean = noisy(TRUTH, 7)
    readings = [
        replace(r, extension=r.extension + off.get(k, 0.0) * r.error) for k, r in enumerate(clean)
    ]
    fit = fitted(TRUTH, readings, robust)
    assert set(fit.outliers) == off.keys()
    assert fit.excluded == (fit.outliers if robust else ())
    for k, size in off.items():
        assert -fit.standardized_residuals[k] / size > 0.5
    if robust:
        same = fitted(TRUTH, [r for k, r in enumerate(clean) if k not in off])
        assert fit.interval("c1") == pytest.approx(same.interval("c1"), rel=1e-6)
        assert fit.degrees_of_freedom == same.degrees_of_freedom


def test_standardized_residuals_are_those_of_fits_to_the_others():
    truth = actuator(LAWS[1])
    readings = noisy(truth)
    fit = fitted(truth, readings)
    for k in (0, 5, 11):
        others = fitted(truth, [*readings[:k], *readings[k + 1 :]])
        (predicted,) = predict(others.trial, [readings[k]])
        row = fit.jacobian[k] * readings[k].error
        spread = (readings[k].error * others.error_scale) ** 2 + row @ others.covariance @ row
        # The fit to the others is that of the linearized model.
        expected = (predicted - readings[k].extension) / np.sqrt(spread)
        assert fit.standardized_residuals[k] == pytest.approx(expected, rel=0.02)


def test_chance_alone_names_readings_in_one_of_a_hundred_tests():
    # The linear model of the fit itself: 400 tests in the time of one fit.
    noise = np.random.default_rng(5)
    jacobian, owners = np.linspace(0.1, 1.0, 12)[:, None], np.arange(12)
    named = sum(
        bool(outliers(noise.standard_normal(12), jacobian, owners, trust_stated=trust))
        for trust in [False, True] * 200
    )
    assert named <= 16  # 2 % of 400 (either test may err), + 3 standard deviations


@pytest.mark.parametrize(
    ("error", "wave", "scatter"),
    [(1.0e-4, 0.3, "TOO_LARGE"), (2.0e-4, 0.0, "AS_STATED"), (5.0e-3, 0.0, "TOO_SMALL")],
)
def test_intervals_are_those_of_least_squares_and_of_what_was_stated(error, wave, scatter):
    truth = actuator(LAWS[1])
    readings = [  # scattered by 0.2 mm, and by the wave
        replace(r, extension=r.extension * (1.0 + wave * (-1) ** k), error=error)
        for k, r in enumerate(noisy(truth))
    ]
    fit = fitted(truth, readings)
    assert fit.scatter.name == scatter
    assert fit.error_scale**2 == pytest.approx(fit.residuals @ fit.residuals / 10.0)
    scale, quantile = fit.error_scale, 2.228139  # Student's t
    if scatter == "TOO_SMALL":
        scale, quantile = 1.0, 1.959964
    covariance = scale**2 * np.linalg.inv(fit.jacobian.T @ fit.jacobian)
    assert fit.covariance == pytest.approx(covariance, rel=1e-6)
    half = np.ptp(fit.interval("c1")) / 2.0
    assert half == pytest.approx(quantile * covariance[0, 0] ** 0.5, rel=1e-5)


def test_exactly_met_readings_are_as_uncertain_as_stated():
    fit = fitted(TRUTH, extensions(TRUTH, [0.0, *PRESSURES]))
    width = 2.0 * 1.959964 / norm(fit.jacobian)
    assert np.ptp(fit.interval("c1")) == pytest.approx(width, rel=1e-5)
    for arguments, said in ((("c1", 0.0), "level"), (("c1", 1.0), "level"), (("c2",), "of c1")):
        with refused(said):
            fit.interval(*arguments)


def test_leaving_one_out_is_fitting_the_others():
    readings = noisy(TRUTH)
    repeat = replace(readings[3], extension=readings[3].extension + 3.0e-4)
    zero = replace(readings[0], pressure=0.0, extension=0.0)  # not left out: any fit predicts it
    result = leave_one_out(fitted(TRUTH, [zero, *readings, repeat]))
    assert result.pressures.tolist() == sorted([*PRESSURES, repeat.pressure])
    at = result.pressures == repeat.pressure
    others = fitted(TRUTH, [zero, *(r for r in readings if r.pressure != repeat.pressure)])
    assert result.predicted[at] == pytest.approx([*predict(others.trial, [repeat])] * 2, rel=1e-6)
    misses, largest = result.predicted - result.measured, readings[-1].extension
    for told, shares in (
        (result.relative_error, misses / result.measured),
        (result.share_of_largest, misses / largest),
        (result.error_scale, misses / repeat.error),
    ):
        assert told == pytest.approx(math.sqrt(np.mean(shares**2)))


def test_what_cannot_be_left_out_is_named():
    readings = [  # softens, and then a point that only the full set reaches
        ExtensionReading(p * 1e3, e * 1e-3, 0.1, 1e-4)
        for p, e in ((20.0, 4.0), (40.0, 10.0), (50.0, 15.0), (55.0, 20.0), (90.0, 40.0))
    ]
    fit = fitted(actuator(Yeoh(c1=130.0e3, c2=0.0, c3=0.0)), readings, fixed={"c3": 0.0})
    result = leave_one_out(fit)
    assert (result.not_predicted, len(result.predicted)) == ((90.0e3,), 4)
    with refused("made at two pressures above 0"):
        leave_one_out(fitted(TRUTH, extensions(TRUTH, [2.0e4] * 3)))


def test_information_criteria_are_those_of_the_likelihood():
    fit = fitted(actuator(LAWS[1]), noisy(actuator(LAWS[1])))
    count, k = len(PRESSURES), 3
    variance = np.mean(fit.residuals**2) * fit.errors**2
    # -2 ln L of normal errors; their squares over the variance add up to their count.
    deviance = np.log(2.0 * math.pi * variance).sum() + count
    corrected = deviance + 2.0 * k + 2.0 * k * (k + 1) / (count - k - 1)
    assert fit.information_criterion == pytest.approx(corrected, rel=1e-12)
    assert fit.bayesian_criterion == pytest.approx(deviance + k * math.log(count), rel=1e-12)


def test_the_law_behind_the_readings_is_chosen_and_of_too_few_the_simplest():
    truth, laws = actuator(LAWS[3]), (MooneyRivlin, NeoHookean, Gent)
    for pressures, best in (
        (np.linspace(10e3, 130e3, 14).tolist(), Gent),
        (PRESSURES[::3], NeoHookean),
    ):
        readings = noisy(truth, 1, pressures)
        fits = [fitted(truth, readings, law=law) for law in laws]
        choice = choose_law([*fits, ("yeoh", SpiralError("no"))])
        assert choice.best.model.fitted_law is best
        assert choice.failures == (("yeoh", "no"),)
        assert list(choice.weights) == sorted(choice.weights, reverse=True)
        assert sum(choice.weights) == pytest.approx(1.0)
    with refused("same readings"):
        choose_law([*fits, fitted(truth, noisy(truth))])
    with refused("one successful fit"):
        choose_law([("gent", SpiralError("no"))])
