# SPDX-License-Identifier: Apache-2.0
"""Inertia and damping of a rod: its mass, the damping of its material, the drag of the air."""

from __future__ import annotations

import math
from dataclasses import dataclass

from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_non_negative, require_positive

# Kelvin-Voigt: loss factor over angular frequency. Silicone and latex lose 5 to 20 % at 1 Hz
# (Nashif, Jones, Henderson, Vibration Damping, 1985, ch. 3): 0.008 to 0.03 s.
DEFAULT_RETARDATION_TIME = 0.016
# Dry air at 20 degC and one atmosphere.
AIR_DENSITY, AIR_VISCOSITY = 1.204, 1.82e-5


@dataclass(frozen=True, slots=True)
class Inertia:
    r"""Inertia of a rod per length.

    .. math:: T = \int \tfrac12 m |\dot p|^2 + \tfrac12 j (|\dot d_2|^2 + |\dot d_3|^2) \, ds

    with the directors :math:`d_2, d_3` across the rod: a section whose second moment is the same in
    every direction, j about a diameter and 2 j about the axis.

    Args:
        mass: m [kg/m], > 0.
        rotary: j [kg m], > 0.

    Raises:
        InvalidInputError: a value is not positive and finite.

    Example:
        >>> tube = Inertia.round(density=1100.0, radius=5.0e-3, bore=4.0e-3)
        >>> round(tube.mass, 6), round(tube.rotary, 12)
        (0.031102, 3.18793e-07)
    """

    mass: float
    rotary: float

    def __post_init__(self) -> None:
        require_positive("mass", self.mass)
        require_positive("rotary", self.rotary)

    @classmethod
    def round(cls, density: float, radius: float, bore: float = 0.0) -> Inertia:
        """Return the inertia of a solid or hollow round section.

        Args:
            density: [kg/m^3].
            radius: outer radius [m].
            bore: inner radius [m].
        """
        outer, inner = require_positive("radius", radius), require_non_negative("bore", bore)
        if not inner < outer:
            raise InvalidInputError("bore", bore, "at least 0 and less than the radius")
        mass = require_positive("density", density) * math.pi * (outer**2 - inner**2)
        return cls(mass, 0.25 * mass * (outer**2 + inner**2))


@dataclass(frozen=True, slots=True)
class Damping:
    r"""The damping of a moving rod.

    - The material (Kelvin-Voigt): the moment :math:`K (u - u^* + T \dot u)`, with one retardation
      time T for bending and twist; a vibration of frequency f decays with the damping ratio
      :math:`\pi f T`.
    - The air: drag across the rod, :math:`\tfrac12 \rho C_d d |v| v` per length, with
      :math:`C_d = 1 + 10 Re^{-2/3}` (White, Viscous Fluid Flow, 3rd ed., section 3-9.2).
    - A linear drag :math:`\nu m v`, which no material has; other codes damp so.

    Args:
        retardation_time: T [s], >= 0; silicone and latex tubes from 0.005 to 0.05 s.
        air: factor on the drag of air at rest, >= 0; 0 without air, from 0.7 to 1.5 for a smooth
            tube (C_d is known to that).
        drag_rate: nu [1/s], >= 0.

    Raises:
        InvalidInputError: a value is negative or not finite.
    """

    retardation_time: float = DEFAULT_RETARDATION_TIME
    air: float = 1.0
    drag_rate: float = 0.0

    def __post_init__(self) -> None:
        require_non_negative("retardation_time", self.retardation_time)
        require_non_negative("air", self.air)
        require_non_negative("drag_rate", self.drag_rate)


UNDAMPED = Damping(0.0, 0.0)
