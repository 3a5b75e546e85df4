# SPDX-License-Identifier: Apache-2.0
"""The fit: what it finds, how sure it says it is, and when it refuses.

``benchmarks/calibration_coverage.py`` studies the coverage with more laws and more tests.
"""

from dataclasses import astuple, replace
from math import hypot

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
from core.recorded import recorded, said
from numpy.testing import assert_allclose

from spiral_core import (
    BendReading,
    CalibrationModel,
    CurvatureForm,
    ExtensionReading,
    FittedQuantity,
    Gent,
    GripReading,
    NeoHookean,
    PressureLaw,
    Section,
    ShapeReading,
    WrapCurve,
    Yeoh,
    grip_window,
    gripper_from_actuator,
    lay_into_coil,
)
from spiral_core.calibration.model import effective_errors
from spiral_core.grip.window import sharp_onset

SECTION = {"pressure_law": PressureLaw.SECTION}
FIBER = {"straight_fiber_radius": 5.3e-3}
FEW = (15.0e3, 30.0e3, 45.0e3, 60.0e3)
# The truth, the readings' kinds, and by what factor the start is off.
RECOVERED = [
    *((actuator(law), {extensions: PRESSURES}, 1.4) for law in LAWS),
    (actuator(LAWS[1]), {extensions: PRESSURES}, 7.0),
    (actuator(LAWS[1]), {extensions: PRESSURES}, 0.15),
    *(
        (actuator(LAWS[0], 88.0, 60.0, curvature_form=form), {bends: FEW, twists: FEW}, 1.4)
        for form in CurvatureForm
    ),
    (actuator(LAWS[1], **SECTION), {bends: FEW, extensions: FEW}, 1.4),
    (actuator(LAWS[0], **FIBER), {extensions: FEW, bends: FEW}, 1.4),
    (actuator(LAWS[0], **FIBER, **SECTION), {bends: FEW, extensions: FEW[:1]}, 1.0),
]


def test_exact_readings_give_back_what_they_are_of():
    for truth, kinds, factor in RECOVERED:
        readings = [
            reading for kind, pressures in kinds.items() for reading in kind(truth, pressures)
        ]
        radius = truth.straight_fiber_radius
        quantities = (FittedQuantity.STRAIGHT_FIBER_RADIUS,) if radius else ()
        start = replace(start_from(truth, factor), straight_fiber_radius=None)
        fit = fitted(start, readings, quantities=quantities)
        # The fit ends where its cost changes by less than 1e-8 of itself.
        expected = [*astuple(truth.material), radius][: len(fit.values)]
        assert_allclose(fit.values, expected, 1e-5)
        known = {"material": truth.material, "straight_fiber_radius": radius}
        assert replace(fit.actuator, **known) == truth
        found = [*astuple(fit.actuator.material), fit.actuator.straight_fiber_radius]
        assert found[: len(expected)] == fit.values.tolist()


def test_shapes_tell_stiffnesses_and_grips_the_constant():
    known = {"bending_stiffness": 4.0e-4, "torsional_stiffness": 2.5e-4}
    truth = replace(
        gripper_from_actuator("truth", spiral(NeoHookean(145.0e3)), density=950.0),
        pressure_max=90.0e3,
        stiffness=Section.inextensible(*known.values()),
    )
    own, readings = truth.actuation.actuator, []
    for pressure in (30.0e3, 60.0e3):
        state = WrapCurve(truth).state_at_pressure(pressure)
        for node, at in ((30, state.arc_lengths[30]), (-1, None)):
            readings.append(ShapeReading(pressure, tuple(state.positions[node]), at, 1.0e-3))
    fit = fitted(own, readings, quantities=tuple(FittedQuantity)[:2], gripper=truth)
    # Two rods with other numbers of elements: the discretization's 1e-5 of the length shows.
    assert_allclose(fit.values, [145.0e3, *known.values()], 2e-3)
    assert fit.gripper.stiffness == fit.stiffness
    grips = [GripReading(40.0e3, 0.05, 1.0)]  # too thick to be wrapped, and hardly known
    grips += [
        GripReading(sharp_onset(grip_window(lay_into_coil(truth, r), until_wrapped=True)), r, 1e-4)
        for r in (0.012, 0.025)
    ]
    # An onset depends on the rod's discretization by about 1e-5.
    fit = fitted(start_from(own), grips, gripper=truth, **known)
    assert_allclose(fit.values, 145.0e3, 1e-4)
    assert fit.readings[0].contact_shift == 0.0


