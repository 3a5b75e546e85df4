# SPDX-License-Identifier: Apache-2.0
"""A measured curve in place of a law: the interpolation, and readings that make one."""

import math
from dataclasses import astuple

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
    InvalidInputError,
    MeasuredActuation,
    TwistReading,
    measured_actuation_from_readings,
)
from spiral_core.errors import ActuationLimit

PRESSURES, CURVATURES = (0.0, 2e4, 4e4, 6e4), (0.0, 8.0, 8.0, 30.0)
TORSIONS = (0.0, -4.0, -9.0, -14.0)
ACTUATION = MeasuredActuation(PRESSURES, CURVATURES, TORSIONS, 0.36)
LAWFUL = FreeActuation(spiral(LAWS[0]))


@given(st.floats(0.0, 6.0e4), st.floats(0.0, 6.0e4))
def test_it_passes_through_the_data_and_is_monotone_between(first, second):
    for point in zip(PRESSURES, CURVATURES, TORSIONS, strict=True):
        assert astuple(ACTUATION.unloaded_shape(point[0])) == (*point[1:], 0.36, None)
    low, high = (ACTUATION.unloaded_shape(p) for p in sorted((first, second)))
    slack = 1e-12  # rounding of the cubic
    assert low.curvature <= high.curvature + slack
    assert low.torsion >= high.torsion - slack
    if 2.0e4 <= min(first, second) <= max(first, second) <= 4.0e4:
        assert low.curvature == high.curvature == pytest.approx(8.0)


def test_it_ends_where_the_data_end():
    assert (ACTUATION.pressure_limit, ACTUATION.limit) == (6.0e4, ActuationLimit.DATA_END)
    with pytest.raises(ActuationLimitError, match="measured actuation data end here"):
        ACTUATION.unloaded_shape(6.0001e4)
    for bad in (-1.0, math.nan, True, "1 psi"):
        with pytest.raises(InvalidInputError):
            ACTUATION.unloaded_shape(bad)


def test_readings_become_a_curve():
    readings = []
    for pressure in (6.0e4, 2.0e4, 4.0e4):
        shape = LAWFUL.unloaded_shape(pressure)
        readings.append(TwistReading(pressure, shape.torsion * 0.2, 0.2, 0.01))
        bend = shape.curvature * 0.2
        for repeat in (bend - 0.01, bend + 0.01):  # whose mean is right
            readings += [BendReading(pressure, repeat, 0.2, 0.01)]
    curve = measured_actuation_from_readings(readings, 0.361, LAWFUL.actuator.fibers)
    assert tuple(curve.pressures) == (0.0, 2.0e4, 4.0e4, 6.0e4)
    for pressure in curve.pressures:
        expected, shape = LAWFUL.unloaded_shape(pressure), curve.unloaded_shape(pressure)
        assert astuple(shape)[:3] == pytest.approx(astuple(expected)[:3], rel=1e-12)


BENDS = [BendReading(p, p * 1e-5, 0.2, 0.01) for p in (1.0e4, 2.0e4, 3.0e4)]
SYMMETRIC = FiberAngles(alpha=1.1, beta=-1.1)


@pytest.mark.parametrize(
    ("readings", "fibers", "match"),
    [
        ([*BENDS, TwistReading(1.0e4, 0.1, 0.2, 0.01)], SYMMETRIC, "pressures of the bend angles"),
        ([ExtensionReading(1.0e4, 0.01, 0.1, 1e-4)], SYMMETRIC, "bend angles and twists only"),
        # A spiral twists: bend angles alone would make a plane coil of it.
        (BENDS, LAWFUL.actuator.fibers, "bend angles and twists: fibers at alpha and beta"),
    ],
)
def test_readings_that_make_no_curve_are_refused(readings, fibers, match):
    with pytest.raises(InvalidInputError, match=match):
        measured_actuation_from_readings(readings, 0.36, fibers)


def test_bend_angles_alone_are_a_plane_coil_of_symmetric_fibers():
    assert measured_actuation_from_readings(BENDS, 0.36, SYMMETRIC).torsions == (0.0,) * 4
