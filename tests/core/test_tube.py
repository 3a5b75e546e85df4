# SPDX-License-Identifier: Apache-2.0
"""Section properties against integration over the annulus, and refused dimensions."""

from __future__ import annotations

import math

import pytest
from scipy.integrate import quad

from spiral_core import Tube

TUBE = Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5)


@pytest.mark.parametrize(
    ("value", "power", "factor"),
    [
        (TUBE.wall_area, 1, 2.0 * math.pi),
        (TUBE.second_moment_of_area, 3, math.pi),
        (TUBE.polar_moment_of_area, 3, 2.0 * math.pi),
    ],
)
def test_section_properties_are_integrals_over_the_annulus(
    value: float, power: int, factor: float
) -> None:
    integral, _ = quad(lambda rho: rho**power, TUBE.inner_radius, TUBE.outer_radius, epsrel=1e-12)
    assert value == pytest.approx(factor * integral, rel=1e-12)


def test_thin_wall_limit() -> None:
    thin = Tube(inner_radius=5.0e-3, wall_thickness=5.0e-9, length=0.1)
    # Thin-wall formulas are exact only to the relative wall, here 1e-6.
    assert thin.second_moment_of_area == pytest.approx(
        math.pi * thin.inner_radius**3 * thin.wall_thickness, rel=3e-6
    )
