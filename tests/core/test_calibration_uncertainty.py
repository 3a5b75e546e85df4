# SPDX-License-Identifier: Apache-2.0
"""The uncertainty carried to the pressure for a radius."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from core.calibration_cases import LAWS, PRESSURES, bends, extensions, spiral

from spiral_core import (
    CalibrationModel,
    CurvatureForm,
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    NotGrippableError,
    WrapCurve,
    calibrate,
    gripper_from_actuator,
    pressure_uncertainty,
)
from spiral_core.calibration.uncertainty import pressure_uncertainty_by_draws


def fitted(law, error=2.0e-4, **mount):
    """Return a fit to noisy extensions of a spiral gripper of some law."""
    truth = spiral(law)
    gripper = gripper_from_actuator("g", truth, density=950.0, pressure_max=110.0e3, **mount)
    readings = extensions(truth, PRESSURES, error, noise=np.random.default_rng(12))
    return calibrate(CalibrationModel(truth, gripper=gripper), readings)


def test_without_gravity_the_pressure_is_as_uncertain_as_the_constant():
    # Pressure is proportional to the one constant, and a weightless coil depends on nothing else.
    fit = fitted(NeoHookean(c1=145.0e3), gravity=(0.0, 0.0, 0.0))
    relative = fit.standard_errors[0] / fit.values[0]
    for result in pressure_uncertainty(fit, (0.012, 0.02)):
        # Central differences of the search for the radius, which ends at 1e-10.
        assert result.standard_error / result.pressure == pytest.approx(relative, rel=1e-4)
        assert result.interval.low < result.pressure < result.interval.high
        assert result.failed_draws == 0.0


@pytest.mark.slow
def test_draws_agree_with_the_linear_propagation():
    fit = fitted(MooneyRivlin(c1=100.0e3, c2=60.0e3))
    radii = (0.012, 0.025)
    linear = pressure_uncertainty(fit, radii)
    drawn = pressure_uncertainty_by_draws(fit, radii, seed=3, draws=120)
    for one, other in zip(linear, drawn, strict=True):
        assert other.pressure == one.pressure
        # The spread of 120 draws of Student's t is uncertain by some 8 %, and wider by 10 %.
        assert other.standard_error == pytest.approx(one.standard_error, rel=0.35)
    with ProcessPoolExecutor(2) as executor:
        again = pressure_uncertainty_by_draws(fit, radii, seed=3, draws=120, executor=executor)
    assert again == drawn


def test_a_combination_nobody_knows_does_not_widen_the_pressure():
    fit = fitted(MooneyRivlin(c1=100.0e3, c2=60.0e3))
    assert fit.standard_errors[0] > 0.2 * abs(fit.value("c1"))
    (result,) = pressure_uncertainty(fit, (0.02,))
    assert result.standard_error < 0.02 * result.pressure


@pytest.mark.parametrize("truth_form", CurvatureForm)
def test_the_interval_covers_what_the_readings_cannot_tell_apart(truth_form):
    fitted_form = next(form for form in CurvatureForm if form is not truth_form)
    known = replace(spiral(NeoHookean(c1=145.0e3)), curvature_form=fitted_form)
    truth = replace(known, curvature_form=truth_form)
    gripper = gripper_from_actuator("g", truth, density=950.0, pressure_max=110.0e3)
    readings = bends(truth, PRESSURES, np.random.default_rng(5), error=0.05)
    fit = calibrate(CalibrationModel(known, gripper=gripper), readings)
    (result,) = pressure_uncertainty(fit, (0.02,))
    true = WrapCurve(gripper).pressure_from_radius(0.02)
    assert not result.own_interval.low <= true <= result.own_interval.high
    assert result.interval.low <= true <= result.interval.high
    (rival,) = result.rivals
    assert truth_form.value in rival.law
    assert rival.interval.low <= true <= rival.interval.high
    assert rival.pressure == pytest.approx(true, rel=0.02)
    (alone,) = pressure_uncertainty(fit, (0.02,), rivals=())
    assert alone.interval == result.own_interval


def test_less_noise_narrows_the_interval_in_proportion():
    wide, narrow = fitted(LAWS[0], 4.0e-4), fitted(LAWS[0], 1.0e-4)
    (a,), (b,) = pressure_uncertainty(wide, (0.02,)), pressure_uncertainty(narrow, (0.02,))
    # Up to the curvature of the extension over the constant.
    assert a.standard_error / b.standard_error == pytest.approx(4.0, rel=0.05)


def test_what_cannot_be_answered_is_refused():
    fit = fitted(LAWS[0])
    with pytest.raises(NotGrippableError):
        pressure_uncertainty(fit, (0.2,))
    with pytest.raises(InvalidInputError, match="at least 40"):
        pressure_uncertainty_by_draws(fit, (0.02,), seed=1, draws=10)
    without = calibrate(CalibrationModel(fit.actuator), fit.readings)
    with pytest.raises(InvalidInputError, match="holds the mounted gripper"):
        pressure_uncertainty(without, (0.02,))
    model = replace(fit.model, law=MooneyRivlin)
    unknown = replace(calibrate(model, fit.readings), covariance=np.diag([1.0e14, 1.0e14]))
    with pytest.raises(InvalidInputError, match="draws"):
        pressure_uncertainty_by_draws(unknown, (0.02,), seed=1, draws=40)
