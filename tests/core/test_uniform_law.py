# SPDX-License-Identifier: Apache-2.0
"""The uniform law against a membrane, its tabulated curve against the law, and what ends it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from core.actuator_cases import (
    PAPER_TUBE,
    actuator,
    extending_pairs,
    repeatable,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from spiral_core import (
    ActuationLimitError,
    Actuator,
    CurvatureForm,
    FreeActuation,
    Gent,
    InvalidInputError,
    InvariantDerivatives,
    MooneyRivlin,
    NeoHookean,
    PressureLaw,
    Yeoh,
)
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.curve import clustered_nodes
from spiral_core.actuator.fibers import (
    fiber_derivatives,
    fiber_state,
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
GENT = Gent(shear_modulus=290.0e3, extension_limit=0.5)
SOFTENING = Yeoh(c1=145.0e3, c2=-30.0e3, c3=3.0e3)
HARD = {
    "fiber locking": actuator(88.0, 60.0),
    "a hoop, whose pressure diverges": actuator(90.0, 60.0),
    "no twist shear": actuator(88.0, 50.0, twist_shear=False),
    "locks far out": actuator(85.0, 84.0),
    "both lock nearly together": actuator(60.0, 60.01),
    "volume maximum": actuator(75.0, -70.0),
    "volume maximum next to rest": actuator(54.8, -54.8),
    "elastomer's limit": actuator(88.0, 70.0, GENT),
    "elastomer's limit, very short": actuator(88.0, 70.0, Gent(290.0e3, 0.01)),
    "elastomer's limit just beyond": actuator(88.0, 60.0, Gent(290.0e3, 2.9)),
    "limit point": actuator(88.0, 70.0, SOFTENING),
    "tiny angle": actuator(88.0, 1.0),
    "tiny angles": actuator(2.0, 1.0),
    "tiny modulus": actuator(material=NeoHookean(1e-6)),
    "huge modulus": actuator(material=MooneyRivlin(1e14, 1e14)),
    "exact form": actuator(curvature_form=EXACT),
    "straight fiber locks": actuator(90.0, 70.0, curvature_form=EXACT),
    "straight fiber locks just beyond": actuator(56.0, -85.75, curvature_form=EXACT),
    "straight fiber far out": actuator(straight_fiber_radius=9.0e-3, curvature_form=EXACT),
}
OPPOSITE, BRITTLE = HARD["volume maximum"], HARD["elastomer's limit"]
STRAIGHT = HARD["straight fiber locks"]
FIRST_ORDER = replace(STRAIGHT, curvature_form=CurvatureForm.FIRST_ORDER)


def first_invariant(stretch):
    derivatives = fiber_derivatives(BRITTLE.fibers, stretch)
    return invariants_from_derivatives(stretch, derivatives).first


# The case, and the stretch that its limit keeps a margin from.
LIMITS = [
    (ActuationLimit.FIBER_LOCKING, HARD["fiber locking"], 2.0),
    (ActuationLimit.FIBER_LOCKING, FIRST_ORDER, locking_stretch(FIRST_ORDER.fibers)),
    # |omega| = 1 with r_f = r: sec^2 - lambda^2 = (tan - 1)^2, hence lambda^2 = 2 tan
    (ActuationLimit.STRAIGHT_FIBER_LOCKING, STRAIGHT, math.sqrt(2 * math.tan(math.radians(70.0)))),
    (ActuationLimit.VOLUME_MAXIMUM, OPPOSITE, largest_volume_stretch(OPPOSITE.fibers)),
    (
        ActuationLimit.MATERIAL_LIMIT,
        BRITTLE,
        brentq(lambda x: 3.5 - first_invariant(x), 1.01, 2.5, xtol=1e-15, rtol=1e-15),
    ),
    (ActuationLimit.LIMIT_POINT, HARD["limit point"], None),
]
EPSILON = 2.0**-52
# From rest, over the branch, to its end.
FRACTIONS = (1e-9, 1e-4, *np.linspace(0.01, 0.99, 8), 1 - 1e-4, 1 - 1e-9, 1.0)


def check(case, fraction):
    """Compare pressure, inverse and shape at a fraction of the branch's elongation."""
    pair = case.fiber_pair
    # Families that nearly coincide magnify rounding.
    crossing = abs(math.sin(pair.alpha - pair.beta))
    tolerance, bits = max(1e-12, 2e-15 / crossing), 8.0 * EPSILON / crossing
    actuation = FreeActuation(case)
    end = actuation.stretch_limit
    stretch = min(1.0 + fraction * (end - 1.0), end)
    # What a few last bits of the stretch mean.
    nearby = [max(stretch * part, 1.0) for part in (1.0 - bits, 1.0, 1.0 + bits)]
    below, expected, above = (pressure_from_stretch(case, one) for one in nearby)
    near = partial(
        pytest.approx, rel=tolerance, abs=max(abs(below - expected), abs(above - expected))
    )
    found = actuation.pressure_from_stretch(stretch)
    assert found == near(expected)
    assert pressure_from_stretch(case, actuation.stretch_from_pressure(found)) == near(found)
    shape = actuation.unloaded_shape_from_stretch(stretch)
    direct = unloaded_shape_from_stretch(case, stretch)
    twists = [fiber_state(pair, one).twist for one in nearby]
    spread = (max(twists) - min(twists)) / case.wound_radius
    rounding = 4.0 * EPSILON / case.fiber_radius + abs(twists[1]) * spread
    lengths = direct.stretch, direct.backbone_length
    assert (shape.stretch, shape.backbone_length) == pytest.approx(lengths, rel=4.0 * EPSILON)
    assert shape.curvature == pytest.approx(direct.curvature, rel=tolerance, abs=rounding)
    assert shape.torsion == pytest.approx(direct.torsion, rel=tolerance, abs=spread)


