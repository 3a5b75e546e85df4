# SPDX-License-Identifier: Apache-2.0
"""The uniform law against a membrane, its tabulated curve against the law, and what ends it."""

from __future__ import annotations

from dataclasses import astuple, replace
from math import atan, cos, inf, nextafter, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE, actuator, degrees, extending_pairs, repeatable
from core.reference_uniform import reference_pressure
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from spiral_core import (
    ActuationLimitError,
    CurvatureForm,
    FreeActuation,
    Gent,
    MooneyRivlin,
    NeoHookean,
    Yeoh,
)
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.fibers import locking_stretch
from spiral_core.actuator.section import END_MARGIN
from spiral_core.errors import ActuationLimit

EXACT = CurvatureForm.EXACT
OPPOSITE = actuator(75.0, -70.0)  # ends with the volume
STRAIGHT = actuator(90.0, 70.0, curvature_form=EXACT)  # locks
# Softens, and stiffens again.
LIMIT_POINT = actuator(88.0, 70.0, Yeoh(145.0e3, -400.0e3, 400.0e3))
FORM = actuator(curvature_form=EXACT)
FAR_OUT = actuator(85.0, 84.0)
HARD = [
    *(OPPOSITE, STRAIGHT, LIMIT_POINT, FORM, FAR_OUT),
    actuator(88.0, 50.0, twist_shear=False),
    actuator(60.0, 60.01),  # both lock nearly together
    actuator(54.8, -54.8),  # the largest volume next to rest
    actuator(88.0, 70.0, Gent(290.0e3, 0.01)),  # a very short branch
    actuator(88.0, 60.0, Gent(290.0e3, 2.9)),  # the elastomer's limit just beyond
    actuator(2.0, 1.0),
    *(actuator(material=law) for law in (NeoHookean(1e-6), MooneyRivlin(1e14, 1e14))),
    actuator(56.0, -85.75, curvature_form=EXACT),  # the straight fiber locks just beyond
    actuator(straight_fiber_radius=9.0e-3, curvature_form=EXACT),
]
# The case, and the stretch that its limit keeps a margin from.
LIMITS = [
    (ActuationLimit.FIBER_LOCKING, actuator(90.0, 70.0), 1.0 / cos(radians(70.0))),
    # |omega| = 1 with r_f = r: sec^2 - lambda^2 = (tan - 1)^2, hence lambda^2 = 2 tan
    (ActuationLimit.STRAIGHT_FIBER_LOCKING, STRAIGHT, sqrt(2 * tan(radians(70.0)))),
    # the fibers at the magic angle
    (
        ActuationLimit.VOLUME_MAXIMUM,
        actuator(60.0, -60.0),
        cos(atan(sqrt(2.0))) / cos(radians(60.0)),
    ),
    # I1 = lambda^2 + lambda^-2 + 1 = 3.5
    (
        ActuationLimit.MATERIAL_LIMIT,
        actuator(90.0, 70.0, Gent(290.0e3, 0.5), twist_shear=False),
        sqrt(2.0),
    ),
    (ActuationLimit.LIMIT_POINT, LIMIT_POINT, None),
]
EPSILON = 2.0**-52
# From rest, over the branch, to its end.
FRACTIONS = (1e-9, 1e-4, *np.linspace(0.01, 0.99, 8), 1 - 1e-4, 1 - 1e-9, 1.0)


def law_at(case, stretch):
    """Return pressure, curvature, torsion, length and stretch, without the tabulated curve."""
    shape = unloaded_shape_from_stretch(case, stretch)
    return np.array((reference_pressure(case, stretch), *astuple(shape)))


def check(case, fraction):
    """Compare pressure, inverse and shape at a fraction of the branch's elongation."""
    actuation = FreeActuation(case)
    # Families that nearly coincide magnify rounding.
    crossing = abs(sin(case.fiber_pair.alpha - case.fiber_pair.beta))
    end, bits = actuation.stretch_limit, 8.0 * EPSILON / crossing
    stretch = min(1.0 + fraction * (end - 1.0), end)
    # What a few last bits of the stretch mean.
    below, expected, above = (
        law_at(case, max(stretch * part, 1.0)) for part in (1.0 - bits, 1.0, 1.0 + bits)
    )
    allowed = np.maximum(abs(below - expected), abs(above - expected))
    # Next to the pole of an elastomer, and of a pair that locks, panels are right to ten digits.
    allowed = np.maximum(allowed, max(1e-10, 2e-15 / crossing) * abs(expected))
    allowed[1:3] += 4.0 * EPSILON / case.fiber_radius
    # A straight fiber that would lock just beyond the end bends the curvature like a root.
    allowed[1] = max(allowed[1], 1e-7 * expected[1])
    allowed[3:] = 4.0 * EPSILON * expected[3:]
    pressure = actuation.pressure_from_stretch(stretch)
    found = pressure, *astuple(actuation.unloaded_shape_from_stretch(stretch))
    assert (abs(found - expected) <= allowed).all()
    again = reference_pressure(case, actuation.stretch_from_pressure(pressure))
    assert abs(again - pressure) <= allowed[0]


def test_the_curve_is_the_law_to_ten_digits():
    for case in HARD:
        for fraction in FRACTIONS:
            check(case, float(fraction))


