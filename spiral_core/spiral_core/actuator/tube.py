# SPDX-License-Identifier: Apache-2.0
"""The elastomer tube at rest, and the section properties that follow from its annulus."""

from __future__ import annotations

import math
from dataclasses import dataclass

from spiral_core.errors import InvalidInputError
from spiral_core.message import Message, Quantity
from spiral_core.validation import require_positive

# Largest dimension accepted [m]; a design for enormous objects may reach a thousand kilometers.
LARGEST = 1.0e9


@dataclass(frozen=True, slots=True)
class Tube:
    r"""An unstretched round tube of uniform wall.

    With inner radius :math:`r` and outer radius :math:`r_o = r + t`:

    .. math:: A = \pi (r_o^2 - r^2), \quad I = \frac{\pi}{4} (r_o^4 - r^4), \quad J = 2 I

    Args:
        inner_radius: radius of the bore r [m], > 0.
        wall_thickness: thickness of the wall t [m], > 0.
        length: unstretched length L [m], > 0.

    Raises:
        InvalidInputError: a dimension is not positive, or larger than ``LARGEST``.

    Example:
        >>> tube = Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5)
        >>> round(tube.outer_radius * 1e3, 5), round(tube.wall_area * 1e6, 3)
        (5.55625, 25.731)
    """

    inner_radius: float
    wall_thickness: float
    length: float

    def __post_init__(self) -> None:
        for field in ("inner_radius", "wall_thickness", "length"):
            value = require_positive(field, getattr(self, field))
            if not value <= LARGEST:
                most = Message("at most {}", Quantity(LARGEST, "m"))
                raise InvalidInputError(field, value, most, "m")

    @property
    def outer_radius(self) -> float:
        """Outer radius r + t [m]."""
        return self.inner_radius + self.wall_thickness

    @property
    def wall_area(self) -> float:
        """Cross-sectional area of the elastomer [m^2]."""
        return math.pi * self.wall_thickness * (self.inner_radius + self.outer_radius)

    @property
    def second_moment_of_area(self) -> float:
        """Second moment of the annulus about a diameter, I [m^4]."""
        return 0.25 * self.wall_area * (self.inner_radius**2 + self.outer_radius**2)

    @property
    def polar_moment_of_area(self) -> float:
        """Polar moment of the annulus about the axis, J = 2 I [m^4]."""
        return 2.0 * self.second_moment_of_area
