# SPDX-License-Identifier: Apache-2.0
r"""The uniform law: pressure of an evenly stretched wall, by virtual work on the tube.

By the uniform law, the elastomer's energy and the enclosed volume depend on the axial stretch
alone, because the two fiber families fix the hoop stretch and the twist. In equilibrium P dV = dU:

.. math:: P(\lambda_1) = V_t \, \frac{du/d\lambda_1}{dV/d\lambda_1}, \qquad
    V = \pi r^2 L \, \lambda_1 \lambda_2^2, \qquad V_t = \pi \, ((r + t)^2 - r^2) \, L

The derivation is in ``docs/derivations/actuator.md``; the default law is
:mod:`spiral_core.actuator.section_law`. :func:`pressure_from_stretch` answers by either.

From rest the stretch rises with the pressure until the first of: a wound fiber locks, the straight
fiber locks, the volume is largest, the elastomer is fully extended, or the tube balloons.

Where a fiber locks, at the elongation E, the fibers bend like the square root of what is left. The
curve is tabulated over a size x in which they are smooth:

.. math:: \lambda_1 - 1 = E \, x \, (2 - x)
"""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

import numpy as np

from spiral_core.actuator.actuator import Actuator, CurvatureForm, PressureLaw
from spiral_core.actuator.curvature import even_curvature
from spiral_core.actuator.curve import Branch, PressurePanels, clustered_nodes
from spiral_core.actuator.fibers import (
    FiberDerivatives,
    OneFamily,
    fiber_derivatives,
    largest_volume_stretch,
    locking_stretch,
    require_extending,
    volume_slope,
)
from spiral_core.actuator.section import ShapePath
from spiral_core.actuator.section_law import section_branch
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.numerics.panels import Array, Panels, graded_edges, refined_panels
from spiral_core.numerics.roots import first_sign_change
from spiral_core.validation import require_finite, require_positive


class Invariants(NamedTuple):
    """Invariants I1 and I2 of the wall's deformation and their derivatives in the stretch.

    Attributes:
        first: I1.
        first_prime: dI1 / d lambda_1.
        second: I2.
        second_prime: dI2 / d lambda_1.
    """

    first: float
    first_prime: float
    second: float
    second_prime: float


def invariants_from_derivatives(
    stretch: float, derivatives: FiberDerivatives, twist_shear: bool = True
) -> Invariants:
    r"""Return I1 and I2 of the wall and their derivatives in the stretch.

    With :math:`g = \lambda_2 \omega`, :math:`a = \lambda_1 \lambda_2` and
    :math:`T = \lambda_1^2 + \lambda_2^2 + g^2` (without g if the twist's shear is left out):

    .. math:: I_1 = T + a^{-2}, \qquad I_2 = a^2 + T a^{-2}

    The derivatives are written in :math:`\lambda_1^4 \lambda_2^2 - 1` and
    :math:`\lambda_1^2 \lambda_2^4 - 1`, so that nothing cancels near rest.

    Args:
        stretch: axial stretch, > 0.
        derivatives: hoop stretch and shear at that stretch.
        twist_shear: whether g counts.

    Source: ``docs/derivations/actuator.md``, "Energy".

    Example:
        >>> import math
        >>> from spiral_core.actuator.fibers import FiberAngles
        >>> derivatives = fiber_derivatives(FiberAngles(alpha=math.pi / 2, beta=math.pi / 3), 1.1)
        >>> result = invariants_from_derivatives(1.1, derivatives)
        >>> round(result.first, 6), round(result.second, 6)
        (3.040256, 3.039595)
    """
    change, hoop, hoop_1, shear, shear_1 = derivatives
    square, hoop_square = stretch * stretch, hoop * hoop
    q = 1.0 / (square * hoop_square)
    t = square + hoop_square
    axial = square * change + (stretch - 1.0) * (stretch + 1.0)  # lambda_1^2 lambda_2 - 1
    around = stretch * change * (hoop + 1.0) + (stretch - 1.0)  # lambda_1 lambda_2^2 - 1
    axial *= (axial + 2.0) / (square * stretch)
    around *= hoop_1 * (around + 2.0) / (hoop_square * hoop)
    first_1 = axial / hoop_square + around / square
    second_1 = axial + around
    if twist_shear:
        t += shear * shear
        first_1 += shear * shear_1
        second_1 += q * shear * (shear_1 - shear * (1.0 / stretch + hoop_1 / hoop))
    return Invariants(t + q, 2.0 * first_1, 1.0 / q + t * q, 2.0 * second_1)


