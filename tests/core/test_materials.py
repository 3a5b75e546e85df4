# SPDX-License-Identifier: Apache-2.0
"""Each law: derivatives, the modulus of a tensile test, its limit; and laws that a user writes."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from core.actuator_cases import actuator, derivative, repeatable
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import (
    ActuationLimitError,
    FreeActuation,
    Gent,
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    PressureLaw,
    Yeoh,
)
from spiral_core.actuator.section import section_path
from spiral_core.errors import ActuationLimit

GENT = Gent(shear_modulus=290.0e3, extension_limit=20.0)
LAWS = [
    NeoHookean(c1=145.0e3),
    MooneyRivlin(c1=118.4e3, c2=105.7e3),
    MooneyRivlin(c1=300.0e3, c2=-50.0e3),
    Yeoh(c1=145.0e3, c2=-5.0e3, c3=1.0e3),
    GENT,
]
every_law = pytest.mark.parametrize("law", LAWS, ids=repr)
invariants = st.floats(3.0, 15.0)


@every_law
def test_no_energy_at_rest_and_the_modulus_of_a_tensile_test(law):
    assert law.energy_density(3.0, 3.0) == 0.0
    assert math.isinf(law.first_invariant_limit) or law is GENT

    @np.vectorize
    def energy(stretch):
        return law.energy_density(stretch**2 + 2.0 / stretch, 2.0 * stretch + stretch**-2)

    @np.vectorize
    def stress(stretch):
        return derivative(energy, stretch, 1e-3)

    assert law.small_strain_modulus == pytest.approx(derivative(stress, 1.0, 1e-3), rel=1e-7)


@every_law
@repeatable
@given(i1=invariants, i2=invariants)
def test_derivatives_match_differences(law, i1, i2):
    differences = (
        derivative(np.vectorize(lambda x: law.energy_density(x, i2)), i1, 1e-3),
        derivative(np.vectorize(lambda y: law.energy_density(i1, y)), i2, 1e-3),
    )
    # The difference divides rounding of an energy of about 1 MJ/m^3 by 1e-3.
    assert law.invariant_derivatives(i1, i2) == pytest.approx(differences, rel=1e-8, abs=1.45e-4)


@pytest.mark.parametrize("beyond", [23.0, math.nan])
@pytest.mark.parametrize("function", [GENT.energy_density, GENT.invariant_derivatives])
def test_gent_says_when_its_chains_run_out(function, beyond):
    with pytest.raises(ActuationLimitError, match="fully extended") as caught:
        function(beyond, 10.0)
    assert caught.value.limit is ActuationLimit.MATERIAL_LIMIT
    assert caught.value.bound == GENT.first_invariant_limit == 23.0
    function(math.nextafter(23.0, 0.0), 10.0)


@dataclass(frozen=True)
class OwnLaw:
    """Neo-Hooke's law, answered by plain tuples, and unknown past some I1."""

    first_invariant_limit: float = math.inf
    known_to: float = math.inf
    small_strain_modulus = 6.0

    def energy_density(self, first, _):
        return first - 3.0 if first < self.known_to else math.nan

    def invariant_derivatives(self, first, _):
        return (1.0 if first < self.known_to else math.nan), 0.0


@pytest.mark.parametrize("law", PressureLaw)
@pytest.mark.parametrize("end", [3.2, 5.0])
def test_a_law_that_is_not_finite_is_refused(law, end):
    with pytest.raises(InvalidInputError, match="finite as far as the fibers go"):
        FreeActuation(actuator(material=OwnLaw(known_to=end), pressure_law=law))


@pytest.mark.parametrize("limit", [3.0, math.nan])
def test_a_limit_at_rest_is_refused(limit):
    with pytest.raises(InvalidInputError, match="first_invariant_limit"):
        actuator(material=OwnLaw(first_invariant_limit=limit))


def test_a_pole_just_beyond_the_range_is_no_limit_point():
    case = actuator(pressure_law=PressureLaw.SECTION)
    farthest = float(section_path(case.fiber_set).motion.first.max())
    material = Gent(shear_modulus=290.0e3, extension_limit=1.001 * farthest)
    found = FreeActuation(actuator(material=material, pressure_law=PressureLaw.SECTION))
    assert found.limit is ActuationLimit.VOLUME_MAXIMUM
