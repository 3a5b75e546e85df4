# SPDX-License-Identifier: Apache-2.0
r"""Fibers that cannot stretch: wound families, single ones, and the motion they leave a tube.

The wall maps an unstretched line element (axial, hoop) by :math:`\lambda_1` along the axis,
:math:`\lambda_2` around it, and a shear :math:`g = \lambda_2 \omega` of the hoop direction per
axial length. A fiber at angle :math:`\varphi` from the axis keeps its length when

.. math:: \lambda_1^2 \cos^2\varphi + (\lambda_2 \sin\varphi + g \cos\varphi)^2 = 1

The derivation, and the branch taken, is in ``docs/derivations/actuator.md``.

Pressure does work only where the volume grows. At rest the volume grows with the stretch when

.. math:: v'(1) = 1 + 2 \cot\alpha \cot\beta > 0

so families of one handedness always extend, and families of opposite handedness do when
:math:`|\tan\alpha \tan\beta| > 2` (for a symmetric pair: beyond the magic angle, 54.7 degrees).
The proof is in ``docs/derivations/actuator.md``. Single fibers run along the tube
and make it bend, or bend and coil.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from spiral_core.actuator.section import LEAST_VOLUME_SLOPE, FiberSet, family_slope
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.message import Message, Quantity
from spiral_core.numerics.roots import last_positive
from spiral_core.rounding import rounded_up
from spiral_core.validation import require_in_range, require_positive

# Rotation and hoop stretch come from dividing by sin(alpha - beta), which magnifies rounding by its
# inverse: at this bound, about 0.006 degrees, twelve digits are left. Windings are far less exact.
SMALLEST_CROSSING = 1e-4

# A family along the axis would lock at once; an angle this small stretches by 5e-9 before it does.
SMALLEST_ANGLE = 1e-4


@dataclass(frozen=True, slots=True)
class FiberAngles:
    """Angles of the two families from the tube's axis, at rest; positive is right-handed.

    The order of the two does not matter, and 90 degrees means the same as -90.

    Args:
        alpha: angle of the first family [rad], -pi/2 to pi/2, not 0.
        beta: angle of the second family [rad], -pi/2 to pi/2, not 0; another than ``alpha``.

    Raises:
        InvalidInputError: an angle is out of range or along the axis, or the families coincide.

    Example:
        >>> fibers = FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0))
        >>> fibers.mirrored().alpha == -fibers.alpha
        True
    """

    alpha: float
    beta: float

    def __post_init__(self) -> None:
        for field, angle in (("alpha", self.alpha), ("beta", self.beta)):
            _require_wound(field, angle)
        if not abs(math.sin(self.alpha - self.beta)) >= SMALLEST_CROSSING:
            raise InvalidInputError(
                "alpha, beta",
                (self.alpha, self.beta),
                f"angles of two families that cross (|sin(alpha - beta)| >= {SMALLEST_CROSSING})",
                "rad",
            )

    @property
    def degrees(self) -> str:
        """The two angles for messages."""
        return f"{math.degrees(self.alpha):.6g} and {math.degrees(self.beta):.6g} degrees"

    def mirrored(self) -> FiberAngles:
        """Return the mirror image: both handednesses swapped."""
        return FiberAngles(alpha=-self.alpha, beta=-self.beta)


def _require_wound(field: str, angle: float) -> None:
    """Raise InvalidInputError unless a family of this angle [rad] is wound about the axis."""
    require_in_range(field, angle, -math.pi / 2, math.pi / 2, "rad")
    if not abs(angle) >= SMALLEST_ANGLE:
        least = Quantity(SMALLEST_ANGLE, "rad", rounded_up)
        requirement = Message("at least {} from the axis (a fiber along it cannot extend)", least)
        raise InvalidInputError(field, angle, requirement, "rad")


@dataclass(frozen=True, slots=True)
class OneFamily:
    """One wound family alone: it leaves the wall a motion that the elastomer decides.

    Args:
        angle: from the tube's axis [rad], -pi/2 to pi/2; positive is right-handed.

    Raises:
        InvalidInputError: the angle is out of range or along the axis.

    Example:
        >>> OneFamily(angle=math.radians(70.0)).mirrored().angle < 0.0
        True
    """

    angle: float

    def __post_init__(self) -> None:
        _require_wound("angle", self.angle)

    def mirrored(self) -> OneFamily:
        """Return the mirror image."""
        return OneFamily(-self.angle)


@dataclass(frozen=True, slots=True)
class FiberState:
    """Deformation of the wall at one axial stretch.

    Attributes:
        stretch: axial stretch lambda_1.
        hoop_stretch: hoop stretch lambda_2.
        radial_stretch: stretch of the wall thickness, lambda_3 = 1 / (lambda_1 lambda_2).
        twist: omega = r delta / L, with r the unstretched radius and delta / L the rotation of
            the far end per unstretched length; positive is right-handed.
    """

    stretch: float
    hoop_stretch: float
    radial_stretch: float
    twist: float


class FiberDerivatives(NamedTuple):
    """Hoop stretch and wall shear with their derivatives in the axial stretch.

    Attributes:
        hoop_change: lambda_2 - 1, to rounding of itself.
        hoop: lambda_2.
        hoop_prime: d lambda_2 / d lambda_1.
        shear: g = lambda_2 omega.
        shear_prime: dg / d lambda_1.
    """

    hoop_change: float
    hoop: float
    hoop_prime: float
    shear: float
    shear_prime: float


def locking_stretch(fibers: FiberAngles) -> float:
    r"""Return the axial stretch at which the first of the two families locks.

    .. math:: \lambda_{lock} = \min(1 / |\cos\alpha|, 1 / |\cos\beta|)

    There the fiber lies along the axis; no state exists beyond.

    Example:
        >>> fibers = FiberAngles(alpha=math.radians(90.0), beta=math.radians(60.0))
        >>> round(locking_stretch(fibers), 12)
        2.0
    """
    return 1.0 / max(math.cos(fibers.alpha), math.cos(fibers.beta))


def fiber_state(fibers: FiberAngles, stretch: float) -> FiberState:
    r"""Return the hoop stretch and the twist that keep both families at their length.

    With :math:`A = \mathrm{sgn}(\sin\alpha) \sqrt{1 - \lambda_1^2 \cos^2\alpha}` and B likewise:

    .. math::
        \lambda_2 = \frac{A \cos\beta - B \cos\alpha}{\sin(\alpha - \beta)}, \qquad
        \lambda_2 \omega = \frac{B \sin\alpha - A \sin\beta}{\sin(\alpha - \beta)}

    evaluated from A - sin(alpha) and B - sin(beta), so that nothing cancels near rest.

    Args:
        fibers: the two families.
        stretch: axial stretch, 0 < stretch < locking stretch (less than 1 is contraction).

    Returns:
        The state of the wall; at ``stretch`` = 1 exactly the unstretched one.

    Raises:
        InvalidInputError: ``stretch`` is not positive and finite.
        ActuationLimitError: ``stretch`` is at or past locking.

    Source: ``docs/derivations/actuator.md``, "Two families".

    Example:
        >>> fibers = FiberAngles(alpha=math.radians(90.0), beta=math.radians(60.0))
        >>> state = fiber_state(fibers, stretch=1.2)
        >>> round(state.hoop_stretch, 12), round(state.twist, 12)
        (1.0, -0.132050807569)
    """
    require_positive("stretch", stretch)
    derivatives = fiber_derivatives(fibers, stretch)
    return FiberState(
        stretch=stretch,
        hoop_stretch=derivatives.hoop,
        radial_stretch=1.0 / (stretch * derivatives.hoop),
        twist=derivatives.shear / derivatives.hoop,
    )


def fiber_derivatives(fibers: FiberAngles, stretch: float) -> FiberDerivatives:
    r"""Return hoop stretch and wall shear with their derivatives in the stretch.

    .. math:: A' = -\lambda_1 \cos^2\alpha / A

    Both results are linear in A and B, and so are their derivatives in A' and B'.
    ``stretch`` is taken as positive; :func:`fiber_state` checks it.

    Raises:
        ActuationLimitError: ``stretch`` is at or past locking, where the derivatives diverge.

    Example:
        >>> fibers = FiberAngles(alpha=math.radians(90.0), beta=math.radians(45.0))
        >>> round(fiber_derivatives(fibers, stretch=1.0).shear_prime, 12)
        -1.0
    """
    alpha, beta = fibers.alpha, fibers.beta
    cos_alpha, sin_alpha = math.cos(alpha), math.sin(alpha)
    cos_beta, sin_beta = math.cos(beta), math.sin(beta)
    square_a = (1.0 - stretch * cos_alpha) * (1.0 + stretch * cos_alpha)
    square_b = (1.0 - stretch * cos_beta) * (1.0 + stretch * cos_beta)
    if not (square_a > 0.0 and square_b > 0.0):
        raise ActuationLimitError(
            ActuationLimit.FIBER_LOCKING, "stretch", stretch, locking_stretch(fibers)
        )
    a = math.copysign(math.sqrt(square_a), alpha)
    b = math.copysign(math.sqrt(square_b), beta)
    elongation = (stretch - 1.0) * (stretch + 1.0)  # lambda_1^2 - 1
    change_a = -elongation * cos_alpha * cos_alpha / (a + sin_alpha)  # A - sin(alpha)
    change_b = -elongation * cos_beta * cos_beta / (b + sin_beta)
    slope_a, slope_b = -stretch * cos_alpha * cos_alpha / a, -stretch * cos_beta * cos_beta / b
    crossing = math.sin(alpha - beta)
    hoop_change = (change_a * cos_beta - change_b * cos_alpha) / crossing
    return FiberDerivatives(
        hoop_change,
        1.0 + hoop_change,
        (slope_a * cos_beta - slope_b * cos_alpha) / crossing,
        (change_b * sin_alpha - change_a * sin_beta) / crossing,
        (slope_b * sin_alpha - slope_a * sin_beta) / crossing,
    )


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
    if slope >= LEAST_VOLUME_SLOPE:
        return
    raise InvalidInputError(
        "fibers",
        fibers.degrees,
        "a pair that extends under pressure: two angles of the same handedness, or of opposite "
        f"handedness with |tan(alpha) tan(beta)| > 2 (here {2.0 / (1.0 - slope):.6g}, "
        "so pressure would not extend the tube)",
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


# Nearer to 90 degrees than this the fiber's pitch is a few wall thicknesses: it is a hoop winding.
LARGEST_ANGLE = math.radians(80.0)
# Angles that differ by less are the same; a fiber that crosses a family at less is one of it.
SAME_ANGLE = 1e-9
SMALLEST_SINGLE_CROSSING = 1e-3


@dataclass(frozen=True, slots=True)
class SingleFiber:
    """One fiber glued along the tube.

    Args:
        angle: gamma, from the tube's axis [rad]; 0 is straight, positive is right-handed; at most
            80 degrees.
        position: where it leaves the base, as an angle around the tube [rad]; of two fibers only
            the difference counts, as the frame's y points half-way between them.

    Raises:
        InvalidInputError: an angle is out of range.

    Example:
        >>> SingleFiber().angle, SingleFiber(angle=0.2).position
        (0.0, 0.0)
    """

    angle: float = 0.0
    position: float = 0.0

    def __post_init__(self) -> None:
        require_in_range("angle", self.angle, -LARGEST_ANGLE, LARGEST_ANGLE, "rad")
        require_in_range("position", self.position, -2.0 * math.pi, 2.0 * math.pi, "rad")


def check_single_fibers(families: FiberAngles | OneFamily, fibers: tuple[SingleFiber, ...]) -> None:
    """Raise InvalidInputError unless single fibers leave the tube a motion, and a uniform one."""
    if not fibers:
        return
    angles = [fiber.angle for fiber in fibers]
    apart = math.degrees(_spread(fibers))
    value: object = ", ".join(f"{math.degrees(angle):.6g}" for angle in angles) + " degrees"
    crossings = [abs(math.sin(family - angles[0])) for family in family_angles(families)]
    if max(angles) - min(angles) > SAME_ANGLE:
        requirement = "at one angle: fibers that cross leave no uniform shape"
    elif min(crossings) < SMALLEST_SINGLE_CROSSING:
        requirement = "at another angle than the wound families, or left out"
    elif len(fibers) > 2:
        value, requirement = len(fibers), "at most 2: three hold the section on all sides"
    elif len(fibers) == 2 and not 0.1 <= apart <= 170.0:
        value = f"{apart:.6g} degrees apart"
        requirement = (
            "two fibers 0.1 to 170 degrees apart: nearer they are one, opposite ones let the tube "
            "neither stretch nor bend"
        )
    else:
        return
    raise InvalidInputError("single_fibers", value, requirement)


def family_angles(families: FiberAngles | OneFamily) -> tuple[float, ...]:
    """Return the angles of the wound families [rad]."""
    if isinstance(families, OneFamily):
        return (families.angle,)
    return families.alpha, families.beta


def fiber_set_of(
    families: FiberAngles | OneFamily,
    fibers: tuple[SingleFiber, ...],
    single_radius: float,
    wall_ratio: float | None,
) -> FiberSet:
    """Return the fibers as the section's kinematics takes them.

    Args:
        families: the wound ones.
        fibers: the single ones.
        single_radius: distance of the single fibers over that of the wound ones.
        wall_ratio: inner radius over that of the wound ones; None for a thin wall.
    """
    tangent = math.tan(fibers[0].angle) if fibers else 0.0
    slopes = tuple(family_slope(angle, tangent) for angle in family_angles(families))
    if not fibers:
        return FiberSet(slopes, half_spread=None, wall_ratio=wall_ratio)
    return FiberSet(slopes, tangent, 0.5 * _spread(fibers), single_radius, wall_ratio)


def _spread(fibers: tuple[SingleFiber, ...]) -> float:
    """Return the angle between two single fibers around the tube [rad], 0 for one."""
    apart = abs(fibers[-1].position - fibers[0].position) % (2.0 * math.pi)
    return min(apart, 2.0 * math.pi - apart)
