# SPDX-License-Identifier: Apache-2.0
r"""Starting values of a fit, from the pressures at the measured stretches.

A measured stretch has a pressure in the model, :math:`P(\lambda_i; c)`, whether or not the
actuator with constants c would be stable there; a measured pressure may have no stretch. So the
constants that meet the pressures at the measured stretches come first, and the fit of the
measured responses starts from them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from spiral_core.actuator.fibers import OneFamily, locking_stretch
from spiral_core.actuator.uniform_law import pressures_from_stretches
from spiral_core.calibration.model import CalibrationModel, Trial, actuation_of
from spiral_core.calibration.problem import difference_jacobian
from spiral_core.calibration.readings import BendReading, ExtensionReading, Reading
from spiral_core.errors import SolverError, SpiralError
from spiral_core.rod.types import Array

# Until the start reaches the highest measured pressure it is made stiffer by these factors: a
# little first, as noise near a limit point asks for no more.
STIFFENING = (1.0, 1.01, 1.03, 1.1, 1.3, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)


# Enough for the linear problem that most laws make of it; it is a start, not an answer.
EVALUATIONS_MAX = 50


class _Point(NamedTuple):
    """A stretch that was measured, its pressure, and the pressure's error for a start."""

    straight: bool
    stretch: float
    pressure: float
    error: float


def starting_values(model: CalibrationModel, readings: Sequence[Reading]) -> tuple[float, ...]:
    """Return values from which every reading can be predicted.

    Args:
        model: what is to be fitted.
        readings: what was measured.

    Raises:
        ActuationLimitError: the measured pressures are past what any start reaches.
    """
    found = _values_from_pressures(model, _points(model, readings))
    beyond = Trial(actuation_of(model.actuator_from(model.start()))).highest_beyond(readings)
    for base in (found, model.start()):
        for factor in STIFFENING:
            scales = (1.0 if name == "extension_limit" else factor for name in model.names)
            values = tuple(a * b for a, b in zip(base, scales, strict=True))
            try:
                trial = Trial(actuation_of(model.actuator_from(values)))
            except SpiralError:  # not an actuator that extends, at any scale
                break
            beyond = trial.highest_beyond(readings)
            if beyond is None:
                return values
    if beyond is None:  # the start itself, where nothing found makes an actuator
        return model.start()
    raise beyond


def _points(model: CalibrationModel, readings: Sequence[Reading]) -> list[_Point]:
    """Return the stretches that extensions and bend angles tell directly, if they are possible."""
    radius = model.actuator.fiber_radius
    fibers = model.actuator.fibers
    locking = math.inf if isinstance(fibers, OneFamily) else locking_stretch(fibers)
    points = []
    for reading in readings:
        if isinstance(reading, ExtensionReading):
            elongation, scale = reading.extension, 1.0
        elif isinstance(reading, BendReading):
            # The first-order form will do for a start.
            elongation, scale = reading.bend_angle * radius, radius
        else:
            continue
        elongation /= reading.section_length
        if not (reading.pressure > 0.0 and 0.0 < elongation < locking - 1.0):
            continue
        slope = reading.pressure / elongation
        error = slope * reading.error * scale / reading.section_length
        is_straight = isinstance(reading, ExtensionReading)
        points.append(_Point(is_straight, 1.0 + elongation, reading.pressure, error))
    return points


def _values_from_pressures(model: CalibrationModel, points: Sequence[_Point]) -> tuple[float, ...]:
    """Return the constants that meet the pressures at the measured stretches best."""
    from scipy.optimize import least_squares

    start = np.array(model.start())
    if len(points) < len(model.names):
        return model.start()
    scales = np.array(model.scales())
    points = sorted(points, key=lambda point: point.straight)
    finished = [point.stretch for point in points if not point.straight]
    straight = [point.stretch for point in points if point.straight]
    measured = np.array([point.pressure for point in points])
    errors = np.array([point.error for point in points])

    def residuals(scaled: Array) -> Array:
        try:
            actuator = model.actuator_from((scaled * scales).tolist())
            modeled = pressures_from_stretches(actuator, finished) if finished else []
            if straight:
                even = actuator.without_single_fibers()
                modeled = [*modeled, *pressures_from_stretches(even, straight)]
        except SpiralError:
            return np.full(len(points), np.nan)
        weighted: Array = (np.array(modeled) - measured) / errors
        return weighted

    low, high = np.array(model.limits()).T / scales
    if not np.isfinite(residuals(start / scales)).all():
        return model.start()

    try:
        found = least_squares(
            residuals,
            start / scales,
            jac=partial(difference_jacobian, residuals),
            bounds=(low, high),
            max_nfev=EVALUATIONS_MAX,
        )
    except SolverError:  # at the edge of what the law allows: no start worth having
        return model.start()
    return tuple(float(value) for value in found.x * scales)
