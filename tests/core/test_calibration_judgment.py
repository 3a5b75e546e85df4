# SPDX-License-Identifier: Apache-2.0
"""What a calibration says about itself: identifiability, choice of law, leave-one-out, units."""

import math
from dataclasses import replace

import numpy as np
import pytest
from core.calibration_cases import LAWS, PRESSURES, actuator, bends, extensions, spiral, twists

from spiral_core import (
    CalibrationModel,
    ExtensionReading,
    FittedQuantity,
    FreeActuation,
    Gent,
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    SpiralError,
    Yeoh,
    calibrate,
    choose_law,
    leave_one_out,
    weak_directions,
)
from spiral_core.calibration.fit import CONDITION_MAX
from spiral_core.calibration.model import contradictions, predict
from spiral_core.calibration.regression import outliers


def noisy(truth, seed=4):
    return extensions(truth, PRESSURES, noise=np.random.default_rng(seed))


def test_constants_of_a_spiral_cannot_be_told_apart():
    truth = spiral(MooneyRivlin(c1=90.0e3, c2=40.0e3))
    fit = calibrate(CalibrationModel(truth), noisy(truth))
    (weak,) = weak_directions(fit)
    assert set(weak.names) == {"c1", "c2"}
    columns = fit.jacobian / np.linalg.norm(fit.jacobian, axis=0)
    assert weak.condition == pytest.approx(np.linalg.cond(columns), rel=1e-6)
    assert weak.condition > CONDITION_MAX
    stretches = [FreeActuation(fit.actuator).stretch_from_pressure(p) for p in PRESSURES]
    assert (weak.stretch_min, weak.stretch_max) == (min(stretches), max(stretches))
    assert "farther from 90 degrees" in str(weak)
    assert "c1 and c2 cannot be told apart" in str(weak)
    # Their sum is well known all the same: the modulus is six times it.
    total = fit.covariance.sum() ** 0.5
    assert total < 0.1 * fit.standard_errors.min()


def test_one_constant_gives_no_warning():
    truth = actuator(LAWS[0])
    fit = calibrate(CalibrationModel(truth), noisy(truth))
    assert weak_directions(fit) == ()


def test_parameters_that_no_reading_depends_on_are_refused():
    truth = actuator(LAWS[0])
    model = CalibrationModel(truth, quantities=(FittedQuantity.BENDING_STIFFNESS,))
    with pytest.raises(
        InvalidInputError, match="such that they depend on bending_stiffness"
    ) as why:
        calibrate(model, noisy(truth))
    assert "only a shape that gravity bends depends on EI and GJ" in str(why.value)
    assert why.value.value.startswith("12 readings from 8000 Pa")


@pytest.mark.parametrize(("law", "pressures"), [(LAWS[0], [0.0]), (LAWS[1], [0.0, 4.0e4])])
def test_repeats_tell_no_more_parameters(law, pressures):
    truth = actuator(law)
    repeats = [p for p in pressures for _ in range(3)]
    with pytest.raises(InvalidInputError, match="different pressures above 0 at least"):
        calibrate(CalibrationModel(truth), extensions(truth, repeats))
    more = extensions(truth, [*repeats, 6.0e4])
    assert calibrate(CalibrationModel(truth), more).value("c1") > 0.0


def test_readings_that_go_the_wrong_way_are_refused():
    truth = spiral(LAWS[0])
    wrong = {
        "extension": [replace(r, extension=-r.extension) for r in noisy(truth)],
        "twist": [replace(r, twist=-r.twist) for r in twists(truth, PRESSURES)],
        "bend_angle": [replace(r, bend_angle=-r.bend_angle) for r in bends(truth, PRESSURES)],
    }
    for quantity, readings in wrong.items():
        with pytest.raises(InvalidInputError, match="for these fibers") as caught:
            calibrate(CalibrationModel(truth), readings)
        assert caught.value.field == quantity
    # Noise about zero may go either way; one reading far below it may not.
    small = [replace(r, extension=-0.1 * r.error, error=10.0) for r in noisy(truth)]
    calibrate(CalibrationModel(truth), [*small, *noisy(truth)])
    one = noisy(truth)
    one[4] = replace(one[4], extension=-one[4].extension)
    with pytest.raises(InvalidInputError, match="check the sign"):
        calibrate(CalibrationModel(truth), one)
    assert calibrate(CalibrationModel(truth), one, robust=True).excluded == (4,)


