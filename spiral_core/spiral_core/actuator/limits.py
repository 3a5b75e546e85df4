# SPDX-License-Identifier: Apache-2.0
"""Where the useful range of an actuator ends, and why.

From rest the stretch rises with the pressure until the first of: a wound fiber locks, the straight
fiber locks, the volume is largest, the elastomer is fully extended, or the tube balloons.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from spiral_core.actuator.actuator import Actuator, CurvatureForm
from spiral_core.actuator.fibers import fiber_derivatives, locking_stretch
from spiral_core.actuator.pressure import invariants_from_derivatives, pressure_point
from spiral_core.actuator.volume import largest_volume_stretch, require_extending
from spiral_core.errors import ActuationLimit, InvalidInputError
from spiral_core.numerics.roots import first_sign_change

# Where a fiber locks or the volume peaks, pressure or its derivatives diverge. The branch stops
# short of that by this fraction of the elongation: nearer, the last bit of the stretch would change
# more than the twelfth digit of the pressure, at pressures a thousand times an actuator's own.
SINGULARITY_MARGIN = 1e-4

# Enough to show every minimum of dP/d lambda_1 for laws of up to three constants; twice as many
# change no limit in the tests' random actuators.
SCAN_NODES = 129


@dataclass(frozen=True, slots=True)
class UsefulBranch:
    """The range of stretch, from 1, over which more pressure means more stretch.

    Attributes:
        stretch_limit: largest stretch of the branch.
        limit: what ends it there.
    """

    stretch_limit: float
    limit: ActuationLimit


def clustered_nodes(end: float, count: int) -> list[float]:
    """Return ``count`` stretches from exactly 1 to exactly ``end``, denser towards the end.

    The distance to the end falls quadratically, as the curves near a limit bend like a square
    root.

    Example:
        >>> clustered_nodes(2.0, 3)
        [1.0, 1.75, 2.0]
    """
    steps = count - 1
    nodes = [end - (end - 1.0) * (1.0 - index / steps) ** 2 for index in range(count)]
    nodes[0], nodes[-1] = 1.0, end
    return nodes


def find_useful_branch(actuator: Actuator) -> UsefulBranch:
    """Return how far pressure can extend an actuator from rest.

    Limits at which something diverges are approached to 1e-4 of the elongation; a limit point
    (dP/d lambda_1 = 0) is located to rounding.

    Args:
        actuator: the actuator.

    Returns:
        The end of the branch and its cause.

    Raises:
        InvalidInputError: the fibers make the tube shorten, or the law is unstable at rest.

    Source: ``docs/derivations/actuator.md``, "Where the useful range ends".

    Example:
        >>> from spiral_core import FiberAngles, NeoHookean, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=NeoHookean(c1=145.0e3),
        ... )
        >>> branch = find_useful_branch(actuator)
        >>> round(branch.stretch_limit, 4), branch.limit.name
        (1.9999, 'FIBER_LOCKING')
    """
    require_extending(actuator.fiber_pair)
    branch = _geometric_branch(actuator)
    if math.isfinite(actuator.material.first_invariant_limit):
        branch = _shortened_by(
            lambda stretch: _invariant_left(actuator, stretch),
            branch,
            ActuationLimit.MATERIAL_LIMIT,
        )
    if actuator.curvature_form is CurvatureForm.EXACT:
        branch = _shortened_by(
            lambda stretch: _straight_fiber_left(actuator, stretch),
            branch,
            ActuationLimit.STRAIGHT_FIBER_LOCKING,
        )
    if not pressure_point(actuator, 1.0).slope > 0.0:
        raise InvalidInputError(
            "material", actuator.material, "a law whose pressure rises with the stretch at rest"
        )
    nodes = clustered_nodes(branch.stretch_limit, SCAN_NODES)
    limit_point = first_sign_change(lambda x: pressure_point(actuator, x).slope, nodes)
    if limit_point is None:
        return branch
    return UsefulBranch(limit_point, ActuationLimit.LIMIT_POINT)


def _geometric_branch(actuator: Actuator) -> UsefulBranch:
    """Return the branch up to fiber locking or the largest volume, whichever comes first."""
    largest_volume = largest_volume_stretch(actuator.fiber_pair)
    if largest_volume is None:
        locking = locking_stretch(actuator.fiber_pair)
        return UsefulBranch(_just_below(locking), ActuationLimit.FIBER_LOCKING)
    return UsefulBranch(_just_below(largest_volume), ActuationLimit.VOLUME_MAXIMUM)


def _just_below(singular_stretch: float) -> float:
    return singular_stretch - SINGULARITY_MARGIN * (singular_stretch - 1.0)


def _invariant_left(actuator: Actuator, stretch: float) -> float:
    """Return how far I1 is from the elastomer's limit, positive below it."""
    derivatives = fiber_derivatives(actuator.fiber_pair, stretch)
    first = invariants_from_derivatives(stretch, derivatives, actuator.twist_shear).first
    return actuator.material.first_invariant_limit - first


def _straight_fiber_left(actuator: Actuator, stretch: float) -> float:
    """Return 1 - |omega| r_f / r, positive while the straight fiber is long enough."""
    derivatives = fiber_derivatives(actuator.fiber_pair, stretch)
    return (
        1.0
        - abs(derivatives.shear / derivatives.hoop)
        * actuator.fiber_radius
        / actuator.tube.inner_radius
    )


def _shortened_by(
    left: Callable[[float], float], branch: UsefulBranch, limit: ActuationLimit
) -> UsefulBranch:
    """Return the branch, ended just before ``left`` stops being positive if that comes first."""
    end = first_sign_change(left, clustered_nodes(branch.stretch_limit, SCAN_NODES))
    return branch if end is None else UsefulBranch(_just_below(end), limit)
