# SPDX-License-Identifier: Apache-2.0
"""Pressure to unloaded shape: by an actuator's mechanics, or interpolated from measurements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from spiral_core.actuator.actuator import Actuator, PressureLaw, UnloadedShape
from spiral_core.actuator.curve import ActuationCurve
from spiral_core.actuator.section_law import section_curve
from spiral_core.actuator.uniform_law import uniform_curve
from spiral_core.brief import brief_repr
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.validation import (
    require_finite,
    require_non_negative,
    require_positive,
    require_vector,
)

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator


@dataclass(frozen=True, slots=True)
class FreeActuation:
    """Pressure to unloaded shape of a fiber-reinforced actuator, by its mechanical model.

    Implements :class:`spiral_core.ActuationModel`. The actuator's ``pressure_law`` decides how the
    pressure follows from the stretch. Constructing one finds where the useful branch ends and
    tabulates it once; the section law keeps the states of the last fiber sets. Every call is then
    a few microseconds.

    Args:
        actuator: the actuator.

    Attributes:
        stretch_limit: stretch at the end of the useful branch, farthest from 1.
        pressure_limit: pressure there [Pa].
        limit: what ends the branch.

    Raises:
        InvalidInputError: pressure would not move this actuator as its fibers can hold.

    Example:
        >>> import math
        >>> from spiral_core import FiberAngles, MooneyRivlin, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=MooneyRivlin(c1=130.0e3, c2=15.0e3),
        ... )
        >>> actuation = FreeActuation(actuator)
        >>> shape = actuation.unloaded_shape(pressure=55.0e3)
        >>> round(shape.curvature, 3), round(shape.torsion, 3)
        (20.365, -13.276)
    """

    __repr__ = brief_repr

    actuator: Actuator
    stretch_limit: float = field(init=False, compare=False)
    pressure_limit: float = field(init=False, compare=False)
    limit: ActuationLimit = field(init=False, compare=False)
    curve: ActuationCurve = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.actuator, Actuator):
            raise InvalidInputError("actuator", self.actuator, "an Actuator")
        uniform = self.actuator.pressure_law is PressureLaw.UNIFORM
        curve = uniform_curve(self.actuator) if uniform else section_curve(self.actuator)
        for name, value in (
            ("stretch_limit", curve.stretch_limit),
            ("pressure_limit", curve.pressure_limit),
            ("limit", curve.limit),
            ("curve", curve),
        ):
            object.__setattr__(self, name, value)

    def pressure_from_stretch(self, stretch: float) -> float:
        """Return the gauge pressure [Pa] at a stretch of the useful branch.

        Args:
            stretch: axial stretch from 1 to ``stretch_limit``.

        Raises:
            InvalidInputError: ``stretch`` is not on the branch's side of 1 or not finite.
            ActuationLimitError: ``stretch`` is past ``stretch_limit``.
        """
        pressure = self.curve.pressure_from_stretch(self._on_branch(stretch))
        # On the branch the pressure lies between these bounds; its rounding may not.
        return min(max(pressure, 0.0), self.pressure_limit)

    def stretch_from_pressure(self, pressure: float) -> float:
        r"""Return the axial stretch at a gauge pressure, on the useful branch.

        Newton's method on :math:`P(\lambda_1) = P` inside a bracket that shrinks with every
        evaluation, until the error left by the last step is below rounding.

        Args:
            pressure: gauge pressure [Pa], 0 <= pressure <= pressure_limit.

        Returns:
            The stretch, to rounding; exactly 1 at zero pressure.

        Raises:
            InvalidInputError: ``pressure`` is negative or not finite.
            ActuationLimitError: ``pressure`` is past ``pressure_limit``.
        """
        return self.curve.stretch_from_pressure(self._in_range(pressure))

    def unloaded_shape(self, pressure: float) -> UnloadedShape:
        """Return the unloaded shape at a gauge pressure [Pa], 0 <= pressure <= pressure_limit.

        Raises:
            InvalidInputError: ``pressure`` is negative or not finite.
            ActuationLimitError: ``pressure`` is past ``pressure_limit``.
        """
        return self.curve.unloaded_shape(self._in_range(pressure))

    def unloaded_shape_from_stretch(self, stretch: float) -> UnloadedShape:
        """Return the unloaded shape at a stretch of the useful branch; raises as the pressure does.

        Args:
            stretch: axial stretch from 1 to ``stretch_limit``.
        """
        return self.curve.unloaded_shape_from_stretch(self._on_branch(stretch))

    def _in_range(self, pressure: float) -> float:
        """Return a pressure of the useful range, or raise."""
        pressure = require_non_negative("pressure", pressure)
        if not pressure <= self.pressure_limit:
            raise ActuationLimitError(self.limit, "pressure", pressure, self.pressure_limit)
        return pressure

    def _on_branch(self, stretch: float) -> float:
        """Return a stretch of the useful branch, or raise."""
        stretch = require_finite("stretch", stretch)
        end = self.stretch_limit
        if end > 1.0 and not stretch >= 1.0:
            raise InvalidInputError("stretch", stretch, "at least 1 (pressure extends the tube)")
        if end < 1.0 and not stretch <= 1.0:
            raise InvalidInputError("stretch", stretch, "at most 1 (pressure shortens the tube)")
        if not abs(stretch - 1.0) <= abs(end - 1.0):
            raise ActuationLimitError(self.limit, "stretch", stretch, end)
        return stretch


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
