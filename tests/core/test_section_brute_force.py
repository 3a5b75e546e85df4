# SPDX-License-Identifier: Apache-2.0
"""The section law against brute force: energy less work minimized over local fields."""

import math

import numpy as np
import pytest
from core.reference_section import POINTS, BruteSection
from core.section_cases import LAWS, one_family, section

from spiral_core import FreeActuation, Gent, MooneyRivlin, NeoHookean, Yeoh
from spiral_core.actuator.fibers import family_angles

pytestmark = pytest.mark.slow


def energy(law):
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


def check(bent, size, singles=(0,), digits=2e-8):
    """Compare a state with the minimum of energy minus pressure times volume."""
    actuation = FreeActuation(bent)
    pressure = actuation.pressure.with_slope(size)[0]
    shape = actuation.unloaded_shape(pressure)
    radius, stretch = bent.wound_radius, shape.stretch
    gamma = bent.single_fibers[0].angle if singles else 0.0
    wall = bent.tube.wall_area / (math.pi * radius**2)
    brute = BruteSection(family_angles(bent.fibers), gamma, singles)
    expected = np.array([1.0, shape.curvature * radius, shape.torsion * radius]) * stretch
    # SLSQP ends at a change of 1e-15 of the energy: half the digits of what minimizes it.
    found = brute.solve(energy(bent.material), pressure, wall)
    assert found == pytest.approx(expected, rel=0.0, abs=digits)


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
def test_brute_force_finds_the_same_state(pair, gamma, singles, law, fraction):
    apart = 360.0 * 2 * max(singles, default=0) / POINTS
    bent = section(*pair, LAWS[law], gamma, apart)
    bent = bent if singles else bent.without_single_fibers()
    check(bent, fraction * FreeActuation(bent).size_limit, singles)


@pytest.mark.parametrize("seed", range(20))
def test_brute_force_agrees_on_random_actuators(seed):
    """Pairs of one handedness and of opposite ones, straight and helical fibers, every law."""
    draw = np.random.default_rng(20260300 + seed)
    beta = draw.uniform(35.0, 75.0)
    alpha = draw.uniform(beta + 8.0, 90.0)
    if seed % 3 == 2:  # opposite hands, beyond the magic angle
        alpha, beta = draw.uniform(65.0, 85.0), -draw.uniform(65.0, 85.0)
    gamma = 0.0 if seed % 2 else draw.uniform(-30.0, 30.0)
    bent = section(alpha, beta, LAWS[seed % 4], gamma)
    check(bent, draw.uniform(0.05, 0.3) * min(FreeActuation(bent).size_limit, 2.0))


@pytest.mark.parametrize(("angle", "gamma"), [(70.0, 0.0), (90.0, 0.0), (75.0, 20.0)])
def test_brute_force_finds_the_same_hoop(angle, gamma):
    # Twelve angles there, 21 points here; SLSQP ends at half the digits of what it minimizes.
    check(one_family(angle, gamma=gamma), 0.3, digits=1e-7)
