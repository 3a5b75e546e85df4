# SPDX-License-Identifier: Apache-2.0
r"""Incompressible hyperelastic laws: energy per unstretched volume from the invariants I1 and I2.

Laws work on scalar floats with ``math``: an actuator evaluates its law a hundred to some thousand
times when it is built, and not when it answers.

The initial Young's modulus of any of them is :math:`E = 6 (\partial u/\partial I_1 +
\partial u/\partial I_2)` at rest (I1 = I2 = 3), and the shear modulus is a third of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.validation import require_finite, require_positive


class InvariantDerivatives(NamedTuple):
    """Derivatives of an energy density u(I1, I2) [Pa].

    Attributes:
        first: du/dI1.
        second: du/dI2.
    """

    first: float
    second: float


@runtime_checkable
class HyperelasticLaw(Protocol):
    """The interface of an elastomer's law: any object with these members."""

    @property
    def small_strain_modulus(self) -> float:
        """Initial Young's modulus E [Pa], > 0."""
        ...

    @property
    def first_invariant_limit(self) -> float:
        """I1 at which the energy diverges; infinite for a law without such a limit."""
        ...

    def energy_density(self, first_invariant: float, second_invariant: float) -> float:
        """Return the energy per unstretched volume [J/m^3], zero at rest."""
        ...

    def invariant_derivatives(
        self, first_invariant: float, second_invariant: float
    ) -> InvariantDerivatives:
        """Return the derivatives of the energy density [Pa]."""
        ...


@dataclass(frozen=True, slots=True)
class NeoHookean:
    r"""Neo-Hookean elastomer: the simplest law, fair up to some 30-40 % strain.

    .. math:: u = C_1 (I_1 - 3), \qquad E = 6 C_1

    Args:
        c1: C1 [Pa], > 0.

    Raises:
        InvalidInputError: ``c1`` is not positive and finite.

    Source: L. R. G. Treloar, The Physics of Rubber Elasticity, 3rd ed., 1975, ch. 4.

    Example:
        >>> law = NeoHookean(c1=145.0e3)
        >>> law.small_strain_modulus
        870000.0
        >>> law.energy_density(3.1, 3.1).__round__(6)
        14500.0
    """

    c1: float

    def __post_init__(self) -> None:
        require_positive("c1", self.c1)

    @property
    def small_strain_modulus(self) -> float:
        """E = 6 C1 [Pa]."""
        return 6.0 * self.c1

    @property
    def first_invariant_limit(self) -> float:
        """Infinite: this law has no limit of chain extension."""
        return math.inf

    def energy_density(self, first_invariant: float, second_invariant: float) -> float:
        """Return C1 (I1 - 3) [J/m^3]; ``second_invariant`` has no part in it."""
        return self.c1 * (first_invariant - 3.0)

    def invariant_derivatives(
        self, first_invariant: float, second_invariant: float
    ) -> InvariantDerivatives:
        """Return the constant derivatives (C1, 0) [Pa]."""
        return InvariantDerivatives(self.c1, 0.0)


@dataclass(frozen=True, slots=True)
class MooneyRivlin:
    r"""Two-constant Mooney-Rivlin elastomer, the law the spiral-gripper paper fits.

    .. math:: u = C_1 (I_1 - 3) + C_2 (I_2 - 3), \qquad E = 6 (C_1 + C_2)

    Either constant may be negative, as published fits over one kind of test sometimes are; their
    sum may not, or the tube would be unstable at rest. Whether a law with a negative constant
    stays stable under pressure is found by the limit point of the actuator, not here.

    Args:
        c1: C1 [Pa].
        c2: C2 [Pa]; C1 + C2 > 0.

    Raises:
        InvalidInputError: a constant is not finite, or C1 + C2 is not positive.

    Source: L. R. G. Treloar, The Physics of Rubber Elasticity, 3rd ed., 1975, ch. 5.

    Example:
        >>> law = MooneyRivlin(c1=130.0e3, c2=15.0e3)
        >>> law.small_strain_modulus
        870000.0
        >>> law.energy_density(3.1, 3.2).__round__(6)
        16000.0
    """

    c1: float
    c2: float

    def __post_init__(self) -> None:
        c1, c2 = require_finite("c1", self.c1), require_finite("c2", self.c2)
        if not c1 + c2 > 0.0:
            raise InvalidInputError("c1 + c2", c1 + c2, "positive, so that the modulus at rest is")

    @property
    def small_strain_modulus(self) -> float:
        """E = 6 (C1 + C2) [Pa]."""
        return 6.0 * (self.c1 + self.c2)

    @property
    def first_invariant_limit(self) -> float:
        """Infinite: this law has no limit of chain extension."""
        return math.inf

    def energy_density(self, first_invariant: float, second_invariant: float) -> float:
        """Return C1 (I1 - 3) + C2 (I2 - 3) [J/m^3]."""
        return self.c1 * (first_invariant - 3.0) + self.c2 * (second_invariant - 3.0)

    def invariant_derivatives(
        self, first_invariant: float, second_invariant: float
    ) -> InvariantDerivatives:
        """Return the constant derivatives (C1, C2) [Pa]."""
        return InvariantDerivatives(self.c1, self.c2)


