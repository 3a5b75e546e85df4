# SPDX-License-Identifier: Apache-2.0
"""Which pairs extend, and where the volume is largest."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.actuator_cases import degrees, extending_pairs, fiber_pairs, fractions, repeatable
from hypothesis import given

from spiral_core import FiberAngles, InvalidInputError
from spiral_core.actuator.fibers import (
    fiber_derivatives,
    fiber_state,
    initial_volume_slope,
    largest_volume_stretch,
    locking_stretch,
    require_extending,
    volume_slope,
)

MAGIC_ANGLE = math.atan(math.sqrt(2.0))


def volume(fibers: FiberAngles, stretch: float) -> float:
    return stretch * fiber_state(fibers, stretch).hoop_stretch ** 2


@pytest.mark.parametrize("fibers", [degrees(88, 60), degrees(60, -60), degrees(70, 55)], ids=repr)
@pytest.mark.parametrize("fraction", [0.1, 0.5, 0.9])
def test_slope_matches_differences(fibers: FiberAngles, fraction: float) -> None:
    stretch = 1.0 + fraction * (locking_stretch(fibers) - 1.0)
    h = 1e-3 * (locking_stretch(fibers) - stretch)
    v = [volume(fibers, stretch + k * h) for k in (-2, -1, 1, 2)]
    # Fourth-order differences at a step of 1e-3.
    assert volume_slope(stretch, fiber_derivatives(fibers, stretch)) == pytest.approx(
        (8 * (v[2] - v[1]) - (v[3] - v[0])) / (12 * h), rel=1e-8
    )


@repeatable
@given(fibers=fiber_pairs)
def test_initial_slope_is_one_plus_twice_the_product_of_cotangents(fibers: FiberAngles) -> None:
    slope = volume_slope(1.0, fiber_derivatives(fibers, 1.0))
    cotangents = 1.0 / (math.tan(fibers.alpha) * math.tan(fibers.beta))
    rounding = 1e-13 * (1.0 + abs(cotangents)) / abs(math.sin(fibers.alpha - fibers.beta))
    assert initial_volume_slope(fibers) == pytest.approx(slope, rel=1e-10, abs=rounding)


@repeatable
@given(fibers=fiber_pairs)
def test_only_volume_that_grows_is_accepted(fibers: FiberAngles) -> None:
    # A thousandth of the way to locking: enough for the sign where the slope is not near zero.
    slope = initial_volume_slope(fibers)
    if abs(slope) < 1e-2:
        return
    step = 1e-6 * (locking_stretch(fibers) - 1.0)
    grows = volume(fibers, 1.0 + step) > volume(fibers, 1.0)
    if abs(slope) * step > 1e-12:
        assert grows == (slope > 0.0)
    if slope > 0.0:
        require_extending(fibers)
    else:
        with pytest.raises(InvalidInputError):
            require_extending(fibers)


def test_error_says_which_pair_and_what_would_extend() -> None:
    with pytest.raises(InvalidInputError) as caught:
        require_extending(degrees(60.0, -30.0))
    message = str(caught.value)
    assert "60 and -30 degrees" in message
    assert "two angles of the same handedness" in message
    assert "|tan(alpha) tan(beta)| > 2 (here 1," in message


@pytest.mark.parametrize("off", [1e-3, 1e-9])
def test_symmetric_pairs_extend_beyond_the_magic_angle(off: float) -> None:
    extending = FiberAngles(alpha=MAGIC_ANGLE + off, beta=-MAGIC_ANGLE - off)
    require_extending(extending)
    with pytest.raises(InvalidInputError):
        require_extending(FiberAngles(alpha=MAGIC_ANGLE - off, beta=-MAGIC_ANGLE + off))


@pytest.mark.parametrize("angle", [55.0, 60.0, 75.0, 89.0])
def test_symmetric_pairs_stop_at_the_magic_angle(angle: float) -> None:
    found = largest_volume_stretch(degrees(angle, -angle))
    closed = math.cos(MAGIC_ANGLE) / math.cos(math.radians(angle))
    assert found == pytest.approx(closed, rel=1e-13)


@repeatable
@given(fibers=extending_pairs, fraction=fractions)
def test_volume_grows_exactly_up_to_its_largest(fibers: FiberAngles, fraction: float) -> None:
    largest = largest_volume_stretch(fibers)
    locking = locking_stretch(fibers)
    if largest is None:
        stretch = 1.0 + fraction * (locking - 1.0) * (1.0 - 1e-14)
        assert volume_slope(stretch, fiber_derivatives(fibers, stretch)) > 0.0
        return
    assert 1.0 <= largest < locking
    stretch = 1.0 + fraction * (largest - 1.0)
    if stretch < largest:
        assert volume_slope(stretch, fiber_derivatives(fibers, stretch)) > 0.0
    beyond = math.nextafter(largest, math.inf)
    assert not volume_slope(beyond, fiber_derivatives(fibers, beyond)) > 0.0


@pytest.mark.parametrize("fibers", [degrees(88, 60), degrees(30, 20), degrees(90, -60)], ids=repr)
def test_one_handedness_or_a_hoop_family_only_grows(fibers: FiberAngles) -> None:
    assert largest_volume_stretch(fibers) is None


def test_largest_volume_is_a_maximum() -> None:
    fibers = degrees(75.0, -70.0)
    largest = largest_volume_stretch(fibers)
    around = [volume(fibers, s) for s in np.linspace(largest - 0.05, largest + 0.05, 11)]
    assert int(np.argmax(around)) == 5
