# SPDX-License-Identifier: Apache-2.0
"""A table of solved wraps from which the wrap of a radius is guessed."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence

import numpy as np

from spiral_core.wrap.wrap import Wrap

# Solved wraps that one interpolation goes through.
NODES = 8
# A wrap nearer to an end of the sub-branch than this fraction of the usual distance is left out:
# the rounding of their difference would spoil the interpolation.
LEAST_GAP = 0.05


class WrapTable:
    r"""Pressures against the contact curvature 1/(r_w + r_o), in which they are almost linear.

    Between two wraps the pressure is the polynomial through the nearest ones, in Newton's form.

    Args:
        branch: wraps of a sub-branch by falling radius, its two ends included.
    """

    def __init__(self, branch: Sequence[Wrap]) -> None:
        self._outer_radius = branch[0].outer_radius
        kept = self._well_spaced(branch)
        curvatures = np.array([self.contact_curvature(wrap.object_radius) for wrap in kept])
        differences = np.array([wrap.pressure for wrap in kept])
        self._curvatures: list[float] = curvatures.tolist()
        self._pressures: list[float] = differences.tolist()
        self._divided: list[list[float]] = [self._pressures]
        for k in range(1, min(NODES, len(kept))):
            differences = np.diff(differences) / (curvatures[k:] - curvatures[:-k])
            self._divided.append(differences.tolist())

    def contact_curvature(self, radius: float) -> float:
        """Return 1/(r_w + r_o) [1/m] for r_w [m]."""
        return 1.0 / (radius + self._outer_radius)

    def bracket_and_guess(self, target: float) -> tuple[float, float, float, float]:
        """Return what a search for a contact curvature [1/m] on the branch starts from.

        Returns:
            The pressures of the wraps next below and next above it in contact curvature [Pa], the
            pressure between them that is guessed [Pa], and the slope of the contact curvature
            there [1/(m Pa)].
        """
        curvatures, pressures = self._curvatures, self._pressures
        above = min(max(bisect_left(curvatures, target), 1), len(curvatures) - 1)
        low, high = pressures[above - 1], pressures[above]
        order = len(self._divided)
        first = min(max(above - order // 2, 0), len(curvatures) - order)
        guess, change = self._divided[-1][first], 0.0
        for k in range(order - 2, -1, -1):
            away = target - curvatures[first + k]
            change = change * away + guess
            guess = guess * away + self._divided[k][first]
        if (low <= guess <= high or high <= guess <= low) and change * (high - low) > 0.0:
            return low, high, guess, 1.0 / change
        change = (high - low) / (curvatures[above] - curvatures[above - 1])
        return low, high, low + change * (target - curvatures[above - 1]), 1.0 / change

    def _well_spaced(self, branch: Sequence[Wrap]) -> list[Wrap]:
        """Return the branch without those next to an end that are too near to it."""
        first, *inner, last = branch
        least = LEAST_GAP * abs(last.pressure - first.pressure) / (len(branch) - 1)
        apart = [
            wrap
            for wrap in inner
            if min(abs(wrap.pressure - first.pressure), abs(wrap.pressure - last.pressure)) > least
        ]
        return [first, *apart, last]
