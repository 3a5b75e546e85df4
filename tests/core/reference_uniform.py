# SPDX-License-Identifier: Apache-2.0
"""The uniform law's wall as ``docs/derivations/actuator.md`` writes it, with 60 digits."""

from decimal import Decimal, localcontext
from math import cos, pi

DIGITS = 60
# Central differences of second order: right to twice as many digits as the step is small.
STEP = Decimal(10) ** -20


def reference_wall(pair, stretch, twist_shear):
    """Return I1, I2, v, hoop stretch and shear at exactly this stretch, and their derivatives."""
    with localcontext() as context:
        context.prec = DIGITS
        behind, here, ahead = (
            _wall(pair, Decimal(stretch) + k * STEP, twist_shear) for k in (-1, 0, 1)
        )
        slopes = [(b - a) / (2 * STEP) for a, b in zip(behind, ahead, strict=True)]
    return [float(value) for value in here], [float(slope) for slope in slopes]


def reference_pressure(case, stretch):
    """Return the pressure of an actuator by equation (6) of that page."""
    tube = case.tube
    (first, second, *_), slopes = reference_wall(case.fibers, stretch, case.twist_shear)
    by_first, by_second = case.material.invariant_derivatives(first, second)
    work = by_first * slopes[0] + by_second * slopes[1]
    return tube.wall_area / (pi * tube.inner_radius**2) * work / slopes[2]


def _wall(pair, stretch, twist_shear):
    families = []
    for angle in (pair.alpha, pair.beta):
        cosine = Decimal(cos(angle))
        sine, hoop = (
            (1 - (part * cosine) ** 2).sqrt().copy_sign(Decimal(angle)) for part in (1, stretch)
        )
        families.append((cosine, sine, hoop))
    (cos_a, sin_a, a), (cos_b, sin_b, b) = families
    crossing = sin_a * cos_b - cos_a * sin_b
    hoop, shear = (a * cos_b - b * cos_a) / crossing, (b * sin_a - a * sin_b) / crossing
    for cosine, sine, around in families:  # no fiber changes its length, or its sense
        assert abs(hoop * sine + shear * cosine - around) < Decimal(10) ** -45
    # C = F^T F of the deformation gradient F: I1 its trace, I2 from the trace of its square.
    g = shear if twist_shear else 0
    axial, mixed, around, radial = stretch**2 + g**2, g * hoop, hoop**2, (stretch * hoop) ** -2
    first = axial + around + radial
    square = axial**2 + 2 * mixed**2 + around**2 + radial**2
    return first, (first**2 - square) / 2, stretch * hoop**2, hoop, shear
