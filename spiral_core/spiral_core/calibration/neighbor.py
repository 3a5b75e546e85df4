"""An actuation model beside another one: for derivatives, without searching the branch again."""

from __future__ import annotations

from dataclasses import dataclass

from spiral_core.actuator.actuator import Actuator
from spiral_core.actuator.curvature import rest_shape_from_stretch
from spiral_core.actuator.free import FreeActuation, InversionStatus
from spiral_core.actuator.interface import RestShape
from spiral_core.actuator.pressure import pressure_point
from spiral_core.errors import ActuationLimit, SolverError

# Newton's method from a stretch that is off by a ten-thousandth ends in three or four steps.
ITERATIONS_MAX = 20
# Relative change of the stretch at which it ends; as the method converges quadratically, what is
# left is rounding, which near a limit is more than one unit.
STRETCH_TOLERANCE = 1e-12


@dataclass(frozen=True, slots=True)
class NeighborActuation:
    """The actuation of an actuator that differs little from one whose branch is known.

    Implements :class:`spiral_core.ActuationModel`. Constructing one costs nothing; a pressure is
    inverted by Newton's method from the known actuator's stretch.

    Args:
        known: the actuation beside it.
        actuator: tube and fibers as those of ``known``, with slightly other constants.

    Example:
        >>> import math
        >>> from dataclasses import replace
        >>> from spiral_core import FiberAngles, NeoHookean, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=NeoHookean(c1=100.0e3),
        ... )
        >>> stiffer = replace(actuator, material=NeoHookean(c1=100.1e3))
        >>> near = NeighborActuation(FreeActuation(actuator), stiffer)
        >>> exact = FreeActuation(stiffer).stretch_from_pressure(50.0e3)
        >>> abs(near.stretch_from_pressure(50.0e3) - exact) < 1e-12
        True
    """

    known: FreeActuation
    actuator: Actuator

    @property
    def pressure_limit(self) -> float:
        """The known actuator's limit [Pa]."""
        return self.known.pressure_limit

    @property
    def limit(self) -> ActuationLimit:
        """What ends the known actuator's range."""
        return self.known.limit

    def stretch_from_pressure(self, pressure: float) -> float:
        """Return the axial stretch at a gauge pressure [Pa].

        Raises:
            InvalidInputError: ``pressure`` is negative or not finite.
            ActuationLimitError: ``pressure`` is past ``pressure_limit``.
            SolverError: this actuator does not reach the pressure near the known one's stretch.
        """
        stretch = self.known.stretch_from_pressure(pressure)
        if pressure == 0.0:
            return stretch
        residual = float("inf")
        for _ in range(ITERATIONS_MAX):
            point = pressure_point(self.actuator, stretch)
            residual = point.pressure - pressure
            if not point.slope > 0.0:
                break
            step = residual / point.slope
            stretch -= step
            if not stretch > 1.0:
                break
            if abs(step) <= STRETCH_TOLERANCE * stretch:
                return stretch
        raise SolverError(InversionStatus.ITERATION_LIMIT, residual, ITERATIONS_MAX)

    def rest_shape(self, pressure: float) -> RestShape:
        """Return the unloaded shape at a gauge pressure [Pa]; raises as the stretch does."""
        return rest_shape_from_stretch(self.actuator, self.stretch_from_pressure(pressure))
