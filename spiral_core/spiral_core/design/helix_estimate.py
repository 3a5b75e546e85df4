# SPDX-License-Identifier: Apache-2.0
r"""Steps 2 to 5 of the design procedure: the estimate of a candidate by the helix model.

The coil of a uniform, unloaded actuator is a helix, and everything about it follows from the
stretch alone: the radius :math:`r_w = \rho - r_o` that it touches, the length
:math:`L = 2 \pi n / \sqrt{\kappa^2 + \tau^2}` of n turns, and the object length :math:`n |p|`.
The material enters only through the pressure. ``docs/design.md`` derives the procedure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spiral_core.actuator.actuation import FreeActuation
from spiral_core.errors import NotGrippableError
from spiral_core.numerics.roots import first_sign_change, minimum
from spiral_core.wrap.helix import Helix

# Stretches at which the radius is looked at to bracket the one wanted; it falls smoothly.
SCAN_NODES = 33
# The radius is infinite at rest: the search starts this fraction of the elongation above it.
START = 1e-9


@dataclass(frozen=True, slots=True)
class GripFigures:
    """A gripper wrapped about one cylinder.

    Args:
        radius: of the cylinder [m].
        pressure: of the perfect wrap [Pa].
        stretch: axial stretch lambda_1 there.
        turns: of the whole length.
        length_needed: gripper length of the turns required [m].
        object_length: object length that those turns cover [m].
        turn_spacing: distance between neighboring turns' centerlines [m].
    """

    radius: float
    pressure: float
    stretch: float
    turns: float
    length_needed: float
    object_length: float
    turn_spacing: float

    @property
    def strain(self) -> float:
        """Axial strain lambda_1 - 1."""
        return self.stretch - 1.0


def helix_radius(actuation: FreeActuation, stretch: float) -> float:
    """Return the radius that the helix at a stretch touches [m]; negative: nothing fits inside."""
    shape = actuation.unloaded_shape_from_stretch(stretch)
    helix = Helix(shape.curvature, shape.torsion)
    return helix.object_radius(actuation.actuator.tube.outer_radius)


def helix_stretch(actuation: FreeActuation, radius: float) -> float:
    """Return the least stretch whose helix is no wider than a cylinder of ``radius`` [m].

    A single fiber that is not straight makes the helix wider first, and then closer: the stretch
    is the one on the way back.

    Raises:
        NotGrippableError: the actuator's own limit comes first, or no helix is so wide.

    Example:
        >>> import math
        >>> from spiral_core import Actuator, FiberAngles, FreeActuation, NeoHookean, Tube
        >>> tube = Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.361)
        >>> fibers = FiberAngles(alpha=math.radians(88.0), beta=math.radians(70.0))
        >>> actuation = FreeActuation(Actuator(tube, fibers, NeoHookean(c1=145.0e3)))
        >>> round(helix_stretch(actuation, radius=30.0e-3), 4)
        1.1135
    """
    widest, nodes = widest_helix(actuation)
    if not radius <= widest:
        raise NotGrippableError(
            radius, "too thick: the single fiber winds the helix closer", widest - radius, widest
        )
    end = actuation.stretch_limit
    stretch = first_sign_change(lambda x: helix_radius(actuation, x) - radius, nodes)
    if stretch is None:
        least = helix_radius(actuation, end)
        raise NotGrippableError(radius, f"too thin: {actuation.limit.value}", radius - least, least)
    return stretch


def widest_helix(actuation: FreeActuation) -> tuple[float, list[float]]:
    """Return the radius that the widest helix touches [m], and stretches from it to the end.

    With a straight fiber it is infinite, but for rounding: the helix of the tube at rest.
    """
    end = actuation.stretch_limit
    # Denser towards the end, near which curves bend like a square root.
    nodes = (end - (end - 1.0) * np.linspace(1.0, 0.0, SCAN_NODES) ** 2).tolist()
    nodes[0] = 1.0 + START * (end - 1.0)
    radii = [helix_radius(actuation, node) for node in nodes]
    widest = max(range(len(nodes)), key=radii.__getitem__)
    if widest == 0:
        return math.inf, nodes
    ends = nodes[widest - 1], nodes[min(widest + 1, len(nodes) - 1)]
    place = minimum(lambda stretch: -helix_radius(actuation, stretch), *ends)
    return helix_radius(actuation, place), [place, *(node for node in nodes if node > place)]


def helix_grip(actuation: FreeActuation, radius: float, turns: float) -> GripFigures:
    """Return how the helix model wraps ``turns`` turns about a cylinder of ``radius`` [m].

    The length of the actuator is taken to be what those turns need.

    Raises:
        NotGrippableError: the actuator's own limit comes first.
    """
    stretch = helix_stretch(actuation, radius)
    shape = actuation.unloaded_shape_from_stretch(stretch)
    helix = Helix(shape.curvature, shape.torsion)
    object_length = helix.object_length(turns)
    unstretched = actuation.actuator.tube.length / shape.backbone_length
    return GripFigures(
        radius=radius,
        pressure=actuation.pressure_from_stretch(stretch),
        stretch=stretch,
        turns=turns,
        length_needed=helix.length_for_turns(turns) * unstretched,
        object_length=object_length,
        turn_spacing=turn_spacing(object_length, turns, helix.helix_angle),
    )


def turn_spacing(object_length: float, turns: float, helix_angle: float) -> float:
    r"""Return the distance between neighboring turns' centerlines, :math:`p \sin\theta` [m].

    That is the distance of two parallel slanted lines, the coil unrolled from its cylinder: the
    turns touch when it falls to the tube's diameter.

    Args:
        object_length: covered by ``turns`` turns [m].
        turns: number of turns.
        helix_angle: between tangent and axis [rad].

    Example:
        >>> round(turn_spacing(0.04, 2.0, math.pi / 2), 6)
        0.02
    """
    return object_length / turns * math.sin(helix_angle)
