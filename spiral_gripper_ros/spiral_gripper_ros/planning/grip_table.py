# SPDX-License-Identifier: Apache-2.0
"""Grips of some radii, and grips interpolated between them within a tolerance. No ROS."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from spiral_gripper_ros.planning.grip_figures import FORCES, GripAnswer, GripFigures, regime_at

# Largest relative error of a force between two radii of the table.
TOLERANCE = 0.05
# Forces are compared at these multiples of the onset, and not below this part of the largest [1].
COMPARED_AT = (1.02, 1.1, 1.2)
NEGLIGIBLE = 0.05
# The table grows to so many times the radii that it begins with.
MOST_REFINED = 4
_Pair = tuple[float, float]


class RefiningTable:
    """Grips of some radii, and grips interpolated between them within the tolerance.

    First come the radii that are given, the middle first. Then the middle between each two is
    solved too: how far the two are off there, halved, is the error that is expected of either
    half; linear in the radius, it would fall to a quarter. The worst pair is halved next, until all
    keep ``TOLERANCE`` or the table is full. A table never changes, so that any thread may read it.

    Args:
        radii: to begin with [m], in order.
    """

    def __init__(self, radii: Sequence[float] = ()) -> None:
        self._first = tuple(radii)
        self._grips: dict[float, GripFigures | None] = {}
        self._solved: list[float] = []
        self._errors: dict[_Pair, float] = {}

    def next_radius(self) -> float | None:
        """Return the radius to be solved next [m]; None: the table is done."""
        missing = [radius for radius in self._first if radius not in self._grips]
        if missing:
            middle = 0.5 * (len(self._first) - 1)
            return min(missing, key=lambda radius: abs(self._first.index(radius) - middle))
        pairs = [pair for pair in pairwise(self._solved) if self._known(pair)]
        worst = max(pairs, key=self._error, default=None)
        is_full = len(self._solved) >= MOST_REFINED * len(self._first)
        if is_full or worst is None or self._error(worst) <= TOLERANCE:
            return None
        return math.sqrt(worst[0] * worst[1])

    def added(self, radius: float, grip: GripFigures | None) -> RefiningTable:
        """Return the table with the grip on a radius [m] too; None: it is not held."""
        table, pair = RefiningTable(self._first), self._around(radius)
        table._grips = {**self._grips, radius: grip}
        table._solved = sorted(table._grips)
        table._errors = self._errors
        if pair is not None and len(table._grips) > len(self._first):
            error = 0.5 * self._deviation(pair, radius, grip)
            table._errors = {**self._errors, (pair[0], radius): error, (radius, pair[1]): error}
        return table

    def answer(self, radius: float, tip_pressure: float, pressure: float) -> GripAnswer | None:
        """Return the grip on a radius at a pressure where it is known within ``TOLERANCE``.

        Args:
            radius: of the object [m].
            tip_pressure: of its wrap by the tip criterion [Pa].
            pressure: gauge [Pa].
        """
        pair = self._around(radius)
        if pair is None or self._error(pair) > TOLERANCE or not self._known(pair):
            return None
        return Blend(pair, self._known(pair), radius, tip_pressure).answer(pressure)

    def window(self, radius: float, tip_pressure: float) -> tuple[float, float, float] | None:
        """Return :attr:`Blend.window` of a radius [m], or None where it is not known."""
        pair = self._around(radius)
        if pair is None or not self._known(pair):
            return None
        return Blend(pair, self._known(pair), radius, tip_pressure).window

    def _around(self, radius: float) -> _Pair | None:
        """Return the two solved radii around one [m], or None if it is outside of them."""
        radii = self._solved
        if len(radii) < 2 or not radii[0] <= radius <= radii[-1]:
            return None
        upper = min(max(bisect_right(radii, radius), 1), len(radii) - 1)
        return radii[upper - 1], radii[upper]

    def _known(self, pair: _Pair) -> list[GripFigures]:
        """Return the grips of two radii; none if one of them is not held."""
        grips = [grip for radius in pair if (grip := self._grips[radius]) is not None]
        return grips if len(grips) == len(pair) else []

    def _error(self, pair: _Pair) -> float:
        return self._errors.get(pair, math.inf)

    def _deviation(self, pair: _Pair, radius: float, grip: GripFigures | None) -> float:
        """Return how far two grips are off the one between them: the largest force's share."""
        known, largest = self._known(pair), 0.0
        if grip is None or not known:
            return math.inf
        for multiple in COMPARED_AT:
            pressure = min(multiple * grip.onset_wrap, grip.top)
            exact = grip.answer(pressure, at_pose=False)
            blend = Blend(pair, known, radius, grip.tip_pressure).answer(pressure)
            for name in FORCES[1:]:
                force = getattr(exact, name)
                scale = max(force, NEGLIGIBLE * exact.normal_force)
                if scale > 0.0:
                    largest = max(largest, abs(getattr(blend, name) - force) / scale)
        return largest


class Blend:
    """The grip on a radius between two that are solved.

    Pressures are compared as multiples of the pressure of each radius's wrap by the tip criterion,
    which takes most of the difference out; what is left is linear in the radius. Where only one of
    the two loses the grip or curls, that one counts.

    Args:
        radii: the two [m], in order.
        grips: on them.
        radius: between them [m].
        tip: its own pressure by the tip criterion [Pa].
    """

    def __init__(
        self, radii: Sequence[float], grips: Sequence[GripFigures], radius: float, tip: float
    ) -> None:
        part = (radius - radii[0]) / (radii[1] - radii[0])
        self._weights, self._grips = (1.0 - part, part), grips
        self._scales = [tip / grip.tip_pressure for grip in grips]

    @property
    def window(self) -> tuple[float, float, float]:
        """Where good grips begin and end, and where the grip is lost [Pa]; inf: nowhere."""
        return self._end("onset_wrap"), self._end("highest_good"), self._end("loss")

    def answer(self, pressure: float) -> GripAnswer:
        """Return the grip at a pressure [Pa]."""
        onset, _, loss = self.window
        curling, forces = self._end("onset_curling"), {}
        if pressure < loss:
            low, high = (
                grip.forces(pressure / scale)
                for grip, scale in zip(self._grips, self._scales, strict=True)
            )
            forces = {name: self._mean(low[name], high[name]) for name in low}
        return GripAnswer(
            at_pose=False,
            computed_at=min(grip.computed_at for grip in self._grips),
            friction=self._grips[0].friction,
            onset_wrap=onset,
            onset_curling=curling,
            loss=loss,
            regime=regime_at(pressure, onset, curling, loss),
            **forces,
        )

    def _end(self, name: str) -> float:
        """Return one of the pressures at which a grip changes [Pa]."""
        low, high = (
            scale * float(getattr(grip, name))
            for grip, scale in zip(self._grips, self._scales, strict=True)
        )
        return min(low, high) if math.isinf(low) or math.isinf(high) else self._mean(low, high)

    def _mean(self, low: float, high: float) -> float:
        return self._weights[0] * low + self._weights[1] * high


def table_radii(smallest: float, largest: float, count: int) -> tuple[float, ...]:
    """Return radii [m] from end to end of a range, evenly spaced in their logarithm.

    Example:
        >>> [round(radius, 4) for radius in table_radii(0.01, 0.04, 3)]
        [0.01, 0.02, 0.04]
    """
    return tuple(float(radius) for radius in np.geomspace(smallest, largest, count))
