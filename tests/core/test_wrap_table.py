# SPDX-License-Identifier: Apache-2.0
"""The table of solved wraps: how near its guesses are, and that nothing spoils them."""

from __future__ import annotations

import math
from typing import cast

import numpy as np
import pytest

from spiral_core import Wrap
from spiral_core.wrap.curve import WrapTable

OUTER_RADIUS = 5.5e-3


class SolvedWrap:
    """What the table reads of a wrap."""

    def __init__(self, pressure: float, object_radius: float) -> None:
        self.pressure, self.object_radius = pressure, object_radius
        self.outer_radius = OUTER_RADIUS


def contact_curvature(pressure: float) -> float:
    """Return a curve like a gripper's: nearly linear, with a ripple from the tip's turning."""
    x = pressure / 1.0e5
    return 20.0 + 80.0 * x + 1.5 * math.sin(9.0 * x)


def slope(pressure: float) -> float:
    """Return its derivative."""
    return (80.0 + 13.5 * math.cos(9.0 * pressure / 1.0e5)) / 1.0e5


def table(*pressures: float, scatter: float = 0.0) -> WrapTable:
    """Return the table of that curve's wraps; every second radius off by ``scatter``."""
    wraps = [
        SolvedWrap(p, (1.0 + (k % 2) * scatter) / contact_curvature(p) - OUTER_RADIUS)
        for k, p in enumerate(sorted(pressures))
    ]
    return WrapTable(cast("list[Wrap]", wraps))


SAMPLES = np.linspace(2.0e4, 1.0e5, 30).tolist()


def test_the_guess_is_near_and_within_its_bracket() -> None:
    guesses = table(*SAMPLES)
    for pressure in np.linspace(SAMPLES[0], SAMPLES[-1], 211).tolist():
        low, high, guess, rate = guesses.bracket_and_guess(contact_curvature(pressure))
        assert low <= guess <= high
        # The ripple's period is 25 samples, the ends see it from one side: 8 nodes leave this much.
        assert guess == pytest.approx(pressure, rel=3e-6)
        assert rate == pytest.approx(slope(pressure), rel=2e-4)


def test_a_sample_next_to_an_end_of_the_branch_does_not_spoil_the_guess() -> None:
    """Solved radii scatter by their tolerance: over a tiny distance that is a wrong slope."""
    near_doubles = table(SAMPLES[0] * (1.0 + 1e-7), *SAMPLES, scatter=1e-9)
    for pressure in np.linspace(SAMPLES[0], SAMPLES[1], 11).tolist():
        guess = near_doubles.bracket_and_guess(contact_curvature(pressure))[2]
        assert guess == pytest.approx(pressure, rel=3e-6)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_short_branch_has_a_coarse_guess_in_its_bracket(count: int) -> None:
    few = table(*np.linspace(2.0e4, 1.0e5, count).tolist())
    for pressure in np.linspace(2.0e4, 1.0e5, 9).tolist():
        low, high, guess, rate = few.bracket_and_guess(contact_curvature(pressure))
        assert low <= guess <= high
        assert guess == pytest.approx(pressure, rel=0.2)  # two samples: a chord of the ripple
        assert rate > 0.0


def test_a_guess_outside_its_bracket_is_replaced_by_the_chord() -> None:
    """Where the samples jump the polynomial swings: then the chord is better."""
    pressures = np.linspace(2.0e4, 1.0e5, 12).tolist()
    curvatures = [20.0 + k + (40.0 if k > 5 else 0.0) for k in range(12)]
    wraps = [
        SolvedWrap(p, 1.0 / c - OUTER_RADIUS) for p, c in zip(pressures, curvatures, strict=True)
    ]
    jump = WrapTable(cast("list[Wrap]", wraps))
    for target in np.linspace(20.0, 71.0, 101).tolist():
        low, high, guess, rate = jump.bracket_and_guess(target)
        assert low <= guess <= high
        assert rate > 0.0
