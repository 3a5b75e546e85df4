# SPDX-License-Identifier: Apache-2.0
r"""The enclosed volume: which pairs of fiber families extend under pressure, and to what limit.

Pressure does work only where the volume grows. At rest the volume grows with the stretch when

.. math:: v'(1) = 1 + 2 \cot\alpha \cot\beta > 0

so families of one handedness always extend, and families of opposite handedness do when
:math:`|\tan\alpha \tan\beta| > 2` (for a symmetric pair: beyond the magic angle, 54.7 degrees).
The proof is in ``docs/derivations/actuator.md``.
"""

from __future__ import annotations

import math

from spiral_core.actuator.fibers import (
    FiberAngles,
    FiberDerivatives,
    fiber_derivatives,
    locking_stretch,
)
from spiral_core.errors import InvalidInputError
from spiral_core.numerics.roots import last_positive


def volume_slope(stretch: float, derivatives: FiberDerivatives) -> float:
    r"""Return dv / d lambda_1 of the enclosed volume over its value at rest.

    .. math:: v = \lambda_1 \lambda_2^2

    Args:
        stretch: axial stretch.
        derivatives: hoop stretch and derivative at that stretch.

    Example:
        >>> fibers = FiberAngles(alpha=math.radians(90.0), beta=math.radians(60.0))
        >>> round(volume_slope(1.2, fiber_derivatives(fibers, 1.2)), 12)
        1.0
    """
    return derivatives.hoop * (derivatives.hoop + 2.0 * stretch * derivatives.hoop_prime)


def initial_volume_slope(fibers: FiberAngles) -> float:
    r"""Return dv/d lambda_1 at rest, :math:`1 + 2 \cot\alpha \cot\beta`.

    Example:
        >>> fibers = FiberAngles(alpha=math.radians(45.0), beta=math.radians(-45.0))
        >>> round(initial_volume_slope(fibers), 12)
        -1.0
    """
    return 1.0 + 2.0 / (math.tan(fibers.alpha) * math.tan(fibers.beta))


def require_extending(fibers: FiberAngles) -> None:
    """Raise InvalidInputError unless pressure extends a tube with these fibers.

    Example:
        >>> require_extending(FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)))
    """
    slope = initial_volume_slope(fibers)
    if slope > 0.0:
        return
    raise InvalidInputError(
        "fibers",
        fibers.degrees,
        "a pair that extends under pressure: two angles of the same handedness, or of opposite "
        f"handedness with |tan(alpha) tan(beta)| > 2 (here {2.0 / (1.0 - slope):.6g}, "
        "so pressure would shorten the tube)",
    )


def largest_volume_stretch(fibers: FiberAngles) -> float | None:
    """Return the stretch at which the enclosed volume is largest, or None if it only grows.

    Only families of opposite handedness have such a stretch, and then exactly one: there the
    pressure diverges, because no volume is left to gain.

    Args:
        fibers: a pair that extends under pressure.

    Returns:
        The stretch to the last float at which the volume still grows; None if it grows up to
        fiber locking.

    Example:
        >>> fibers = FiberAngles(alpha=math.radians(60.0), beta=math.radians(-60.0))
        >>> round(largest_volume_stretch(fibers), 9)  # 2 / sqrt(3): the fibers at the magic angle
        1.154700538
    """
    if fibers.alpha * fibers.beta > 0.0:
        return None

    def slope(stretch: float) -> float:
        return volume_slope(stretch, fiber_derivatives(fibers, stretch))

    # At locking itself the derivatives do not exist; four units of rounding below it they do.
    end = locking_stretch(fibers) * (1.0 - 4.0 * math.ulp(1.0))
    return None if slope(end) > 0.0 else last_positive(slope, 1.0, end)
