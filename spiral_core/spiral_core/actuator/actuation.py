# SPDX-License-Identifier: Apache-2.0
"""Pressure to unloaded shape and stiffness: by an actuator's mechanics, or from measurements."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence, Sized
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from spiral_core.actuator.actuator import ActuationModel, Actuator, PressureLaw, UnloadedShape
from spiral_core.actuator.curvature import shape_on_path
from spiral_core.actuator.curve import PressurePanels
from spiral_core.actuator.section import ShapePath, section_path, sideways_motion
from spiral_core.actuator.section_law import mean_energy_slope, useful_branch
from spiral_core.brief import brief_repr
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.message import Message, Quantity
from spiral_core.numerics.panels import rising_root
from spiral_core.numerics.roots import first_sign_change
from spiral_core.validation import (
    require_finite,
    require_kind,
    require_non_negative,
    require_positive,
    require_vector,
)

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

# Sizes at which the pressure is tabulated, besides the edges of its panels: brackets for the
# inverse, and where it stops rising. Enough to show every minimum of the slope for laws of up to
# three constants.
TABLE_NODES = 129


@dataclass(frozen=True, slots=True)
class FreeActuation:
    """Pressure to unloaded shape of a fiber-reinforced actuator, by its mechanical model.

    Implements :class:`~spiral_core.actuator.actuator.ActuationModel`. The actuator's
    ``pressure_law`` decides how the
    pressure follows from the stretch. Constructing one finds where the useful branch ends and
    tabulates it once; the section law keeps the states of the last fiber sets. Every call is then
    a few microseconds.

    Args:
        actuator: the actuator.

    Attributes:
        stretch_limit: stretch at the end of the useful branch, farthest from 1.
        pressure_limit: pressure there [Pa].
        limit: what ends the branch.
        size_limit: size of the deformation there; ``path`` and ``pressure`` are tabulated over it.

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
    size_limit: float = field(init=False, compare=False, repr=False)
    path: ShapePath = field(init=False, compare=False, repr=False)
    pressure: PressurePanels = field(init=False, compare=False, repr=False)
    _sizes: Sequence[float] = field(init=False, compare=False, repr=False)
    _pressures: Sequence[float] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        actuator = self.actuator
        require_kind("actuator", actuator, Actuator)
        path, pressure, end, limit = useful_branch(actuator)
        steps = TABLE_NODES - 1
        even = [end * (1.0 - (1.0 - k / steps) ** 2) for k in range(TABLE_NODES)]
        # The panels become narrow where the pressure bends, such as at rest, far from the end.
        sizes = sorted({*even, *(size for size in pressure.work.inner if size < end)})
        table = {size: pressure.with_slope(size) for size in sizes}
        modulus = actuator.material.small_strain_modulus
        if not all(map(math.isfinite, (modulus, *(value for value, _ in table.values())))):
            raise InvalidInputError(
                "material", actuator.material, "a law that is finite as far as the fibers go"
            )
        if not min(table[0.0][1], modulus) > 0.0:
            raise InvalidInputError(
                "material", actuator.material, "a law whose pressure rises with the stretch at rest"
            )
        peak = first_sign_change(
            lambda size: (table.get(size) or pressure.with_slope(size))[1], sizes
        )
        if peak is not None:
            limit = ActuationLimit.LIMIT_POINT
            sizes = [*(size for size in sizes if size < peak), peak]
            table[peak] = pressure.with_slope(peak)
        pressures = [table[size][0] for size in sizes]
        for name, value in (
            ("stretch_limit", path.stretch_at(sizes[-1])),
            ("pressure_limit", pressures[-1]),
            ("limit", limit),
            ("size_limit", sizes[-1]),
            ("path", path),
            ("pressure", pressure),
            ("_sizes", sizes),
            ("_pressures", pressures),
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
        pressure = self.pressure.with_slope(self._size_from_stretch(stretch))[0]
        # On the branch the pressure lies between these bounds; its rounding may not.
        return min(max(pressure, 0.0), self.pressure_limit)

    def stretch_from_pressure(self, pressure: float) -> float:
        """Return the axial stretch at a gauge pressure [Pa], on the useful branch.

        Args:
            pressure: gauge pressure [Pa], 0 <= pressure <= pressure_limit.

        Returns:
            The stretch, to rounding; exactly 1 at zero pressure.

        Raises:
            InvalidInputError: ``pressure`` is negative or not finite.
            ActuationLimitError: ``pressure`` is past ``pressure_limit``.
        """
        return self.path.stretch_at(self.size_from_pressure(pressure))

    def unloaded_shape(self, pressure: float) -> UnloadedShape:
        """Return the unloaded shape at a gauge pressure [Pa]; raises as the stretch does."""
        return shape_on_path(self.actuator, self.path, self.size_from_pressure(pressure))

    def unloaded_shape_from_stretch(self, stretch: float) -> UnloadedShape:
        """Return the unloaded shape at a stretch of the useful branch; raises as the pressure does.

        Args:
            stretch: axial stretch from 1 to ``stretch_limit``.
        """
        return shape_on_path(self.actuator, self.path, self._size_from_stretch(stretch))

    def size_from_pressure(self, pressure: float) -> float:
        r"""Return the size of the deformation at a gauge pressure [Pa]: Newton's method.

        On :math:`P(x) = P` inside a bracket that shrinks with every evaluation, until the error
        left by the last step is below rounding.
        """
        pressure = _in_range(self, pressure)
        sizes, table = self._sizes, self._pressures
        cell = bisect_right(table, pressure) - 1
        low, below = sizes[cell], table[cell]
        if below == pressure or cell == len(table) - 1:
            return low
        high = sizes[cell + 1]
        start = low + (high - low) * (pressure - below) / (table[cell + 1] - below)
        return rising_root(self.pressure.with_slope, pressure, low, high, start)

    def _size_from_stretch(self, stretch: float) -> float:
        """Return the size at a stretch of the useful branch, or raise."""
        stretch = require_finite("stretch", stretch)
        end = self.stretch_limit
        if end > 1.0 and not stretch >= 1.0:
            raise InvalidInputError("stretch", stretch, "at least 1 (pressure extends the tube)")
        if end < 1.0 and not stretch <= 1.0:
            raise InvalidInputError("stretch", stretch, "at most 1 (pressure shortens the tube)")
        if not abs(stretch - 1.0) <= abs(end - 1.0):
            raise ActuationLimitError(self.limit, "stretch", stretch, end)
        return self.size_limit if stretch == end else self.path.strain_from_stretch(stretch)


def _in_range(actuation: ActuationModel, pressure: float) -> float:
    """Return a pressure of an actuation's range, or raise."""
    pressure = require_non_negative("pressure", pressure)
    if not pressure <= actuation.pressure_limit:
        raise ActuationLimitError(actuation.limit, "pressure", pressure, actuation.pressure_limit)
    return pressure


# The interpolating cubic needs at least three points to differ from a straight line.
POINTS_MIN = 3


@dataclass(frozen=True, slots=True)
class MeasuredActuation:
    r"""Measured :math:`\kappa(P)` and :math:`\tau(P)`, interpolated without overshoot.

    Implements :class:`~spiral_core.actuator.actuator.ActuationModel`. Between two points the
    interpolating cubic is
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

    __repr__ = brief_repr

    pressures: Sequence[float]
    curvatures: Sequence[float]
    torsions: Sequence[float]
    backbone_length: float
    _interpolant: PchipInterpolator = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        from scipy.interpolate import PchipInterpolator

        given: object = self.pressures
        count = len(given) if isinstance(given, Sized) else 0
        if not count >= POINTS_MIN:
            raise InvalidInputError("pressures", count, f"at least {POINTS_MIN} points")
        for name in ("pressures", "curvatures", "torsions"):
            object.__setattr__(self, name, require_vector(name, getattr(self, name), count))
        require_positive("backbone_length", self.backbone_length)
        if not (self.pressures[0] == 0.0 and all(a < b for a, b in pairwise(self.pressures))):
            raise InvalidInputError("pressures", self.pressures, "rising, and the first 0")
        require_non_negative("curvatures", self.curvatures[0])
        points = pairwise(zip(self.pressures, self.curvatures, strict=True))
        for (below, curvature), (above, higher) in points:
            if higher < curvature:
                requirement = Message(
                    "never falling: at {} no smaller than at {}",
                    Quantity(above, "Pa"),
                    Quantity(below, "Pa"),
                )
                raise InvalidInputError("curvatures", higher, requirement, "rad/m")
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
        curvature, torsion = self._interpolant(_in_range(self, pressure))
        return UnloadedShape(float(curvature), float(torsion), self.backbone_length)


# Less change of the torsion with the far side's strain than this is rounding.
NO_TWIST = 1e-9
# At rest the stiffness is that at this strain of the far side: sideways it is 0 by 0.
LEAST_STRAIN = 1e-6


@dataclass(frozen=True, slots=True)
class SectionStiffness:
    """Stiffness of a section at fixed pressure, per unstretched length, by the section law.

    Fibers that do not stretch leave bending in its own plane and twist one motion together.

    Attributes:
        bending: moment over curvature, the twist left free [N m^2].
        torsional: torque over twist, the curvature left free [N m^2]; infinite without twist.
        twist_per_curvature: how far it twists as it bends.
        sideways: out of that plane [N m^2]; infinite with two single fibers.
    """

    bending: float
    torsional: float
    twist_per_curvature: float
    sideways: float


def section_stiffness(actuation: FreeActuation, pressure: float) -> SectionStiffness:
    r"""Return the stiffness at a pressure [Pa] from 0 to the actuator's limit.

    At fixed pressure the energy less the pressure's work rises by half
    :math:`\pi a^2 L \, P'(y) v'(y)` times the square of a change of y, so that the bending
    stiffness is :math:`\pi a^4 P' v' / \kappa_n'^2` with :math:`\kappa_n = a \hat\kappa`. Bent
    sideways, the fiber leaves the plane of the coil by an angle, whose cosine c the energy
    less the work, per :math:`\pi a^2 L`, depends on:
    :math:`-\pi a^4 (d\Phi/dc) / \kappa_n^2`.

    Raises:
        InvalidInputError: it has one wound family, no single fiber, or the uniform law.
    """
    actuator = actuation.actuator
    if actuator.pressure_law is not PressureLaw.SECTION:
        requirement = "section: the even wall of the uniform law has no stiffness of its own"
        raise InvalidInputError("pressure_law", actuator.pressure_law.value, requirement)
    actuator.fiber_pair  # noqa: B018 - refuses one family
    if not actuator.single_fibers:
        raise InvalidInputError("single_fibers", (), "one that makes the section bend")
    path = section_path(actuator.fiber_set)
    size = max(actuation.size_from_pressure(pressure), LEAST_STRAIN)
    volume = path.volume_slope(size)
    curvature, curvature_slope = path.curvature.with_slope(size)
    torsion, torsion_slope = path.torsion.with_slope(size)
    bend, twist = curvature + size * curvature_slope, torsion + size * torsion_slope
    held, slope = actuation.pressure.with_slope(size)
    rise = math.pi * actuator.wound_radius**4 * slope * volume
    torsional = rise / twist**2 if abs(twist) > NO_TWIST else math.inf
    sideways = math.inf
    if len(actuator.single_fibers) == 1:
        motion = sideways_motion(path.fibers, np.array([path.direction * size]))
        wall = actuator.tube.wall_area / (math.pi * actuator.wound_radius**2)
        energy = wall * float(mean_energy_slope(motion, actuator.material)[0])
        work = held * float(motion.volume_slope[0])
        sideways = math.pi * actuator.wound_radius**4 * (work - energy) / (size * curvature) ** 2
    return SectionStiffness(rise / bend**2, torsional, twist / bend, sideways)
