# SPDX-License-Identifier: Apache-2.0
"""Each law: zero at rest, analytic derivatives, moduli from simple tests, and its limits."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from core.actuator_cases import repeatable
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import ActuationLimitError, Gent, HyperelasticLaw, MooneyRivlin, NeoHookean, Yeoh
from spiral_core.errors import ActuationLimit

LAWS: list[HyperelasticLaw] = [
    NeoHookean(c1=145.0e3),
    MooneyRivlin(c1=118.4e3, c2=105.7e3),
    MooneyRivlin(c1=300.0e3, c2=-50.0e3),
    Yeoh(c1=145.0e3, c2=-5.0e3, c3=1.0e3),
    Gent(shear_modulus=290.0e3, extension_limit=20.0),
]
every_law = pytest.mark.parametrize("law", LAWS, ids=repr)
invariants = st.floats(3.0, 15.0)


def uniaxial_energy(law: HyperelasticLaw, stretch: float) -> float:
    return law.energy_density(stretch**2 + 2.0 / stretch, 2.0 * stretch + stretch**-2)


def second_difference(function: Callable[[float], float], x: float, h: float) -> float:
    """Return the second derivative, extrapolated from two steps."""

    def difference(step: float) -> float:
        return (function(x + step) - 2.0 * function(x) + function(x - step)) / step**2

    return (4.0 * difference(h) - difference(2.0 * h)) / 3.0


@every_law
def test_rest_has_no_energy(law: HyperelasticLaw) -> None:
    assert law.energy_density(3.0, 3.0) == 0.0


@every_law
def test_protocol_is_met(law: HyperelasticLaw) -> None:
    assert isinstance(law, HyperelasticLaw)


@every_law
def test_modulus_is_the_initial_slope_of_a_tensile_test(law: HyperelasticLaw) -> None:
    curvature = second_difference(lambda s: uniaxial_energy(law, s), 1.0, 2e-3)
    # A second difference in doubles keeps about eight digits.
    assert law.small_strain_modulus == pytest.approx(curvature, rel=1e-7)


@every_law
def test_simple_shear_gives_a_third_of_youngs_modulus(law: HyperelasticLaw) -> None:
    curvature = second_difference(lambda g: law.energy_density(3 + g**2, 3 + g**2), 0.0, 2e-3)
    # A second difference in doubles keeps about eight digits.
    assert law.small_strain_modulus / 3.0 == pytest.approx(curvature, rel=1e-7)


@every_law
@repeatable
@given(i1=invariants, i2=invariants)
def test_derivatives_match_differences(law: HyperelasticLaw, i1: float, i2: float) -> None:
    h = 1e-3
    derivatives = law.invariant_derivatives(i1, i2)
    numeric = np.array(
        [
            extrapolated(lambda d: law.energy_density(i1 + d, i2), h),
            extrapolated(lambda d: law.energy_density(i1, i2 + d), h),
        ]
    )
    # The difference divides rounding of an energy of about 1 MJ/m^3 by 1e-3.
    np.testing.assert_allclose(derivatives, numeric, rtol=1e-8, atol=1e-6 * 145.0)


def extrapolated(function: Callable[[float], float], h: float) -> float:
    """Return the derivative at 0 to fourth order."""
    near = (function(h) - function(-h)) / (2.0 * h)
    far = (function(2.0 * h) - function(-2.0 * h)) / (4.0 * h)
    return (4.0 * near - far) / 3.0


def test_gent_approaches_neo_hookean() -> None:
    gent, neo = Gent(shear_modulus=290.0e3, extension_limit=1e9), NeoHookean(c1=145.0e3)
    assert gent.energy_density(4.0, 4.0) == pytest.approx(neo.energy_density(4.0, 4.0), rel=1e-8)


@pytest.mark.parametrize("excess", [0.0, 1e-9, 5.0, math.nan])
def test_gent_says_when_its_chains_run_out(excess: float) -> None:
    law = Gent(shear_modulus=290.0e3, extension_limit=20.0)
    for function in (law.energy_density, law.invariant_derivatives):
        with pytest.raises(ActuationLimitError, match="fully extended") as caught:
            function(23.0 + excess, 10.0)
        assert caught.value.limit is ActuationLimit.MATERIAL_LIMIT
        assert caught.value.bound == 23.0
    assert law.energy_density(math.nextafter(23.0, 0.0), 10.0) > 0.0


def test_only_gent_has_a_limit() -> None:
    limits = [law.first_invariant_limit for law in LAWS]
    assert limits == [math.inf, math.inf, math.inf, math.inf, 23.0]
