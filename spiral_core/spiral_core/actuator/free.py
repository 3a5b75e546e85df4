"""A FREE actuator as an actuation model: pressure to stretch to rest shape, fast and exact."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from enum import Enum
from itertools import pairwise

from spiral_core.actuator.actuator import Actuator
from spiral_core.actuator.curvature import rest_shape_from_stretch
from spiral_core.actuator.interface import RestShape
from spiral_core.actuator.limits import clustered_nodes, find_useful_branch
from spiral_core.actuator.pressure import PressurePoint, pressure_point
from spiral_core.errors import (
    ActuationLimit,
    ActuationLimitError,
    InvalidInputError,
    SolverError,
)
from spiral_core.validation import require_finite, require_non_negative

# The table only supplies the first guess and a bracket; with this many nodes the cubic guess is so
# near that most inversions need two evaluations.
TABLE_NODES = 129

# Newton's error after a step is about step^2 / w, where dP/d lambda_1 varies over w: the width of
# the table's cell, or the distance to the branch's end. At this step over w it is below rounding.
CONVERGED_STEP = 1e-8

# Bisection alone would be done in 50 steps; the margin is for Newton steps that help little.
ITERATIONS_MAX = 100


class InversionStatus(Enum):
    """How the inversion of the pressure-stretch relation ended."""

    ITERATION_LIMIT = "the stretch for this pressure was not found; report the actuator's values"


@dataclass(frozen=True, slots=True)
class FreeActuation:
    """Pressure to rest shape of a fiber-reinforced actuator, by its mechanical model.

    Implements :class:`spiral_core.ActuationModel`. Constructing one finds where the useful branch
    ends and tabulates it once (a few milliseconds); every call is then a few microseconds.

    Args:
        actuator: the actuator.

    Attributes:
        stretch_limit: largest stretch of the useful branch.
        pressure_limit: pressure there [Pa].
        limit: what ends the branch.

    Raises:
        InvalidInputError: pressure would not extend this actuator.

    Example:
        >>> from spiral_core import FiberAngles, MooneyRivlin, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=MooneyRivlin(c1=130.0e3, c2=15.0e3),
        ... )
        >>> actuation = FreeActuation(actuator)
        >>> shape = actuation.rest_shape(pressure=55.0e3)
        >>> round(shape.curvature, 3), round(shape.torsion, 3)
        (30.349, -20.404)
    """

    actuator: Actuator
    stretch_limit: float = field(init=False, compare=False)
    pressure_limit: float = field(init=False, compare=False)
    limit: ActuationLimit = field(init=False, compare=False)
    _stretches: list[float] = field(init=False, compare=False, repr=False)
    _pressures: list[float] = field(init=False, compare=False, repr=False)
    _slopes: list[float] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.actuator, Actuator):
            raise InvalidInputError("actuator", self.actuator, "an Actuator")
        branch = find_useful_branch(self.actuator)
        stretches = clustered_nodes(branch.stretch_limit, TABLE_NODES)
        points = [pressure_point(self.actuator, stretch) for stretch in stretches]
        pressures = [point.pressure for point in points]
        if not all(low < high < math.inf for low, high in pairwise(pressures)):
            raise InvalidInputError(
                "actuator", self.actuator, "one whose pressure rises up to its stretch limit"
            )
        for name, value in (
            ("stretch_limit", branch.stretch_limit),
            ("pressure_limit", pressures[-1]),
            ("limit", branch.limit),
            ("_stretches", stretches),
            ("_pressures", pressures),
            ("_slopes", [point.slope for point in points]),
        ):
            object.__setattr__(self, name, value)

    def pressure_from_stretch(self, stretch: float) -> float:
        """Return the gauge pressure [Pa] at a stretch of the useful branch.

        Args:
            stretch: axial stretch, 1 <= stretch <= stretch_limit.

        Raises:
            InvalidInputError: ``stretch`` is below 1 or not finite.
            ActuationLimitError: ``stretch`` is past ``stretch_limit``.
        """
        if not require_finite("stretch", stretch) >= 1.0:
            raise InvalidInputError("stretch", stretch, "at least 1 (pressure extends the tube)")
        if not stretch <= self.stretch_limit:
            raise ActuationLimitError(self.limit, "stretch", stretch, self.stretch_limit)
        pressure = pressure_point(self.actuator, stretch).pressure
        # On the branch the pressure lies between these bounds; its rounding may not.
        return min(max(pressure, 0.0), self.pressure_limit)

    def stretch_from_pressure(self, pressure: float) -> float:
        r"""Return the axial stretch at a gauge pressure, on the useful branch.

        Newton's method on :math:`P(\lambda_1) = P` with the analytic derivative, from the table's
        cubic guess and inside a bracket that shrinks with every evaluation, until the error left
        by the last step is below rounding.

        Args:
            pressure: gauge pressure [Pa], 0 <= pressure <= pressure_limit.

        Returns:
            The stretch, to rounding; exactly 1 at zero pressure.

        Raises:
            InvalidInputError: ``pressure`` is negative or not finite.
            ActuationLimitError: ``pressure`` is past ``pressure_limit``.
        """
        pressure = require_non_negative("pressure", pressure)
        if not pressure <= self.pressure_limit:
            raise ActuationLimitError(self.limit, "pressure", pressure, self.pressure_limit)
        cell = bisect_right(self._pressures, pressure) - 1
        if self._pressures[cell] == pressure:
            return self._stretches[cell]
        return self._solved_in_cell(cell, pressure)

    def rest_shape(self, pressure: float) -> RestShape:
        """Return the unloaded shape at a gauge pressure [Pa], 0 <= pressure <= pressure_limit.

        Raises:
            InvalidInputError: ``pressure`` is negative or not finite.
            ActuationLimitError: ``pressure`` is past ``pressure_limit``.
        """
        return rest_shape_from_stretch(self.actuator, self.stretch_from_pressure(pressure))

    def _solved_in_cell(self, cell: int, pressure: float) -> float:
        """Return the stretch for a pressure strictly between two nodes of the table."""
        low, high = self._stretches[cell], self._stretches[cell + 1]
        stretch = min(max(self._guess(cell, pressure), low), high)
        width = high - low
        residual = math.inf
        for _ in range(ITERATIONS_MAX):
            point: PressurePoint = pressure_point(self.actuator, stretch)
            residual = point.pressure - pressure
            if residual > 0.0:
                high = stretch
            else:
                low = stretch
            step = residual / point.slope if point.slope > 0.0 else math.inf
            following = stretch - step
            if abs(step) <= CONVERGED_STEP * min(width, self.stretch_limit - stretch):
                return following
            if not low < following < high:
                following = 0.5 * (low + high)
                if not low < following < high:  # neighboring floats: no better one exists
                    return stretch
            stretch = following
        raise SolverError(InversionStatus.ITERATION_LIMIT, residual, ITERATIONS_MAX)

    def _guess(self, cell: int, pressure: float) -> float:
        """Return the stretch interpolated in one cell: a first guess, not an answer."""
        low, high = self._stretches[cell], self._stretches[cell + 1]
        pressure_low, pressure_high = self._pressures[cell], self._pressures[cell + 1]
        height = pressure_high - pressure_low
        t = (pressure - pressure_low) / height
        if cell == len(self._stretches) - 2:  # near a limit the stretch bends like a square root
            return high - (high - low) * math.sqrt(1.0 - t)
        start, end = height / self._slopes[cell], height / self._slopes[cell + 1]
        rise = high - low
        curve = start + end - 2.0 * rise
        return low + t * (start + t * (3.0 * rise - 2.0 * start - end + t * curve))