@pytest.mark.parametrize(("apart", "refused"), [(2.0e-3, False), (3.5e-3, True)])
def test_readings_at_one_pressure_that_are_far_apart_are_refused(apart, refused):
    truth = actuator(LAWS[0])
    readings = noisy(truth)
    readings.append(replace(readings[5], extension=readings[5].extension + apart))
    found = contradictions(CalibrationModel(truth).trial((130.0e3,)), readings)
    assert [one.places for one in found] == ([(5, 12)] if refused else [])
    if refused:
        with pytest.raises(InvalidInputError, match="at one pressure they are"):
            calibrate(CalibrationModel(truth), readings)
        assert 12 in calibrate(CalibrationModel(truth), readings, robust=True).outliers


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("off", "robust"),
    [
        ({}, False),
        ({}, True),
        ({7: 6.0}, False),
        ({2: 15.0}, False),
        ({2: 15.0}, True),
        ({3: 9.0, 8: 9.0}, True),
    ],
)
def test_readings_that_chance_does_not_explain_are_named(off, sign, robust):
    truth = actuator(LAWS[0])
    clean = noisy(truth, 7)
    readings = [
        replace(r, extension=r.extension + sign * off.get(k, 0.0) * r.error)
        for k, r in enumerate(clean)
    ]
    fit = calibrate(CalibrationModel(truth), readings, robust=robust)
    assert set(fit.outliers) == off.keys()
    assert fit.excluded == (fit.outliers if robust else ())
    standardized = fit.standardized_residuals
    for k, size in off.items():
        assert -sign * standardized[k] > (0.5 * size if len(off) == 1 or robust else 0.0)
    if robust:
        others = [r for k, r in enumerate(clean) if k not in off]
        same = calibrate(CalibrationModel(truth), others)
        assert fit.interval("c1") == pytest.approx(same.interval("c1"), rel=1e-6)
        assert fit.degrees_of_freedom == same.degrees_of_freedom


def test_standardized_residuals_are_those_of_fits_to_the_others():
    truth = actuator(LAWS[1])
    readings = noisy(truth)
    fit = calibrate(CalibrationModel(truth), readings)
    for k in (0, 5, 11):
        others = calibrate(CalibrationModel(truth), [*readings[:k], *readings[k + 1 :]])
        (predicted,) = predict(others.model.trial(others.values.tolist()), [readings[k]])
        row = fit.jacobian[k] * readings[k].error
        error = np.hypot(
            readings[k].error * others.error_scale, np.sqrt(row @ others.covariance @ row)
        )
        # The fit to the others is that of the linearized model.
        expected = (predicted - readings[k].extension) / error
        assert fit.standardized_residuals[k] == pytest.approx(expected, rel=0.02)


def test_chance_alone_names_readings_in_one_of_a_hundred_tests():
    # The linear model of the fit itself: 400 tests in the time of one fit.
    noise = np.random.default_rng(5)
    jacobian, owners = np.linspace(0.1, 1.0, 12)[:, None], np.arange(12)
    named = sum(
        bool(outliers(noise.standard_normal(12), jacobian, owners, trust_stated=trust))
        for _ in range(200)
        for trust in (False, True)
    )
    assert named <= 16  # 2 % of 400 (either test may err), + 3 standard deviations


def test_scatter_is_judged_by_what_was_stated():
    truth = actuator(LAWS[0])
    stated = {1.0e-4: "TOO_LARGE", 2.0e-4: "AS_STATED", 5.0e-3: "TOO_SMALL"}
    readings = noisy(truth)  # scattered by 0.2 mm
    noisier = [
        replace(r, extension=r.extension * (1.0 + 0.3 * (-1) ** i)) for i, r in enumerate(readings)
    ]
    for error, expected in stated.items():
        chosen = noisier if expected == "TOO_LARGE" else readings
        fit = calibrate(CalibrationModel(truth), [replace(r, error=error) for r in chosen])
        assert fit.scatter.name == expected
        low, high = fit.interval("c1")
        known = float(np.linalg.norm(fit.jacobian))
        factor = 1.959964 if expected == "TOO_SMALL" else 2.200985 * fit.error_scale
        assert high - low == pytest.approx(2.0 * factor / known, rel=1e-5)


def test_bend_angles_alone_do_not_tell_the_fiber_radius():
    truth = actuator(LAWS[0])
    readings = bends(truth, PRESSURES, np.random.default_rng(9))
    model = CalibrationModel(truth, quantities=(FittedQuantity.STRAIGHT_FIBER_RADIUS,))
    fit = calibrate(model, readings[:4])
    assert any("add the extension of a straight section" in str(w) for w in weak_directions(fit))


def test_leaving_one_out_is_fitting_the_others():
    truth = actuator(LAWS[0])
    readings = noisy(truth)
    readings.append(replace(readings[3], extension=readings[3].extension + 3.0e-4))  # a repeat
    model = CalibrationModel(truth)
    result = leave_one_out(calibrate(model, readings))
    assert result.not_predicted == ()
    assert len(result.predicted) == len(readings)
    at = result.pressures == readings[3].pressure
    assert at.sum() == 2
    others = [r for r in readings if r.pressure != readings[3].pressure]
    expected = predict(model.trial(calibrate(model, others).values.tolist()), [readings[3]])
    assert result.predicted[at] == pytest.approx([expected[0]] * 2, rel=1e-6)
    errors = result.predicted / result.measured - 1.0
    assert result.relative_error == pytest.approx(math.sqrt(np.mean(errors**2)))
    misses, largest = result.predicted - result.measured, max(r.extension for r in readings)
    assert result.share_of_largest == pytest.approx(math.sqrt(np.mean(misses**2)) / largest)
    stated = np.array([readings[0].error])
    assert result.error_scale == pytest.approx(math.sqrt(np.mean((misses / stated) ** 2)))


