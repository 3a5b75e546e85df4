# SPDX-License-Identifier: Apache-2.0
"""What a calibration says about itself: identifiability, choice of law, leave-one-out, units."""

from dataclasses import replace
from functools import partial
from math import pi

import numpy as np
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
from core.recorded import recorded, said
from numpy.linalg import norm
from numpy.testing import assert_allclose

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
    assert_allclose(weak.condition, np.linalg.cond(columns), 1e-6)
    assert weak.condition > CONDITION_MAX
    recorded("calibration/weak", [str(weak), fit])
    # Their sum is well known all the same: the modulus is six times it.
    assert fit.covariance.sum() ** 0.5 < 0.1 * fit.standard_errors.min()
    assert weak_directions(fitted(TRUTH, noisy(TRUTH))) == ()


def test_what_readings_can_be_fitted_to_is_recorded():
    """Not if they tell too little, go the wrong way, or are far apart at one pressure."""
    coil, readings = spiral(LAWS[0]), noisy(TRUTH)
    asked = [(TRUTH, readings, {"quantities": (FittedQuantity.BENDING_STIFFNESS,)})]
    for law, pressures in ((LAWS[0], [0.0]), (LAWS[1], [0.0, 4.0e4])):
        truth = actuator(law)
        asked += [(truth, extensions(truth, 3 * pressures + more), {}) for more in ([], [6.0e4])]
    for quantity, measure in [("extension", noisy), ("twist", twists), ("bend_angle", bends)]:
        right = measure(coil, pressures=PRESSURES)
        wrong = [replace(r, **{quantity: -getattr(r, quantity)}) for r in right]
        one = [*right[:4], wrong[4], *right[5:]]
        # Noise about zero may go either way; one reading far below it may not.
        near = [replace(r, **{quantity: -0.1 * r.error}, error=10.0) for r in right]
        asked += [(coil, each, {}) for each in (wrong, one, [*right, *near])]
        asked.append((coil, one, {"robust": True}))
    for apart in (2.0e-3, 3.5e-3):
        more = [*readings, replace(readings[5], extension=readings[5].extension + apart)]
        asked += [(TRUTH, more, {"robust": robust}) for robust in (False, True)]
    vague = replace(more[-1], extension=more[-1].extension + apart, error=1.0)
    asked.append((TRUTH, [*more, vague], {}))  # does not hide that two others are far apart
    found = {}
    for k, (truth, given, choices) in enumerate(asked):
        fit = said(partial(fitted, truth, given, **choices))
        found[f"{k}"] = fit if isinstance(fit, str) else f"without {fit.excluded}: {fit.outliers}"
    # Softens, and then a point that only the full set reaches.
    soft = [
        ExtensionReading(p * 1e3, e * 1e-3, 0.1, 1e-4)
        for p, e in ((20.0, 4.0), (40.0, 10.0), (50.0, 15.0), (55.0, 20.0), (90.0, 40.0))
    ]
    fits = (
        fitted(actuator(Yeoh(130.0e3, 0.0, 0.0)), soft, fixed={"c3": 0.0}),
        fitted(TRUTH, extensions(TRUTH, [2.0e4] * 3)),
    )
    recorded("calibration/refused", found | {"one out": [said(leave_one_out, fit) for fit in fits]})


def test_readings_that_chance_does_not_explain_are_named():
    for off in [{}, {7: 6.0}, {3: -9.0, 8: -9.0}]:
        clean = noisy(TRUTH, 7)
        readings = [
            replace(r, extension=r.extension + off.get(k, 0.0) * r.error)
            for k, r in enumerate(clean)
        ]
        fit, robust = (fitted(TRUTH, readings, each) for each in (False, True))
        assert ({*robust.outliers}, robust.excluded) == (off.keys(), robust.outliers)
        same = fitted(TRUTH, [r for k, r in enumerate(clean) if k not in off])
        assert_allclose(robust.interval("c1"), same.interval("c1"), 1e-6)
        if len(off) < 2:
            assert (fit.outliers, fit.excluded) == (robust.outliers, ())
        for k, size in off.items():  # two that agree do not hide each other
            for one in (robust, fit):
                assert k in one.outliers
                assert -one.standardized_residuals[k] / size > 0.5


def test_standardized_residuals_are_those_of_fits_to_the_others():
    for k in [0, 5, 11]:
        truth = actuator(LAWS[1])
        readings = noisy(truth)
        fit = fitted(truth, readings)
        reading = readings.pop(k)
        others = fitted(truth, readings)
        row = fit.jacobian[k] * reading.error
        spread = (reading.error * others.error_scale) ** 2 + row @ others.covariance @ row
        # The fit to the others is that of the linearized model.
        expected = (predict(others.trial, [reading])[0] - reading.extension) / np.sqrt(spread)
        assert_allclose(fit.standardized_residuals[k], expected, 0.02)


