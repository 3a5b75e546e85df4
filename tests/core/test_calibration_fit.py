# SPDX-License-Identifier: Apache-2.0
"""The fit: what it finds, how sure it says it is, and when it refuses."""

import math
from dataclasses import replace

import numpy as np
import pytest
from core.calibration_cases import LAWS, PRESSURES, TUBE, actuator, extensions, spiral, start_from

from spiral_core import (
    ActuationLimitError,
    BendReading,
    CalibrationModel,
    CurvatureForm,
    ExtensionReading,
    FittedQuantity,
    FreeActuation,
    Gent,
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    PressureLaw,
    Section,
    ShapeReading,
    SolverError,
    TwistReading,
    WrapCurve,
    Yeoh,
    calibrate,
    gripper_from_actuator,
)
from spiral_core.calibration.fit import CalibrationStatus, Problem
from spiral_core.calibration.model import effective_errors, predict


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_exact_readings_give_back_the_constants_of_any_law(law):
    truth = actuator(law)
    fit = calibrate(CalibrationModel(start_from(truth)), extensions(truth, PRESSURES))
    expected = [getattr(law, name) for name in fit.names]
    # The fit ends where its cost changes by less than 1e-8 of itself.
    assert fit.values == pytest.approx(expected, rel=1e-5)
    assert fit.actuator.material == type(law)(*fit.values.tolist())


@pytest.mark.parametrize("factor", [0.15, 0.5, 2.0, 7.0])
def test_a_start_far_off_finds_the_same(factor):
    truth = actuator(LAWS[1])
    fit = calibrate(CalibrationModel(start_from(truth, factor)), extensions(truth, PRESSURES))
    assert fit.values == pytest.approx([90.0e3, 40.0e3], rel=1e-5)


@pytest.mark.parametrize("law", [NeoHookean, MooneyRivlin, Yeoh, Gent])
def test_another_law_starts_from_the_same_modulus(law):
    known = actuator(NeoHookean(c1=145.0e3))
    model = CalibrationModel(known, law=law)
    material = model.actuator_from(model.start()).material
    assert material.small_strain_modulus == pytest.approx(870.0e3)


@pytest.mark.parametrize("form", CurvatureForm)
def test_bend_angles_and_twists_of_one_actuator_fit_together(form):
    truth = actuator(NeoHookean(c1=130.0e3), 88.0, 60.0, curvature_form=form)
    actuation = FreeActuation(truth)
    readings = []
    for pressure in (20.0e3, 40.0e3, 60.0e3):
        shape = actuation.unloaded_shape(pressure)
        bend = shape.curvature * shape.backbone_length
        twist = shape.torsion * shape.backbone_length
        readings.append(BendReading(pressure, bend, TUBE.length, 0.01))
        readings.append(TwistReading(pressure, twist, TUBE.length, 0.01))
    model = CalibrationModel(start_from(truth))
    assert predict(model.trial((130.0e3,)), readings) == pytest.approx(
        [value for reading in readings for value in reading.measured], rel=1e-12
    )
    assert calibrate(model, readings).value("c1") == pytest.approx(130.0e3, rel=1e-6)


def test_fiber_radius_is_told_by_extension_and_bend_angle():
    truth = actuator(NeoHookean(c1=130.0e3), straight_fiber_radius=5.2e-3)
    actuation = FreeActuation(truth)
    bends = [
        BendReading(p, actuation.unloaded_shape(p).curvature * 0.2, 0.2, 0.01)
        for p in PRESSURES[::4]
    ]
    model = CalibrationModel(
        replace(start_from(truth), straight_fiber_radius=None),
        quantities=(FittedQuantity.STRAIGHT_FIBER_RADIUS,),
    )
    fit = calibrate(model, [*extensions(truth, PRESSURES[::3]), *bends])
    assert fit.value("straight_fiber_radius") == pytest.approx(5.2e-3, rel=1e-6)
    assert fit.actuator.straight_fiber_radius == fit.value("straight_fiber_radius")