@pytest.mark.parametrize("name", HARD)
def test_the_curve_is_the_law_to_twelve_digits(name):
    for fraction in FRACTIONS:
        check(HARD[name], float(fraction))


@repeatable
@given(
    fibers=extending_pairs,
    law=st.sampled_from([MooneyRivlin(c1=130.0e3, c2=15.0e3), SOFTENING, GENT]),
    fraction=st.one_of(st.floats(0.0, 1.0), st.sampled_from([1e-12, 1e-6, 1 - 1e-12, 1 - 1e-6])),
    form=st.sampled_from(CurvatureForm),
)
def test_random_curves_are_the_law(fibers, law, fraction, form):
    case = actuator(material=law, curvature_form=form)
    check(replace(case, fibers=fibers), fraction)


@pytest.mark.parametrize("name", ["exact form", "locks far out"])
def test_near_rest_the_shape_is_right_to_its_own_rounding(name):
    actuation = FreeActuation(HARD[name])
    pressures = actuation.pressure_limit * np.logspace(-9, -15, 7)
    near = [actuation.unloaded_shape(pressure) for pressure in pressures.tolist()]
    for ten, one in pairwise(near):
        # A tenth of the pressure is a tenth of the curvature, but for its square.
        tenth = 0.1 * ten.curvature, 0.1 * ten.torsion
        assert (one.curvature, one.torsion) == pytest.approx(tenth, rel=1e-7)


@pytest.mark.parametrize(("limit", "case", "stretch"), LIMITS)
def test_limit_is_reached_to_its_margin_and_not_passed(limit, case, stretch):
    actuation = FreeActuation(case)
    end, top = actuation.stretch_limit, actuation.pressure_limit
    assert actuation.limit is limit
    if stretch is not None:
        margin = SINGULARITY_MARGIN * (stretch - 1.0)
        assert end == pytest.approx(stretch - margin, rel=1e-13)
        ask = unloaded_shape_from_stretch if "FIBER" in limit.name else pressure_from_stretch
        ask(case, stretch * (1.0 - 1e-9))
        with pytest.raises(ActuationLimitError) as caught:
            ask(case, stretch * (1.0 + 1e-9))
        bound = {"STRAIGHT_FIBER_LOCKING": 1.0, "MATERIAL_LIMIT": 3.5}.get(limit.name, stretch)
        assert (caught.value.limit, caught.value.bound) == (limit, pytest.approx(bound))
    assert actuation.stretch_from_pressure(top) == end
    assert actuation.pressure_from_stretch(end) == top
    assert actuation.unloaded_shape(top).stretch == end
    for ask, quantity, bound in (
        (actuation.unloaded_shape, "pressure", top),
        (actuation.pressure_from_stretch, "stretch", end),
    ):
        past = math.nextafter(bound, math.inf)
        with pytest.raises(ActuationLimitError) as caught:
            ask(past)
        error = caught.value
        assert (error.limit, error.quantity) == (limit, quantity)
        assert (error.value, error.bound) == (past, bound)
    assert actuation.unloaded_shape(0.0) == UnloadedShape(0.0, 0.0, PAPER_TUBE.length, 1.0)


