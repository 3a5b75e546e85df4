# SPDX-License-Identifier: Apache-2.0
"""The uniform law as ``docs/derivations/actuator.md`` writes it, with 45 digits."""

import math
from decimal import Decimal, localcontext

DIGITS = 45
# Central differences of second order: right to twice as many digits as the step is small.
STEP = Decimal(10) ** -15


def reference_wall(pair, stretch, twist_shear=True):
    """Return I1, I2, v, hoop stretch and shear at exactly this stretch, and their derivatives."""
    with localcontext() as context:
        context.prec = DIGITS
        behind, here, ahead = (
            _wall(pair, Decimal(stretch) + k * STEP, twist_shear) for k in (-1, 0, 1)
        )
        slopes = [(b - a) / (2 * STEP) for a, b in zip(behind, ahead, strict=True)]
    return [float(value) for value in here], [float(slope) for slope in slopes]


def reference_pressure(actuator, stretch):
    """Return (6) at exactly this stretch [Pa]: differences of I1, I2 and v in place of formulas."""
    values, slopes = reference_wall(actuator.fiber_pair, stretch, actuator.twist_shear)
    by_first, by_second = actuator.material.invariant_derivatives(*values[:2])
    inner, outer = actuator.tube.inner_radius, actuator.tube.outer_radius
    work = by_first * slopes[0] + by_second * slopes[1]
    return (outer**2 / inner**2 - 1.0) * work / slopes[2]


def reference_twist(actuator, stretch):
    """Return omega at exactly this stretch."""
    (*_, hoop, shear), _ = reference_wall(actuator.fiber_pair, stretch)
    return shear / hoop


def _wall(pair, stretch, twist_shear):
    cos_a, cos_b = Decimal(math.cos(pair.alpha)), Decimal(math.cos(pair.beta))
    sin_a = (1 - cos_a**2).sqrt().copy_sign(Decimal(pair.alpha))
    sin_b = (1 - cos_b**2).sqrt().copy_sign(Decimal(pair.beta))
    a = (1 - (stretch * cos_a) ** 2).sqrt().copy_sign(sin_a)
    b = (1 - (stretch * cos_b) ** 2).sqrt().copy_sign(sin_b)
    crossing = sin_a * cos_b - cos_a * sin_b
    hoop, shear = (a * cos_b - b * cos_a) / crossing, (b * sin_a - a * sin_b) / crossing
    # C = F^T F of the deformation gradient F: I1 its trace, I2 from the trace of its square.
    g = shear if twist_shear else 0
    axial, mixed, around, radial = stretch**2 + g**2, g * hoop, hoop**2, (stretch * hoop) ** -2
    first = axial + around + radial
    square = axial**2 + 2 * mixed**2 + around**2 + radial**2
    return first, (first**2 - square) / 2, stretch * hoop**2, hoop, shear
