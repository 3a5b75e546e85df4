# SPDX-License-Identifier: Apache-2.0
"""Fibers that run along the tube one by one and make it bend, or bend and coil."""

from __future__ import annotations

import math
from dataclasses import dataclass

from spiral_core.actuator.fibers import FiberAngles, OneFamily
from spiral_core.errors import InvalidInputError
from spiral_core.section.fiber_set import FiberSet, family_slope
from spiral_core.validation import require_in_range

# Nearer to 90 degrees than this the fiber's pitch is a few wall thicknesses: it is a hoop winding.
LARGEST_ANGLE = math.radians(80.0)
# Angles that differ by less are the same; a fiber that crosses a family at less is one of it.
SAME_ANGLE = 1e-9
SMALLEST_CROSSING = 1e-3


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
        require_in_range("angle", self.angle, -LARGEST_ANGLE, LARGEST_ANGLE)
        require_in_range("position", self.position, -2.0 * math.pi, 2.0 * math.pi)


def check_single_fibers(families: FiberAngles | OneFamily, fibers: tuple[SingleFiber, ...]) -> None:
    """Raise InvalidInputError unless single fibers leave the tube a motion, and a uniform one."""
    if not fibers:
        return
    angles = [fiber.angle for fiber in fibers]
    degrees = ", ".join(f"{math.degrees(angle):.6g}" for angle in angles) + " degrees"
    if max(angles) - min(angles) > SAME_ANGLE:
        raise InvalidInputError(
            "single_fibers", degrees, "at one angle: fibers that cross leave no uniform shape"
        )
    for family in family_angles(families):
        if abs(math.sin(family - angles[0])) < SMALLEST_CROSSING:
            raise InvalidInputError(
                "single_fibers", degrees, "at another angle than the wound families, or left out"
            )
    if len(fibers) > 2:
        raise InvalidInputError(
            "single_fibers", len(fibers), "at most 2: three hold the section on all sides"
        )
    spread = math.degrees(_spread(fibers))
    if len(fibers) == 2 and not 0.1 <= spread <= 170.0:
        raise InvalidInputError(
            "single_fibers",
            f"{spread:.6g} degrees apart",
            "two fibers 0.1 to 170 degrees apart: nearer they are one, opposite ones let the tube "
            "neither stretch nor bend",
        )


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
