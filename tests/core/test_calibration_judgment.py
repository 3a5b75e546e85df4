"""What a calibration says about itself: identifiability, choice of law, leave-one-out, units."""

import math
from dataclasses import replace

import numpy as np
import pytest
from core.calibration_cases import LAWS, PRESSURES, TUBE, actuator, extensions, spiral

from spiral_core import (
    BendReading,
    CalibrationModel,
    ExtensionReading,
    FittedQuantity,
    FreeActuation,
    Gent,
    GripReading,
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    ShapeReading,
    SpiralError,
    WrapCurve,
    Yeoh,
    calibrate,
    choose_law,
    gripper_from_actuator,
    leave_one_out,
    weak_directions,
)
from spiral_core.calibration.identifiability import CONDITION_MAX, condition_indices
from spiral_core.calibration.model import Trial
from spiral_core.calibration.plausibility import find_unit_mix_up
from spiral_core.calibration.predict import predict


def noisy(truth, seed=4):
    return extensions(truth, PRESSURES, noise=np.random.default_rng(seed))


def test_constants_of_a_spiral_cannot_be_told_apart():
    truth = spiral(MooneyRivlin(c1=90.0e3, c2=40.0e3))
    fit = calibrate(CalibrationModel(truth), noisy(truth))
    (weak,) = weak_directions(fit)
    assert set(weak.names) == {"c1", "c2"}
    assert weak.condition == condition_indices(fit)[-1] > CONDITION_MAX
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
    assert condition_indices(fit) == (1.0,)


def test_stiffness_is_undetermined_without_shapes():
    truth = actuator(LAWS[0])
    model = CalibrationModel(truth, quantities=(FittedQuantity.BENDING_STIFFNESS,))
    fit = calibrate(model, noisy(truth))
    (weak,) = weak_directions(fit)
    assert weak.names == ("bending_stiffness",)
    assert "only a shape that gravity bends depends on EI and GJ" in str(weak)
    assert fit.standard_errors[1] > 1e6 * fit.value("bending_stiffness")
    assert fit.interval("c1") == pytest.approx(
        calibrate(CalibrationModel(truth), noisy(truth)).interval("c1"), rel=0.01
    )


def test_bend_angles_alone_do_not_tell_the_fiber_radius():
    truth = actuator(LAWS[0])
    noise = np.random.default_rng(9)
    readings = []
    for pressure in PRESSURES:
        bend = FreeActuation(truth).rest_shape(pressure).curvature * TUBE.length
        readings.append(
            BendReading(pressure, bend + 0.02 * noise.standard_normal(), TUBE.length, 0.02)
        )
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
    with pytest.raises(InvalidInputError, match="two pressures"):
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


PSI = 6.894757293168361


@pytest.mark.parametrize(
    ("pressure", "response", "expected"),
    [
        (1.0, 1.0, None),
        (1.6, 1.0, None),  # handbook constants may be this far off
        (1.0 / PSI, 1.0, "psi taken for kPa"),
        (PSI, 1.0, "kPa taken for psi"),
        (0.01, 1.0, "bar taken for kPa"),
        (100.0, 1.0, "kPa taken for bar"),
        (PSI / 100.0, 1.0, "bar taken for psi"),
        (100.0 / PSI, 1.0, "psi taken for bar"),
        (1.0, 1.0 / 25.4, "inches taken for mm"),
        (1.0, 25.4, "mm taken for inches"),
    ],
)
def test_mix_ups_of_units_are_named(pressure, response, expected):
    truth = actuator(NeoHookean(c1=145.0e3))
    readings = [
        replace(r, pressure=r.pressure * pressure, extension=r.extension * response)
        for r in noisy(truth)
    ]
    found = find_unit_mix_up(Trial(FreeActuation(truth), None), readings)
    assert (found and found.description) == expected


@pytest.mark.parametrize("degrees_for_radians", [True, False])
def test_mix_ups_of_angles_are_named(degrees_for_radians):
    truth = actuator(NeoHookean(c1=145.0e3))
    factor = math.degrees(1.0) if degrees_for_radians else math.radians(1.0)
    readings = [
        BendReading(p, factor * FreeActuation(truth).rest_shape(p).curvature * 0.2, 0.2, 0.01)
        for p in PRESSURES
    ]
    found = find_unit_mix_up(Trial(FreeActuation(truth), None), readings)
    name = "degrees taken for radians" if degrees_for_radians else "radians taken for degrees"
    assert found is not None
    assert found.description == name


def test_shapes_and_grips_reveal_mix_ups_too():
    gripper = gripper_from_actuator(
        "g", spiral(NeoHookean(c1=145.0e3)), density=950.0, pressure_max=110.0e3
    )
    curve = WrapCurve(gripper)
    trial = Trial(gripper.actuation, gripper)
    grips = [
        GripReading(curve.pressure_from_radius(r) / PSI, r, 1.0e-4) for r in (0.012, 0.02, 0.03)
    ]
    shapes = [
        ShapeReading(
            p, tuple((curve.state_at_pressure(p).tip_position * 25.4).tolist()), None, 1e-3
        )
        for p in (30.0e3, 60.0e3, 90.0e3)
    ]
    assert find_unit_mix_up(trial, grips).description == "psi taken for kPa"
    assert find_unit_mix_up(trial, shapes).description == "mm taken for inches"
    assert find_unit_mix_up(trial, [replace(g, pressure=g.pressure * PSI) for g in grips]) is None
