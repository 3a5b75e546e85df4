# SPDX-License-Identifier: Apache-2.0
"""The fit: what it finds, how sure it says it is, and when it refuses.

``benchmarks/calibration_coverage.py`` studies the coverage with more laws and more tests.
"""

import math
from dataclasses import astuple, replace

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
    Gent,
    GripReading,
    InvalidInputError,
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
from spiral_core.calibration.fit import CalibrationStatus
from spiral_core.calibration.model import effective_errors

SECTION = {"pressure_law": PressureLaw.SECTION}
FIBER = {"straight_fiber_radius": 5.3e-3}
FEW = (15.0e3, 30.0e3, 45.0e3, 60.0e3)
# The truth, the readings' kinds, and by what factor the start is off.
RECOVERED = [
    *((actuator(law), [(extensions, PRESSURES)], 1.4) for law in LAWS),
    *((actuator(LAWS[1]), [(extensions, PRESSURES)], factor) for factor in (0.15, 7.0)),
    *(
        (actuator(LAWS[0], 88.0, 60.0, curvature_form=form), [(bends, FEW), (twists, FEW)], 1.4)
        for form in CurvatureForm
    ),
    (actuator(LAWS[1], **SECTION), [(bends, FEW), (extensions, FEW)], 1.4),
    (actuator(LAWS[0], **FIBER), [(extensions, FEW), (bends, FEW)], 1.4),
    (actuator(LAWS[0], **FIBER, **SECTION), [(bends, FEW), (extensions, FEW[:1])], 1.0),
]


@pytest.mark.parametrize("case", range(len(RECOVERED)))
def test_exact_readings_give_back_what_they_are_of(case):
    truth, kinds, factor = RECOVERED[case]
    readings = [reading for kind, pressures in kinds for reading in kind(truth, pressures)]
    radius = truth.straight_fiber_radius
    quantities = () if radius is None else (FittedQuantity.STRAIGHT_FIBER_RADIUS,)
    start = replace(start_from(truth, factor), straight_fiber_radius=None)
    fit = fitted(start, readings, quantities=quantities)
    # The fit ends where its cost changes by less than 1e-8 of itself.
    expected = [*astuple(truth.material), *(radius for _ in quantities)]
    assert fit.values == pytest.approx(expected, rel=1e-5)
    known = {"material": truth.material, "straight_fiber_radius": radius}
    assert replace(fit.actuator, **known) == truth
    found = [*astuple(fit.actuator.material), fit.actuator.straight_fiber_radius]
    assert found[: len(expected)] == fit.values.tolist()


def test_shapes_tell_stiffnesses_and_grips_the_constant():
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
    quantities = (FittedQuantity.BENDING_STIFFNESS, FittedQuantity.TORSIONAL_STIFFNESS)
    model = CalibrationModel(truth.actuation.actuator, quantities=quantities, gripper=truth)
    # From the material, until fitted.
    assert (model.start()[1:] != (4.0e-4, 2.5e-4)).all()
    fit = calibrate(model, readings)
    # Two rods with other numbers of elements: the discretization's 1e-5 of the length shows.
    assert fit.values == pytest.approx([145.0e3, 4.0e-4, 2.5e-4], rel=2e-3)
    assert fit.gripper.stiffness == fit.stiffness
    grips = [GripReading(curve.pressure_from_radius(r), r, 1.0e-4) for r in (0.012, 0.018, 0.025)]
    start = start_from(truth.actuation.actuator)
    known = {"bending_stiffness": 4.0e-4, "torsional_stiffness": 2.5e-4}
    fit = fitted(start, grips, gripper=truth, **known)
    # A radius depends on the rod's discretization by about 1e-5.
    assert fit.value("c1") == pytest.approx(145.0e3, rel=1e-3)


