# SPDX-License-Identifier: Apache-2.0
"""The fit: what it finds, how sure it says it is, and when it refuses."""

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
    spiral,
    start_from,
    twists,
)

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
    WrapCurve,
    Yeoh,
    calibrate,
    gripper_from_actuator,
)
from spiral_core.calibration.fit import CalibrationStatus, Problem
from spiral_core.calibration.model import effective_errors

RADIUS = {FittedQuantity.STRAIGHT_FIBER_RADIUS: 5.3e-3}
SECTION = {"pressure_law": PressureLaw.SECTION}
FIBER = {"straight_fiber_radius": 5.3e-3}
FEW = (15.0e3, 30.0e3, 45.0e3, 60.0e3)
RECOVERED = {
    **{type(law).__name__: (actuator(law), [(extensions, PRESSURES)], 1.4, {}) for law in LAWS},
    **{
        f"a start off by {factor}": (actuator(LAWS[1]), [(extensions, PRESSURES)], factor, {})
        for factor in (0.15, 0.5, 2.0, 7.0)
    },
    **{
        f"bends and twists, {form.value}": (
            actuator(LAWS[0], 88.0, 60.0, curvature_form=form),
            [(bends, FEW), (twists, FEW)],
            1.4,
            {},
        )
        for form in CurvatureForm
    },
    "bends and extensions, section law": (
        actuator(LAWS[1], **SECTION),
        [(bends, FEW), (extensions, FEW)],
        1.4,
        {},
    ),
    "fiber radius": (
        actuator(LAWS[0], **FIBER),
        [(extensions, FEW), (bends, FEW)],
        1.4,
        RADIUS,
    ),
    "fiber radius, section law": (
        actuator(LAWS[0], **FIBER, **SECTION),
        [(bends, FEW), (extensions, FEW[:1])],
        1.0,
        RADIUS,
    ),
}


@pytest.mark.parametrize("case", RECOVERED)
def test_exact_readings_give_back_what_they_are_of(case):
    truth, kinds, factor, quantities = RECOVERED[case]
    readings = [reading for kind, pressures in kinds for reading in kind(truth, pressures)]
    start = start_from(truth, factor)
    if quantities:
        start = replace(start, straight_fiber_radius=None)
    fit = calibrate(CalibrationModel(start, quantities=tuple(quantities)), readings)
    constants = fit.names[: len(fit.names) - len(quantities)]
    expected = [*(getattr(truth.material, name) for name in constants), *quantities.values()]
    # The fit ends where its cost changes by less than 1e-8 of itself.
    assert fit.values == pytest.approx(expected, rel=1e-5)
    assert fit.actuator == replace(
        truth,
        material=type(truth.material)(*fit.values[: len(constants)].tolist()),
        straight_fiber_radius=fit.values[-1] if quantities else None,
    )


@pytest.mark.parametrize("law", [NeoHookean, MooneyRivlin, Yeoh, Gent])
def test_another_law_starts_from_the_same_modulus(law):
    known = actuator(NeoHookean(c1=145.0e3))
    model = CalibrationModel(known, law=law)
    material = model.actuator_from(model.start()).material
    assert material.small_strain_modulus == pytest.approx(870.0e3)


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
    # From the material, until fitted.
    assert (model.start()[1:] != (4.0e-4, 2.5e-4)).all()
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


SHAPE = ShapeReading(3.0e4, (0.3, 0.1, 0.0), None, 1.0e-3)
SOFT = CalibrationModel(actuator(Yeoh(c1=1.0, c2=-20.0, c3=0.0)), fixed={"c2": -20.0, "c3": -1.0e9})


@pytest.mark.parametrize(
    ("model", "readings", "error", "said"),
    [
        (
            CalibrationModel(actuator(LAWS[1])),
            extensions(actuator(LAWS[1]), PRESSURES[:2]),
            InvalidInputError,
            "readings must be at least 3, to fit c1, c2",
        ),
        (CalibrationModel(actuator(LAWS[0])), [SHAPE], InvalidInputError, "gripper must be given"),
        (
            CalibrationModel(
                spiral(LAWS[0]), gripper=gripper_from_actuator("g", spiral(LAWS[0]), density=950.0)
            ),
            [replace(SHAPE, arc_length=0.4)],
            InvalidInputError,
            "arc_length must be at most the length",
        ),
        (
            SOFT,
            [ExtensionReading(p, 0.01, 0.1, 1.0e-4) for p in (1.0e8, 2.0e8, 4.0e8, 3.0e8)],
            ActuationLimitError,
            "4e.08|400",
        ),
    ],
    ids=["too few", "no gripper", "past the tip", "no start reaches"],
)
def test_readings_that_cannot_be_fitted_are_refused(model, readings, error, said):
    with pytest.raises(error, match=said):
        calibrate(model, readings)


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
    truth = actuator(LAWS[0], 88.0, 60.0, **SECTION)
    finished, readings = FreeActuation(truth), extensions(truth, FEW)
    fit = calibrate(CalibrationModel(start_from(truth)), readings)
    assert fit.actuation.unloaded_shape(60.0e3).curvature == pytest.approx(
        finished.unloaded_shape(60.0e3).curvature, rel=1e-6
    )
    # The uniform law takes both for one: a third of the pressure is missing.
    paper = replace(truth, pressure_law=PressureLaw.UNIFORM)
    fit = calibrate(CalibrationModel(start_from(paper)), readings)
    missing = finished.pressure_from_stretch(1.1) / fit.actuation.pressure_from_stretch(1.1)
    assert missing == pytest.approx(1.42, abs=0.01)
