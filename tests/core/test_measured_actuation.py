# SPDX-License-Identifier: Apache-2.0
"""A measured curve in place of a law: the interpolation, and the rest of the chain unchanged."""

import math

import numpy as np
import pytest
from core.calibration_cases import LAWS, spiral
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import (
    ActuationLimitError,
    BendReading,
    ExtensionReading,
    FiberAngles,
    FreeActuation,
    Gripper,
    InvalidInputError,
    MeasuredActuation,
    NotGrippableError,
    TwistReading,
    WrapCurve,
    gripper_from_actuator,
    measured_actuation_from_readings,
)
from spiral_core.actuator.actuator import ActuationModel
from spiral_core.errors import ActuationLimit

GOOD = {
    "pressures": (0.0, 2.0e4, 4.0e4, 6.0e4),
    "curvatures": (0.0, 8.0, 8.0, 30.0),
    "torsions": (0.0, -4.0, -9.0, -14.0),
    "backbone_length": 0.36,
}


def test_it_is_an_actuation_model_that_passes_through_the_data():
    actuation = MeasuredActuation(**GOOD)
    assert isinstance(actuation, ActuationModel)
    for pressure, curvature, torsion in zip(
        GOOD["pressures"], GOOD["curvatures"], GOOD["torsions"], strict=True
    ):
        shape = actuation.unloaded_shape(pressure)
        assert (shape.curvature, shape.torsion) == (curvature, torsion)
        assert (shape.backbone_length, shape.stretch) == (0.36, None)


@given(st.floats(0.0, 6.0e4), st.floats(0.0, 6.0e4))
def test_it_is_monotone_between_the_data(first, second):
    actuation = MeasuredActuation(**GOOD)
    low, high = (actuation.unloaded_shape(p) for p in sorted((first, second)))
    slack = 1e-12  # rounding of the cubic
    assert low.curvature <= high.curvature + slack
    assert low.torsion >= high.torsion - slack
    if 2.0e4 <= min(first, second) <= max(first, second) <= 4.0e4:
        assert low.curvature == high.curvature == pytest.approx(8.0)


def test_it_ends_where_the_data_end():
    actuation = MeasuredActuation(**GOOD)
    assert actuation.pressure_limit == 6.0e4
    assert actuation.limit is ActuationLimit.DATA_END
    with pytest.raises(ActuationLimitError, match="measured actuation data end here"):
        actuation.unloaded_shape(6.0001e4)
    for bad in (-1.0, math.nan, math.inf, True, "1 psi"):
        with pytest.raises(InvalidInputError):
            actuation.unloaded_shape(bad)


def test_the_rest_of_the_chain_does_not_see_a_difference():
    lawful = gripper_from_actuator("lawful", spiral(LAWS[0]), density=950.0, pressure_max=110.0e3)
    pressures = np.linspace(0.0, 110.0e3, 45)
    shapes = [lawful.unloaded_shape(float(p)) for p in pressures]
    measured = Gripper(
        name="measured",
        tube=lawful.tube,
        actuation=MeasuredActuation(
            pressures=pressures.tolist(),
            curvatures=[shape.curvature for shape in shapes],
            torsions=[shape.torsion for shape in shapes],
            backbone_length=lawful.tube.length,
        ),
        stiffness=lawful.stiffness,
        weight_per_length=lawful.weight_per_length,
        pressure_max=110.0e3,
    )
    known, found = WrapCurve(lawful), WrapCurve(measured)
    # 45 points interpolate the law's curve to about 1e-5.
    assert found.radius_max == pytest.approx(known.radius_max, rel=1e-3)
    for radius in (0.01, 0.02, 0.03):
        wrap, expected = found.wrap_for_radius(radius), known.wrap_for_radius(radius)
        assert wrap.pressure == pytest.approx(expected.pressure, rel=1e-4)
        assert wrap.turns == pytest.approx(expected.turns, rel=1e-3)
    with pytest.raises(NotGrippableError):
        found.wrap_for_radius(found.radius_max * 1.1)
    with pytest.raises(InvalidInputError, match="measured actuation data end here"):
        Gripper("too far", lawful.tube, measured.actuation, lawful.stiffness, 0.2, 120.0e3)


def test_readings_become_a_curve():
    actuation = FreeActuation(spiral(LAWS[0]))
    readings = []
    for pressure in (6.0e4, 2.0e4, 4.0e4):
        shape = actuation.unloaded_shape(pressure)
        for sign in (1.0, -1.0):  # repeats, whose mean is right
            bend = shape.curvature * 0.2 + sign * 0.01
            readings.append(BendReading(pressure, bend, 0.2, 0.01))
            readings.append(TwistReading(pressure, shape.torsion * 0.2, 0.2, 0.01))
    curve = measured_actuation_from_readings(readings, 0.361, spiral(LAWS[0]).fibers)
    assert tuple(curve.pressures) == (0.0, 2.0e4, 4.0e4, 6.0e4)
    for pressure in curve.pressures:
        expected, shape = actuation.unloaded_shape(pressure), curve.unloaded_shape(pressure)
        assert shape.curvature == pytest.approx(expected.curvature, rel=1e-12)
        assert shape.torsion == pytest.approx(expected.torsion, rel=1e-12)


SYMMETRIC = (0.36, FiberAngles(alpha=1.1, beta=-1.1))


def test_readings_that_make_no_curve_are_refused():
    bends = [BendReading(p, p * 1e-5, 0.2, 0.01) for p in (1.0e4, 2.0e4, 3.0e4)]
    with pytest.raises(InvalidInputError, match="pressures of the bend angles"):
        measured_actuation_from_readings([*bends, TwistReading(1.0e4, 0.1, 0.2, 0.01)], *SYMMETRIC)
    with pytest.raises(InvalidInputError, match="bend angles and twists only"):
        measured_actuation_from_readings([ExtensionReading(1.0e4, 0.01, 0.1, 1e-4)], *SYMMETRIC)
    with pytest.raises(InvalidInputError) as caught:
        measured_actuation_from_readings([*bends, BendReading(4.0e4, 0.2, 0.2, 0.01)], *SYMMETRIC)
    assert caught.value.field == "curvatures"
    # A spiral twists: bend angles alone would make a plane coil of it.
    with pytest.raises(InvalidInputError, match="bend angles and twists: fibers at alpha and beta"):
        measured_actuation_from_readings(bends, 0.36, spiral(LAWS[0]).fibers)
    assert measured_actuation_from_readings(bends, *SYMMETRIC).torsions == (0.0,) * 4
