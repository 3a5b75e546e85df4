# SPDX-License-Identifier: Apache-2.0
r"""Kinematics of a tube wound with two families of fibers that cannot stretch.

The wall maps an unstretched line element (axial, hoop) by :math:`\lambda_1` along the axis,
:math:`\lambda_2` around it, and a shear :math:`g = \lambda_2 \omega` of the hoop direction per
axial length. A fiber at angle :math:`\varphi` from the axis keeps its length when

.. math:: \lambda_1^2 \cos^2\varphi + (\lambda_2 \sin\varphi + g \cos\varphi)^2 = 1

The derivation, and the branch taken, is in ``docs/derivations/actuator.md``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
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
            require_in_range(field, angle, -math.pi / 2, math.pi / 2)
            if not abs(angle) >= SMALLEST_ANGLE:
                raise InvalidInputError(
                    field,
                    angle,
                    f"at least {SMALLEST_ANGLE} rad from the axis (a fiber along it cannot extend)",
                )
        if not abs(math.sin(self.alpha - self.beta)) >= SMALLEST_CROSSING:
            raise InvalidInputError(
                "alpha, beta",
                (self.alpha, self.beta),
                f"angles of two families that cross (|sin(alpha - beta)| >= {SMALLEST_CROSSING})",
            )

    @property
    def degrees(self) -> str:
        """The two angles for messages."""
        return f"{math.degrees(self.alpha):.6g} and {math.degrees(self.beta):.6g} degrees"

    def mirrored(self) -> FiberAngles:
        """Return the mirror image: both handednesses swapped."""
        return FiberAngles(alpha=-self.alpha, beta=-self.beta)


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
        require_in_range("angle", self.angle, -math.pi / 2, math.pi / 2)
        if not abs(self.angle) >= SMALLEST_ANGLE:
            raise InvalidInputError(
                "angle", self.angle, f"at least {SMALLEST_ANGLE} rad from the axis"
            )

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
