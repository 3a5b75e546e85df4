# SPDX-License-Identifier: Apache-2.0
"""The uniform law as ``docs/derivations/actuator.md`` writes it, with 45 digits."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

from spiral_core import Actuator

DIGITS = 45
# Central differences of second order: right to twice as many digits as the step is small.
STEP = Decimal(10) ** -15


def reference_pressure(actuator: Actuator, stretch: float) -> float:
    """Return (6) at exactly this stretch [Pa]: differences of I1, I2 and v in place of formulas."""
    with localcontext() as context:
        context.prec = DIGITS
        first, second, _ = _state(actuator, Decimal(stretch))
        ahead, behind = (_state(actuator, Decimal(stretch) + step) for step in (STEP, -STEP))
        i1, i2, volume = (a - b for a, b in zip(ahead, behind, strict=True))
        law = actuator.material.invariant_derivatives(float(first), float(second))
        inner = Decimal(actuator.tube.inner_radius)
        outer = inner + Decimal(actuator.tube.wall_thickness)
        work = Decimal(law.first) * i1 + Decimal(law.second) * i2
        return float((outer**2 / inner**2 - 1) * work / volume)


def reference_twist(actuator: Actuator, stretch: float) -> float:
    """Return omega at exactly this stretch."""
    with localcontext() as context:
        context.prec = DIGITS
        hoop, shear = _hoop_and_shear(actuator, Decimal(stretch))
        return float(shear / hoop)


def _hoop_and_shear(actuator: Actuator, stretch: Decimal) -> tuple[Decimal, Decimal]:
    """Return (2), as it stands."""
    pair = actuator.fiber_pair
    cos_a, cos_b = Decimal(math.cos(pair.alpha)), Decimal(math.cos(pair.beta))
    sin_a = (1 - cos_a**2).sqrt().copy_sign(Decimal(pair.alpha))
    sin_b = (1 - cos_b**2).sqrt().copy_sign(Decimal(pair.beta))
    a = (1 - (stretch * cos_a) ** 2).sqrt().copy_sign(sin_a)
    b = (1 - (stretch * cos_b) ** 2).sqrt().copy_sign(sin_b)
    crossing = sin_a * cos_b - cos_a * sin_b
    return (a * cos_b - b * cos_a) / crossing, (b * sin_a - a * sin_b) / crossing


def _state(actuator: Actuator, stretch: Decimal) -> tuple[Decimal, Decimal, Decimal]:
    """Return I1 and I2 by (4), and v."""
    hoop, shear = _hoop_and_shear(actuator, stretch)
    area = (stretch * hoop) ** 2
    trace = stretch**2 + hoop**2 + (shear**2 if actuator.twist_shear else 0)
    return trace + 1 / area, area + trace / area, stretch * hoop**2
