"""Whether readings could be in the units they claim, judged by the actuator as it is described.

Handbook constants are off by tens of percent; a psi taken for a kPa is off by a factor of seven.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from spiral_core.calibration.model import Trial
from spiral_core.calibration.predict import predict
from spiral_core.calibration.readings import (
    ExtensionReading,
    GripReading,
    Reading,
    ShapeReading,
)
from spiral_core.errors import SpiralError

PSI_IN_KPA = 6.894757293168361
BAR_IN_KPA = 100.0
INCH_IN_MM = 25.4
# A discrepancy is the logarithm of a ratio. Readings this far from the description are suspicious:
# a factor of 2.6, as far from 1 as from one psi in kPa.
SUSPICIOUS = 0.5 * math.log(PSI_IN_KPA)
# A mix-up is named only if it explains the readings this much better than their stated units.
BETTER = 0.5
# Where nothing is predicted, or with another sign, the readings are as wrong as this ratio.
HOPELESS = math.log(1.0e3)


@dataclass(frozen=True, slots=True)
class UnitMixUp:
    """A mistake that would explain readings which the description cannot.

    Attributes:
        description: what was probably taken for what, such as ``"psi taken for kPa"``.
        pressure_factor: what the pressures would have to be multiplied by.
        response_factor: what the measured responses would have to be multiplied by.
        discrepancy: median ratio between predicted and measured responses as the readings are.
        discrepancy_if: the same with the mistake corrected.
    """

    description: str
    pressure_factor: float
    response_factor: float
    discrepancy: float
    discrepancy_if: float


def find_unit_mix_up(trial: Trial, readings: Sequence[Reading]) -> UnitMixUp | None:
    """Return the mix-up of units that explains implausible readings, or None if all is plausible.

    Args:
        trial: the actuator and, for shapes and grips, the gripper as described, uncalibrated.
        readings: readings of one kind.

    Example:
        >>> from spiral_core import (
        ...     Actuator, ExtensionReading, FiberAngles, FreeActuation, NeoHookean, Tube
        ... )
        >>> actuation = FreeActuation(
        ...     Actuator(
        ...         tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...         fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...         material=NeoHookean(c1=145.0e3),
        ...     )
        ... )
        >>> extension = 0.1 * (actuation.stretch_from_pressure(8.0 * 6894.757) - 1.0)
        >>> readings = [ExtensionReading(8.0e3, extension, 0.1, 1.0e-4)]  # 8 psi, entered as kPa
        >>> find_unit_mix_up(Trial(actuation, None), readings).description
        'psi taken for kPa'
    """
    stated = _discrepancy(trial, readings, 1.0, 1.0)
    if stated <= SUSPICIOUS:
        return None
    found: UnitMixUp | None = None
    for description, pressure_factor, response_factor in _hypotheses(readings[0]):
        value = _discrepancy(trial, readings, pressure_factor, response_factor)
        if value < BETTER * stated and (found is None or math.exp(value) < found.discrepancy_if):
            found = UnitMixUp(
                description, pressure_factor, response_factor, math.exp(stated), math.exp(value)
            )
    return found


def _hypotheses(reading: Reading) -> list[tuple[str, float, float]]:
    """Return the mistakes that a kind of reading allows: name, factors of pressure and response."""
    found = [
        ("psi taken for kPa", PSI_IN_KPA, 1.0),
        ("kPa taken for psi", 1.0 / PSI_IN_KPA, 1.0),
        ("bar taken for kPa", BAR_IN_KPA, 1.0),
        ("kPa taken for bar", 1.0 / BAR_IN_KPA, 1.0),
        ("bar taken for psi", BAR_IN_KPA / PSI_IN_KPA, 1.0),
        ("psi taken for bar", PSI_IN_KPA / BAR_IN_KPA, 1.0),
    ]
    if isinstance(reading, ExtensionReading | ShapeReading | GripReading):
        found.append(("inches taken for mm", 1.0, INCH_IN_MM))
        found.append(("mm taken for inches", 1.0, 1.0 / INCH_IN_MM))
    else:
        found.append(("radians taken for degrees", 1.0, math.degrees(1.0)))
        found.append(("degrees taken for radians", 1.0, math.radians(1.0)))
    return found


def _discrepancy(
    trial: Trial, readings: Sequence[Reading], pressure_factor: float, response_factor: float
) -> float:
    """Return the median |ln(predicted / measured)| of the readings with both factors applied."""
    values = [
        _discrepancy_of_one(trial, reading, pressure_factor, response_factor)
        for reading in readings
        if reading.pressure > 0.0 and any(reading.measured)
    ]
    return float(np.median(values)) if values else 0.0


def _discrepancy_of_one(
    trial: Trial, reading: Reading, pressure_factor: float, response_factor: float
) -> float:
    measured = np.array(reading.measured) * response_factor
    try:
        predicted = predict(trial, [replace(reading, pressure=reading.pressure * pressure_factor)])
    except SpiralError:
        return HOPELESS
    if isinstance(reading, ShapeReading):
        # How far apart the points are, against the nearer one's distance from the base: a factor
        # between two lengths counts as for the other kinds, and so does the direction.
        apart = float(np.linalg.norm(predicted - measured))
        nearer = min(float(np.linalg.norm(predicted)), float(np.linalg.norm(measured)))
        return math.log1p(min(apart / nearer, math.exp(HOPELESS)))
    ratio = float(predicted[0] / measured[0])
    return min(abs(math.log(ratio)), HOPELESS) if ratio > 0.0 else HOPELESS
