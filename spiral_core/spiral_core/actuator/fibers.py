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

from spiral_core.actuator.section import FiberSet, family_slope
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.message import Message, Quantity
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
        >>> fibers.degrees
        '88 and 60 degrees'
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
        >>> round(OneFamily(angle=math.radians(-70.0)).angle, 3)
        -1.222
    """

    angle: float

    def __post_init__(self) -> None:
        _require_wound("angle", self.angle)


@dataclass(frozen=True, slots=True)
class FiberState:
    """Deformation of the wall at one axial stretch.

    Attributes:
        hoop_stretch: hoop stretch lambda_2.
        twist: omega = r delta / L, with r the unstretched radius and delta / L the rotation of
            the far end per unstretched length; positive is right-handed.
    """

    hoop_stretch: float
    twist: float


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
    changes = []
    for angle in (fibers.alpha, fibers.beta):
        cosine, sine = math.cos(angle), math.sin(angle)
        square = (1.0 - stretch * cosine) * (1.0 + stretch * cosine)
        if not square > 0.0:
            limit, end = ActuationLimit.FIBER_LOCKING, locking_stretch(fibers)
            raise ActuationLimitError(limit, "stretch", stretch, end)
        elongation = (stretch - 1.0) * (stretch + 1.0)  # lambda_1^2 - 1
        root = math.copysign(math.sqrt(square), angle)
        changes.append((-elongation * cosine * cosine / (root + sine), cosine, sine))
    (a, cos_alpha, sin_alpha), (b, cos_beta, sin_beta) = changes
    crossing = math.sin(fibers.alpha - fibers.beta)
    hoop = 1.0 + (a * cos_beta - b * cos_alpha) / crossing
    return FiberState(hoop, (b * sin_alpha - a * sin_beta) / crossing / hoop)


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
        "so pressure would not extend the tube)",
    )


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
    twist_shear: bool,
) -> FiberSet:
    """Return the fibers as the section's kinematics takes them.

    Args:
        families: the wound ones.
        fibers: the single ones.
        single_radius: distance of the single fibers over that of the wound ones.
        wall_ratio: inner radius over that of the wound ones; None for a thin wall.
        twist_shear: whether the energy counts the shear by the twist.
    """
    tangent = math.tan(fibers[0].angle) if fibers else 0.0
    slopes = tuple(family_slope(angle, tangent) for angle in family_angles(families))
    if not fibers:
        return FiberSet(slopes, half_spread=None, wall_ratio=wall_ratio, twist_shear=twist_shear)
    return FiberSet(slopes, tangent, 0.5 * _spread(fibers), single_radius, wall_ratio, twist_shear)


def _spread(fibers: tuple[SingleFiber, ...]) -> float:
    """Return the angle between two single fibers around the tube [rad], 0 for one."""
    apart = abs(fibers[-1].position - fibers[0].position) % (2.0 * math.pi)
    return min(apart, 2.0 * math.pi - apart)
