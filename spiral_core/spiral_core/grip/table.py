# SPDX-License-Identifier: Apache-2.0
"""Grips of some radii of a gripper, and grips interpolated between them within a tolerance."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from spiral_core.errors import InvalidInputError
from spiral_core.grip.curve import FORCES, GripAnswer, GripCurve, regime_at
from spiral_core.rod.types import Vector

# Largest relative error of a force between two radii of the table.
TOLERANCE = 0.05
# Where radii are held is located to this part of a radius.
EDGE = 0.01
# Radii that are nearer than this part of them are not halved: a force jumps between them.
JUMP = 1e-3
# Forces are compared at these multiples of the onset, and not below this part of the largest [1].
COMPARED_AT = (1.02, 1.1, 1.2)
NEGLIGIBLE = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class GripTable:
    """Grips of some radii of one gripper, and grips interpolated between two of them.

    The error expected between two radii is half of how far they were off the grip in their middle:
    linear in the radius, it would fall to a quarter.

    Args:
        radii: (n,) [m], increasing, at least two.
        grips: on them (n,); None: not held.
        errors: expected of the largest force between each two (n - 1,) [1]; inf: not known.
        gravity: that they are for, in the base frame [m/s^2].
        rate: of the ramps that the settling times follow [Pa/s].
        computed_at: when, or when it was read [s].

    Raises:
        InvalidInputError: the radii do not increase, or there are not as many values as radii.
    """

    radii: tuple[float, ...]
    grips: tuple[GripCurve | None, ...]
    errors: tuple[float, ...]
    gravity: Vector
    rate: float
    computed_at: float = 0.0

    def __post_init__(self) -> None:
        count = len(self.radii)
        if count < 2 or not all(b > a for a, b in pairwise((0.0, *self.radii))):
            raise InvalidInputError("radii", self.radii, "at least two, above 0 and increasing")
        if (len(self.grips), len(self.errors)) != (count, count - 1):
            found = (len(self.grips), len(self.errors))
            raise InvalidInputError("grips, errors", found, f"{count} and {count - 1} values")

    def answer(self, radius: float, tip_pressure: float, pressure: float) -> GripAnswer | None:
        """Return the grip on a radius at a pressure where it is known within ``TOLERANCE``.

        Args:
            radius: of the object [m].
            tip_pressure: of its wrap by the tip criterion [Pa].
            pressure: gauge [Pa].
        """
        pair = self._around(radius)
        blend = self._blend(pair, radius, tip_pressure)
        if blend is None or not self.errors[pair] <= TOLERANCE:
            return None
        return replace(blend.answer(pressure), computed_at=self.computed_at)

    def window(self, radius: float, tip_pressure: float) -> tuple[float, float, float] | None:
        """Return :attr:`Blend.window` of a radius [m], or None where it is not known."""
        blend = self._blend(self._around(radius), radius, tip_pressure)
        return None if blend is None else blend.window

    def is_not_held(self, radius: float) -> bool:
        """Return whether a radius [m] is not held, or next to one of the table that is not."""
        below, above = bisect_right(self.radii, radius) - 1, bisect_left(self.radii, radius)
        return None in self.grips[max(below, 0) : above + 1]

    @property
    def held(self) -> list[float]:
        """The radii of the table that are held [m], rising."""
        return [own for own, grip in zip(self.radii, self.grips, strict=True) if grip is not None]

    def nearest_held(self, radius: float) -> float | None:
        """Return the radius of the table that is held and nearest to one [m], if any is."""
        return min(self.held, key=lambda own: abs(own - radius), default=None)

    def poor(self, most: int) -> list[int]:
        """Return the pairs of radii that a radius between them improves, the worst first.

        Both are held, off by more than ``TOLERANCE`` and more than ``JUMP`` apart, or one is not
        held and more than ``EDGE`` away.

        Args:
            most: how many at most.
        """
        pairs = [pair for pair in range(len(self.errors)) if self._is_poor(pair)]
        return sorted(pairs, key=lambda pair: -self.errors[pair])[: max(most, 0)]

    def _is_poor(self, pair: int) -> bool:
        after = pair + 2
        is_held = [grip is not None for grip in self.grips[pair:after]]
        low, high = self.radii[pair:after]
        if all(is_held):
            return self.errors[pair] > TOLERANCE and high > (1.0 + JUMP) * low
        return any(is_held) and high > (1.0 + EDGE) * low

    def halved(self, pair: int, radius: float, grip: GripCurve | None) -> GripTable:
        """Return the table with one more grip, on a radius between a pair [m]; None: not held."""
        after, error = pair + 1, 0.5 * self._deviation(pair, radius, grip)
        return replace(
            self,
            radii=(*self.radii[:after], radius, *self.radii[after:]),
            grips=(*self.grips[:after], grip, *self.grips[after:]),
            errors=(*self.errors[:pair], error, error, *self.errors[after:]),
        )

    def _around(self, radius: float) -> int:
        """Return the pair that is around a radius [m], or next to it."""
        after = min(max(bisect_right(self.radii, radius), 1), len(self.radii) - 1)
        at_end = self.grips[after] is None and after > 1 and radius == self.radii[after - 1]
        return after - 1 - at_end

    def _blend(self, pair: int, radius: float, tip_pressure: float) -> Blend | None:
        """Return the grip between a pair; None outside of it, or where one is not held."""
        (low, high), (one, other) = self.radii[pair : pair + 2], self.grips[pair : pair + 2]
        if one is None or other is None or not low <= radius <= high:
            return None
        return Blend((low, high), (one, other), radius, tip_pressure)

    def _deviation(self, pair: int, radius: float, grip: GripCurve | None) -> float:
        """Return how far a pair is off the grip between: the largest force's share."""
        blend = None if grip is None else self._blend(pair, radius, grip.tip_pressure)
        if grip is None or blend is None:
            return math.inf
        largest = 0.0
        for multiple in COMPARED_AT:
            pressure = min(multiple * grip.onset_wrap, grip.top)
            exact, blended = grip.answer(pressure, at_pose=False), blend.answer(pressure)
            for name in FORCES[1:]:
                force = getattr(exact, name)
                scale = max(force, NEGLIGIBLE * exact.normal_force)
                if scale > 0.0:
                    largest = max(largest, abs(getattr(blended, name) - force) / scale)
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
        self, radii: Sequence[float], grips: Sequence[GripCurve], radius: float, tip: float
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
            computed_at=0.0,
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
