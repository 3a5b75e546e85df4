# SPDX-License-Identifier: Apache-2.0
r"""How air fills an actuator: flow through an orifice into a volume that grows with pressure.

Mass flow through a valve or line of sonic conductance C and critical pressure ratio b (ISO 6358-1),
from :math:`p_1` to :math:`p_2`, both absolute:

.. math:: \dot m = C \rho_0 p_1 \begin{cases} 1 & p_2/p_1 \le b \\
    \sqrt{1 - \left(\frac{p_2/p_1 - b}{1 - b}\right)^2} & \text{else} \end{cases}

and with an ideal gas at constant temperature :math:`\dot m R T = \frac{d}{dt}(p V(p))`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.rod.types import Array
from spiral_core.validation import require_in_range, require_non_negative, require_positive

# Reference conditions of ISO 6358 (ISO 8778): 100 kPa, 20 degC, 65 % humidity.
REFERENCE_PRESSURE, REFERENCE_DENSITY = 1e5, 1.185
ATMOSPHERE = 101_325.0
# Pressures in between at which the flow is looked at.
SAMPLES = 400

Volume = Callable[[float], float]


@dataclass(frozen=True, slots=True)
class Orifice:
    """A valve, a fitting or a line in the terms of ISO 6358.

    Args:
        conductance: sonic conductance C [m^3/(s Pa)], > 0; data sheets give dm^3/(s bar),
            1 dm^3/(s bar) = 1e-8 m^3/(s Pa).
        critical_ratio: b, from 0 to below 1; 0.2 to 0.5 for valves.

    Raises:
        InvalidInputError: a value is out of its range.

    Example:
        Choked from 300 kPa into the atmosphere, in grams per second:

        >>> round(1e3 * Orifice(1e-9).mass_flow(3e5, 101325.0), 3)
        0.355
    """

    conductance: float
    critical_ratio: float = 0.3

    def __post_init__(self) -> None:
        require_positive("conductance", self.conductance)
        if not require_in_range("critical_ratio", self.critical_ratio, 0.0, 1.0) < 1.0:
            raise InvalidInputError("critical_ratio", self.critical_ratio, "below 1")

    def mass_flow(self, upstream: float, downstream: float) -> float:
        """Return the mass flow [kg/s] between two absolute pressures [Pa]; negative backwards."""
        high, low = (
            require_positive("upstream", upstream),
            require_positive("downstream", downstream),
        )
        sign = 1.0
        if low > high:
            high, low, sign = low, high, -1.0
        over = max(0.0, (low / high - self.critical_ratio) / (1.0 - self.critical_ratio))
        share = math.sqrt(max(0.0, 1.0 - over * over))
        return sign * self.conductance * REFERENCE_DENSITY * high * share


def orifices_in_series(first: Orifice, second: Orifice) -> Orifice:
    r"""Return one orifice for two after each other, :math:`C^{-3} = C_1^{-3} + C_2^{-3}`.

    The approximation of ISO 6358-3's users for lines of components; b is the mean of both, weighted
    with the third powers of their resistance.

    Example:
        >>> round(orifices_in_series(Orifice(1e-9), Orifice(1e-9)).conductance * 1e9, 3)
        0.794
    """
    a, b = first.conductance**-3, second.conductance**-3
    ratio = (a * first.critical_ratio + b * second.critical_ratio) / (a + b)
    return Orifice((a + b) ** (-1.0 / 3.0), ratio)


@dataclass(frozen=True, slots=True)
class Supply:
    """What an actuator is filled from and vented to, through one orifice.

    Args:
        orifice: of regulator and line together.
        pressure: gauge pressure of the supply [Pa], > 0.
        dead_volume: of the line and fittings behind the valve [m^3], >= 0.

    Raises:
        InvalidInputError: a value is out of its range.
    """

    orifice: Orifice
    pressure: float
    dead_volume: float = 0.0

    def __post_init__(self) -> None:
        require_positive("pressure", self.pressure)
        require_non_negative("dead_volume", self.dead_volume)

    def time_to_fill(self, volume: Volume, start: float, end: float) -> float:
        """Return the time [s] in which the fully open valve takes the pressure up, or down.

        Args:
            volume: enclosed volume [m^3] of the actuator at a gauge pressure [Pa].
            start: gauge pressure [Pa].
            end: gauge pressure [Pa]; below ``start`` the tube is vented to the atmosphere.

        Returns:
            Infinite where the supply's pressure, or the atmosphere's, is not beyond ``end``.
        """
        first = require_non_negative("start", start)
        last = require_non_negative("end", end)
        # Denser towards the end, where the flow may die.
        share = 1.0 - (1.0 - np.linspace(0.0, 1.0, SAMPLES)) ** 2
        pressures: Array = first + (last - first) * share
        inverse = np.empty(SAMPLES)
        for i, pressure in enumerate(pressures):
            rate = self.rates(volume, float(pressure))[0 if last >= first else 1]
            inverse[i] = 1.0 / rate if rate > 0.0 else math.inf
        if not np.all(np.isfinite(inverse[:-1])):
            return math.inf
        # At an end where the flow dies as a root, the mean of the inverse is twice the last known.
        if not math.isfinite(inverse[-1]):
            inverse[-1] = 3.0 * inverse[-2]
        steps = 0.5 * (inverse[1:] + inverse[:-1]) * np.abs(np.diff(pressures))
        return float(np.sum(steps))

    def rates(self, volume: Volume, pressure: float) -> tuple[float, float]:
        """Return how fast a gauge pressure rises and falls with the valve fully open [Pa/s]."""
        slope = self._stored_slope(volume, pressure)
        inside = pressure + ATMOSPHERE
        fill = self.orifice.mass_flow(self.pressure + ATMOSPHERE, inside)
        vent = self.orifice.mass_flow(inside, ATMOSPHERE)
        return fill / slope, vent / slope

    def _stored_slope(self, volume: Volume, pressure: float) -> float:
        """Return d(mass)/d(pressure) [kg/Pa] of the air in actuator and line."""
        step = max(10.0, 1e-4 * pressure)
        low, high = max(0.0, pressure - step), pressure + step
        stored = [
            (gauge + ATMOSPHERE) * (require_positive("volume", volume(gauge)) + self.dead_volume)
            for gauge in (low, high)
        ]
        slope = (stored[1] - stored[0]) / (high - low)
        return require_positive("volume", slope) * REFERENCE_DENSITY / REFERENCE_PRESSURE
