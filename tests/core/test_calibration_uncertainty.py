# SPDX-License-Identifier: Apache-2.0
"""The uncertainty carried to the pressure for a radius."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from core.calibration_cases import LAWS, PRESSURES, bends, extensions, fitted, refused, spiral
from core.recorded import recorded
from numpy.testing import assert_allclose

from spiral_core import (
    CurvatureForm,
    MooneyRivlin,
    NeoHookean,
    NotGrippableError,
    WrapCurve,
    gripper_from_actuator,
    pressure_uncertainty,
)
from spiral_core.calibration.uncertainty import pressure_uncertainty_by_draws

ONE, TWO = NeoHookean(145.0e3), MooneyRivlin(100.0e3, 60.0e3)


def mounted(truth, **mount):
    return gripper_from_actuator("g", truth, density=950.0, pressure_max=110.0e3, **mount)


def measured(law, error=2.0e-4, **mount):
    """Return a fit to noisy extensions of a spiral gripper of some law."""
    truth = spiral(law)
    readings = extensions(truth, PRESSURES, error, noise=np.random.default_rng(12))
    return fitted(truth, readings, gripper=mounted(truth, **mount))


def test_without_gravity_the_pressure_is_as_uncertain_as_the_constant():
    # Pressure is proportional to the one constant, and a weightless coil depends on nothing else.
    fit = measured(ONE, gravity=(0.0, 0.0, 0.0))
    for result in pressure_uncertainty(fit, (0.012, 0.02)):
        # Central differences of the search for the radius, which ends at 1e-10.
        relative = result.standard_error / result.pressure
        assert_allclose(relative, fit.standard_errors[0] / fit.values[0], 1e-4)
        assert result.interval.low < result.pressure < result.interval.high


@pytest.mark.slow
def test_draws_agree_with_the_linear_propagation():
    fit, radii = measured(TWO), (0.012, 0.025)
    drawn = pressure_uncertainty_by_draws(fit, radii, seed=3, draws=120)
    for one, other in zip(pressure_uncertainty(fit, radii), drawn, strict=True):
        assert other.pressure == one.pressure
        assert other.failed_draws == 0.0
        # The spread of 120 draws of Student's t is uncertain by some 8 %, and wider by 10 %.
        assert_allclose(other.standard_error, one.standard_error, 0.35)
    with ProcessPoolExecutor(2) as executor:
        again = pressure_uncertainty_by_draws(fit, radii, seed=3, draws=120, executor=executor)
    assert again == drawn


def test_the_error_of_the_pressure_is_that_of_the_slopes_though_nobody_knows_the_constants():
    fit = measured(TWO)
    assert fit.standard_errors[0] > 0.2 * abs(fit.value("c1"))
    pressures = [
        WrapCurve(fit.model.trial(fit.values + step).gripper).pressure_from_radius(0.02)
        for step in (*np.diag(1e-3 * fit.values), *np.diag(-1e-3 * fit.values))
    ]
    slopes = (np.array(pressures[:2]) - pressures[2:]) / (2e-3 * fit.values)
    (result,) = pressure_uncertainty(fit, (0.02,))
    # Of two constants that nearly cancel: a thousandth of the slopes is left of the differences.
    expected = np.sqrt(slopes @ fit.covariance @ slopes)
    assert_allclose(result.standard_error, expected, 0.01)
    assert result.standard_error < 0.02 * result.pressure


def test_the_error_is_known_up_to_the_pressure_limit():
    """Beyond it the gripper has no shape: slopes there are those of one side."""
    fit = measured(ONE)
    least = WrapCurve(fit.trial.gripper).radius_min
    at_end, inside = pressure_uncertainty(fit, (least, 1.01 * least), rivals=())
    assert at_end.pressure == fit.trial.gripper.pressure_max
    assert_allclose(at_end.standard_error, inside.standard_error, 0.02)


def test_the_interval_covers_what_the_readings_cannot_tell_apart():
    for truth_form in CurvatureForm:
        (other_form,) = {*CurvatureForm} - {truth_form}
        truth = replace(spiral(ONE), curvature_form=truth_form)
        readings = bends(truth, PRESSURES, np.random.default_rng(5), error=0.05)
        fit = fitted(replace(truth, curvature_form=other_form), readings, gripper=mounted(truth))
        (result,) = pressure_uncertainty(fit, (0.02,))
        (rival,) = result.rivals
        assert truth_form.value in rival.law
        true = WrapCurve(mounted(truth)).pressure_from_radius(0.02)
        for interval, covers in (
            (result.own_interval, False),
            (result.interval, True),
            (rival.interval, True),
        ):
            assert (interval.low <= true <= interval.high) is covers
        (alone,) = pressure_uncertainty(fit, (0.02,), rivals=())
        assert alone.interval == result.own_interval


def test_what_cannot_be_answered_is_refused_and_draws_that_fail_are_told():
    fit = measured(LAWS[0])
    least = WrapCurve(fit.trial.gripper).radius_min
    drawn = pressure_uncertainty_by_draws(fit, (1.001 * least, 0.02), seed=1, draws=40)
    assert 0.0 == drawn[1].failed_draws < drawn[0].failed_draws
    recorded("calibration/draws", [*drawn, *pressure_uncertainty(fit, (0.02,))])
    with pytest.raises(NotGrippableError):
        pressure_uncertainty(fit, (0.2,))
    with refused("holds the mounted gripper"):
        pressure_uncertainty(fitted(fit.actuator, fit.readings), (0.02,))
    two = fitted(fit.actuator, fit.readings, law=MooneyRivlin, gripper=fit.gripper)
    unknown = replace(two, covariance=np.diag([1.0e14, 1.0e14]))
    for said, asked, draws in (("at least 40", fit, 39), ("draws", unknown, 40)):
        with refused(said):
            pressure_uncertainty_by_draws(asked, (0.02,), seed=1, draws=draws)
