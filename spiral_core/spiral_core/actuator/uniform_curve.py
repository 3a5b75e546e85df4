# SPDX-License-Identifier: Apache-2.0
"""The uniform law's curve: pressure to stretch to shape on the useful branch, fast and exact."""

from __future__ import annotations

import math
from bisect import bisect_right
from enum import Enum
from itertools import pairwise

from spiral_core.actuator.actuator import Actuator
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.interface import UnloadedShape
from spiral_core.actuator.limits import clustered_nodes, find_useful_branch
from spiral_core.actuator.pressure import PressurePoint, pressure_point
from spiral_core.errors import InvalidInputError, SolverError

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


class UniformCurve:
    """Pressure, stretch and shape of one actuator by the uniform law.

    Args:
        actuator: two wound families, with or without a straight fiber.

    Raises:
        InvalidInputError: pressure would not extend this actuator.
    """

    __slots__ = (
        "_actuator", "_pressures", "_slopes", "_stretches", "limit", "pressure_limit",
        "stretch_limit",
    )  # fmt: skip

    def __init__(self, actuator: Actuator) -> None:
        branch = find_useful_branch(actuator)
        stretches = clustered_nodes(branch.stretch_limit, TABLE_NODES)
        points = [pressure_point(actuator, stretch) for stretch in stretches]
        pressures = [point.pressure for point in points]
        if not all(low < high < math.inf for low, high in pairwise(pressures)):
            raise InvalidInputError(
                "actuator", actuator, "one whose pressure rises up to its stretch limit"
            )
        self._actuator = actuator
        self.stretch_limit, self.limit = branch.stretch_limit, branch.limit
        self.pressure_limit = pressures[-1]
        self._stretches, self._pressures = stretches, pressures
        self._slopes = [point.slope for point in points]

    def pressure_from_stretch(self, stretch: float) -> float:
        """Return the pressure [Pa] at a stretch from 1 to ``stretch_limit``."""
        return pressure_point(self._actuator, stretch).pressure

    def stretch_from_pressure(self, pressure: float) -> float:
        """Return the stretch at a pressure [Pa] from 0 to ``pressure_limit``."""
        cell = bisect_right(self._pressures, pressure) - 1
        if self._pressures[cell] == pressure:
            return self._stretches[cell]
        return self._solved_in_cell(cell, pressure)

    def unloaded_shape(self, pressure: float) -> UnloadedShape:
        """Return the unloaded shape at a pressure [Pa] from 0 to ``pressure_limit``."""
        return unloaded_shape_from_stretch(self._actuator, self.stretch_from_pressure(pressure))

    def unloaded_shape_from_stretch(self, stretch: float) -> UnloadedShape:
        """Return the unloaded shape at a stretch from 1 to ``stretch_limit``."""
        return unloaded_shape_from_stretch(self._actuator, stretch)

    def _solved_in_cell(self, cell: int, pressure: float) -> float:
        """Return the stretch for a pressure strictly between two nodes of the table."""
        low, high = self._stretches[cell], self._stretches[cell + 1]
        stretch = min(max(self._guess(cell, pressure), low), high)
        width = high - low
        residual = math.inf
        for _ in range(ITERATIONS_MAX):
            point: PressurePoint = pressure_point(self._actuator, stretch)
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
