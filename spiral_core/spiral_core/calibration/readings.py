# SPDX-License-Identifier: Apache-2.0
"""Readings of a bench test: one frozen value for each, with its stated error.

Every reading is a response to a pressure. Its ``measured`` components are compared with what the
model predicts at that pressure; ``error`` is their standard error, and ``pressure_error`` the
pressure's. The errors are weights: a fit estimates their common scale from its residuals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from spiral_core.validation import (
    require_finite,
    require_non_negative,
    require_positive,
    require_vector,
)


@dataclass(frozen=True, slots=True)
class ExtensionReading:
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

    def __post_init__(self) -> None:
        require_finite("extension", self.extension)
        require_positive("section_length", self.section_length)
        _check_common(self)

    @property
    def measured(self) -> tuple[float, ...]:
        """The extension [m]."""
        return (self.extension,)


@dataclass(frozen=True, slots=True)
class TwistReading:
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

    def __post_init__(self) -> None:
        require_finite("twist", self.twist)
        require_positive("section_length", self.section_length)
        _check_common(self)

    @property
    def measured(self) -> tuple[float, ...]:
        """The twist [rad]."""
        return (self.twist,)


@dataclass(frozen=True, slots=True)
class BendReading:
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

    def __post_init__(self) -> None:
        require_finite("bend_angle", self.bend_angle)
        require_positive("section_length", self.section_length)
        _check_common(self)

    @property
    def measured(self) -> tuple[float, ...]:
        """The bend angle [rad]."""
        return (self.bend_angle,)


@dataclass(frozen=True, slots=True)
class ShapeReading:
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

    def __post_init__(self) -> None:
        require_vector("position", self.position, 3)
        if self.arc_length is not None:
            require_positive("arc_length", self.arc_length)
        _check_common(self)

    @property
    def measured(self) -> tuple[float, ...]:
        """The three coordinates [m]."""
        return self.position


@dataclass(frozen=True, slots=True)
class GripReading:
    """Pressure at which a mounted gripper wraps a cylinder perfectly: its whole length touches.

    The radius is the response that is compared; a stated error of the pressure counts through the
    slope of the radius over the pressure.

    Args:
        pressure: gauge pressure [Pa], > 0.
        object_radius: radius of the cylinder [m], > 0.
        error: standard error of ``object_radius`` [m], > 0.
        pressure_error: standard error of ``pressure`` [Pa], >= 0.

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

    def __post_init__(self) -> None:
        require_positive("pressure", self.pressure)
        require_positive("object_radius", self.object_radius)
        _check_common(self)

    @property
    def measured(self) -> tuple[float, ...]:
        """The object's radius [m]."""
        return (self.object_radius,)


Reading: TypeAlias = ExtensionReading | TwistReading | BendReading | ShapeReading | GripReading


def _check_common(reading: Reading) -> None:
    """Check what all readings share."""
    require_non_negative("pressure", reading.pressure)
    require_positive("error", reading.error)
    require_non_negative("pressure_error", reading.pressure_error)
