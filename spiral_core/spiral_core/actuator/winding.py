# SPDX-License-Identifier: Apache-2.0
"""Winding data of an actuator: pitches, turns and fiber lengths from its fiber angles."""

from __future__ import annotations

import math
from dataclasses import dataclass

from spiral_core.actuator.actuator import Actuator
from spiral_core.actuator.single_fiber import family_angles


@dataclass(frozen=True, slots=True)
class Winding:
    """One wound fiber, laid on the outside of the tube at rest.

    Args:
        angle: from the tube's axis [rad]; positive is right-handed.
        pitch: advance along the tube per turn [m], > 0.
        turns: turns over the length of the actuator.
        fiber_length: length of one fiber, without what is tied off [m].
    """

    angle: float
    pitch: float
    turns: float
    fiber_length: float

    @property
    def hand(self) -> str:
        """Which way it winds: ``"right"`` or ``"left"``."""
        return "right" if self.angle > 0.0 else "left"


def windings_of(actuator: Actuator) -> tuple[Winding, ...]:
    r"""Return the windings of an actuator's families, one or two.

    .. math:: p = \frac{2 \pi r_o}{|\tan\varphi|}, \qquad N = L / p, \qquad
        \ell = L / |\cos\varphi|

    on the outer radius :math:`r_o`, where the fibers lie. Where several fibers of a family are
    wound side by side, each has this pitch. Exactly at 90 degrees, which cannot be wound but may
    be computed with, the pitch vanishes and the turns are as many as the float of pi/2 allows.

    Args:
        actuator: the actuator.

    Example:
        >>> from spiral_core import FiberAngles, NeoHookean, Tube
        >>> tube = Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.361)
        >>> fibers = FiberAngles(alpha=math.radians(88.0), beta=math.radians(70.0))
        >>> first, second = windings_of(Actuator(tube, fibers, NeoHookean(c1=145.0e3)))
        >>> round(second.pitch * 1e3, 2), round(second.turns, 1), second.hand
        (12.71, 28.4, 'right')
    """
    return tuple(_winding(actuator, angle) for angle in family_angles(actuator.fibers))


def _winding(actuator: Actuator, angle: float) -> Winding:
    length = actuator.tube.length
    around = 2.0 * math.pi * actuator.tube.outer_radius
    pitch = around / abs(math.tan(angle))
    return Winding(angle, pitch, length / pitch, length / abs(math.cos(angle)))
