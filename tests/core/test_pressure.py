# SPDX-License-Identifier: Apache-2.0
"""The pressure against work and energy, a membrane's balance, tensors, and hand calculations."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from core.actuator_cases import (
    PAPER_TUBE,
    actuator,
    degrees,
    extending_pairs,
    repeatable,
)
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import (
    ActuationLimitError,
    Actuator,
    FiberAngles,
    Gent,
    HyperelasticLaw,
    InvalidInputError,
    InvariantDerivatives,
    MooneyRivlin,
    NeoHookean,
    Yeoh,
)
from spiral_core.actuator.fibers import (
    fiber_derivatives,
    fiber_state,
    largest_volume_stretch,
    locking_stretch,
)
from spiral_core.actuator.uniform_law import (
    energy_from_stretch,
    invariants_from_derivatives,
    pressure_from_stretch,
)
from spiral_core.errors import ActuationLimit


@dataclasses.dataclass(frozen=True)
class Coupled:
    """u = c (I1 - 3) + d (I1 - 3) (I2 - 3) + e (I2 - 3)^2."""

    c: float = 145.0e3
    d: float = 40.0e3
    e: float = 30.0e3
    small_strain_modulus: float = 870.0e3
    first_invariant_limit: float = math.inf

    def energy_density(self, first_invariant: float, second_invariant: float) -> float:
        x, y = first_invariant - 3.0, second_invariant - 3.0
        return self.c * x + self.d * x * y + self.e * y * y

    def invariant_derivatives(
        self, first_invariant: float, second_invariant: float
    ) -> InvariantDerivatives:
        x, y = first_invariant - 3.0, second_invariant - 3.0
        return InvariantDerivatives(self.c + self.d * y, self.d * x + 2.0 * self.e * y)


LAWS: list[HyperelasticLaw] = [
    Coupled(),
    NeoHookean(c1=145.0e3),
    MooneyRivlin(c1=118.4e3, c2=105.7e3),
    Yeoh(c1=145.0e3, c2=-5.0e3, c3=1.0e3),
    Gent(shear_modulus=290.0e3, extension_limit=30.0),
]
PAIRS = [(88.0, 50.0), (88.0, 60.0), (90.0, 70.0), (80.0, -75.0), (65.0, 50.0)]


def end_of_extension(fibers: FiberAngles) -> float:
    return largest_volume_stretch(fibers) or locking_stretch(fibers)


def enclosed_volume(case: Actuator, stretch: float) -> float:
    rest = math.pi * case.tube.inner_radius**2 * case.tube.length
    return rest * stretch * fiber_state(case.fibers, stretch).hoop_stretch ** 2


@repeatable
@given(fibers=extending_pairs, fraction=st.floats(1e-3, 0.99), shear=st.booleans())
def test_invariants_are_those_of_the_deformation_gradient(
    fibers: FiberAngles, fraction: float, shear: bool
) -> None:
    stretch = 1.0 + fraction * (locking_stretch(fibers) - 1.0)
    state = fiber_state(fibers, stretch)
    gradient = np.diag([stretch, state.hoop_stretch, state.radial_stretch])
    if shear:
        gradient[1, 0] = state.hoop_stretch * state.twist
    cauchy_green = gradient.T @ gradient
    first = np.trace(cauchy_green)
    second = 0.5 * (first**2 - np.trace(cauchy_green @ cauchy_green))
    values = invariants_from_derivatives(stretch, fiber_derivatives(fibers, stretch), shear)
    assert values.first == pytest.approx(first, rel=1e-13)
    # The textbook second invariant is a difference of squares.
    assert values.second == pytest.approx(second, rel=1e-12, abs=1e-14 * first**2)


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("shear", [True, False])
def test_work_done_equals_energy_stored(
    pair: tuple[float, float], law: HyperelasticLaw, shear: bool
) -> None:
    case = actuator(*pair, material=law, twist_shear=shear)
    end = end_of_extension(case.fibers)
    for fraction in (0.01, 0.2, 0.5, 0.8):
        stretch = 1.0 + fraction * (end - 1.0)
        h = 1e-3 * (end - stretch) * fraction
        energy = [energy_from_stretch(case, stretch + k * h) for k in (-2, -1, 1, 2)]
        room = [enclosed_volume(case, stretch + k * h) for k in (-2, -1, 1, 2)]
        work_rate = 8 * (energy[2] - energy[1]) - (energy[3] - energy[0])
        volume_rate = 8 * (room[2] - room[1]) - (room[3] - room[0])
        # Fourth-order differences of energies that are small near rest: nine digits or so.
        assert pressure_from_stretch(case, stretch) == pytest.approx(
            work_rate / volume_rate, rel=1e-7
        )


@pytest.mark.parametrize("stretch", [1.01, 1.1, 1.3])
@pytest.mark.parametrize(("c1", "c2"), [(145.0e3, 0.0), (118.4e3, 105.7e3)])
def test_without_twist_shear_it_is_a_membrane_in_pure_shear(
    stretch: float, c1: float, c2: float
) -> None:
    # Hoop fibers alone: pressure on the end cap balances the axial stress of Mooney's strip held
    # at its width, 2 (C1 + C2) (lambda - lambda^-3) per unstretched area.
    case = actuator(90.0, 60.0, MooneyRivlin(c1, c2), twist_shear=False)
    stress = 2.0 * (c1 + c2) * (stretch - stretch**-3)
    force = stress * PAPER_TUBE.wall_area
    cap = math.pi * PAPER_TUBE.inner_radius**2
    assert pressure_from_stretch(case, stretch) == pytest.approx(force / cap, rel=1e-12)


@pytest.mark.parametrize(("beta", "percent"), [(50.0, 27), (60.0, 13), (70.0, 5)])
def test_twist_shear_stiffens_as_documented(beta: float, percent: int) -> None:
    with_shear, without = (
        pressure_from_stretch(actuator(88.0, beta, twist_shear=flag), 1.1) for flag in (True, False)
    )
    assert round(100.0 * (with_shear / without - 1.0)) == percent


def test_pair_that_shortens_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="45 and -45 degrees"):
        pressure_from_stretch(actuator(45.0, -45.0), 1.01)


def test_past_the_largest_volume_is_refused() -> None:
    case = actuator(60.0, -60.0)
    largest = largest_volume_stretch(degrees(60.0, -60.0))
    with pytest.raises(ActuationLimitError, match="volume") as caught:
        pressure_from_stretch(case, 1.2)
    assert caught.value.limit is ActuationLimit.VOLUME_MAXIMUM
    assert caught.value.bound == largest


def test_past_locking_is_refused() -> None:
    with pytest.raises(ActuationLimitError) as caught:
        pressure_from_stretch(actuator(88.0, 60.0), 2.1)
    assert caught.value.limit is ActuationLimit.FIBER_LOCKING