@pytest.mark.parametrize("stretch", [1.01, 1.3])
@pytest.mark.parametrize(("c1", "c2"), [(145.0e3, 0.0), (118.4e3, 105.7e3)])
def test_without_twist_shear_it_is_a_membrane_in_pure_shear(stretch, c1, c2):
    # Hoop fibers alone: pressure on the end cap balances the axial stress of Mooney's strip held
    # at its width, 2 (C1 + C2) (lambda - lambda^-3) per unstretched area.
    case = actuator(90.0, 60.0, MooneyRivlin(c1, c2), twist_shear=False)
    force = 2.0 * (c1 + c2) * (stretch - stretch**-3) * PAPER_TUBE.wall_area
    cap = math.pi * PAPER_TUBE.inner_radius**2
    assert pressure_from_stretch(case, stretch) == pytest.approx(force / cap, rel=1e-12)


@pytest.mark.parametrize(("beta", "percent"), [(50.0, 27), (60.0, 13), (70.0, 5)])
def test_twist_shear_stiffens_as_documented(beta, percent):
    with_shear, without = (
        pressure_from_stretch(actuator(88.0, beta, twist_shear=flag), 1.1) for flag in (True, False)
    )
    assert round(100.0 * (with_shear / without - 1.0)) == percent


def test_limit_point_before_the_elastomer_stiffens_again_is_found():
    case = actuator(88.0, 70.0, Yeoh(c1=145.0e3, c2=-400.0e3, c3=400.0e3))
    branch = FreeActuation(case)
    assert branch.limit is ActuationLimit.LIMIT_POINT
    grid = np.linspace(1.0, 2.0, 20001)
    pressures = [pressure_from_stretch(case, float(stretch)) for stretch in grid]
    first_peak = int(np.argmax(np.diff(pressures) < 0.0))
    # To the width of the grid; far above it the pressure exceeds the peak again.
    assert branch.stretch_limit == pytest.approx(grid[first_peak], abs=5e-5)
    assert pressures[-1] > 2.0 * pressures[first_peak]


laws = st.one_of(
    st.builds(NeoHookean, c1=st.floats(1e4, 1e6)),
    st.builds(MooneyRivlin, c1=st.floats(1e4, 1e6), c2=st.floats(-9e3, 1e6)),
    st.builds(Yeoh, c1=st.floats(1e5, 1e6), c2=st.floats(-5e4, 1e4), c3=st.floats(-1e3, 1e4)),
    st.builds(Gent, shear_modulus=st.floats(1e4, 1e6), extension_limit=st.floats(0.1, 100.0)),
)


@repeatable
@given(fibers=extending_pairs, law=laws, shear=st.booleans())
def test_pressure_rises_all_along_the_branch(fibers, law, shear):
    case = Actuator(PAPER_TUBE, fibers, law, twist_shear=shear, pressure_law=PressureLaw.UNIFORM)
    branch = FreeActuation(case)
    assert 1.0 < branch.stretch_limit < locking_stretch(fibers)
    nodes = clustered_nodes(branch.stretch_limit, 777)
    pressures = [pressure_from_stretch(case, stretch) for stretch in nodes]
    # At a limit point the last ones are equal but for rounding.
    least = -1e-12 * branch.pressure_limit / abs(math.sin(fibers.alpha - fibers.beta))
    assert np.diff(pressures).min() > least
    assert np.diff(pressures[:-20]).min() > 0.0


class UnstableAtRest:
    """A law with no stiffness: what a fit without data might produce."""

    small_strain_modulus = 0.0
    first_invariant_limit = math.inf

    def energy_density(self, first, second):
        return 0.0 * (first + second)

    def invariant_derivatives(self, first, second):
        return InvariantDerivatives(0.0 * first, 0.0 * second)


def test_what_does_not_extend_or_has_no_stiffness_is_refused():
    with pytest.raises(InvalidInputError, match="extends under pressure"):
        FreeActuation(actuator(50.0, -50.0))
    with pytest.raises(InvalidInputError, match=r"material.*pressure rises"):
        FreeActuation(actuator(material=UnstableAtRest()))
