# SPDX-License-Identifier: Apache-2.0
"""Conversion between the numbers of a device and gauge pressures: unit, reference, scale."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_finite, require_non_negative

# Pascals in each unit that regulators use.
UNITS = {
    "Pa": 1.0,
    "hPa": 1.0e2,
    "mbar": 1.0e2,
    "kPa": 1.0e3,
    "bar": 1.0e5,
    "MPa": 1.0e6,
    "psi": 6894.757293168361,
}


class Reference(Enum):
    """The reference (zero) of a pressure."""

    GAUGE = "gauge"  # the air around
    ABSOLUTE = "absolute"  # vacuum, as sensor_msgs/FluidPressure defines it


@dataclass(frozen=True, slots=True)
class PressureScale:
    r"""How a device states a pressure.

    .. math:: n = n_0 + s \, (p + p_a) / u

    with the gauge pressure :math:`p`, the ambient pressure :math:`p_a` (absolute reference only),
    the unit :math:`u`, the device's number per unit :math:`s` and its number at zero :math:`n_0`.

    Args:
        unit: a key of ``UNITS``.
        reference: what the device counts from.
        ambient_pressure: absolute pressure of the air around [Pa], >= 0.
        scale: device's number per unit; not 0.
        offset: device's number at a pressure of zero.

    Raises:
        InvalidInputError: a value is out of its range.

    Example:
        >>> PressureScale("mbar", Reference.ABSOLUTE, 101325.0).to_device(50000.0)
        1513.25
        >>> volts = PressureScale("kPa", scale=10.0 / 900.0)  # 0 to 10 V for 0 to 900 kPa
        >>> round(volts.to_device(45000.0), 6), round(volts.to_gauge(0.5), 6)
        (0.5, 45000.0)
    """

    unit: str = "Pa"
    reference: Reference = Reference.GAUGE
    ambient_pressure: float = 0.0
    scale: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        if self.unit not in UNITS:
            raise InvalidInputError("unit", self.unit, f"one of {', '.join(UNITS)}")
        require_non_negative("ambient_pressure", self.ambient_pressure)
        require_finite("offset", self.offset)
        if require_finite("scale", self.scale) == 0.0:
            raise InvalidInputError("scale", self.scale, "a finite number that is not 0")

    def to_device(self, pressure: float) -> float:
        """Return the device's number of a gauge pressure [Pa]."""
        return self.offset + self.scale * (pressure + self._zero()) / UNITS[self.unit]

    def to_gauge(self, number: float) -> float:
        """Return the gauge pressure [Pa] of the device's number; any float, NaN included."""
        return (number - self.offset) / self.scale * UNITS[self.unit] - self._zero()

    def _zero(self) -> float:
        return self.ambient_pressure if self.reference is Reference.ABSOLUTE else 0.0


def require_representable(
    name: str, scale: PressureScale, pressure_limit: float, span: tuple[float, float]
) -> None:
    """Refuse a scale whose set-points are beyond a device's numbers.

    Args:
        name: of the parameter that is to be changed.
        scale: how the device states a set-point.
        pressure_limit: largest gauge pressure that is passed on [Pa].
        span: smallest and largest number of the device.

    Raises:
        InvalidInputError: 0 Pa or ``pressure_limit`` is beyond them.

    Example:
        >>> require_representable("command_format", PressureScale("hPa"), 1e5, (0, 65535))
    """
    for pressure in (0.0, pressure_limit):
        number = scale.to_device(pressure)
        if not span[0] <= number <= span[1]:
            requirement = (
                f"such that {pressure:g} Pa is a number from {span[0]:g} to {span[1]:g}; "
                "choose another format, command_unit, command_scale or pressure_limit"
            )
            raise InvalidInputError(name, number, requirement)
