# SPDX-License-Identifier: Apache-2.0
"""Elastomer laws that a user writes: what is refused, and where a law's pole lies by the range."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest
from core.actuator_cases import actuator

from spiral_core import Actuator, FreeActuation, Gent, InvalidInputError, NeoHookean, PressureLaw
from spiral_core.actuator.section import section_path
from spiral_core.errors import ActuationLimit

both_laws = pytest.mark.parametrize("law", PressureLaw)


@dataclass(frozen=True)
class OwnLaw:
    """Neo-Hooke's law, answered by plain tuples, and unknown past some I1."""

    first_invariant_limit: float = math.inf
    known_to: float = math.inf
    small_strain_modulus = 6.0

    def energy_density(self, first_invariant: float, second_invariant: float) -> float:
        return first_invariant - 3.0 if first_invariant < self.known_to else math.nan

    def invariant_derivatives(
        self, first_invariant: float, second_invariant: float
    ) -> tuple[float, float]:
        return (1.0 if first_invariant < self.known_to else math.nan), 0.0


def own(law: PressureLaw, **values: float) -> Actuator:
    return actuator(material=OwnLaw(**values), pressure_law=law)


@both_laws
def test_plain_tuples_will_do(law: PressureLaw) -> None:
    reference = FreeActuation(actuator(material=NeoHookean(c1=1.0), pressure_law=law))
    assert FreeActuation(own(law)).pressure_limit == reference.pressure_limit


@both_laws
@pytest.mark.parametrize("end", [3.2, 5.0])
def test_a_law_that_is_not_finite_is_refused(law: PressureLaw, end: float) -> None:
    with pytest.raises(InvalidInputError, match="finite as far as the fibers go"):
        FreeActuation(own(law, known_to=end))


@both_laws
@pytest.mark.parametrize("limit", [2.0, 3.0, math.nan])
def test_a_limit_at_rest_is_refused(law: PressureLaw, limit: float) -> None:
    with pytest.raises(InvalidInputError, match="first_invariant_limit"):
        own(law, first_invariant_limit=limit)


def test_a_pole_just_beyond_the_range_is_no_limit_point() -> None:
    case = actuator(pressure_law=PressureLaw.SECTION)
    farthest = float(section_path(case.fiber_set).motion.first.max())
    material = Gent(shear_modulus=290.0e3, extension_limit=1.001 * farthest)
    found = FreeActuation(actuator(material=material, pressure_law=PressureLaw.SECTION))
    assert found.limit is ActuationLimit.VOLUME_MAXIMUM