def test_leaving_one_out_judges_readings_near_zero_by_the_largest_of_their_kind():
    readings = noisy(actuator(LAWS[0]))
    tiny = replace(readings[0], pressure=1.0, extension=1e-9)
    result = leave_one_out(calibrate(CalibrationModel(actuator(LAWS[0])), [tiny, *readings]))
    assert result.relative_error > 100.0 * result.share_of_largest
    assert 0.0 < result.share_of_largest < 0.2


def test_pressure_zero_is_not_left_out():
    truth = actuator(LAWS[0])
    readings = noisy(truth)
    fit = calibrate(
        CalibrationModel(truth), [replace(readings[0], pressure=0.0, extension=0.0), *readings]
    )
    result = leave_one_out(fit)
    assert result.pressures.tolist() == list(PRESSURES)
    assert 0.0 < result.relative_error < 0.2
    exact = replace(result, measured=result.measured * 0.0)
    assert exact.relative_errors.tolist() == []


def test_a_pressure_past_the_reduced_fits_limit_is_named():
    readings = [  # softens, and then a point that only the full set reaches
        ExtensionReading(p * 1e3, e * 1e-3, 0.1, 1e-4)
        for p, e in ((20.0, 4.0), (40.0, 10.0), (50.0, 15.0), (55.0, 20.0), (90.0, 40.0))
    ]
    model = CalibrationModel(actuator(Yeoh(c1=130.0e3, c2=0.0, c3=0.0)), fixed={"c3": 0.0})
    result = leave_one_out(calibrate(model, readings))
    assert result.not_predicted == (90.0e3,)
    assert len(result.predicted) == 4


def test_leaving_out_needs_two_pressures():
    truth = actuator(LAWS[0])
    readings = [replace(r, pressure=2.0e4) for r in extensions(truth, [2.0e4, 2.0e4, 2.0e4])]
    with pytest.raises(InvalidInputError, match="made at two pressures above 0"):
        leave_one_out(calibrate(CalibrationModel(truth), readings))


def test_the_law_behind_the_readings_is_chosen():
    for truth_law, expected in ((LAWS[0], NeoHookean), (LAWS[3], Gent)):
        truth = actuator(truth_law)
        readings = extensions(
            truth, np.linspace(10e3, 130e3, 14).tolist(), noise=np.random.default_rng(1)
        )
        models = [CalibrationModel(truth, law=law) for law in (MooneyRivlin, NeoHookean, Gent)]
        choice = choose_law([calibrate(model, readings) for model in models])
        assert choice.best.model.fitted_law is expected
        assert sum(choice.weights) == pytest.approx(1.0)
        assert list(choice.weights) == sorted(choice.weights, reverse=True)


def test_information_criteria_are_those_of_the_likelihood():
    truth = actuator(LAWS[1])
    fit = calibrate(CalibrationModel(truth), noisy(truth))
    count, k = len(PRESSURES), 3
    scaled = fit.residuals * fit.errors
    variance = np.mean(fit.residuals**2) * fit.errors**2
    deviance = float(np.sum(np.log(2.0 * math.pi * variance) + scaled**2 / variance))
    corrected = deviance + 2.0 * k + 2.0 * k * (k + 1) / (count - k - 1)
    assert fit.information_criterion == pytest.approx(corrected, rel=1e-12)
    assert fit.bayesian_criterion == pytest.approx(deviance + k * math.log(count), rel=1e-12)


def test_too_few_readings_rank_the_simplest_law_first():
    truth = actuator(LAWS[1])
    readings = extensions(truth, PRESSURES[::3], noise=np.random.default_rng(2))
    fits = [calibrate(CalibrationModel(truth, law=law), readings) for law in (Yeoh, MooneyRivlin)]
    assert fits[0].information_criterion == fits[1].information_criterion == math.inf
    choice = choose_law([*fits, ("gent", SpiralError("no"))])
    assert choice.best is fits[1]
    assert choice.weights == (0.0, 0.0)
    assert choice.failures == (("gent", "no"),)


def test_choosing_among_nothing_or_different_readings_is_refused():
    truth = actuator(LAWS[0])
    with pytest.raises(InvalidInputError, match="one successful fit"):
        choose_law([("gent", SpiralError("no"))])
    fits = [calibrate(CalibrationModel(truth), noisy(truth, seed)) for seed in (1, 2)]
    with pytest.raises(InvalidInputError, match="same readings"):
        choose_law(fits)