def test_stated_errors_only_weigh_readings_against_each_other():
    truth = actuator(LAWS[1])
    readings = noisy(truth, 5)
    doubled = [replace(reading, error=2.0 * reading.error) for reading in readings]
    fit, same = fitted(truth, readings), fitted(truth, doubled)
    assert same.values == pytest.approx(fit.values, rel=1e-4)
    assert same.standard_errors == pytest.approx(fit.standard_errors, rel=1e-4)
    assert same.error_scale == pytest.approx(0.5 * fit.error_scale, rel=1e-6)
    precise = [replace(r, error=1.0e-9) if r is readings[5] else r for r in readings]
    assert abs(fitted(truth, precise).predictions[5] - readings[5].extension) < 1.0e-8


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "pressures", "pressure_noise", "tests", "lowest", "highest"),
    [
        (LAWS[1], PRESSURES, 0.0, 500, 0.93, 0.97),
        # Of 100 tests, 95 % +- 3 standard deviations of such a share.
        (LAWS[0], PRESSURES[::3], 1.0e3, 100, 0.885, 1.0),
    ],
)
def test_intervals_hold_the_truth_as_often_as_they_say(
    law, pressures, pressure_noise, tests, lowest, highest
):
    truth, noise = actuator(law), np.random.default_rng(20260101)
    hits = []
    for _ in range(tests):
        readings = extensions(truth, pressures, noise=noise, pressure_noise=pressure_noise)
        fit = fitted(truth, readings)
        ends = [(*fit.interval(name), getattr(law, name)) for name in fit.names]
        hits.append([low <= true <= high for low, high, true in ends])
    assert all(lowest <= share <= highest for share in np.mean(hits, axis=0))


def test_error_of_the_pressure_counts_through_the_slope():
    truth = actuator(LAWS[0])
    below, reading, above = extensions(truth, [49.99e3, 50.0e3, 50.01e3])
    slope = (above.extension - below.extension) / 20.0
    trial = CalibrationModel(truth).trial((130.0e3,))
    (error,) = effective_errors(trial, [replace(reading, pressure_error=1.0e3)])
    # The slope comes from steps of a thousandth of the pressure.
    assert error == pytest.approx(math.hypot(reading.error, 1.0e3 * slope), rel=1e-5)
    assert effective_errors(trial, [reading]).tolist() == [reading.error]


def test_fixed_constants_are_held_and_chains_that_never_run_out_end_at_the_bound():
    truth = actuator(LAWS[1])
    fit = fitted(truth, extensions(truth, PRESSURES), fixed={"c2": 40.0e3})
    assert fit.names == ("c1",)
    assert fit.value("c1") == pytest.approx(90.0e3, rel=1e-6)
    assert fit.actuator.material.c2 == 40.0e3
    endless = fitted(actuator(LAWS[0]), extensions(actuator(LAWS[0]), PRESSURES), law=Gent)
    assert endless.at_bound == ("extension_limit",)
    assert endless.value("shear_modulus") == pytest.approx(260.0e3, rel=1e-3)


SHAPE = ShapeReading(3.0e4, (0.3, 0.1, 0.0), None, 1.0e-3)
MOUNTED = gripper_from_actuator("g", spiral(LAWS[0]), density=950.0)


def test_readings_that_cannot_be_fitted_are_refused():
    truth = actuator(LAWS[1])
    with pytest.raises(InvalidInputError, match="readings must be at least 3, to fit c1, c2"):
        fitted(truth, extensions(truth, PRESSURES[:2]))
    with pytest.raises(InvalidInputError, match="gripper must be given"):
        fitted(actuator(LAWS[0]), [SHAPE])
    with pytest.raises(InvalidInputError, match="arc_length must be at most the length"):
        fitted(spiral(LAWS[0]), [replace(SHAPE, arc_length=0.4)], gripper=MOUNTED)
    soft = actuator(Yeoh(c1=1.0, c2=-20.0, c3=0.0))
    readings = [ExtensionReading(p, 0.01, 0.1, 1.0e-4) for p in (1.0e8, 2.0e8, 4.0e8, 3.0e8)]
    with pytest.raises(ActuationLimitError, match=r"4e.08|400"):
        fitted(soft, readings, fixed={"c2": -20.0, "c3": -1.0e9})


def test_a_fit_that_finds_no_minimum_says_so(monkeypatch):
    # The slope first falls: Mooney-Rivlin would need a modulus of zero at rest.
    rows = ((68.9e3, 2.06), (103.4e3, 2.40), (137.9e3, 2.65))
    readings = [BendReading(p, bend, 0.18, 0.02 * bend) for p, bend in rows]
    with pytest.raises(SolverError) as caught:
        fitted(actuator(LAWS[1], 80.0, -80.0), readings)
    assert caught.value.status is CalibrationStatus.STUCK
    monkeypatch.setattr("spiral_core.calibration.fit.EVALUATIONS_MAX", 1)
    with pytest.raises(SolverError) as caught:
        fitted(start_from(actuator(LAWS[1]), 3.0), extensions(actuator(LAWS[1]), PRESSURES))
    assert caught.value.status is CalibrationStatus.ITERATION_LIMIT