def energy_from_stretch(actuator: Actuator, stretch: float) -> float:
    """Return the elastic energy of the whole tube by the uniform law [J], zero at rest.

    Args:
        actuator: the actuator, whatever its own law.
        stretch: axial stretch, positive and below fiber locking.

    Raises:
        InvalidInputError: the stretch is not positive and finite.
        ActuationLimitError: fiber locking, or the elastomer's limit, is reached.

    Source: ``docs/derivations/actuator.md``, "Energy".

    Example:
        >>> import math
        >>> from spiral_core import FiberAngles, NeoHookean, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=NeoHookean(c1=145.0e3),
        ... )
        >>> round(energy_from_stretch(actuator, 1.1), 6)
        0.077412
    """
    require_positive("stretch", stretch)
    derivatives = fiber_derivatives(actuator.fiber_pair, stretch)
    values = invariants_from_derivatives(stretch, derivatives, actuator.twist_shear)
    density = actuator.material.energy_density(values.first, values.second)
    return density * actuator.tube.wall_area * actuator.tube.length


def uniform_pressure(actuator: Actuator, stretch: float, derivatives: FiberDerivatives) -> float:
    r"""Return the pressure [Pa] of the uniform law at a stretch that is known to be valid.

    .. math:: P = c \frac{u'}{v'}, \qquad c = \frac{(r + t)^2 - r^2}{r^2}

    Args:
        actuator: an actuator that extends.
        stretch: axial stretch, between 1 and the first of fiber locking and largest volume.
        derivatives: of its fibers at that stretch.

    Raises:
        ActuationLimitError: the elastomer's limit is reached.
    """
    i1, i1_1, i2, i2_1 = invariants_from_derivatives(stretch, derivatives, actuator.twist_shear)
    by_first, by_second = actuator.material.invariant_derivatives(i1, i2)
    tube = actuator.tube
    relative_wall = tube.wall_thickness / tube.inner_radius
    energy_1 = by_first * i1_1 + by_second * i2_1
    return relative_wall * (2.0 + relative_wall) * energy_1 / volume_slope(stretch, derivatives)


def pressure_from_stretch(actuator: Actuator, stretch: float) -> float:
    """Return the gauge pressure that holds the actuator at an axial stretch, by its own law.

    Equilibria past a limit point, where the pressure falls as the tube balloons, are answered too:
    whether a state can be reached by pressure is for :class:`spiral_core.FreeActuation` to say.

    Args:
        actuator: the actuator.
        stretch: axial stretch, >= 1.

    Returns:
        The pressure [Pa]; 0 at ``stretch`` = 1.

    Raises:
        InvalidInputError: ``stretch`` is below 1, or the fibers make the tube shorten.
        ActuationLimitError: fiber locking, the largest volume or the elastomer's limit is reached.

    Source: ``docs/derivations/actuator.md``, "Pressure".

    Example:
        >>> import math
        >>> from spiral_core import FiberAngles, MooneyRivlin, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=MooneyRivlin(c1=130.0e3, c2=15.0e3),
        ... )
        >>> round(pressure_from_stretch(actuator, 1.1))
        56477
        >>> from dataclasses import replace
        >>> even = replace(actuator, pressure_law=PressureLaw.UNIFORM)
        >>> round(pressure_from_stretch(even, 1.1))
        39787
    """
    if not require_finite("stretch", stretch) >= 1.0:
        raise InvalidInputError("stretch", stretch, "at least 1 (pressure extends the tube)")
    if not isinstance(actuator.fibers, OneFamily):
        require_extending(actuator.fibers)
    if actuator.pressure_law is PressureLaw.UNIFORM:
        pair = actuator.fiber_pair
        derivatives = fiber_derivatives(pair, stretch)
        if not volume_slope(stretch, derivatives) > 0.0:
            limit, end = ActuationLimit.VOLUME_MAXIMUM, largest_volume_stretch(pair) or stretch
            raise ActuationLimitError(limit, "stretch", stretch, end)
        return uniform_pressure(actuator, stretch, derivatives)
    path, pressure, end, limit = section_branch(actuator)
    longest = path.stretch_at(end)
    if not stretch <= longest:
        raise ActuationLimitError(limit, "stretch", stretch, longest)
    return pressure.with_slope(path.strain_from_stretch(stretch))[0]


# Where a fiber locks or the volume peaks, pressure or its derivatives diverge. The branch stops
# short of that by this fraction of the elongation: nearer, the last bit of the stretch would change
# more than the twelfth digit of the pressure, at pressures a thousand times an actuator's own.
SINGULARITY_MARGIN = 1e-4
# Stretches at which a limit of the elastomer or of the straight fiber is looked for.
SCAN_NODES = 129
# A panel is at most this fraction of its distance to the nearest singular point: its polynomials
# are then right to rounding, and end, two orders before what they leave out, below the tolerance.
# A panel on which they do not, as by an elastomer whose limit is just beyond the range, is halved.
PANEL_WIDTH, TAIL_TOLERANCE, HALVINGS = 1.0 / 3.0, 1e-11, 5
# Families that lock so near to each other, as a fraction of the elongation, lock together.
SAME_LOCKING = 1e-9


