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

import numpy as np
from numpy.typing import ArrayLike, NDArray

from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_finite, require_non_negative, require_positive

# Below this angle (x - sin x) / x^3 comes from its series, whose error there is under 1e-17; above
# it the subtraction loses less than two digits.
SERIES_ANGLE = 1.0


@dataclass(frozen=True, slots=True)
class Helix:
    """A helix of constant curvature and torsion, per length of its centerline.

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


def helix_from_curvature(curvature: float, torsion: float) -> Helix:
    r"""Return the helix whose centerline has constant curvature and torsion.

    .. math:: \rho = \kappa / (\kappa^2 + \tau^2), \quad p = 2\pi\tau / (\kappa^2 + \tau^2)

    Exact for a uniform, unloaded rod; gravity and contact are left to :mod:`spiral_core.rod.types`.

    Args:
        curvature: centerline curvature [1/m], > 0.
        torsion: centerline torsion [1/m]; positive is right-handed.

    Returns:
        The helix; its pitch carries the sign of ``torsion``.

    Raises:
        InvalidInputError: ``curvature`` is not positive and finite.

    Example:
        >>> helix = helix_from_curvature(curvature=20.0, torsion=10.0)
        >>> round(helix.radius, 6), round(helix.pitch, 6)
        (0.04, 0.125664)
    """
    return Helix(curvature=curvature, torsion=torsion)


def helix_positions(
    curvature: float, torsion: float, arc_lengths: ArrayLike
) -> NDArray[np.float64]:
    r"""Return points of the centerline in the base frame.

    With :math:`k^2 = \kappa^2 + \tau^2`, :math:`C = (1 - \cos ks) / (ks)^2` and
    :math:`S = (ks - \sin ks) / (ks)^3`:

    .. math:: p(s) = (s - \kappa^2 s^3 S, \; \kappa s^2 C, \; \kappa \tau s^3 S)

    Smooth down to a straight rod: curvature and torsion may both be zero.

    Args:
        curvature: curvature [1/m]; positive bends towards +y.
        torsion: torsion [1/m]; positive is right-handed.
        arc_lengths: distances from the base along the centerline [m], shape (n,).

    Returns:
        Positions [m], shape (n, 3).

    Raises:
        InvalidInputError: a value is not finite, or ``arc_lengths`` is not one-dimensional.

    Example:
        >>> helix_positions(curvature=10.0, torsion=0.0, arc_lengths=[math.pi / 20.0]).round(6)
        array([[0.1, 0.1, 0. ]])
    """
    curvature, torsion = require_finite("curvature", curvature), require_finite("torsion", torsion)
    s = _require_arc_lengths(arc_lengths)
    angle = math.hypot(curvature, torsion) * s
    bent = s**3 * _sine_deficit(angle)
    half_versine = np.sinc(angle / (2.0 * math.pi)) ** 2 / 2.0  # (1 - cos x) / x^2
    return np.column_stack(
        (s - curvature**2 * bent, curvature * s**2 * half_versine, curvature * torsion * bent)
    )


def helix_orientations(
    curvature: float, torsion: float, arc_lengths: ArrayLike
) -> NDArray[np.float64]:
    r"""Return material frames along the centerline as quaternions in the base frame.

    The frame at s is the base frame turned by :math:`k s` about the axis :math:`(\tau, 0, \kappa)`.

    Args:
        curvature: curvature [1/m]; positive bends towards +y.
        torsion: torsion [1/m]; positive is right-handed.
        arc_lengths: distances from the base along the centerline [m], shape (n,).

    Returns:
        Unit quaternions (x, y, z, w), continuous along the rod, shape (n, 4).

    Raises:
        InvalidInputError: a value is not finite, or ``arc_lengths`` is not one-dimensional.

    Example:
        >>> helix_orientations(curvature=0.0, torsion=10.0, arc_lengths=[math.pi / 10.0]).round(6)
        array([[1., 0., 0., 0.]])
    """
    curvature, torsion = require_finite("curvature", curvature), require_finite("torsion", torsion)
    s = _require_arc_lengths(arc_lengths)
    half_angle = 0.5 * math.hypot(curvature, torsion) * s
    scale = 0.5 * s * np.sinc(half_angle / math.pi)  # sin(k s / 2) / k
    return np.column_stack(
        (torsion * scale, np.zeros_like(s), curvature * scale, np.cos(half_angle))
    )


def _require_arc_lengths(arc_lengths: ArrayLike) -> NDArray[np.float64]:
    requirement = "a one-dimensional array of finite numbers"
    try:
        s = np.asarray(arc_lengths, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInputError("arc_lengths", arc_lengths, requirement) from None
    if s.ndim != 1 or not bool(np.isfinite(s).all()):
        raise InvalidInputError("arc_lengths", arc_lengths, requirement)
    return s


def _sine_deficit(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (x - sin x) / x^3, by its series near zero; the limit at zero is 1/6."""
    small = np.abs(angle) < SERIES_ANGLE
    square = np.where(small, angle, 0.0) ** 2
    series = np.zeros_like(angle)
    for order in range(8, -1, -1):
        series = 1.0 / math.factorial(2 * order + 3) - square * series
    x = np.where(small, 1.0, angle)
    return np.where(small, series, (x - np.sin(x)) / x**3)
