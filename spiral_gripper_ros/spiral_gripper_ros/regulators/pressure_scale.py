# SPDX-License-Identifier: Apache-2.0
"""Conversion between the numbers of a device and gauge pressures: unit, reference, scale."""

from __future__ import annotations

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.regulators.parameters import ABSOLUTE, UNITS, RegulatorParameters


class PressureScale:
    r"""How a device states a pressure.

    .. math:: n = n_0 + s \, (p + p_a) / u

    with the gauge pressure :math:`p`, the ambient pressure :math:`p_a` (absolute reference only),
    the unit :math:`u`, the device's number per unit :math:`s` and its number at zero :math:`n_0`.

    Args:
        values: checked values.
        side: "command" or "measured".

    Raises:
        InvalidInputError: the scale is 0.

    Example:
        >>> given = {"command_unit": "mbar", "command_reference": "absolute"}
        >>> PressureScale(RegulatorParameters(**given), "command").to_device(50000.0)
        1513.25
        >>> given = {"measured_unit": "kPa", "measured_scale": 10.0 / 900.0}
        >>> volts = PressureScale(RegulatorParameters(**given), "measured")  # 0 to 10 V: 900 kPa
        >>> round(volts.to_device(45000.0), 6), round(volts.to_gauge(0.5), 6)
        (0.5, 45000.0)
    """

    def __init__(self, values: RegulatorParameters, side: str) -> None:
        unit, reference, self._scale, self._offset = (
            getattr(values, f"{side}_{part}") for part in ("unit", "reference", "scale", "offset")
        )
        if self._scale == 0.0:
            raise InvalidInputError(f"{side}_scale", 0.0, "a number that is not 0")
        self._unit = UNITS[unit]
        self._zero = values.ambient_pressure if reference == ABSOLUTE else 0.0

    def to_device(self, pressure: float) -> float:
        """Return the device's number of a gauge pressure [Pa]."""
        return float(self._offset + self._scale * (pressure + self._zero) / self._unit)

    def to_gauge(self, number: float) -> float:
        """Return the gauge pressure [Pa] of the device's number; any float, NaN included."""
        return float((number - self._offset) / self._scale * self._unit - self._zero)


def require_representable(
    name: str, values: RegulatorParameters, span: tuple[float, float]
) -> None:
    """Refuse a scale whose set-points are beyond a device's numbers.

    Args:
        name: of the parameter that is to be changed.
        values: with the scale, and the largest gauge pressure that is passed on.
        span: smallest and largest number of the device.

    Raises:
        InvalidInputError: 0 Pa or ``pressure_limit`` is beyond them.

    Example:
        >>> require_representable("command_format", RegulatorParameters(), (0.0, 1.0e6))
    """
    scale = PressureScale(values, "command")
    for pressure in (0.0, values.pressure_limit):
        number = scale.to_device(pressure)
        if not span[0] <= number <= span[1]:
            requirement = (
                f"such that {pressure:g} Pa is a number from {span[0]:g} to {span[1]:g}; "
                "choose another format, command_unit, command_scale or pressure_limit"
            )
            raise InvalidInputError(name, number, requirement)
