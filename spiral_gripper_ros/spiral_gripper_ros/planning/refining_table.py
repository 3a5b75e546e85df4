# SPDX-License-Identifier: Apache-2.0
"""A table of grips over a range of radii, refined to an interpolation tolerance. No ROS."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from spiral_gripper_ros.planning.grip_table import (
    GripAnswer,
    GripEntry,
    blended_answer,
    blended_window,
    neighbors,
)

# Largest relative error of a force between two radii of the table.
TOLERANCE = 0.05
# Forces are compared at these multiples of the onset, and not below this part of the largest [1].
COMPARED_AT = (1.02, 1.1, 1.2)
NEGLIGIBLE = 0.05
# The table grows to so many times the radii that it begins with.
MOST_REFINED = 4
_FORCES = ("normal_force", "away", "towards", "down")
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
        self._entries: dict[float, GripEntry | None] = {}
        self._solved: list[float] = []
        self._errors: dict[_Pair, float] = {}

    def next_radius(self) -> float | None:
        """Return the radius to be solved next [m]; None: the table is done."""
        missing = [radius for radius in self._first if radius not in self._entries]
        if missing:
            middle = 0.5 * (len(self._first) - 1)
            return min(missing, key=lambda radius: abs(self._first.index(radius) - middle))
        if len(self._solved) >= MOST_REFINED * len(self._first):
            return None
        rough = [pair for pair in pairwise(self._solved) if self._is_rough(pair)]
        if not rough:
            return None
        low, high = max(rough, key=self._error)
        return math.sqrt(low * high)

    def added(self, radius: float, entry: GripEntry | None) -> RefiningTable:
        """Return the table with the grip on a radius [m] too; None: it is not held."""
        table = RefiningTable(self._first)
        table._entries = {**self._entries, radius: entry}
        table._solved = sorted(table._entries)
        table._errors = self._errors
        places = neighbors(self._solved, radius)
        if places is not None and len(table._entries) > len(self._first):
            pair = self._solved[places[0]], self._solved[places[1]]
            error = math.inf if entry is None else 0.5 * self._deviation(pair, radius, entry)
            table._errors = {**self._errors, (pair[0], radius): error, (radius, pair[1]): error}
        return table

    def answer(self, radius: float, tip_pressure: float, pressure: float) -> GripAnswer | None:
        """Return the grip on a radius where it is known within ``TOLERANCE``.

        The arguments are those of :func:`blended_answer`.
        """
        pair = self._around(radius)
        if pair is None or self._error(pair) > TOLERANCE:
            return None
        return blended_answer(pair, self._known(pair), radius, tip_pressure, pressure)

    def window(self, radius: float, tip_pressure: float) -> tuple[float, float, float] | None:
        """Return :func:`blended_window`, or None where it is not known."""
        pair = self._around(radius)
        if pair is None:
            return None
        return blended_window(pair, self._known(pair), radius, tip_pressure)

    def _around(self, radius: float) -> _Pair | None:
        """Return the two radii around one [m] if both are held."""
        places = neighbors(self._solved, radius)
        if places is None:
            return None
        pair = self._solved[places[0]], self._solved[places[1]]
        return pair if len(self._known(pair)) == len(pair) else None

    def _known(self, pair: _Pair) -> list[GripEntry]:
        return [entry for radius in pair if (entry := self._entries[radius]) is not None]

    def _error(self, pair: _Pair) -> float:
        return self._errors.get(pair, math.inf)

    def _is_rough(self, pair: _Pair) -> bool:
        return self._error(pair) > TOLERANCE and len(self._known(pair)) == len(pair)

    def _deviation(self, pair: _Pair, radius: float, entry: GripEntry) -> float:
        """Return how far two grips are off the one between them: the largest force's share."""
        figures, known = entry.figures, self._known(pair)
        if len(known) < len(pair):
            return math.inf
        largest = 0.0
        for multiple in COMPARED_AT:
            pressure = min(multiple * figures.onset_wrap, figures.top)
            exact = entry.answer(pressure, at_pose=False)
            blend = blended_answer(pair, known, radius, figures.tip_pressure, pressure)
            for name in _FORCES:
                force = getattr(exact, name)
                scale = max(force, NEGLIGIBLE * exact.normal_force)
                if scale > 0.0:
                    largest = max(largest, abs(getattr(blend, name) - force) / scale)
        return largest
