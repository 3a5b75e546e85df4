# SPDX-License-Identifier: Apache-2.0
"""The two families: what they keep, closed forms, singular corners, and whether they extend."""

import contextlib
from math import sin, sqrt

import pytest
from core.actuator_cases import degrees, fiber_pairs, fractions, repeatable
from core.reference_uniform import reference_wall
from hypothesis import given
from numpy.testing import assert_allclose

from spiral_core import ActuationLimitError, InvalidInputError
from spiral_core.actuator.fibers import (
    fiber_state,
    initial_volume_slope,
    locking_stretch,
    require_extending,
)
from spiral_core.errors import ActuationLimit


def stretch_at(fibers, fraction):
    """Return the stretch at a fraction of the way from rest to just below locking."""
    return 1.0 + (locking_stretch(fibers) - 1.0) * min(fraction, 1.0 - 1e-14)


@repeatable
@given(fibers=fiber_pairs, fraction=fractions)
def test_the_wall_is_that_of_the_reference(fibers, fraction):
    stretch = stretch_at(fibers, fraction)
    found = fiber_state(fibers, stretch)
    values, slopes = reference_wall(fibers, stretch, True)
    *_, hoop, shear = values
    # Near families magnify rounding; next to locking the last bit of the stretch counts.
    largest = 1.0 + max(map(abs, (*values[3:], *slopes[3:])))
    scale = largest * (1e-13 + 1e-15 / (locking_stretch(fibers) - stretch))
    scale /= abs(sin(fibers.alpha - fibers.beta))
    near_rest = scale * (stretch - 1.0) + 1e-24  # where nothing cancels
    assert_allclose(found.hoop_stretch, hoop, 1e-13, near_rest)
    assert_allclose(found.twist, shear / hoop, 1e-13, near_rest * (1.0 + abs(shear)) / hoop**2)


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
    assert_allclose(slope, reference_wall(fibers, 1.0, True)[1][2], 1e-10, rounding)
    with contextlib.nullcontext() if slope > 0.0 else pytest.raises(InvalidInputError):
        require_extending(fibers)
