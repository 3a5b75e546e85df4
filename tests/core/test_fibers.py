# SPDX-License-Identifier: Apache-2.0
"""The two families: what they keep, closed forms, singular corners, and the volume they enclose."""

import contextlib
from dataclasses import astuple
from math import inf, nextafter, sin, sqrt

import pytest
from core.actuator_cases import degrees, extending_pairs, fiber_pairs, fractions, repeatable
from core.reference_uniform import reference_wall
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from spiral_core import ActuationLimitError, InvalidInputError
from spiral_core.actuator.fibers import (
    fiber_derivatives,
    fiber_state,
    initial_volume_slope,
    largest_volume_stretch,
    locking_stretch,
    require_extending,
    volume_slope,
)
from spiral_core.actuator.uniform_law import invariants_from_derivatives
from spiral_core.errors import ActuationLimit


def stretch_at(fibers, fraction):
    """Return the stretch at a fraction of the way from rest to just below locking."""
    return 1.0 + (locking_stretch(fibers) - 1.0) * min(fraction, 1.0 - 1e-14)


@repeatable
@given(fibers=fiber_pairs, fraction=fractions, shear=st.booleans())
def test_the_wall_and_its_derivatives_are_those_of_the_reference(fibers, fraction, shear):
    stretch = stretch_at(fibers, fraction)
    found = fiber_derivatives(fibers, stretch)
    values, slopes = reference_wall(fibers, stretch, shear)
    # Near families magnify rounding; next to locking the last bit of the stretch counts.
    largest = 1.0 + max(map(abs, found))
    scale = largest * (1e-13 + 1e-15 / (locking_stretch(fibers) - stretch))
    scale /= abs(sin(fibers.alpha - fibers.beta))
    invariants = invariants_from_derivatives(stretch, found, shear)
    near_rest = scale * (stretch - 1.0) + 1e-24  # where nothing cancels
    for one, expected, rel, error in (
        (found[1::2], values[3:], 1e-13, near_rest),
        (found[2::2], slopes[3:], 1e-11, scale),
        ([volume_slope(stretch, found)], slopes[2:3], 1e-11, 4.0 * largest * scale),
        (invariants[::2], values[:2], 1e-13, largest * scale),
        (invariants[1::2], slopes[:2], 1e-11, largest**2 * near_rest),
    ):
        assert_allclose(list(one), expected, rel, error)
    radial, twist = 1.0 / (stretch * found.hoop), found.shear / found.hoop
    assert astuple(fiber_state(fibers, stretch)) == (stretch, found.hoop, radial, twist)


def test_locking_is_where_a_fiber_lies_along_the_axis():
    fibers, locking = degrees(-45, 60), sqrt(2.0)
    fiber_state(fibers, locking * (1.0 - 1e-15))
    past, bound = locking * (1.0 + 1e-15), pytest.approx(locking, rel=1e-15)
    with pytest.raises(ActuationLimitError, match="locks") as caught:
        fiber_state(fibers, past)
    assert caught.value.args == (ActuationLimit.FIBER_LOCKING, "stretch", past, bound)


@repeatable
@given(fibers=fiber_pairs)
def test_volume_grows_at_rest_by_the_cotangents_or_the_pair_is_refused(fibers):
    slope = initial_volume_slope(fibers)
    rounding = 1e-13 * (1.0 + abs(slope)) / abs(sin(fibers.alpha - fibers.beta))
    exact = volume_slope(1.0, fiber_derivatives(fibers, 1.0))
    assert_allclose(slope, exact, 1e-10, rounding)
    with contextlib.nullcontext() if slope > 0.0 else pytest.raises(InvalidInputError):
        require_extending(fibers)


@repeatable
@given(fibers=extending_pairs, fraction=fractions)
def test_volume_grows_exactly_up_to_its_largest(fibers, fraction):
    def grows(stretch):
        return volume_slope(stretch, fiber_derivatives(fibers, stretch)) > 0.0

    largest = largest_volume_stretch(fibers)
    if largest is None:
        assert grows(stretch_at(fibers, fraction))
        return
    assert 1.0 <= largest < locking_stretch(fibers)
    stretch = 1.0 + fraction * (largest - 1.0)
    assert grows(stretch) or stretch == largest
    assert not grows(nextafter(largest, inf))
