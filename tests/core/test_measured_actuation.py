# SPDX-License-Identifier: Apache-2.0
"""A measured curve in place of a law: the interpolation, and readings that make one."""

from dataclasses import astuple

from core.calibration_cases import LAWS, spiral
from core.recorded import recorded, said
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from spiral_core import (
    BendReading,
    ExtensionReading,
    FiberAngles,
    FreeActuation,
    MeasuredActuation,
    TwistReading,
    measured_actuation_from_readings,
)

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
    if 2.0e4 <= first <= 4.0e4:
        assert_allclose(ACTUATION.unloaded_shape(first).curvature, 8.0)


def test_readings_become_a_curve():
    readings = []
    for pressure in (6.0e4, 2.0e4, 4.0e4):
        shape = LAWFUL.unloaded_shape(pressure)
        readings.append(TwistReading(pressure, shape.torsion * 0.2, 0.2, 0.01))
        readings += [  # the mean is right
            BendReading(pressure, shape.curvature * 0.2 + off, 0.2, 0.01) for off in (-0.01, 0.01)
        ]
    curve = measured_actuation_from_readings(readings, 0.361, LAWFUL.actuator.fibers)
    assert tuple(curve.pressures) == PRESSURES
    for pressure in PRESSURES:
        expected, shape = LAWFUL.unloaded_shape(pressure), curve.unloaded_shape(pressure)
        assert_allclose(astuple(shape)[:3], astuple(expected)[:3], 1e-12)
    # Bend angles alone are a plane coil of symmetric fibers.
    assert measured_actuation_from_readings(BENDS, 0.36, SYMMETRIC).torsions == (0.0,) * 4


BENDS = [BendReading(p, p * 1e-5, 0.2, 0.01) for p in (1.0e4, 2.0e4, 3.0e4)]
SYMMETRIC = FiberAngles(1.1, -1.1)


def test_readings_that_make_no_curve_are_refused():
    """A spiral twists: bend angles alone would make a plane coil of it."""
    found = [
        said(measured_actuation_from_readings, readings, 0.36, fibers)
        for readings, fibers in (
            ([*BENDS, TwistReading(1.0e4, 0.1, 0.2, 0.01)], SYMMETRIC),
            ([ExtensionReading(1.0e4, 0.01, 0.1, 1e-4)], SYMMETRIC),
            (BENDS, LAWFUL.actuator.fibers),
        )
    ]
    recorded("calibration/curve", [*found, said(ACTUATION.unloaded_shape, 6.0001e4)])
