# SPDX-License-Identifier: Apache-2.0
r"""The shape of a uniform, unloaded rod: a helix, in closed form.

In the material frame (x tangent, y towards the straight fiber, z = x cross y) the strain vector
:math:`u = (\tau, 0, \kappa)` is constant, so the frame turns steadily about one fixed axis and the
centerline is a helix about it. Shapes are given in the base frame: the material frame of the
clamped end, at the origin, with the tube leaving along +x. See ``docs/conventions.md``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from spiral_core.validation import require_finite, require_non_negative, require_positive


@dataclass(frozen=True, slots=True)
class Helix:
    r"""A helix of constant curvature and torsion, per length of its centerline.

    .. math:: \rho = \kappa / (\kappa^2 + \tau^2), \quad p = 2\pi\tau / (\kappa^2 + \tau^2)

    Exact for a uniform, unloaded rod; gravity and contact are left to :mod:`spiral_core.rod`.

    Args:
        curvature: centerline curvature [1/m], > 0.
        torsion: centerline torsion [1/m]; positive is right-handed, 0 is a circle.

    Raises:
        InvalidInputError: ``curvature`` is not positive, or a value is not finite.

    Source: ``docs/derivations/actuator.md``, "Helix".

    Example:
        >>> helix = Helix(curvature=20.0, torsion=-10.0)
        >>> round(helix.radius, 6), round(helix.pitch, 6)
        (0.04, -0.125664)
        >>> round(helix.turns(0.36), 6) == round(0.36 / helix.length_for_turns(1.0), 6)
        True
    """

    curvature: float
    torsion: float

    def __post_init__(self) -> None:
        require_positive("curvature", self.curvature)
        require_finite("torsion", self.torsion)

    @property
    def angular_rate(self) -> float:
        """Angle turned about the axis per length, sqrt(kappa^2 + tau^2) [rad/m]."""
        return math.hypot(self.curvature, self.torsion)

    @property
    def radius(self) -> float:
        """Distance of the centerline from the axis, kappa / (kappa^2 + tau^2) [m]."""
        return self.curvature / self.angular_rate / self.angular_rate

    @property
    def pitch(self) -> float:
        """Advance per turn, 2 pi tau / (kappa^2 + tau^2) [m]; it has the sign of the torsion."""
        return 2.0 * math.pi * self.torsion / self.angular_rate / self.angular_rate

    @property
    def helix_angle(self) -> float:
        r"""Angle theta between tangent and axis, tan(theta) = kappa / \|tau\| [rad], to pi/2."""
        return math.atan2(self.curvature, abs(self.torsion))

    def turns(self, length: float) -> float:
        """Return the number of turns of a centerline of ``length`` [m], L sqrt(k^2+t^2) / 2 pi."""
        return require_non_negative("length", length) * self.angular_rate / (2.0 * math.pi)

    def length_for_turns(self, turns: float) -> float:
        """Return the length of centerline [m] that makes ``turns`` turns, >= 0."""
        return require_non_negative("turns", turns) * 2.0 * math.pi / self.angular_rate

    def object_length(self, turns: float) -> float:
        """Return the length of object [m] that ``turns`` turns cover along the axis, >= 0."""
        return require_non_negative("turns", turns) * abs(self.pitch)

    def object_radius(self, outer_radius: float) -> float:
        """Return the radius of the cylinder the coil just touches, helix radius - r_o [m].

        Args:
            outer_radius: outer radius of the tube r_o [m], > 0.

        Returns:
            The radius [m]; zero or negative when the tube itself fills the coil and nothing fits.
        """
        return self.radius - require_positive("outer_radius", outer_radius)
