# SPDX-License-Identifier: Apache-2.0
"""An elastomer law of your own: the pressure that wraps an object of 20 mm, by two exponents.

Run ``python examples/elastomer_law.py``. The law is the one-term law of O. Lopez-Pamies (Comptes
Rendus Mecanique 338, 2010, 3-11), u = 3^(1-a) / (2 a) mu (I1^a - 3^a); a = 1 is neo-Hooke's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from spiral_core import InvariantDerivatives, WrapCurve, gripper_from_actuator
from spiral_gripper import load_description


@dataclass(frozen=True)  # hashable: a law is the key of a cache
class LopezPamies:
    """The members of ``spiral_core.HyperelasticLaw``: an energy of two invariants."""

    shear_modulus: float  # [Pa]
    exponent: float

    @property
    def small_strain_modulus(self) -> float:
        """Young's modulus at small strain [Pa]."""
        return 3.0 * self.shear_modulus

    @property
    def first_invariant_limit(self) -> float:
        """I1 at which the law ends: nowhere."""
        return math.inf

    def energy_density(self, first_invariant: float, second_invariant: float) -> float:
        """Return the energy per volume at rest [J/m^3]."""
        a = self.exponent
        scale = self.shear_modulus * math.pow(3.0, 1.0 - a) / (2.0 * a)
        return scale * (math.pow(first_invariant, a) - math.pow(3.0, a))

    def invariant_derivatives(
        self, first_invariant: float, second_invariant: float
    ) -> InvariantDerivatives:
        """Return the derivatives of the energy by I1 and I2 [Pa]."""
        first = 0.5 * self.shear_modulus * math.pow(first_invariant / 3.0, self.exponent - 1.0)
        return InvariantDerivatives(first=first, second=0.0)


actuator = load_description("paper_design_70").actuator
for exponent in (1.0, 0.8):
    stiff = replace(actuator, material=LopezPamies(shear_modulus=290.0e3, exponent=exponent))
    curve = WrapCurve(gripper_from_actuator("my law", stiff, density=950.0))
    print(f"a = {exponent}: {1e-3 * curve.pressure_from_radius(0.02):.2f} kPa")
