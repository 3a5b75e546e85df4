# SPDX-License-Identifier: Apache-2.0
r"""How the amplitude of one vibration decays: by its material, by the air, by linear drag.

With the modal mass :math:`M = \sum m_i |\xi_i|^2` of a shape :math:`\xi` whose fastest node has
length one, and the average of the power over a period,

.. math:: \dot A = -\tfrac12 (k T + \nu) A - \chi (g A^{4/3} + b A^2)

where k is the stiffness of the material alone over the modal mass, and :math:`\chi` the factor on
the air's drag. Derived in ``docs/derivations/motion.md``, section 3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spiral_core.rod.motion.inertia import AIR_DENSITY, AIR_VISCOSITY, Damping
from spiral_core.rod.types import Array
from spiral_core.validation import require_positive

# Means of |sin|^3 and of |sin|^(7/3) over a period.
CUBE_MEAN = 4.0 / (3.0 * math.pi)
SEVEN_THIRDS_MEAN = math.gamma(5.0 / 3.0) / (math.sqrt(math.pi) * math.gamma(13.0 / 6.0))
# Intervals of equal ratio on which a decay is integrated, by Simpson's rule; even.
INTERVALS = 400


@dataclass(frozen=True, slots=True)
class Swing:
    """One vibration of small amplitude, and what takes its energy.

    Args:
        frequency: undamped [Hz].
        material: stiffness of the material over the modal mass [1/s^2]; the square of the angular
            frequency where neither weight nor tension add stiffness.
        air_creeping: g, drag of the air at low speed [m^(-1/3)/s].
        air_inertial: b, drag of the air at high speed [1/(m s)].
    """

    frequency: float
    material: float
    air_creeping: float
    air_inertial: float

    def decay_rate(self, amplitude: Array, damping: Damping) -> Array:
        """Return -dA/dt over A [1/s] at amplitudes [m] of the node that moves farthest.

        Overdamped vibrations creep back at the slower of their two rates.
        """
        half = 0.5 * (self.material * damping.retardation_time + damping.drag_rate)
        omega = 2.0 * math.pi * self.frequency
        linear = half
        if half > omega:
            linear = omega * omega / (half + math.sqrt(half * half - omega * omega))
        air = self.air_creeping * np.cbrt(amplitude) + self.air_inertial * amplitude
        rate: Array = linear + damping.air * air
        return rate

    def settling_time(self, damping: Damping, start: float, end: float) -> float:
        """Return the time in which an amplitude falls from start to end [m]; infinite undamped.

        Raises:
            InvalidInputError: an amplitude is not positive.
        """
        first, last = require_positive("start", start), require_positive("end", end)
        if not first > last:
            return 0.0
        amplitudes = np.geomspace(last, first, INTERVALS + 1)
        rates = self.decay_rate(amplitudes, damping)
        if not np.all(rates > 0.0):
            return math.inf
        from scipy.integrate import simpson  # scipy takes long to load

        return float(simpson(1.0 / rates, dx=math.log(first / last) / INTERVALS))


def air_coefficients(
    shape: Array, lengths: Array, mass: float, omega: float, diameter: float
) -> tuple[float, float]:
    """Return g and b of a vibration in air.

    Args:
        shape: displacements across the rod (n,), as speeds over that of the fastest node.
        lengths: that nodes stand for (n,) [m].
        mass: modal mass [kg].
        omega: angular frequency [rad/s].
        diameter: of the rod [m].
    """
    half, creeping = 0.5 * AIR_DENSITY / mass, 10.0 * np.cbrt(AIR_VISCOSITY / AIR_DENSITY) ** 2
    slow = half * np.cbrt(diameter) * creeping * SEVEN_THIRDS_MEAN * np.cbrt(omega)
    fast = half * diameter * CUBE_MEAN * omega
    return (
        float(slow * np.sum(lengths * np.cbrt(shape) ** 7)),
        float(fast * np.sum(lengths * shape**3)),
    )