@dataclass(frozen=True, slots=True)
class Yeoh:
    r"""Three-constant Yeoh elastomer: softens, then stiffens (c2 < 0 < c3 in most fits).

    .. math:: u = C_1 (I_1 - 3) + C_2 (I_1 - 3)^2 + C_3 (I_1 - 3)^3, \qquad E = 6 C_1

    Args:
        c1: C1 [Pa], > 0.
        c2: C2 [Pa], either sign.
        c3: C3 [Pa], either sign.

    Raises:
        InvalidInputError: ``c1`` is not positive, or a constant is not finite.

    Source: O. H. Yeoh, Rubber Chemistry and Technology 66(5), 1993, 754-771.

    Example:
        >>> law = Yeoh(c1=145.0e3, c2=-5.0e3, c3=1.0e3)
        >>> law.small_strain_modulus
        870000.0
        >>> law.energy_density(5.0, 4.0).__round__(6)
        278000.0
    """

    c1: float
    c2: float
    c3: float

    def __post_init__(self) -> None:
        require_positive("c1", self.c1)
        require_finite("c2", self.c2)
        require_finite("c3", self.c3)

    @property
    def small_strain_modulus(self) -> float:
        """E = 6 C1 [Pa]."""
        return 6.0 * self.c1

    @property
    def first_invariant_limit(self) -> float:
        """Infinite: a polynomial has no pole."""
        return math.inf

    def energy_density(self, first_invariant: float, second_invariant: float) -> float:
        """Return the cubic in I1 - 3 [J/m^3]; ``second_invariant`` has no part in it."""
        x = first_invariant - 3.0
        return x * (self.c1 + x * (self.c2 + x * self.c3))

    def invariant_derivatives(
        self, first_invariant: float, second_invariant: float
    ) -> InvariantDerivatives:
        """Return the derivatives of the cubic [Pa]; those in I2 vanish."""
        x = first_invariant - 3.0
        first = self.c1 + x * (2.0 * self.c2 + x * 3.0 * self.c3)
        return InvariantDerivatives(first, 0.0)


@dataclass(frozen=True, slots=True)
class Gent:
    r"""Gent elastomer: neo-Hookean at first, whose chains are fully extended at I1 - 3 = Jm.

    .. math:: u = -\frac{\mu J_m}{2} \ln\left(1 - \frac{I_1 - 3}{J_m}\right), \qquad E = 3 \mu

    Args:
        shear_modulus: initial shear modulus mu [Pa], > 0.
        extension_limit: Jm, the largest I1 - 3, > 0 (30 to 100 for natural rubber).

    Raises:
        InvalidInputError: a parameter is not positive and finite.

    Source: A. N. Gent, Rubber Chemistry and Technology 69(1), 1996, 59-61.

    Example:
        >>> law = Gent(shear_modulus=290.0e3, extension_limit=50.0)
        >>> law.small_strain_modulus
        870000.0
        >>> round(law.energy_density(3.5, 3.4))
        72865
    """

    shear_modulus: float
    extension_limit: float

    def __post_init__(self) -> None:
        require_positive("shear_modulus", self.shear_modulus)
        require_positive("extension_limit", self.extension_limit)

    @property
    def small_strain_modulus(self) -> float:
        """E = 3 mu [Pa]."""
        return 3.0 * self.shear_modulus

    @property
    def first_invariant_limit(self) -> float:
        """I1 at which the chains are fully extended, 3 + Jm."""
        return 3.0 + self.extension_limit

    def energy_density(self, first_invariant: float, second_invariant: float) -> float:
        """Return the logarithmic energy [J/m^3]; ``second_invariant`` has no part in it.

        Raises:
            ActuationLimitError: ``first_invariant`` has reached 3 + Jm.
        """
        self._refuse_past_limit(first_invariant)
        jm = self.extension_limit
        return -0.5 * self.shear_modulus * jm * math.log1p(-(first_invariant - 3.0) / jm)

    def invariant_derivatives(
        self, first_invariant: float, second_invariant: float
    ) -> InvariantDerivatives:
        """Return the derivatives of the logarithm [Pa]; those in I2 vanish.

        Raises:
            ActuationLimitError: ``first_invariant`` has reached 3 + Jm.
        """
        self._refuse_past_limit(first_invariant)
        remaining = 1.0 - (first_invariant - 3.0) / self.extension_limit
        return InvariantDerivatives(0.5 * self.shear_modulus / remaining, 0.0)

    def _refuse_past_limit(self, first_invariant: float) -> None:
        if not first_invariant - 3.0 < self.extension_limit:
            raise ActuationLimitError(
                ActuationLimit.MATERIAL_LIMIT,
                "first_invariant",
                first_invariant,
                self.first_invariant_limit,
            )