def test_stated_errors_only_weigh_readings_against_each_other():
    truth = actuator(LAWS[1])
    readings = noisy(truth, 5)
    fit, same = (
        fitted(truth, [replace(r, error=factor * r.error) for r in readings]) for factor in (1, 2)
    )
    assert_allclose(same.values, fit.values, 1e-4)
    assert_allclose(same.standard_errors, fit.standard_errors, 1e-4)
    assert_allclose(same.error_scale, 0.5 * fit.error_scale, 1e-6)
    readings[5] = replace(readings[5], error=1.0e-9)
    assert abs(fitted(truth, readings).predictions[5] - readings[5].extension) < 1.0e-8


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
    truth, noise, hits = actuator(law), np.random.default_rng(20260101), []
    for _ in range(tests):
        fit = fitted(truth, extensions(truth, pressures, 2e-4, noise, pressure_noise))
        low, high = np.transpose([fit.interval(name) for name in fit.names])
        hits.append((low <= astuple(law)) & (astuple(law) <= high))
    assert all(lowest <= share <= highest for share in np.mean(hits, axis=0))


def test_error_of_the_pressure_counts_through_the_slope():
    truth = actuator(LAWS[0])
    below, reading, above = extensions(truth, [49.99e3, 50.0e3, 50.01e3])
    slope = (above.extension - below.extension) / 20.0
    uncertain = replace(reading, pressure_error=1.0e3)
    found = effective_errors(CalibrationModel(truth).trial((130.0e3,)), [reading, uncertain])
    # The slope comes from steps of a thousandth of the pressure.
    assert_allclose(found, (reading.error, hypot(reading.error, 1.0e3 * slope)), 1e-5)


def test_fixed_constants_are_held_and_chains_that_never_run_out_end_at_the_bound():
    truth, soft = actuator(LAWS[1]), actuator(LAWS[0])
    fit = fitted(truth, extensions(truth, PRESSURES), fixed={"c2": 40.0e3})
    assert fit.names == ("c1",)
    assert_allclose(astuple(fit.actuator.material), (90.0e3, 40.0e3), 1e-6)
    endless = fitted(soft, extensions(soft, PRESSURES), law=Gent)
    assert endless.at_bound == ("extension_limit",)


SHAPE = ShapeReading(3.0e4, (0.3, 0.1, 0.0), 0.4, 1.0e-3)
MOUNTED = gripper_from_actuator("g", spiral(LAWS[0]), density=950.0)
FAR = [ExtensionReading(p, 0.01, 0.1, 1.0e-4) for p in (1.0e8, 2.0e8, 4.0e8, 3.0e8)]
# The slope first falls: Mooney-Rivlin would need a modulus of zero at rest.
ROWS = ((68.9e3, 2.06), (103.4e3, 2.40), (137.9e3, 2.65))
FALLING = [BendReading(p, bend, 0.18, 0.02 * bend) for p, bend in ROWS]


def test_readings_that_cannot_be_fitted_are_refused():
    found = [
        said(lambda: fitted(actuator(law, 80.0, -80.0), readings, **model))  # noqa: B023
        for law, readings, model in (
            (LAWS[1], FAR[:2], {}),
            (LAWS[0], [SHAPE], {}),
            (LAWS[0], [SHAPE], {"gripper": MOUNTED}),
            (Yeoh(1.0, -20.0, -1.0e9), FAR, {}),
            (LAWS[1], FALLING, {}),
        )
    ]
    recorded("calibration/unfitted", found)
