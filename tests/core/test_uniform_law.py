# SPDX-License-Identifier: Apache-2.0
"""The uniform law against a membrane, its tabulated curve against the law, and what ends it."""

from __future__ import annotations

from dataclasses import astuple, replace
from functools import partial
from math import inf, nextafter, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE, actuator, extending_pairs, repeatable
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import brentq

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
from spiral_core.actuator.curve import clustered_nodes
from spiral_core.actuator.fibers import (
    fiber_derivatives,
    largest_volume_stretch,
    locking_stretch,
)
from spiral_core.actuator.uniform_law import (
    SINGULARITY_MARGIN,
    invariants_from_derivatives,
    pressure_from_stretch,
)
from spiral_core.errors import ActuationLimit

EXACT = CurvatureForm.EXACT
GENT = Gent(290.0e3, 0.5)
SOFTENING = Yeoh(145.0e3, -30.0e3, 3.0e3)
OPPOSITE = actuator(75.0, -70.0)  # ends with the volume
BRITTLE = actuator(88.0, 70.0, GENT)
STRAIGHT = actuator(90.0, 70.0, curvature_form=EXACT)  # locks
LIMIT_POINT, FORM = actuator(88.0, 70.0, SOFTENING), actuator(curvature_form=EXACT)
FAR_OUT = actuator(85.0, 84.0)
HARD = [
    *(OPPOSITE, BRITTLE, STRAIGHT, LIMIT_POINT, FORM, FAR_OUT),
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
FIRST_ORDER = replace(STRAIGHT, curvature_form=CurvatureForm.FIRST_ORDER)


def first_invariant(stretch):
    derivatives = fiber_derivatives(BRITTLE.fibers, stretch)
    return invariants_from_derivatives(stretch, derivatives).first


# The case, and the stretch that its limit keeps a margin from.
LIMITS = [
    (ActuationLimit.FIBER_LOCKING, actuator(88.0, 60.0), 2.0),
    (ActuationLimit.FIBER_LOCKING, FIRST_ORDER, locking_stretch(FIRST_ORDER.fibers)),
    # |omega| = 1 with r_f = r: sec^2 - lambda^2 = (tan - 1)^2, hence lambda^2 = 2 tan
    (ActuationLimit.STRAIGHT_FIBER_LOCKING, STRAIGHT, sqrt(2 * tan(radians(70.0)))),
    (ActuationLimit.VOLUME_MAXIMUM, OPPOSITE, largest_volume_stretch(OPPOSITE.fibers)),
    (
        ActuationLimit.MATERIAL_LIMIT,
        BRITTLE,
        brentq(lambda x: 3.5 - first_invariant(x), 1.01, 2.5, xtol=1e-15, rtol=1e-15),
    ),
    (ActuationLimit.LIMIT_POINT, LIMIT_POINT, None),
]
EPSILON = 2.0**-52
# From rest, over the branch, to its end.
FRACTIONS = (1e-9, 1e-4, *np.linspace(0.01, 0.99, 8), 1 - 1e-4, 1 - 1e-9, 1.0)


def check(case, fraction):
    """Compare pressure, inverse and shape at a fraction of the branch's elongation."""
    actuation = FreeActuation(case)
    # Families that nearly coincide magnify rounding.
    crossing = abs(sin(case.fiber_pair.alpha - case.fiber_pair.beta))
    tolerance, bits = max(1e-12, 2e-15 / crossing), 8.0 * EPSILON / crossing
    end = actuation.stretch_limit
    stretch = min(1.0 + fraction * (end - 1.0), end)
    # What a few last bits of the stretch mean.
    nearby = [max(stretch * part, 1.0) for part in (1.0 - bits, 1.0, 1.0 + bits)]
    below, expected, above = (pressure_from_stretch(case, one) for one in nearby)
    near = partial(
        pytest.approx, rel=tolerance, abs=np.abs((below, above) - np.array(expected)).max()
    )
    found = actuation.pressure_from_stretch(stretch)
    assert found == near(expected)
    assert pressure_from_stretch(case, actuation.stretch_from_pressure(found)) == near(found)
    shape = np.array(astuple(actuation.unloaded_shape_from_stretch(stretch)))
    shapes = np.array([astuple(unloaded_shape_from_stretch(case, one)) for one in nearby])
    rounding = np.ptp(shapes, axis=0) + 4.0 * EPSILON / case.fiber_radius
    rounding[2:] = 0.0  # lengths have none
    error = np.array((tolerance, tolerance, 4.0 * EPSILON, 4.0 * EPSILON)) * abs(shapes[1])
    assert (abs(shape - shapes[1]) <= error + rounding).all()


def test_the_curve_is_the_law_to_twelve_digits():
    for case in HARD:
        for fraction in FRACTIONS:
            check(case, float(fraction))


def test_near_rest_the_shape_is_right_to_its_own_rounding():
    """A tenth of the pressure is a tenth of curvature and torsion, but for its square."""
    for case in (FORM, FAR_OUT):
        actuation = FreeActuation(case)
        for pressure in actuation.pressure_limit * np.logspace(-9, -14, 6):
            ten, one = (actuation.unloaded_shape(p) for p in (pressure, 0.1 * pressure))
            tenth = 0.1 * ten.curvature, 0.1 * ten.torsion
            assert_allclose((one.curvature, one.torsion), tenth, 1e-7)


def test_limit_is_reached_to_its_margin_and_not_passed():
    for limit, case, stretch in LIMITS:
        actuation = FreeActuation(case)
        end, top = actuation.stretch_limit, actuation.pressure_limit
        assert actuation.limit is limit
        if stretch is not None:
            margin = SINGULARITY_MARGIN * (stretch - 1.0)
            assert_allclose(end, stretch - margin, 1e-13)
            ask = unloaded_shape_from_stretch if "FIBER" in limit.name else pressure_from_stretch
            ask(case, stretch * (1.0 - 1e-9))
            with pytest.raises(ActuationLimitError) as caught:
                ask(case, stretch * (1.0 + 1e-9))
            bound = {"STRAIGHT_FIBER_LOCKING": 1.0, "MATERIAL_LIMIT": 3.5}.get(limit.name, stretch)
            assert (caught.value.limit, caught.value.bound) == (limit, pytest.approx(bound))
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
    for stretch, c1, c2 in [(1.01, 145.0e3, 0.0), (1.3, 118.4e3, 105.7e3)]:
        # Hoop fibers alone: pressure on the end cap balances the axial stress of Mooney's strip
        # held at its width, 2 (C1 + C2) (lambda - lambda^-3) per unstretched area.
        case = actuator(90.0, 60.0, MooneyRivlin(c1, c2), twist_shear=False)
        force = 2.0 * (c1 + c2) * (stretch - stretch**-3) * PAPER_TUBE.wall_area
        cap = pi * PAPER_TUBE.inner_radius**2
        assert_allclose(pressure_from_stretch(case, stretch), force / cap, 1e-12)


def test_twist_shear_stiffens_as_documented():
    for beta, percent in [(50.0, 27), (60.0, 13), (70.0, 5)]:
        with_shear, without = (
            pressure_from_stretch(actuator(88.0, beta, twist_shear=flag), 1.1)
            for flag in (True, False)
        )
        assert round(100.0 * (with_shear / without - 1.0)) == percent


def test_limit_point_before_the_elastomer_stiffens_again_is_found():
    case = actuator(88.0, 70.0, Yeoh(145.0e3, -400.0e3, 400.0e3))
    grid = np.linspace(1.0, 2.0, 20001)
    pressures = [pressure_from_stretch(case, stretch) for stretch in grid.tolist()]
    first_peak = int(np.argmax(np.diff(pressures) < 0.0))
    # To the width of the grid; far above it the pressure exceeds the peak again.
    assert_allclose(FreeActuation(case).stretch_limit, grid[first_peak], 0, 5e-5)
    assert pressures[-1] > 2.0 * pressures[first_peak]


laws = st.one_of(
    st.builds(NeoHookean, st.floats(1e4, 1e6)),
    st.builds(MooneyRivlin, st.floats(1e4, 1e6), st.floats(-9e3, 1e6)),
    st.builds(Yeoh, st.floats(1e5, 1e6), st.floats(-5e4, 1e4), st.floats(-1e3, 1e4)),
    st.builds(Gent, st.floats(1e4, 1e6), st.floats(0.1, 100.0)),
)


@repeatable
@given(
    fibers=extending_pairs,
    law=st.sampled_from([MooneyRivlin(130.0e3, 15.0e3), SOFTENING, GENT]),
    fraction=st.one_of(st.floats(0.0, 1.0), st.sampled_from([1e-12, 1e-6, 1 - 1e-12, 1 - 1e-6])),
    form=st.sampled_from(CurvatureForm),
)
def test_random_curves_are_the_law(fibers, law, fraction, form):
    check(replace(actuator(material=law, curvature_form=form), fibers=fibers), fraction)


@repeatable
@given(fibers=extending_pairs, law=laws, shear=st.booleans())
def test_pressure_rises_all_along_the_branch(fibers, law, shear):
    case = replace(actuator(material=law, twist_shear=shear), fibers=fibers)
    branch = FreeActuation(case)
    assert 1.0 < branch.stretch_limit < locking_stretch(fibers)
    nodes = clustered_nodes(branch.stretch_limit, 777)
    pressures = [pressure_from_stretch(case, stretch) for stretch in nodes]
    # At a limit point the last ones are equal but for rounding.
    least = -1e-12 * branch.pressure_limit / abs(sin(fibers.alpha - fibers.beta))
    assert np.diff(pressures).min() > least
    assert np.diff(pressures[:-20]).min() > 0.0