def uniform_curve(actuator: Actuator) -> Branch:
    """Return the branch of an actuator with two families, by the uniform law.

    Limits at which something diverges are approached to 1e-4 of the elongation.

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
        >>> branch = uniform_curve(actuator)
        >>> round(branch.path.stretch_at(branch.end), 4), branch.limit.name
        (1.9999, 'FIBER_LOCKING')
    """
    pair = actuator.fiber_pair
    require_extending(pair)
    last, limit = _range(actuator)
    straight = limit is ActuationLimit.STRAIGHT_FIBER_LOCKING
    reach = (last if straight else locking_stretch(pair)) - 1.0

    def size_of(stretch: float) -> float:
        part = (stretch - 1.0) / reach
        return part / (1.0 + math.sqrt(1.0 - part))

    def sample(sizes: Array) -> Array:
        """Return W, V, curvature, torsion and elongation over the size: (5, panels, NODES)."""
        rows = []
        for size in sizes.ravel().tolist():
            rise = reach * (2.0 - size)  # elongation over the size
            stretch = 1.0 + size * rise
            # Over the elongation of the rounded stretch, the quotients have no rounding of it.
            per_size = rise / (stretch - 1.0)
            derivatives = fiber_derivatives(pair, stretch)
            volume = volume_slope(stretch, derivatives) * 2.0 * reach * (1.0 - size)
            pressure = uniform_pressure(actuator, stretch, derivatives) * per_size
            twist = derivatives.shear / derivatives.hoop
            curvature = even_curvature(actuator, stretch, twist) * actuator.wound_radius * per_size
            rows.append((pressure * volume, volume, curvature, twist * per_size, rise))
        return np.array(rows).T.reshape(-1, *sizes.shape)

    end = size_of(_just_below(last))
    # The next family locks behind this one, if any does.
    behind = [1.0 / math.cos(angle) - 1.0 - reach for angle in (pair.alpha, pair.beta)]
    nearest = min((one for one in behind if one > SAME_LOCKING * reach), default=math.inf)
    right = 1.0 + math.sqrt(nearest / reach)
    if limit is ActuationLimit.MATERIAL_LIMIT:
        right = size_of(last)
    left = 1.0 / (reach + math.sqrt(reach * (reach + 1.0)))  # the stretch is 0
    edges = graded_edges(end, left, right, PANEL_WIDTH)
    edges, samples = refined_panels(edges, sample, TAIL_TOLERANCE, HALVINGS)
    work, volume, curvature, torsion, stretch = (Panels(edges, one) for one in samples)
    path = ShapePath(
        fibers=actuator.fiber_set,
        direction=1.0,
        strain_limit=end,
        limit=limit,
        stretch=stretch,
        curvature=curvature,
        torsion=torsion,
    )
    return Branch(path, PressurePanels(work, volume), end, limit)


def _range(actuator: Actuator) -> tuple[float, ActuationLimit]:
    """Return the stretch at which the useful range ends, but for a limit point, and why."""
    pair, material = actuator.fiber_pair, actuator.material
    last, limit = locking_stretch(pair), ActuationLimit.FIBER_LOCKING
    largest_volume = largest_volume_stretch(pair)
    if largest_volume is not None:
        last, limit = largest_volume, ActuationLimit.VOLUME_MAXIMUM

    def room(reason: ActuationLimit, stretch: float) -> float:
        """Return how far I1, or what the twist takes of the straight fiber, is from its limit."""
        derivatives = fiber_derivatives(pair, stretch)
        if reason is ActuationLimit.MATERIAL_LIMIT:
            values = invariants_from_derivatives(stretch, derivatives, actuator.twist_shear)
            return material.first_invariant_limit - values.first
        twist = abs(derivatives.shear / derivatives.hoop)
        return 1.0 - twist * actuator.fiber_radius / actuator.tube.inner_radius

    for reason, may_end in (
        (ActuationLimit.MATERIAL_LIMIT, math.isfinite(material.first_invariant_limit)),
        (ActuationLimit.STRAIGHT_FIBER_LOCKING, actuator.curvature_form is CurvatureForm.EXACT),
    ):
        nodes = clustered_nodes(_just_below(last), SCAN_NODES)
        end = first_sign_change(partial(room, reason), nodes) if may_end else None
        if end is not None:
            last, limit = end, reason
    return last, limit


def _just_below(singular_stretch: float) -> float:
    return singular_stretch - SINGULARITY_MARGIN * (singular_stretch - 1.0)
