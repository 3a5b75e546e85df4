# SPDX-License-Identifier: Apache-2.0
"""What ends the useful range, and that nothing ends it sooner or later."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE, actuator, extending_pairs, repeatable
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from spiral_core import (
    Actuator,
    CurvatureForm,
    FiberAngles,
    FreeActuation,
    Gent,
    HyperelasticLaw,
    InvalidInputError,
    InvariantDerivatives,
    MooneyRivlin,
    NeoHookean,
    PressureLaw,
    Yeoh,
)
from spiral_core.actuator.curve import clustered_nodes
from spiral_core.actuator.fibers import fiber_derivatives, largest_volume_stretch, locking_stretch
from spiral_core.actuator.uniform_law import (
    SINGULARITY_MARGIN,
    invariants_from_derivatives,
    pressure_from_stretch,
)
from spiral_core.errors import ActuationLimit

laws = st.one_of(
    st.builds(NeoHookean, c1=st.floats(1e4, 1e6)),
    st.builds(MooneyRivlin, c1=st.floats(1e4, 1e6), c2=st.floats(-9e3, 1e6)),
    st.builds(Yeoh, c1=st.floats(1e5, 1e6), c2=st.floats(-5e4, 1e4), c3=st.floats(-1e3, 1e4)),
    st.builds(Gent, shear_modulus=st.floats(1e4, 1e6), extension_limit=st.floats(0.1, 100.0)),
)
OPPOSITE, BRITTLE = actuator(75.0, -70.0), actuator(88.0, 70.0, Gent(290.0e3, 0.5))
MILD = actuator(88.0, 70.0, Yeoh(c1=145.0e3, c2=-1.0e3, c3=3.0e3))
EXACT = actuator(90.0, 70.0, curvature_form=CurvatureForm.EXACT)
FIRST_ORDER = dataclasses.replace(EXACT, curvature_form=CurvatureForm.FIRST_ORDER)


def first_invariant(stretch: float) -> float:
    derivatives = fiber_derivatives(BRITTLE.fibers, stretch)
    return invariants_from_derivatives(stretch, derivatives).first


# The case, and the stretch that its limit keeps a margin from.
LIMITS = [
    (ActuationLimit.FIBER_LOCKING, actuator(88.0, 60.0), 2.0),
    (ActuationLimit.FIBER_LOCKING, MILD, locking_stretch(MILD.fibers)),
    (ActuationLimit.FIBER_LOCKING, FIRST_ORDER, locking_stretch(FIRST_ORDER.fibers)),
    # |omega| = 1 with r_f = r: sec^2 - lambda^2 = (tan - 1)^2, hence lambda^2 = 2 tan
    (ActuationLimit.STRAIGHT_FIBER_LOCKING, EXACT, math.sqrt(2.0 * math.tan(math.radians(70.0)))),
    (ActuationLimit.VOLUME_MAXIMUM, OPPOSITE, largest_volume_stretch(OPPOSITE.fibers)),
    (
        ActuationLimit.MATERIAL_LIMIT,
        BRITTLE,
        brentq(lambda x: 3.5 - first_invariant(x), 1.01, 2.5, xtol=1e-15, rtol=1e-15),
    ),
]


@pytest.mark.parametrize(("limit", "case", "stretch"), LIMITS)
def test_what_ends_the_range_is_approached_to_the_margin(
    limit: ActuationLimit, case: Actuator, stretch: float
) -> None:
    branch = FreeActuation(case)
    assert branch.limit is limit
    margin = SINGULARITY_MARGIN * (stretch - 1.0)
    assert branch.stretch_limit == pytest.approx(stretch - margin, rel=1e-13)


def test_larger_fiber_radius_locks_sooner() -> None:
    near, far = (
        FreeActuation(dataclasses.replace(EXACT, straight_fiber_radius=radius)).stretch_limit
        for radius in (4.0e-3, 6.0e-3)
    )
    assert far < near


def test_limit_point_before_the_elastomer_stiffens_again_is_found() -> None:
    case = actuator(88.0, 70.0, Yeoh(c1=145.0e3, c2=-400.0e3, c3=400.0e3))
    branch = FreeActuation(case)
    assert branch.limit is ActuationLimit.LIMIT_POINT
    grid = np.linspace(1.0, 2.0, 20001)
    pressures = [pressure_from_stretch(case, float(stretch)) for stretch in grid]
    first_peak = int(np.argmax(np.diff(pressures) < 0.0))
    # To the width of the grid; far above it the pressure exceeds the peak again.
    assert branch.stretch_limit == pytest.approx(grid[first_peak], abs=5e-5)
    assert pressures[-1] > 2.0 * pressures[first_peak]


@repeatable
@given(fibers=extending_pairs, law=laws, shear=st.booleans())
def test_pressure_rises_all_along_the_branch(
    fibers: FiberAngles, law: HyperelasticLaw, shear: bool
) -> None:
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

    def energy_density(self, first_invariant: float, second_invariant: float) -> float:
        return 0.0 * (first_invariant + second_invariant)

    def invariant_derivatives(self, first: float, second: float) -> InvariantDerivatives:
        return InvariantDerivatives(0.0 * first, 0.0 * second)


def test_what_does_not_extend_or_has_no_stiffness_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="extends under pressure"):
        FreeActuation(actuator(50.0, -50.0))
    with pytest.raises(InvalidInputError, match=r"material.*pressure rises"):
        FreeActuation(actuator(material=UnstableAtRest()))


@pytest.mark.parametrize("count", [2, 3, 129])
def test_nodes_begin_and_end_exactly_and_increase(count: int) -> None:
    nodes = clustered_nodes(1.7, count)
    assert (len(nodes), nodes[0], nodes[-1]) == (count, 1.0, 1.7)
    assert np.all(np.diff(nodes) > 0.0)