def test_chance_alone_names_readings_in_one_of_a_hundred_tests():
    # The linear model of the fit itself: 400 tests in the time of one fit.
    noise = np.random.default_rng(5)
    jacobian, owners = np.linspace(0.1, 1.0, 12)[:, None], np.arange(12)
    named = sum(
        bool(outliers(noise.standard_normal(12), jacobian, owners, trust_stated=trust))
        for trust in [False, True] * 200
    )
    assert named <= 16  # 2 % of 400 (either test may err), + 3 standard deviations


def test_intervals_are_those_of_least_squares_and_of_what_was_stated():
    for error, wave, scatter in [
        (1.0e-4, 0.3, "TOO_LARGE"),
        (2.0e-4, 0.0, "AS_STATED"),
        (5.0e-3, 0.0, "TOO_SMALL"),
    ]:
        truth = actuator(LAWS[1])
        readings = [  # scattered by 0.2 mm, and by the wave
            replace(r, extension=r.extension * (1.0 + wave * (-1) ** k), error=error)
            for k, r in enumerate(noisy(truth))
        ]
        fit = fitted(truth, readings)
        assert fit.scatter.name == scatter
        assert_allclose(fit.error_scale**2, fit.residuals @ fit.residuals / 10.0)
        scale, quantile = fit.error_scale, 2.228139  # Student's t
        if scatter == "TOO_SMALL":
            scale, quantile = 1.0, 1.959964
        covariance = scale**2 * np.linalg.inv(fit.jacobian.T @ fit.jacobian)
        assert_allclose(fit.covariance, covariance, 1e-6)
        half = np.ptp(fit.interval("c1")) / 2.0
        assert_allclose(half, quantile * covariance[0, 0] ** 0.5, 1e-5)


def test_exactly_met_readings_are_as_uncertain_as_stated():
    fit = fitted(TRUTH, extensions(TRUTH, [0.0, *PRESSURES]))
    assert_allclose(np.ptp(fit.interval("c1")), 2.0 * 1.959964 / norm(fit.jacobian), 1e-5)
    for field, *arguments in (("level", "c1", 0.0), ("level", "c1", 1.0), ("of c1", "c2")):
        with refused(field):
            fit.interval(*arguments)


def test_leaving_one_out_is_fitting_the_others():
    readings = noisy(TRUTH)
    repeat = replace(readings[3], extension=readings[3].extension + 3.0e-4)
    zero = replace(readings[0], pressure=0.0, extension=0.0)  # not left out: any fit predicts it
    result = leave_one_out(fitted(TRUTH, [zero, *readings, repeat]))
    assert result.pressures.tolist() == sorted([*PRESSURES, repeat.pressure])
    others = fitted(TRUTH, [zero, *(r for r in readings if r.pressure != repeat.pressure)])
    same = result.predicted[result.pressures == repeat.pressure]
    assert_allclose(same, [*predict(others.trial, [repeat])] * 2, 1e-6)
    misses = result.predicted - result.measured
    for told, scale in (
        (result.relative_error, result.measured),
        (result.share_of_largest, readings[-1].extension),
        (result.error_scale, repeat.error),
    ):
        assert_allclose(told, np.sqrt(np.mean((misses / scale) ** 2)))


def test_information_criteria_are_those_of_the_likelihood():
    fit = fitted(actuator(LAWS[1]), noisy(actuator(LAWS[1])))
    n, k = len(PRESSURES), 3
    variance = np.mean(fit.residuals**2) * fit.errors**2
    # -2 ln L of normal errors; their squares over the variance add up to their count.
    deviance = np.log(2.0 * pi * variance).sum() + n
    corrected = deviance + 2.0 * k + 2.0 * k * (k + 1) / (n - k - 1)
    criteria = fit.information_criterion, fit.bayesian_criterion
    assert_allclose(criteria, (corrected, deviance + k * np.log(n)), 1e-12)


def test_the_law_behind_the_readings_is_chosen_and_of_too_few_the_simplest():
    for pressures, best in [(np.linspace(10e3, 130e3, 14), Gent), (PRESSURES[::3], NeoHookean)]:
        truth = actuator(LAWS[3])
        readings, no = noisy(truth, 1, pressures), ("yeoh", SpiralError("no"))
        fits = [fitted(truth, readings, law=law) for law in (MooneyRivlin, NeoHookean, Gent)]
        choice = choose_law([*fits, no])
        assert choice.best.model.fitted_law is best
        wrong = [*fits, fitted(truth, noisy(truth))], [no]
        found = [choice.weights, choice.failures, *(said(choose_law, each) for each in wrong)]
        recorded(f"calibration/{best.__name__}", found)
        assert_allclose(sum(choice.weights), 1.0)
