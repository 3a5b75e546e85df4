# SPDX-License-Identifier: Apache-2.0
"""A measured actuation curve in place of a hyperelastic law: curvature and torsion by pressure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from spiral_core.actuator.interface import UnloadedShape
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.validation import require_non_negative, require_positive, require_vector

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

# The interpolating cubic needs at least three points to differ from a straight line.
POINTS_MIN = 3


@dataclass(frozen=True, slots=True)
class MeasuredActuation:
    r"""Measured :math:`\kappa(P)` and :math:`\tau(P)`, interpolated without overshoot.

    Implements :class:`spiral_core.ActuationModel`. Between two points the interpolating cubic is
    monotone wherever the data are (PCHIP), without overshoot; past the last point it raises.

    Args:
        pressures: gauge pressures [Pa], rising, the first 0.
        curvatures: at those pressures [1/m], >= 0 and never falling.
        torsions: at those pressures [1/m]; positive is right-handed.
        backbone_length: length of the backbone that the curvatures and torsions are per [m], > 0.

    Attributes:
        pressure_limit: the last pressure [Pa].
        limit: always ``DATA_END``.

    Raises:
        InvalidInputError: fewer than three points, lists of different length, or values that are
            not finite, not rising or falling.

    Source: F. N. Fritsch, J. Butland, SIAM Journal on Scientific and Statistical Computing 5, 1984,
    300-304 (as ``scipy.interpolate.PchipInterpolator``).

    Example:
        >>> actuation = MeasuredActuation(
        ...     pressures=(0.0, 20.0e3, 40.0e3, 60.0e3),
        ...     curvatures=(0.0, 8.0, 18.0, 30.0),
        ...     torsions=(0.0, -4.0, -9.0, -14.0),
        ...     backbone_length=0.36,
        ... )
        >>> shape = actuation.unloaded_shape(40.0e3)
        >>> shape.curvature, shape.torsion, shape.backbone_length
        (18.0, -9.0, 0.36)
    """

    pressures: Sequence[float]
    curvatures: Sequence[float]
    torsions: Sequence[float]
    backbone_length: float
    _interpolant: PchipInterpolator = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        from scipy.interpolate import PchipInterpolator

        count = len(self.pressures)
        if not count >= POINTS_MIN:
            raise InvalidInputError("pressures", count, f"at least {POINTS_MIN} points")
        for name in ("pressures", "curvatures", "torsions"):
            object.__setattr__(self, name, require_vector(name, getattr(self, name), count))
        require_positive("backbone_length", self.backbone_length)
        if not (self.pressures[0] == 0.0 and all(a < b for a, b in pairwise(self.pressures))):
            raise InvalidInputError("pressures", self.pressures, "rising, and the first 0")
        falling = any(a > b for a, b in pairwise(self.curvatures))
        if falling or not self.curvatures[0] >= 0.0:
            raise InvalidInputError(
                "curvatures", self.curvatures, "non-negative and never falling with the pressure"
            )
        values = np.column_stack((self.curvatures, self.torsions))
        interpolant = PchipInterpolator(self.pressures, values, extrapolate=False)
        object.__setattr__(self, "_interpolant", interpolant)

    @property
    def pressure_limit(self) -> float:
        """The last measured pressure [Pa]."""
        return self.pressures[-1]

    @property
    def limit(self) -> ActuationLimit:
        """The data end there."""
        return ActuationLimit.DATA_END

    def unloaded_shape(self, pressure: float) -> UnloadedShape:
        """Return the unloaded shape at a gauge pressure [Pa], 0 <= pressure <= pressure_limit.

        Raises:
            InvalidInputError: ``pressure`` is negative or not finite.
            ActuationLimitError: ``pressure`` is past the last measured one.
        """
        pressure = require_non_negative("pressure", pressure)
        if not pressure <= self.pressure_limit:
            raise ActuationLimitError(self.limit, "pressure", pressure, self.pressure_limit)
        curvature, torsion = self._interpolant(pressure)
        return UnloadedShape(float(curvature), float(torsion), self.backbone_length)
