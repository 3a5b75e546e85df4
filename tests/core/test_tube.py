# SPDX-License-Identifier: Apache-2.0
"""Section properties against integration over the annulus, and refused dimensions."""

from __future__ import annotations

import math

import pytest
from scipy.integrate import quad

from spiral_core import InvalidInputError, Tube

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


def test_outer_radius_is_bore_plus_wall() -> None:
    assert TUBE.outer_radius == pytest.approx(5.55625e-3, rel=1e-15)


def test_thin_wall_limit() -> None:
    thin = Tube(inner_radius=5.0e-3, wall_thickness=5.0e-9, length=0.1)
    # Thin-wall formulas are exact only to the relative wall, here 1e-6.
    assert thin.second_moment_of_area == pytest.approx(
        math.pi * thin.inner_radius**3 * thin.wall_thickness, rel=3e-6
    )


@pytest.mark.parametrize("field", ["inner_radius", "wall_thickness", "length"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, True, "5 mm"])
def test_dimensions_must_be_positive(field: str, value: object) -> None:
    dimensions: dict[str, object] = {"inner_radius": 5e-3, "wall_thickness": 1e-3, "length": 0.5}
    with pytest.raises(InvalidInputError) as caught:
        Tube(**(dimensions | {field: value}))  # type: ignore[arg-type]
    assert caught.value.field == field


@pytest.mark.parametrize("field", ["inner_radius", "wall_thickness", "length"])
@pytest.mark.parametrize("value", [1.1e9, 1e300])
def test_no_tube_is_so_large_that_its_section_overflows(field: str, value: float) -> None:
    sizes = {"inner_radius": 5e-3, "wall_thickness": 1e-3, "length": 0.5, field: value}
    with pytest.raises(InvalidInputError, match=rf"{field} must be at most 1e\+09 m"):
        Tube(**sizes)