def test_shapes_tell_stiffnesses_and_positions_agree_with_the_gripper():
    truth = gripper_from_actuator(
        "truth",
        spiral(NeoHookean(c1=145.0e3)),
        density=950.0,
        pressure_max=90.0e3,
        stiffness=Section.inextensible(bending=4.0e-4, torsional=2.5e-4),
    )
    curve = WrapCurve(truth)
    readings = []
    for pressure in (30.0e3, 60.0e3):
        state = curve.state_at_pressure(pressure)
        for node in (len(state.arc_lengths) // 2, -1):
            arc_length = None if node == -1 else float(state.arc_lengths[node])
            position = tuple(state.positions[node].tolist())
            readings.append(ShapeReading(pressure, position, arc_length, 1.0e-3))
    model = CalibrationModel(
        truth.actuation.actuator,
        quantities=(FittedQuantity.BENDING_STIFFNESS, FittedQuantity.TORSIONAL_STIFFNESS),
        gripper=truth,
    )
    assert model.start()[1:] != (4.0e-4, 2.5e-4)  # from the material, until fitted
    fit = calibrate(model, readings)
    # Two rods with other numbers of elements: the discretization's 1e-5 of the length shows.
    assert fit.values == pytest.approx([145.0e3, 4.0e-4, 2.5e-4], rel=2e-3)
    assert fit.stiffness.bending == fit.value("bending_stiffness")
    assert fit.gripper.stiffness == fit.stiffness


def test_grips_tell_the_constant():
    from spiral_core import GripReading

    gripper = gripper_from_actuator(
        "truth", spiral(NeoHookean(c1=145.0e3)), density=950.0, pressure_max=110.0e3
    )
    curve = WrapCurve(gripper)
    readings = [
        GripReading(curve.pressure_from_radius(r), r, 1.0e-4) for r in (0.012, 0.018, 0.025)
    ]
    model = CalibrationModel(start_from(gripper.actuation.actuator), gripper=gripper)
    # A radius depends on the rod's discretization by about 1e-5.
    assert calibrate(model, readings).value("c1") == pytest.approx(145.0e3, rel=1e-3)


def test_known_stiffness_is_kept_and_unknown_follows_the_fit():
    model = CalibrationModel(spiral(NeoHookean(c1=100.0e3)), bending_stiffness=5.0e-4)
    assert model.stiffness_from((200.0e3,)).bending == 5.0e-4
    ratio = model.stiffness_from((200.0e3,)).torsional / model.stiffness_from((100.0e3,)).torsional
    assert ratio == pytest.approx(2.0)


def test_jacobian_is_the_derivative_of_the_residuals():
    truth = actuator(LAWS[1])
    readings = tuple(extensions(truth, PRESSURES))
    problem = Problem(CalibrationModel(truth), readings, np.full(len(readings), 2.0e-4))
    at, _ = problem.solve(np.array([100.0e3, 30.0e3]))
    jacobian = problem.jacobian(at)
    for k, step in enumerate(np.diag([50.0, 50.0])):
        column = (problem.residuals(at + step) - problem.residuals(at - step)) / 100.0
        # Both are differences, of an error of about 1e-8.
        assert jacobian[:, k] == pytest.approx(column, rel=1e-5)


def test_stated_errors_only_weigh_readings_against_each_other():
    truth = actuator(LAWS[1])
    readings = extensions(truth, PRESSURES, noise=np.random.default_rng(5))
    doubled = [replace(reading, error=2.0 * reading.error) for reading in readings]
    fit, same = (calibrate(CalibrationModel(truth), r) for r in (readings, doubled))
    assert same.values == pytest.approx(fit.values, rel=1e-4)
    assert same.standard_errors == pytest.approx(fit.standard_errors, rel=1e-4)
    assert same.error_scale == pytest.approx(0.5 * fit.error_scale, rel=1e-6)
    precise = [replace(r, error=1.0e-9) if r is readings[5] else r for r in readings]
    through = calibrate(CalibrationModel(truth), precise)
    assert abs(through.predictions[5] - readings[5].extension) < 1.0e-8


def test_covariance_is_that_of_linear_least_squares():
    truth = actuator(LAWS[1])
    readings = extensions(truth, PRESSURES, noise=np.random.default_rng(6))
    fit = calibrate(CalibrationModel(truth), readings)
    expected = fit.error_scale**2 * np.linalg.inv(fit.jacobian.T @ fit.jacobian)
    assert fit.covariance == pytest.approx(expected, rel=1e-6)
    assert fit.error_scale**2 == pytest.approx(fit.residuals @ fit.residuals / 10.0)
    low, high = fit.interval("c1")
    assert high - low == pytest.approx(2.0 * 2.228139 * fit.standard_errors[0], rel=1e-6)
    assert fit.correlation == pytest.approx(fit.correlation.T)
    assert np.diag(fit.correlation).tolist() == [1.0, 1.0]


def test_error_of_the_pressure_counts_through_the_slope():
    truth = actuator(LAWS[0])
    reading = extensions(truth, [50.0e3])[0]
    trial = CalibrationModel(truth).trial((130.0e3,))
    actuation = FreeActuation(truth)
    slope = (
        0.1
        * (actuation.stretch_from_pressure(50.01e3) - actuation.stretch_from_pressure(49.99e3))
        / 20.0
    )
    (error,) = effective_errors(trial, [replace(reading, pressure_error=1.0e3)])
    # The slope comes from steps of a thousandth of the pressure.
    assert error == pytest.approx(math.hypot(reading.error, 1.0e3 * slope), rel=1e-5)
    assert effective_errors(trial, [reading]).tolist() == [reading.error]


def test_robust_fit_withstands_outliers_that_spoil_least_squares():
    truth = actuator(LAWS[0])
    readings = extensions(truth, PRESSURES, noise=np.random.default_rng(7))
    spoiled = [
        replace(r, extension=r.extension + 4.0e-3) if i in (3, 8) else r
        for i, r in enumerate(readings)
    ]
    model = CalibrationModel(truth)
    off = calibrate(model, spoiled).value("c1") / 130.0e3 - 1.0
    robust = calibrate(model, spoiled, robust=True)
    assert abs(off) > 0.02
    assert abs(robust.value("c1") / 130.0e3 - 1.0) < 0.005
    low, high = robust.interval("c1")
    assert low < 130.0e3 < high
    clean = calibrate(model, readings, robust=True)
    assert clean.value("c1") == pytest.approx(calibrate(model, readings).value("c1"), rel=5e-3)


def test_fixed_constants_are_held():
    truth = actuator(LAWS[1])
    fit = calibrate(CalibrationModel(truth, fixed={"c2": 40.0e3}), extensions(truth, PRESSURES))
    assert fit.names == ("c1",)
    assert fit.value("c1") == pytest.approx(90.0e3, rel=1e-6)
    assert fit.actuator.material.c2 == 40.0e3


def test_stable_range_is_that_of_the_fitted_actuator():
    truth = actuator(LAWS[2])
    fit = calibrate(CalibrationModel(truth), extensions(truth, PRESSURES))
    assert fit.actuation.pressure_limit == pytest.approx(
        FreeActuation(truth).pressure_limit, rel=1e-3
    )


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda a: CalibrationModel("tube"), "actuator"),
        (lambda a: CalibrationModel(a, fixed={"c3": 1.0}), "fixed"),
        (lambda a: CalibrationModel(a, fixed={"c1": 1.0, "c2": 1.0}), "fixed"),
        (lambda a: CalibrationModel(a, fixed={"c1": math.nan}), "c1"),
        (lambda a: CalibrationModel(a, law=int), "law"),
    ],
)
def test_a_model_that_makes_no_sense_is_refused(make, field):
    with pytest.raises(InvalidInputError) as caught:
        make(actuator(LAWS[1]))
    assert caught.value.field == field


