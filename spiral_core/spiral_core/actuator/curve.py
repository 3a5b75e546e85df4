# SPDX-License-Identifier: Apache-2.0
r"""An actuator's curve: from pressure to stretch and unloaded shape on the useful branch.

Both pressure laws tabulate the actuator once, over a size x of its deformation that is 0 at rest:
the far side's strain, or a measure of the elongation. With polynomials on panels

.. math:: P(x) = x \, \frac{W(x)}{V(x)}, \qquad \lambda_1 = 1 + x \, S(x), \qquad
    x \, W = \frac{V_t}{\pi a^2 L} \frac{du}{dx}, \quad V = \frac{dv}{dx}

the inverse, from a pressure to x, is Newton's method in a few evaluations. As each quantity is
tabulated over x, its relative accuracy near rest is that far from it.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import NamedTuple

from spiral_core.actuator.actuator import Actuator, CurvatureForm, UnloadedShape
from spiral_core.actuator.section import ShapePath
from spiral_core.errors import ActuationLimit, InvalidInputError
from spiral_core.numerics.panels import Panels, rising_root
from spiral_core.numerics.roots import first_sign_change

# Sizes at which the pressure is tabulated: brackets for the inverse, and where it stops rising.
# Enough to show every minimum of the slope for laws of up to three constants.
TABLE_NODES = 129


class PressurePanels(NamedTuple):
    """Pressure over the size x of the deformation, by virtual work: the elastomer's part.

    Attributes:
        work: W, derivative of the elastic energy over x and over the volume at rest [Pa].
        volume: V, derivative of the enclosed volume over that at rest.
    """

    work: Panels
    volume: Panels

    def with_slope(self, size: float) -> tuple[float, float]:
        """Return the pressure [Pa] at a size, and its derivative in it."""
        work, work_slope = self.work.with_slope(size)
        volume, volume_slope = self.volume.with_slope(size)
        quotient = work / volume
        slope = (work_slope - quotient * volume_slope) / volume
        return size * quotient, quotient + size * slope


class ActuationCurve:
    """Pressure, stretch and unloaded shape of one actuator.

    Args:
        actuator: the actuator.
        path: its shapes over the size, in its curvature form.
        pressure: its pressure over the size.
        end: size at which path or material end the curve.
        limit: why it ends there.

    Raises:
        InvalidInputError: the pressure does not rise at rest, or is not finite.

    Attributes:
        path, pressure: as given.
        size_limit: where the useful branch ends.
        stretch_limit: the stretch there.
        pressure_limit: the pressure there [Pa].
        limit: what ends it.
    """

    __slots__ = (
        "_carries_stretch", "_changes", "_length", "_pressures", "_radius", "_sizes", "limit",
        "path", "pressure", "pressure_limit", "size_limit", "stretch_limit",
    )  # fmt: skip

    def __init__(
        self,
        actuator: Actuator,
        path: ShapePath,
        pressure: PressurePanels,
        end: float,
        limit: ActuationLimit,
    ) -> None:
        self._length, self._radius = actuator.tube.length, actuator.wound_radius
        self._carries_stretch = actuator.curvature_form is CurvatureForm.EXACT
        self.path, self.pressure, self.limit = path, pressure, limit
        steps = TABLE_NODES - 1
        sizes = [end * (1.0 - (1.0 - k / steps) ** 2) for k in range(TABLE_NODES)]
        table = {size: pressure.with_slope(size) for size in sizes}
        if not all(math.isfinite(value) for value, _ in table.values()):
            raise InvalidInputError(
                "material", actuator.material, "a law that is finite as far as the fibers go"
            )
        if not table[0.0][1] > 0.0:
            raise InvalidInputError(
                "material", actuator.material, "a law whose pressure rises with the stretch at rest"
            )
        peak = first_sign_change(
            lambda size: (table.get(size) or pressure.with_slope(size))[1], sizes
        )
        if peak is not None:
            self.limit = ActuationLimit.LIMIT_POINT
            sizes = [*(size for size in sizes if size < peak), peak]
            table[peak] = pressure.with_slope(peak)
        self._sizes, self._pressures = sizes, [table[size][0] for size in sizes]
        self.size_limit, self.pressure_limit = sizes[-1], self._pressures[-1]
        stretches = [self._stretch_at(size) for size in sizes]
        self._changes = [abs(stretch - 1.0) for stretch in stretches]
        self.stretch_limit = stretches[-1]

    def pressure_from_stretch(self, stretch: float) -> float:
        """Return the pressure [Pa] at a stretch from 1 to ``stretch_limit``."""
        return self.pressure.with_slope(self._size_from_stretch(stretch))[0]

    def stretch_from_pressure(self, pressure: float) -> float:
        """Return the stretch at a pressure [Pa] from 0 to ``pressure_limit``."""
        return self._stretch_at(self.size_from_pressure(pressure))

    def unloaded_shape(self, pressure: float) -> UnloadedShape:
        """Return the unloaded shape at a pressure [Pa] from 0 to ``pressure_limit``."""
        return self._shape_at(self.size_from_pressure(pressure))

    def unloaded_shape_from_stretch(self, stretch: float) -> UnloadedShape:
        """Return the unloaded shape at a stretch from 1 to ``stretch_limit``."""
        return self._shape_at(self._size_from_stretch(stretch))

    def size_from_pressure(self, pressure: float) -> float:
        """Return the size of the deformation at a pressure [Pa] from 0 to ``pressure_limit``."""
        return self._solved(self.pressure.with_slope, self._pressures, pressure)

    def _size_from_stretch(self, stretch: float) -> float:
        return self._solved(self.path.change, self._changes, abs(stretch - 1.0))

    def _solved(
        self,
        function: Callable[[float], tuple[float, float]],
        table: Sequence[float],
        target: float,
    ) -> float:
        """Return the size at which a function, tabulated at the sizes, has a value."""
        cell = bisect_right(table, target) - 1
        low, below = self._sizes[cell], table[cell]
        if below == target or cell == len(table) - 1:
            return low
        high = self._sizes[cell + 1]
        start = low + (high - low) * (target - below) / (table[cell + 1] - below)
        return rising_root(function, target, low, high, start)

    def _stretch_at(self, size: float) -> float:
        return 1.0 + size * self.path.stretch(size)

    def _shape_at(self, size: float) -> UnloadedShape:
        """Return the unloaded shape at a size, on a backbone that stretches in the exact form."""
        path, stretch = self.path, self._stretch_at(size)
        carried = stretch if self._carries_stretch else 1.0
        scale = 1.0 / (self._radius * carried)
        return UnloadedShape(
            size * path.curvature(size) * scale,
            (path.fibers.single_slope + size * path.torsion(size)) * scale,
            carried * self._length,
            stretch,
        )


def clustered_nodes(end: float, count: int) -> list[float]:
    """Return ``count`` stretches from exactly 1 to exactly ``end``, denser towards the end.

    The distance to the end falls quadratically, as the curves near a limit bend like a square
    root.

    Example:
        >>> clustered_nodes(2.0, 3)
        [1.0, 1.75, 2.0]
    """
    steps = count - 1
    nodes = [end - (end - 1.0) * (1.0 - index / steps) ** 2 for index in range(count)]
    nodes[0], nodes[-1] = 1.0, end
    return nodes
