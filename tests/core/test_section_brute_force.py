# SPDX-License-Identifier: Apache-2.0
"""The section law against brute force: energy less work minimized over local fields."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.actuator_cases import LATEX, PAPER_TUBE
from core.reference_section import POINTS, BruteSection, Found
from core.section_cases import LAWS, one_family, section

from spiral_core import (
    Actuator,
    FreeActuation,
    Gent,
    HyperelasticLaw,
    MooneyRivlin,
    NeoHookean,
    Yeoh,
)


def energy(law: HyperelasticLaw):  # type: ignore[no-untyped-def]
    """Return a law's energy as its docstring has it, for complex arguments too."""
    match law:
        case NeoHookean(c1=c1):
            return lambda i, j: c1 * (i - 3.0)
        case MooneyRivlin(c1=c1, c2=c2):
            return lambda i, j: c1 * (i - 3.0) + c2 * (j - 3.0)
        case Yeoh(c1=c1, c2=c2, c3=c3):
            return lambda i, j: c1 * (i - 3.0) + c2 * (i - 3.0) ** 2 + c3 * (i - 3.0) ** 3
        case Gent(shear_modulus=mu, extension_limit=jm):
            return lambda i, j: -0.5 * mu * jm * np.log(1.0 - (i - 3.0) / jm)
    raise AssertionError(law)


def check_against_brute_force(bent: Actuator, singles: tuple[int, ...], fraction: float) -> None:
    """Compare a state with the minimum of energy minus pressure times volume."""
    actuation = FreeActuation(bent)
    size = fraction * actuation.size_limit
    pressure = actuation.pressure.with_slope(size)[0]
    shape = actuation.unloaded_shape(pressure)
    radius, stretch = bent.wound_radius, shape.stretch or math.nan
    gamma = bent.single_fibers[0].angle if bent.single_fibers else 0.0
    brute = BruteSection((bent.fibers.alpha, bent.fibers.beta), gamma, singles)
    guess = Found(1.0, 0.01 if singles else 0.0, math.tan(gamma), 0.0, 0.0)
    wall = bent.tube.wall_area / (math.pi * radius**2)
    found = brute.solve(energy(bent.material), pressure, wall, guess)
    # SLSQP ends at a change of 1e-15 of the energy: half the digits of what minimizes it.
    assert found.stretch == pytest.approx(stretch, abs=2e-8)
    assert found.curvature == pytest.approx(shape.curvature * stretch * radius, abs=2e-8)
    assert found.torsion == pytest.approx(shape.torsion * stretch * radius, abs=2e-8)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pair", "gamma", "singles", "law", "fraction"),
    [
        ((88.0, 60.0), 0.0, (0,), 1, 0.1),
        ((88.0, 50.0), 0.0, (0,), 3, 0.2),
        ((65.0, -65.0), 0.0, (0,), 2, 0.5),
        ((88.0, 60.0), 20.0, (0,), 0, 0.1),
        ((75.0, 50.0), -35.0, (0,), 1, 0.1),
        ((88.0, 60.0), 15.0, (3, -3), 1, 0.1),
        ((88.0, 60.0), 0.0, (), 1, 0.1),
        ((45.0, -45.0), 0.0, (), 1, 0.4),
    ],
)
def test_brute_force_finds_the_same_state(
    pair: tuple[float, float],
    gamma: float,
    singles: tuple[int, ...],
    law: int,
    fraction: float,
) -> None:
    apart = 360.0 * 2 * max(singles, default=0) / POINTS
    bent = section(*pair, LAWS[law], gamma=gamma, apart=apart)
    check_against_brute_force(bent if singles else bent.without_single_fibers(), singles, fraction)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_brute_force_agrees_on_random_actuators(seed: int) -> None:
    """Pairs of one handedness and of opposite ones, straight and helical fibers, every law."""
    draw = np.random.default_rng(20260300 + seed)
    beta = draw.uniform(35.0, 75.0)
    alpha = draw.uniform(beta + 8.0, 90.0)
    if seed % 3 == 2:  # opposite hands, beyond the magic angle
        alpha, beta = draw.uniform(65.0, 85.0), -draw.uniform(65.0, 85.0)
    gamma = 0.0 if seed % 2 else draw.uniform(-30.0, 30.0)
    bent = section(alpha, beta, LAWS[seed % 4], gamma=gamma)
    limit = FreeActuation(bent).size_limit
    check_against_brute_force(bent, (0,), draw.uniform(0.05, 0.3) * min(1.0, 2.0 / limit))


@pytest.mark.slow
@pytest.mark.parametrize(("angle", "gamma"), [(70.0, 0.0), (90.0, 0.0), (75.0, 20.0)])
def test_brute_force_finds_the_same_hoop(angle: float, gamma: float) -> None:
    bent = one_family(angle, gamma=gamma)
    actuation = FreeActuation(bent)
    pressure = actuation.pressure.with_slope(0.3)[0]
    shape = actuation.unloaded_shape(pressure)
    radius, stretch = PAPER_TUBE.inner_radius, shape.stretch or math.nan
    brute = BruteSection((math.radians(angle),), math.radians(gamma))
    wall = PAPER_TUBE.wall_area / (math.pi * radius**2)
    guess = Found(1.0, 0.01, math.tan(math.radians(gamma)), 0.0, 0.0)
    found = brute.solve(energy(LATEX), pressure, wall, guess)
    # Twelve angles there, 21 points here; SLSQP ends at half the digits of what it minimizes.
    assert found.stretch == pytest.approx(stretch, abs=1e-7)
    assert found.curvature == pytest.approx(shape.curvature * stretch * radius, abs=1e-7)
    assert found.torsion == pytest.approx(shape.torsion * stretch * radius, abs=1e-7)