def test_too_few_readings_are_refused():
    truth = actuator(LAWS[1])
    with pytest.raises(InvalidInputError, match="at least 3, to fit c1, c2"):
        calibrate(CalibrationModel(truth), extensions(truth, PRESSURES[:2]))


def test_a_shape_without_a_mounted_gripper_is_refused():
    readings = [ShapeReading(3.0e4, (0.3, 0.1, 0.0), None, 1.0e-3)]
    with pytest.raises(InvalidInputError) as caught:
        calibrate(CalibrationModel(actuator(LAWS[0])), readings)
    assert caught.value.field == "gripper"


def test_a_point_past_the_tip_is_refused():
    gripper = gripper_from_actuator("g", spiral(LAWS[0]), density=950.0)
    readings = [ShapeReading(3.0e4, (0.3, 0.1, 0.0), 0.4, 1.0e-3)]
    with pytest.raises(InvalidInputError) as caught:
        calibrate(CalibrationModel(spiral(LAWS[0]), gripper=gripper), readings)
    assert caught.value.field == "arc_length"


def test_pressures_no_start_reaches_are_refused():
    soft = actuator(Yeoh(c1=1.0, c2=-20.0, c3=0.0))
    readings = [ExtensionReading(p, 0.01, 0.1, 1.0e-4) for p in (1.0e8, 2.0e8, 3.0e8, 4.0e8)]
    with pytest.raises(ActuationLimitError) as caught:
        calibrate(CalibrationModel(soft, fixed={"c2": -20.0, "c3": -1.0e9}), readings)
    assert caught.value.value == 4.0e8


def test_a_fit_that_does_not_end_says_so(monkeypatch):
    truth = actuator(LAWS[1])
    monkeypatch.setattr("spiral_core.calibration.fit.EVALUATIONS_MAX", 1)
    readings = extensions(truth, PRESSURES)
    with pytest.raises(SolverError) as caught:
        calibrate(CalibrationModel(truth), readings, start=(300.0e3, 1.0e3))
    assert caught.value.status is CalibrationStatus.ITERATION_LIMIT


