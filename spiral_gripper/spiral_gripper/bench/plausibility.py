# SPDX-License-Identifier: Apache-2.0
"""Detection of mix-ups of units in readings, by comparison with the described gripper.

A rubber may be several times as stiff as the described one, so that a factor of seven in the
pressure proves nothing. Readings that no elastomer gives are refused.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from spiral_core import (
    BendReading,
    ExtensionReading,
    ShapeReading,
    SpiralError,
    TwistReading,
)
from spiral_core.calibration.model import Trial, predict
from spiral_core.calibration.readings import Reading
from spiral_gripper.bench.measurements import COLUMN_OF, COLUMNS
from spiral_gripper.files.plausibility import MODULI
from spiral_gripper.files.units import convert_from_si, parse_quantity

# Discrepancies are logarithms of ratios. A cause explains one if it leaves less than this factor,
# which constants from a handbook may be off by.
EXPLAINED = math.log(1.6)
# A second mix-up is named if it explains the readings this much less well at most [logarithm].
NEARLY = 0.1
# Units that differ by less than this fraction are one.
SAME_UNIT = 1e-9
# Where nothing is predicted, or with another sign, the readings are as wrong as this ratio.
HOPELESS = math.log(1.0e3)
# Steps in which the modulus is sought that the readings need [logarithm].
MODULUS_STEP = 0.1


def possible_mix_ups(
    trial: Trial, readings: Sequence[Reading], units: Mapping[str, str]
) -> list[str]:
    """Return the mix-up of units that would make the readings those of the described gripper.

    Args:
        trial: the actuator and, for shapes and grips, the gripper as described, uncalibrated.
        readings: readings of one kind.
        units: in which the file states pressure and response, by column.

    Returns:
        Mix-ups such as ``"psi taken for kPa"``, the likeliest first; others only if they explain
        the readings nearly as well. Empty if none does.
    """
    column = COLUMN_OF[type(readings[0])]
    found = []
    for name in ("pressure", column):
        dimension, stated = COLUMNS[name], units.get(name, COLUMNS[name].usual_units[0])
        for unit in dimension.usual_units:
            factor = convert_from_si(parse_quantity(f"1 {unit}", dimension), stated, dimension)
            if abs(factor - 1.0) < SAME_UNIT:
                continue
            factors = (factor, 1.0) if name == "pressure" else (1.0, factor)
            found.append((discrepancy(trial, readings, *factors), f"{unit} taken for {stated}"))
    least = min(left for left, _ in found)
    limit = min(EXPLAINED, least + NEARLY)
    return [name for left, name in sorted(found) if left < limit]


def needed_modulus(trial: Trial, readings: Sequence[Reading]) -> float | None:
    """Return the Young's modulus [Pa] with which the description meets readings best.

    A law whose constants are all multiplied by a factor needs so many times the pressure.

    Args:
        trial: the gripper as described.
        readings: readings of one kind.

    Returns:
        The modulus, or None if no elastomer's comes nearer to the readings than a factor of 1.6 in
        the median.

    Example:
        >>> import math
        >>> from spiral_core import Actuator, FiberAngles, FreeActuation, NeoHookean, Tube
        >>> tube = Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5)
        >>> fibers = FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0))
        >>> described = FreeActuation(Actuator(tube, fibers, NeoHookean(c1=100.0e3)))
        >>> actual = Actuator(tube, fibers, NeoHookean(c1=600.0e3)).without_single_fibers()
        >>> extension = 0.1 * (FreeActuation(actual).stretch_from_pressure(40.0e3) - 1.0)
        >>> readings = [ExtensionReading(40.0e3, extension, 0.1, 1.0e-4)]
        >>> round(needed_modulus(Trial(described), readings) / 3.6e6, 1)
        1.0
    """
    stated = trial.actuation.actuator.material.small_strain_modulus
    low, high = (math.log(end / stated) for end in MODULI)
    count = math.ceil((high - low) / MODULUS_STEP) + 1
    factors = [math.exp(x) for x in sorted(np.linspace(low, high, count).tolist(), key=abs)]
    lefts = [discrepancy(trial, readings, 1.0 / factor, 1.0) for factor in factors]
    best = int(np.argmin(lefts))
    return factors[best] * stated if lefts[best] < EXPLAINED else None


def discrepancy(
    trial: Trial, readings: Sequence[Reading], pressure_factor: float, response_factor: float
) -> float:
    """Return the median |ln(predicted / measured)| of the readings with both factors applied."""

    def of_one(reading: Reading) -> float:
        measured = np.array(reading.measured) * response_factor
        try:
            asked = replace(reading, pressure=reading.pressure * pressure_factor)
            predicted = predict(trial, [asked])
        except SpiralError:
            return HOPELESS
        if isinstance(reading, ShapeReading):
            # How far apart the points are, against the nearer one's distance from the base: a
            # factor between two lengths counts as for the other kinds, and so does the direction.
            vectors = (predicted - measured, predicted, measured)
            apart, *sizes = (float(np.linalg.norm(vector)) for vector in vectors)
            return math.log1p(min(apart / min(sizes), math.exp(HOPELESS)))
        ratio = float(predicted[0] / measured[0])
        return min(abs(math.log(ratio)), HOPELESS) if ratio > 0.0 else HOPELESS

    values = [of_one(one) for one in readings if one.pressure > 0.0 and any(one.measured)]
    return float(np.median(values)) if values else 0.0


def other_explanations(
    trial: Trial, readings: Sequence[Reading], units: Mapping[str, str]
) -> list[str]:
    """Return other explanations than a different rubber for a difference from the description.

    Args:
        trial: the gripper as described.
        readings: readings of one kind.
        units: in which the file states pressure and response, by column.
    """
    found = possible_mix_ups(trial, readings, units)
    ratios = [
        reading.measured[0] / predict(trial, [reading])[0] * reading.section_length
        for reading in readings
        if isinstance(reading, ExtensionReading | TwistReading | BendReading)
        and 0.0 < reading.pressure <= trial.actuation_for(reading).pressure_limit
    ]
    if ratios and (length := float(np.median(ratios))) > 0.0:
        found.append(f"a measured section of {length * 1e3:.3g} mm (--section-length)")
    return found
