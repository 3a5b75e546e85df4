# SPDX-License-Identifier: Apache-2.0
"""Readings of a bench test: one frozen value for each, with its stated error.

Every reading is a response to a pressure. Its ``measured`` components are compared with what the
model predicts at that pressure; ``error`` is their standard error, and ``pressure_error`` the
pressure's. The errors are weights: a fit estimates their common scale from its residuals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any, ClassVar, TypeAlias

from spiral_core.errors import InvalidInputError
from spiral_core.validation import (
    require_finite,
    require_non_negative,
    require_positive,
    require_vector,
)

# No measurement is larger, and none is known better [SI]: ratios and their squares stay finite.
LARGEST = 1.0e12
LEAST_ERROR = 1.0e-12
# What a reading's fields must be.
_CHECKS: dict[str, Callable[[str, Any], object]] = {
    "pressure": require_non_negative,
    "extension": require_finite,
    "twist": require_finite,
    "bend_angle": require_finite,
    "position": partial(require_vector, size=3),
    "object_radius": require_positive,
    "section_length": require_positive,
    "arc_length": require_positive,
    "contact_shift": require_finite,
    "error": require_positive,
    "pressure_error": require_non_negative,
}


def require_size(field: str, *values: float) -> None:
    """Refuse numbers [SI] above :data:`LARGEST`, and an error below :data:`LEAST_ERROR`.

    Raises:
        InvalidInputError: one of them is; the field's name is in it.
    """
    least = LEAST_ERROR if field == "error" else 0.0
    for value in values:
        if not least <= abs(value) <= LARGEST:
            requirement = f"from {least:g} to {LARGEST:g} in size, in SI units"
            raise InvalidInputError(field, value, requirement)


class _Reading:
    """What all readings share.

    Attributes:
        quantity: name of the field that was measured.
    """

    __slots__ = ()
    quantity: ClassVar[str]

    def __post_init__(self) -> None:
        for each in fields(self):  # type: ignore[arg-type]  # of the dataclass that inherits
            value = getattr(self, each.name)
            if each.name in ("arc_length", "contact_shift") and value is None:
                continue
            _CHECKS[each.name](each.name, value)
            require_size(each.name, *(value if each.name == "position" else (value,)))

    @property
    def measured(self) -> tuple[float, ...]:
        """The measured components, in SI units."""
        value: float = getattr(self, self.quantity)
        return (value,)


@dataclass(frozen=True, slots=True)
class ExtensionReading(_Reading):
    """Extension of a straight section: tube and wound fibers without the straight fiber.

    Args:
        pressure: gauge pressure [Pa], >= 0.
        extension: gain in length of the section [m].
        section_length: unstretched length of the section [m], > 0.
        error: standard error of ``extension`` [m], > 0.
        pressure_error: standard error of ``pressure`` [Pa], >= 0.

    Raises:
        InvalidInputError: a value is out of its range.

    Example:
        >>> ExtensionReading(40.0e3, 0.012, section_length=0.1, error=2.0e-4).measured
        (0.012,)
    """

    pressure: float
    extension: float
    section_length: float
    error: float
    pressure_error: float = 0.0

    quantity: ClassVar[str] = "extension"


@dataclass(frozen=True, slots=True)
class TwistReading(_Reading):
    """Rotation of the far end of a straight section about its axis.

    Args:
        pressure: gauge pressure [Pa], >= 0.
        twist: rotation of the far end [rad]; positive is right-handed.
        section_length: unstretched length of the section [m], > 0.
        error: standard error of ``twist`` [rad], > 0.
        pressure_error: standard error of ``pressure`` [Pa], >= 0.

    Raises:
        InvalidInputError: a value is out of its range.

    Example:
        >>> TwistReading(40.0e3, -1.3, section_length=0.1, error=0.02).measured
        (-1.3,)
    """

    pressure: float
    twist: float
    section_length: float
    error: float
    pressure_error: float = 0.0

    quantity: ClassVar[str] = "twist"


@dataclass(frozen=True, slots=True)
class BendReading(_Reading):
    """Angle through which a finished actuator bends when nothing but pressure loads it.

    Args:
        pressure: gauge pressure [Pa], >= 0.
        bend_angle: curvature times length [rad]: the angle between the tangents of its two ends,
            for an actuator that does not twist.
        section_length: unstretched length that bends [m], > 0.
        error: standard error of ``bend_angle`` [rad], > 0.
        pressure_error: standard error of ``pressure`` [Pa], >= 0.

    Raises:
        InvalidInputError: a value is out of its range.

    Example:
        >>> BendReading(100.0e3, 0.97, section_length=0.18, error=0.02).measured
        (0.97,)
    """

    pressure: float
    bend_angle: float
    section_length: float
    error: float
    pressure_error: float = 0.0

    quantity: ClassVar[str] = "bend_angle"


@dataclass(frozen=True, slots=True)
class ShapeReading(_Reading):
    """Position of one point of the backbone of a mounted gripper, under its weight.

    Args:
        pressure: gauge pressure [Pa], >= 0.
        position: of the point in the base frame (3,) [m].
        arc_length: unstretched length from the base to the point [m], > 0; None is the tip.
        error: standard error of each coordinate [m], > 0.
        pressure_error: standard error of ``pressure`` [Pa], >= 0.

    Raises:
        InvalidInputError: a value is out of its range.

    Example:
        >>> ShapeReading(40.0e3, (0.2, 0.1, -0.05), arc_length=None, error=1.0e-3).measured
        (0.2, 0.1, -0.05)
    """

    pressure: float
    position: tuple[float, float, float]
    arc_length: float | None
    error: float
    pressure_error: float = 0.0

    quantity: ClassVar[str] = "position"

    @property
    def measured(self) -> tuple[float, ...]:
        """The three coordinates [m]."""
        return self.position


@dataclass(frozen=True, slots=True)
class GripReading(_Reading):
    """Lowest pressure at which the tip of a mounted gripper touches the cylinder that it wraps.

    The cylinder lies where the free coil would wrap it, as :func:`spiral_core.lay_into_coil` has
    it. The radius is the response that is compared; a stated error of the pressure counts through
    the slope of the radius over the pressure.

    Args:
        pressure: gauge pressure [Pa], > 0.
        object_radius: radius of the cylinder [m], > 0.
        error: standard error of ``object_radius`` [m], > 0.
        pressure_error: standard error of ``pressure`` [Pa], >= 0.
        contact_shift: radius of the cylinder minus that of the free coil when the tip touches [m];
            None: a fit computes it (:func:`spiral_core.calibration.model.with_contact`). 0 is a
            radius of the free coil, by the tip criterion.

    Raises:
        InvalidInputError: a value is out of its range.

    Example:
        >>> GripReading(47.0e3, 0.021, error=1.0e-4, pressure_error=1.0e3).measured
        (0.021,)
    """

    pressure: float
    object_radius: float
    error: float
    pressure_error: float = 0.0
    contact_shift: float | None = field(default=None, compare=False)

    quantity: ClassVar[str] = "object_radius"

    def __post_init__(self) -> None:
        require_positive("pressure", self.pressure)
        _Reading.__post_init__(self)


Reading: TypeAlias = ExtensionReading | TwistReading | BendReading | ShapeReading | GripReading
