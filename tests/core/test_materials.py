# SPDX-License-Identifier: Apache-2.0
"""Each law: derivatives, the modulus of a tensile test, its limit; and laws that a user writes."""

from dataclasses import dataclass
from math import inf, isinf, nan, nextafter

import numpy as np
import pytest
from core import section_cases
from core.actuator_cases import actuator, derivative, repeatable
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from spiral_core import (
    ActuationLimitError,
    FreeActuation,
    Gent,
    InvalidInputError,
    MooneyRivlin,
    PressureLaw,
)
from spiral_core.actuator.section import section_path
from spiral_core.errors import ActuationLimit

LAWS = [*section_cases.LAWS, MooneyRivlin(300.0e3, -50.0e3)]
GENT = LAWS[3]
every_law = pytest.mark.parametrize("law", LAWS)
invariants = st.floats(3.0, 15.0)


@every_law
def test_no_energy_at_rest_and_the_modulus_of_a_tensile_test(law):
    assert law.energy_density(3.0, 3.0) == 0.0
    assert isinf(law.first_invariant_limit) or law is GENT

    @np.vectorize
    def energy(stretch):
        return law.energy_density(stretch**2 + 2.0 / stretch, 2.0 * stretch + stretch**-2)

    stress = np.vectorize(lambda stretch: derivative(energy, stretch, 1e-3))
    assert_allclose(law.small_strain_modulus, derivative(stress, 1.0, 1e-3), 1e-7)


@every_law
@repeatable
@given(i1=invariants, i2=invariants)
def test_derivatives_match_differences(law, i1, i2):
    energy = np.vectorize(law.energy_density)
    differences = (
        derivative(lambda x: energy(x, i2), i1, 1e-3),
        derivative(lambda y: energy(i1, y), i2, 1e-3),
    )
    # The difference divides rounding of an energy of about 1 MJ/m^3 by 1e-3.
    assert_allclose(law.invariant_derivatives(i1, i2), differences, 1e-8, 1.45e-4)


def test_gent_says_when_its_chains_run_out():
    for function in [GENT.energy_density, GENT.invariant_derivatives]:
        function(nextafter(33.0, 0.0), 10.0)
        for beyond in [33.0, nan]:
            with pytest.raises(ActuationLimitError, match="fully extended") as caught:
                function(beyond, 10.0)
            found = caught.value.limit, caught.value.bound
            assert found == (ActuationLimit.MATERIAL_LIMIT, GENT.first_invariant_limit)


@dataclass(frozen=True)
class OwnLaw:
    """Neo-Hooke's law, answered by plain tuples, and unknown past some I1."""

    first_invariant_limit: float = inf
    known_to: float = inf
    small_strain_modulus: float = 6.0

    def energy_density(self, first, _):
        return first - 3.0 if first < self.known_to else nan

    def invariant_derivatives(self, first, _):
        return self.small_strain_modulus / 6.0 if first < self.known_to else nan, 0.0


@pytest.mark.parametrize("law", PressureLaw)
def test_a_law_that_nothing_can_be_solved_with_is_refused(law):
    for own, said in [
        (OwnLaw(known_to=3.2), "finite as far as the fibers go"),
        (OwnLaw(known_to=5.0), "finite as far as the fibers go"),
        (OwnLaw(3.0), "first_invariant_limit"),
        (OwnLaw(nan), "first_invariant_limit"),
        # What a fit without data might produce.
        (OwnLaw(small_strain_modulus=0.0), "material.*pressure rises"),
    ]:
        with pytest.raises(InvalidInputError, match=said):
            FreeActuation(actuator(material=own, pressure_law=law))


def test_a_pole_just_beyond_the_range_is_no_limit_point():
    farthest = section_path(section_cases.section(88.0, 60.0).fiber_set).motion.first.max()
    pole = FreeActuation(section_cases.section(88.0, 60.0, Gent(290.0e3, 1.001 * float(farthest))))
    assert pole.limit is ActuationLimit.VOLUME_MAXIMUM