def test_near_rest_the_shape_is_right_to_its_own_rounding():
    """A tenth of the pressure is a tenth of curvature and torsion, but for its square."""
    for case in (FORM, FAR_OUT):
        actuation = FreeActuation(case)
        pressures = actuation.pressure_limit * np.logspace(-9, -15, 7)
        turns = np.array([astuple(actuation.unloaded_shape(one))[:2] for one in pressures])
        assert_allclose(turns[1:], 0.1 * turns[:-1], 1e-7)


def test_limit_is_reached_to_its_margin_and_not_passed():
    for limit, case, stretch in LIMITS:
        actuation = FreeActuation(case)
        end, top = actuation.stretch_limit, actuation.pressure_limit
        assert actuation.limit is limit
        if stretch is not None:
            assert_allclose((stretch - end) / (stretch - 1.0), END_MARGIN, 1e-7)
        assert actuation.unloaded_shape(top).stretch == end == actuation.stretch_from_pressure(top)
        assert actuation.pressure_from_stretch(end) == top
        for ask, quantity, bound in (
            (actuation.unloaded_shape, "pressure", top),
            (actuation.pressure_from_stretch, "stretch", end),
        ):
            past = nextafter(bound, inf)
            with pytest.raises(ActuationLimitError) as caught:
                ask(past)
            assert caught.value.args == (limit, quantity, past, bound)
        assert actuation.unloaded_shape(0.0) == UnloadedShape(0.0, 0.0, PAPER_TUBE.length, 1.0)


def test_without_twist_shear_it_is_a_membrane_in_pure_shear():
    # Hoop fibers alone: pressure on the end cap balances the axial stress of Mooney's strip
    # held at its width, 2 (C1 + C2) (lambda - lambda^-3) per unstretched area.
    case = actuator(90.0, 60.0, MooneyRivlin(118.4e3, 105.7e3), twist_shear=False)
    for stretch in (1.01, 1.3):
        force = 2.0 * 224.1e3 * (stretch - stretch**-3) * PAPER_TUBE.wall_area
        cap = pi * PAPER_TUBE.inner_radius**2
        assert_allclose(FreeActuation(case).pressure_from_stretch(stretch), force / cap, 1e-12)


def test_twist_shear_stiffens_as_documented():
    for beta, percent in [(50.0, 27), (60.0, 13), (70.0, 5)]:
        with_shear, without = (
            FreeActuation(actuator(88.0, beta, twist_shear=flag)).pressure_from_stretch(1.1)
            for flag in (True, False)
        )
        assert round(100.0 * (with_shear / without - 1.0)) == percent


def test_limit_point_next_to_rest_is_found():
    """At a five-hundredth of the size at which fibers that are almost parallel lock."""
    law = Yeoh(100e3, -19389.0, 3885.0)
    case = replace(actuator(material=law, twist_shear=False), fibers=degrees(5.0, 5.01))
    found = FreeActuation(replace(case, curvature_form=CurvatureForm.FIRST_ORDER))
    assert found.limit is ActuationLimit.LIMIT_POINT
    sizes = np.linspace(0.0, found.size_limit, 1000)
    slopes = [found.pressure.with_slope(size)[1] for size in sizes.tolist()]
    assert min(slopes) > -1e-9 * slopes[0]
    assert found.pressure.with_slope(1.01 * found.size_limit)[1] < 0.0


def test_limit_point_before_the_elastomer_stiffens_again_is_found():
    found, grid = FreeActuation(LIMIT_POINT), np.linspace(1.0, 2.0, 20001)
    sizes = map(found.path.strain_from_stretch, grid.tolist())
    pressures = [found.pressure.with_slope(size)[0] for size in sizes]
    first_peak = int(np.argmax(np.diff(pressures) < 0.0))
    # To the width of the grid; far above it the pressure exceeds the peak again.
    assert_allclose(found.stretch_limit, grid[first_peak], 0, 5e-5)
    assert pressures[-1] > 2.0 * pressures[first_peak]


stiffnesses = st.floats(1e4, 1e6)
laws = st.one_of(
    st.builds(MooneyRivlin, stiffnesses, st.floats(-9e3, 1e6)),
    st.builds(Yeoh, st.floats(1e5, 1e6), st.floats(-5e4, 1e4), st.floats(-1e3, 1e4)),
    st.builds(Gent, stiffnesses, st.floats(0.1, 100.0)),
)


@repeatable
@given(
    fibers=extending_pairs,
    law=laws,
    fraction=st.one_of(st.floats(0.0, 1.0), st.sampled_from([1e-12, 1e-6, 1 - 1e-12, 1 - 1e-6])),
    form=st.sampled_from(CurvatureForm),
    shear=st.booleans(),
)
def test_random_curves_are_the_law_and_their_pressure_rises(fibers, law, fraction, form, shear):
    case = replace(actuator(material=law, curvature_form=form), fibers=fibers)
    check(case, fraction)
    case = replace(case, twist_shear=shear)
    branch = FreeActuation(case)
    assert 1.0 < branch.stretch_limit < locking_stretch(fibers)
    end = branch.stretch_limit
    nodes = end - (end - 1.0) * np.linspace(1.0, 0.0, 777) ** 2  # denser towards the end
    nodes[0] = 1.0
    rises = np.diff([branch.pressure_from_stretch(stretch) for stretch in nodes.tolist()])
    # At a limit point the last ones are equal but for rounding.
    assert rises.min() > -1e-12 * branch.pressure_limit / abs(sin(fibers.alpha - fibers.beta))
    assert rises[:-20].min() > 0.0
