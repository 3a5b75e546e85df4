# SPDX-License-Identifier: Apache-2.0
"""The section law against brute force: energy less work minimized over local fields."""

from math import pi

import numpy as np
import pytest
from core.reference_section import POINTS, least_section
from core.section_cases import LAWS, one_family, section
from numpy.testing import assert_allclose

from spiral_core import FreeActuation, Gent, OneFamily
from spiral_core.actuator.fibers import family_angles

pytestmark = pytest.mark.slow


def energy(law):
    """Return a law's energy, for complex arguments too."""
    if isinstance(law, Gent):
        limit = law.extension_limit
        return lambda i, _: -0.5 * law.shear_modulus * limit * np.log(1.0 - (i - 3.0) / limit)
    return law.energy_density


CHOSEN = [  # what the random ones are not
    (section(88.0, 60.0, LAWS[1], gamma=15.0, apart=360.0 * 6 / POINTS), 0.1),
    (section(88.0, 60.0, LAWS[1]).without_single_fibers(), 0.1),
    (section(45.0, -45.0, LAWS[1]).without_single_fibers(), 0.4),
    (section(65.0, -65.0, LAWS[2]), 0.5),
    (one_family(70.0), 0.15),
    (one_family(90.0), 0.15),
    (one_family(75.0, gamma=20.0), 0.15),
]


def random_case(seed):
    """Return a pair of one handedness or of opposite ones, a straight or a helical fiber."""
    draw = np.random.default_rng(20260300 + seed)
    beta = draw.uniform(35.0, 75.0)
    alpha = draw.uniform(beta + 8.0, 90.0)
    if seed % 3 == 2:  # opposite hands, beyond the magic angle
        alpha, beta = draw.uniform(65.0, 85.0), -draw.uniform(65.0, 85.0)
    gamma = 0.0 if seed % 2 else draw.uniform(-30.0, 30.0)
    return section(alpha, beta, LAWS[seed % 4], gamma), draw.uniform(0.05, 0.3)


@pytest.mark.parametrize(("bent", "fraction"), [*CHOSEN, *map(random_case, range(20))])
def test_brute_force_finds_the_same_state(bent, fraction):
    actuation = FreeActuation(bent)
    pressure, _ = actuation.pressure.with_slope(fraction * min(actuation.size_limit, 2.0))
    shape = actuation.unloaded_shape(pressure)
    radius = bent.wound_radius
    singles = [round(one.position * POINTS / (2.0 * pi)) for one in bent.single_fibers]
    gamma = bent.single_fibers[0].angle if singles else 0.0
    load = pressure * pi * radius**2 / bent.tube.wall_area
    found = least_section(family_angles(bent.fibers), gamma, singles, energy(bent.material), load)
    expected = np.array([1.0, shape.curvature * radius, shape.torsion * radius]) * shape.stretch
    # SLSQP ends at a change of 1e-15 of the energy: half the digits of what minimizes it. One
    # family is solved for at twelve angles, here at 21 points.
    digits = 1e-7 if isinstance(bent.fibers, OneFamily) else 2e-8
    assert_allclose(found, expected, 0.0, digits)
