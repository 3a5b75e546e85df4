# SPDX-License-Identifier: Apache-2.0
"""From bend angles and twists to a measured actuation curve, for a gripper without a good law."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from spiral_core.actuator.actuation import MeasuredActuation
from spiral_core.actuator.fibers import FiberAngles
from spiral_core.calibration.readings import BendReading, Reading, TwistReading
from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_positive

# Angles that are opposite to this [rad] do not twist; files state them with many more digits.
SYMMETRIC = 1e-6


def measured_actuation_from_readings(
    readings: Sequence[Reading], tube_length: float, fibers: FiberAngles
) -> MeasuredActuation:
    r"""Return the actuation curve that bend angles and twists describe.

    Curvature is bend angle over length, torsion twist over length. Repeats at one pressure are
    averaged, and the curve starts straight, at zero pressure.

    Args:
        readings: bend angles; and twists at the same pressures, or none at all for an actuator
            that does not twist (:math:`\alpha = -\beta`).
        tube_length: unstretched length of the gripper that the curve is for [m].
        fibers: its wound fibers' angles; the single fiber is straight.

    Raises:
        InvalidInputError: readings of another kind, no twists for fibers that twist, twists at
            other pressures than the bend angles, or curvatures that fall as the pressure rises.

    Example:
        >>> readings = [BendReading(p, 2.0e-5 * p, 0.2, 0.01) for p in (2.0e4, 4.0e4, 6.0e4)]
        >>> fibers = FiberAngles(alpha=1.1, beta=-1.1)
        >>> actuation = measured_actuation_from_readings(readings, 0.2, fibers)
        >>> round(actuation.unloaded_shape(5.0e4).curvature, 6)
        5.0
    """
    require_positive("tube_length", tube_length)
    curvatures: defaultdict[float, list[float]] = defaultdict(list)
    torsions: defaultdict[float, list[float]] = defaultdict(list)
    for reading in readings:
        if isinstance(reading, BendReading):
            curvatures[reading.pressure].append(reading.bend_angle / reading.section_length)
        elif isinstance(reading, TwistReading):
            torsions[reading.pressure].append(reading.twist / reading.section_length)
        else:
            kind = type(reading).__name__
            raise InvalidInputError("readings", kind, "bend angles and twists only")
    if not torsions and not abs(fibers.alpha + fibers.beta) <= SYMMETRIC:
        raise InvalidInputError(
            "readings",
            "bend angles only",
            "bend angles and twists: fibers at alpha and beta that are not opposite twist the "
            "gripper, and bend angles do not tell by how much",
        )
    if torsions and torsions.keys() != curvatures.keys():
        lonely = sorted(torsions.keys() ^ curvatures.keys())
        raise InvalidInputError(
            "readings", lonely, "twists at the pressures of the bend angles, and only there [Pa]"
        )
    rising = sorted(pressure for pressure in curvatures if pressure > 0.0)
    return MeasuredActuation(
        pressures=(0.0, *rising),
        curvatures=(0.0, *(float(np.mean(curvatures[p])) for p in rising)),
        torsions=(0.0, *(float(np.mean(torsions[p])) if torsions else 0.0 for p in rising)),
        backbone_length=tube_length,
    )