def test_a_fit_against_the_edge_of_what_is_possible_is_no_answer():
    # The slope first falls: Mooney-Rivlin would need a modulus of zero at rest.
    rows = ((68.9e3, 2.06), (103.4e3, 2.40), (137.9e3, 2.65))
    readings = [BendReading(p, bend, 0.18, 0.02 * bend) for p, bend in rows]
    with pytest.raises(SolverError) as caught:
        calibrate(CalibrationModel(actuator(LAWS[1], 80.0, -80.0)), readings)
    assert caught.value.status is CalibrationStatus.STUCK


def test_chains_that_never_run_out_end_at_the_bound():
    truth = actuator(LAWS[0])
    fit = calibrate(CalibrationModel(truth, law=Gent), extensions(truth, PRESSURES))
    assert fit.at_bound == ("extension_limit",)
    assert fit.value("shear_modulus") == pytest.approx(260.0e3, rel=1e-3)


def test_readings_refuse_what_cannot_be():
    for bad in (
        {"pressure": -1.0},
        {"pressure": math.nan},
        {"extension": math.inf},
        {"section_length": 0.0},
        {"error": 0.0},
        {"pressure_error": -1.0},
    ):
        values = {"pressure": 1.0e4, "extension": 1.0e-3, "section_length": 0.1, "error": 1.0e-4}
        with pytest.raises(InvalidInputError) as caught:
            ExtensionReading(**(values | bad))
        assert caught.value.field == next(iter(bad))


def test_constants_of_a_straight_section_carry_to_the_finished_actuator():
    """Extension is measured without the straight fiber, bending with it: one set of constants."""
    truth = actuator(NeoHookean(c1=130.0e3), 88.0, 60.0, pressure_law=PressureLaw.SECTION)
    straight, finished = FreeActuation(truth.without_single_fibers()), FreeActuation(truth)
    pressures = (15.0e3, 30.0e3, 45.0e3, 60.0e3)
    readings = [
        ExtensionReading(p, 0.1 * (straight.stretch_from_pressure(p) - 1.0), 0.1, 2.0e-4)
        for p in pressures
    ]
    fit = calibrate(CalibrationModel(start_from(truth)), readings)
    assert fit.value("c1") == pytest.approx(130.0e3, rel=1e-6)
    assert fit.actuation.unloaded_shape(60.0e3).curvature == pytest.approx(
        finished.unloaded_shape(60.0e3).curvature, rel=1e-6
    )
    # The uniform law takes both for one: a third of the pressure is missing.
    paper = replace(truth, pressure_law=PressureLaw.UNIFORM)
    fit = calibrate(CalibrationModel(start_from(paper)), readings)
    missing = finished.pressure_from_stretch(1.1) / fit.actuation.pressure_from_stretch(1.1)
    assert missing == pytest.approx(1.42, abs=0.01)


def test_bends_and_extensions_of_one_tube_fit_together():
    truth = actuator(MooneyRivlin(c1=90.0e3, c2=40.0e3), pressure_law=PressureLaw.SECTION)
    straight, finished = FreeActuation(truth.without_single_fibers()), FreeActuation(truth)
    pressures = np.linspace(10.0e3, 60.0e3, 6)
    bends = [
        BendReading(p, finished.unloaded_shape(p).curvature * 0.2, 0.2, 0.01) for p in pressures
    ]
    extensions_ = [
        ExtensionReading(p, 0.1 * (straight.stretch_from_pressure(p) - 1.0), 0.1, 2.0e-4)
        for p in pressures
    ]
    fit = calibrate(CalibrationModel(start_from(truth)), [*bends, *extensions_])
    assert fit.values == pytest.approx([90.0e3, 40.0e3], rel=1e-5)


def test_straight_fiber_radius_is_fitted_with_the_section_law():
    truth = actuator(
        NeoHookean(c1=130.0e3), pressure_law=PressureLaw.SECTION, straight_fiber_radius=5.3e-3
    )
    finished, straight = FreeActuation(truth), FreeActuation(truth.without_single_fibers())
    readings = [
        BendReading(p, finished.unloaded_shape(p).curvature * 0.2, 0.2, 0.01)
        for p in (20.0e3, 40.0e3, 60.0e3)
    ]
    readings.append(
        ExtensionReading(40.0e3, 0.1 * (straight.stretch_from_pressure(40.0e3) - 1.0), 0.1, 1e-4)
    )
    model = CalibrationModel(
        replace(truth, straight_fiber_radius=None),
        quantities=(FittedQuantity.STRAIGHT_FIBER_RADIUS,),
    )
    fit = calibrate(model, readings)
    assert fit.value("straight_fiber_radius") == pytest.approx(5.3e-3, rel=1e-5)
    assert fit.value("c1") == pytest.approx(130.0e3, rel=1e-5)
