# SPDX-License-Identifier: Apache-2.0
r"""The fibers of a tube as the numbers that the section's kinematics needs.

In material coordinates along the single fibers and around the tube, the metric of the wall is

.. math:: M_{11} = 1 + T^2 + m, \quad M_{12} = T + z, \quad M_{22} = 1 + n, \quad T = \tan\gamma

A family at the angle :math:`\varphi` keeps its length if :math:`p^2 m + 2 p z + n = 0` with
:math:`p = 1 / (\tan\varphi - T)`: linear. Two families leave m alone free, with
:math:`z = -(p + q) m / 2` and :math:`n = p q m`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# float64, or complex128 while a derivative is taken by the complex step
Numbers = NDArray[Any]


@dataclass(frozen=True, slots=True)
class FiberSet:
    """The fibers of a section, checked by who builds it; hashable, as paths are cached by it.

    Args:
        slopes: p of each wound family (one or two).
        single_slope: T, tangent of the single fibers' angle; 0 without any.
        half_spread: single fibers lie at plus and minus this material angle [rad]; None: none.
        single_radius: their distance from the axis over the radius of the wound fibers.
        wall_ratio: inner radius over the radius of the wound fibers; None takes the wall as thin.
    """

    slopes: tuple[float, ...]
    single_slope: float = 0.0
    half_spread: float | None = 0.0
    single_radius: float = 1.0
    wall_ratio: float | None = None

    @property
    def is_bending(self) -> bool:
        """Whether there is a single fiber, which makes the section bend."""
        return self.half_spread is not None

    def wall_change(self, strain: Numbers, free: Numbers | None = None) -> tuple[Numbers, Numbers]:
        """Return z and n of the metric at a strain m; one family leaves z free, to be given."""
        if free is not None:
            (p,) = self.slopes
            return free, -p * (p * strain + 2.0 * free)
        p, q = self.slopes
        return -0.5 * (p + q) * strain, p * q * strain

    def collapse_strains(self) -> tuple[float, float]:
        """Return the strains m < 0 and m > 0 at which two families leave the wall no area."""
        p, q = self.slopes
        tangent = self.single_slope
        linear = 1.0 + p * q * (1.0 + tangent * tangent) + (p + q) * tangent
        square = 0.25 * (p - q) ** 2
        root = math.sqrt(linear * linear + 4.0 * square)
        # Neither root from a difference of what is nearly equal.
        large = 0.5 * (linear + math.copysign(root, linear)) / square
        other = -1.0 / (square * large)
        return min(large, other), max(large, other)


def family_slope(angle: float, single_slope: float) -> float:
    """Return p = 1/(tan(angle) - T), 0 for a hoop.

    Example:
        >>> family_slope(math.radians(45.0), 0.0).__round__(12), family_slope(math.pi / 2, 0.0)
        (1.0, 0.0)
    """
    cosine, sine = math.cos(angle), math.sin(angle)
    if abs(angle) == 0.5 * math.pi:
        cosine = 0.0
    return cosine / (sine - single_slope * cosine)
