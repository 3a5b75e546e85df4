# SPDX-License-Identifier: Apache-2.0
r"""The uniform law's curve: an evenly stretched wall, and where its useful range ends.

From rest the stretch rises with the pressure until the first of: a wound fiber locks, the straight
fiber locks, the volume is largest, the elastomer is fully extended, or the tube balloons.

Where a fiber locks, at the elongation E, the fibers bend like the square root of what is left. The
curve is tabulated over a size x in which they are smooth:

.. math:: \lambda_1 - 1 = E \, x \, (2 - x)
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from spiral_core.actuator.actuator import Actuator, CurvatureForm
from spiral_core.actuator.curvature import even_curvature
from spiral_core.actuator.curve import ActuationCurve, PressurePanels, clustered_nodes
from spiral_core.actuator.fibers import FiberAngles, fiber_derivatives, locking_stretch
from spiral_core.actuator.pressure import invariants_from_derivatives, uniform_pressure
from spiral_core.actuator.volume import largest_volume_stretch, require_extending, volume_slope
from spiral_core.errors import ActuationLimit
from spiral_core.numerics.panels import Array, Panels, graded_edges, halved_edges, panel_nodes
from spiral_core.numerics.roots import first_sign_change
from spiral_core.section.path import ShapePath

# Where a fiber locks or the volume peaks, pressure or its derivatives diverge. The branch stops
# short of that by this fraction of the elongation: nearer, the last bit of the stretch would change
# more than the twelfth digit of the pressure, at pressures a thousand times an actuator's own.
SINGULARITY_MARGIN = 1e-4
# Stretches at which a limit of the elastomer or of the straight fiber is looked for.
SCAN_NODES = 129
# A panel is at most this fraction of its distance to the nearest singular point: its polynomials
# are then right to rounding, and end, two orders before what they leave out, below the tolerance.
# A panel on which they do not, as by an elastomer whose limit is just beyond the range, is halved.
PANEL_WIDTH, TAIL_TOLERANCE, HALVINGS = 1.0 / 3.0, 1e-11, 3
# Families that lock so near to each other, as a fraction of the elongation, lock together.
SAME_LOCKING = 1e-9


def uniform_curve(actuator: Actuator) -> ActuationCurve:
    """Return the curve of an actuator with two families, by the uniform law.

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
        >>> curve = uniform_curve(actuator)
        >>> round(curve.stretch_limit, 4), curve.limit.name
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

    end = size_of(_just_below(last))
    right = 1.0 + math.sqrt(_next_locking(pair, reach) / reach)
    if limit is ActuationLimit.MATERIAL_LIMIT:
        right = size_of(last)
    left = 1.0 / (reach + math.sqrt(reach * (reach + 1.0)))  # the stretch is 0
    edges = graded_edges(end, left, right, PANEL_WIDTH)
    for _ in range(HALVINGS):
        samples = _samples(actuator, reach, edges)
        finer = halved_edges(edges, samples[:3], TAIL_TOLERANCE)
        if finer == edges:
            break
        edges = finer
    else:
        samples = _samples(actuator, reach, edges)
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
    return ActuationCurve(actuator, path, PressurePanels(work, volume), end, limit)


def _samples(actuator: Actuator, reach: float, edges: tuple[float, ...]) -> Array:
    """Return W, V, curvature, torsion and elongation over the size at the panels' nodes.

    Returns:
        (5, panels, NODES), the shapes' times the wound radius as in :class:`ShapePath`.
    """
    sizes = panel_nodes(edges)
    rows = [_sample(actuator, reach, size) for size in sizes.ravel().tolist()]
    return np.array(rows).T.reshape(-1, *sizes.shape)


def _sample(actuator: Actuator, reach: float, size: float) -> tuple[float, ...]:
    """Return one node's values: :func:`_samples`."""
    rise = reach * (2.0 - size)  # elongation over the size
    stretch = 1.0 + size * rise
    # Divided by the elongation of the rounded stretch, the quotients have no rounding of it.
    per_size = rise / (stretch - 1.0)
    derivatives = fiber_derivatives(actuator.fiber_pair, stretch)
    volume = volume_slope(stretch, derivatives) * 2.0 * reach * (1.0 - size)
    pressure = uniform_pressure(actuator, stretch, derivatives) * per_size
    twist = derivatives.shear / derivatives.hoop
    curvature = even_curvature(actuator, stretch, twist) * actuator.wound_radius * per_size
    return pressure * volume, volume, curvature, twist * per_size, rise


def _next_locking(fibers: FiberAngles, reach: float) -> float:
    """Return how far behind an elongation the next family locks; infinite if none does."""
    cosines = math.cos(fibers.alpha), math.cos(fibers.beta)
    behind = [1.0 / cosine - 1.0 - reach for cosine in cosines]
    return min((one for one in behind if one > SAME_LOCKING * reach), default=math.inf)


def _range(actuator: Actuator) -> tuple[float, ActuationLimit]:
    """Return the stretch at which the useful range ends, but for a limit point, and why."""
    pair, material = actuator.fiber_pair, actuator.material
    last, limit = locking_stretch(pair), ActuationLimit.FIBER_LOCKING
    largest_volume = largest_volume_stretch(pair)
    if largest_volume is not None:
        last, limit = largest_volume, ActuationLimit.VOLUME_MAXIMUM
    if math.isfinite(material.first_invariant_limit):
        end = _first_end(lambda stretch: _invariant_left(actuator, stretch), last)
        if end is not None:
            last, limit = end, ActuationLimit.MATERIAL_LIMIT
    if actuator.curvature_form is CurvatureForm.EXACT:
        end = _first_end(lambda stretch: _straight_fiber_left(actuator, stretch), last)
        if end is not None:
            last, limit = end, ActuationLimit.STRAIGHT_FIBER_LOCKING
    return last, limit


def _first_end(left: Callable[[float], float], last: float) -> float | None:
    """Return where ``left`` stops being positive before the range's end, if it does."""
    return first_sign_change(left, clustered_nodes(_just_below(last), SCAN_NODES))


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
