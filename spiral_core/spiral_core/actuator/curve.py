# SPDX-License-Identifier: Apache-2.0
r"""What a pressure law finds of an actuator: shapes and pressure over the size of its deformation.

Both laws tabulate the actuator once, over a size x of its deformation that is 0 at rest: the far
side's strain. With polynomials on panels

.. math:: P(x) = x \, \frac{W(x)}{V(x)}, \qquad \lambda_1 = 1 + x \, S(x), \qquad
    x \, W = \frac{V_t}{\pi a^2 L} \frac{du}{dx}, \quad V = \frac{dv}{dx}

the inverse, from a pressure to x, is Newton's method in a few evaluations. As each quantity is
tabulated over x, its relative accuracy near rest is that far from it.
"""

from __future__ import annotations

from typing import NamedTuple

from spiral_core.actuator.section import ShapePath
from spiral_core.errors import ActuationLimit
from spiral_core.numerics.panels import Panels


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


class Branch(NamedTuple):
    """Shapes and pressures of one actuator from rest on.

    Attributes:
        path: its shapes over the size, in its curvature form.
        pressure: its pressure over the size.
        end: size at which path or material end the branch.
        limit: why it ends there.
    """

    path: ShapePath
    pressure: PressurePanels
    end: float
    limit: ActuationLimit
