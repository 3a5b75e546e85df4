# SPDX-License-Identifier: Apache-2.0
"""Objects whose radius varies: where the coil goes, which pressure, what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.gripper_cases import paper_gripper

from spiral_core import (
    NotGrippableError,
    ObjectProfile,
    WrapCurve,
    WrapRegime,
    wrap_for_profile,
)


@pytest.fixture(scope="module")
def curve() -> WrapCurve:
    """Return the paper's 70 degree design, hanging."""
    return WrapCurve(paper_gripper("70 degrees"))


def test_a_cylinder_is_wrapped_like_a_cylinder(curve: WrapCurve) -> None:
    wrap = wrap_for_profile(curve, ObjectProfile([0.0, 0.5], [0.02, 0.02]))
    perfect = curve.wrap_for_radius(0.02)
    assert wrap.pressure == pytest.approx(perfect.pressure, rel=1e-9)
    assert wrap.pressure_of_thickest == wrap.pressure_of_mean == wrap.pressure
    assert wrap.end - wrap.start == pytest.approx(perfect.object_length_needed, rel=1e-9)
    assert {station.regime for station in wrap.stations} == {WrapRegime.PERFECT_WRAP}


def test_the_papers_cylinder_that_varies_between_its_two_objects(curve: WrapCurve) -> None:
    wave = np.linspace(0.0, 0.4, 81)
    radii = 0.0205 + 0.0095 * np.cos(2.0 * math.pi * wave / 0.4)
    wrap = wrap_for_profile(curve, ObjectProfile(wave, radii))
    assert 0.011 <= wrap.radius_min < wrap.radius_max <= 0.030
    assert wrap.pressure == pytest.approx(curve.pressure_from_radius(wrap.radius_min))
    assert wrap.pressure_of_thickest < wrap.pressure_of_mean < wrap.pressure
    assert WrapRegime.OVERHANG not in {station.regime for station in wrap.stations}


def test_the_most_even_place_is_taken(curve: WrapCurve) -> None:
    # A steep cone with a cylinder at its thin end.
    profile = ObjectProfile([0.0, 0.3, 0.45], [0.035, 0.015, 0.015])
    wrap = wrap_for_profile(curve, profile)
    assert wrap.start >= 0.3 - 1e-9
    assert wrap.radius_min == pytest.approx(wrap.radius_max)


def test_a_cone_is_held_past_its_perfect_wrap_where_it_is_thick(curve: WrapCurve) -> None:
    wrap = wrap_for_profile(curve, ObjectProfile([0.0, 0.3], [0.030, 0.011]))
    first, last = wrap.stations[0], wrap.stations[-1]
    assert first.radius > last.radius
    assert (first.regime, last.regime) == (WrapRegime.CURLING, WrapRegime.PERFECT_WRAP)
    assert first.pressure < last.pressure == pytest.approx(wrap.pressure)
    # The thickest place decides how much of the object the coil covers.
    needed = curve.wrap_for_radius(wrap.radius_max).object_length_needed
    assert needed <= wrap.end - wrap.start + 1e-9


def test_the_two_ends_of_an_object_are_alike(curve: WrapCurve) -> None:
    here = wrap_for_profile(curve, ObjectProfile([0.0, 0.3], [0.030, 0.011]))
    there = wrap_for_profile(curve, ObjectProfile([0.0, 0.3], [0.011, 0.030]))
    # Starts are tried at 101 places: the two windows differ by at most one step.
    assert there.radius_min == pytest.approx(here.radius_min, abs=0.019 / 100.0)
    assert there.radius_max == pytest.approx(here.radius_max, abs=2 * 0.019 / 100.0)


@pytest.mark.parametrize(
    ("positions", "radii", "constraint"),
    [
        ([0.0, 0.3], [0.0005, 0.0004], "too thin"),
        ([0.0, 0.3], [0.08, 0.09], "too thick"),
        ([0.0, 0.02], [0.02, 0.02], "in radius is 0.02 m long, and the coil covers"),
        ([0.0, 0.1, 0.2], [0.09, 0.01, 0.09], "in radius is .* m long, and the coil covers"),
        # Ten meters of object, none of them even enough for the coil: a margin that is not met.
        (
            np.linspace(0.0, 10.0, 201).tolist(),
            [0.02 if i % 2 else 0.08 for i in range(201)],
            "in radius is .* m long, and the coil covers",
        ),
    ],
)
def test_what_cannot_be_wrapped_says_why(
    curve: WrapCurve, positions: list[float], radii: list[float], constraint: str
) -> None:
    with pytest.raises(NotGrippableError, match=constraint) as raised:
        wrap_for_profile(curve, ObjectProfile(positions, radii))
    assert raised.value.margin < 0.0
    nearest = raised.value.nearest_radius
    # The radius is not what forbids a grip where there is room for some of the object.
    assert (nearest is None) == ("coil covers" in constraint)
    assert nearest is None or curve.radius_min <= nearest <= curve.radius_max


def test_profile_is_linear_between_its_samples_and_cannot_be_changed() -> None:
    radii = np.array([0.03, 0.01])
    profile = ObjectProfile([0.0, 0.2], radii)
    radii[0] = 1.0
    assert profile.radius_at(0.1) == pytest.approx(0.02)
    assert profile.extremes(0.05, 0.15) == pytest.approx((0.015, 0.025))
    with pytest.raises(ValueError, match="read-only"):
        np.asarray(profile.radii)[0] = 1.0
