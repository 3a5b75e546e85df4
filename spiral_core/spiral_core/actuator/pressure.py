# SPDX-License-Identifier: Apache-2.0
r"""Pressure that holds an actuator at a stretch, by virtual work on the tube.

By the uniform law, the elastomer's energy and the enclosed volume depend on the axial stretch
alone, because the two fiber families fix the hoop stretch and the twist. In equilibrium P dV = dU:

.. math:: P(\lambda_1) = V_t \, \frac{du/d\lambda_1}{dV/d\lambda_1}, \qquad
    V = \pi r^2 L \, \lambda_1 \lambda_2^2, \qquad V_t = \pi \, ((r + t)^2 - r^2) \, L

The derivation is in ``docs/derivations/actuator.md``. The section law, the default, is in
:mod:`spiral_core.actuator.section_curve`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from spiral_core.actuator.actuator import Actuator, PressureLaw
from spiral_core.actuator.fibers import FiberDerivatives, OneFamily, fiber_derivatives
from spiral_core.actuator.one_family import OneFamilyPath, one_family_path
from spiral_core.actuator.section_curve import SectionEnergy
from spiral_core.actuator.volume import (
    largest_volume_stretch,
    require_extending,
    volume_ratio_from_derivatives,
)
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.section.path import ShapePath, section_path
from spiral_core.validation import require_finite, require_positive


class Invariants(NamedTuple):
    """Invariants I1 and I2 of the wall's deformation and their derivatives in the stretch.

    Attributes:
        first: I1, and with a prime and a second prime its derivatives.
        first_prime: dI1 / d lambda_1.
        first_double_prime: second derivative of I1.
        second: I2.
        second_prime: dI2 / d lambda_1.
        second_double_prime: second derivative of I2.
    """

    first: float
    first_prime: float
    first_double_prime: float
    second: float
    second_prime: float
    second_double_prime: float


class PressurePoint(NamedTuple):
    """Pressure [Pa] at a stretch, and its derivative dP / d lambda_1 [Pa]."""

    pressure: float
    slope: float


def invariants_from_derivatives(
    stretch: float, derivatives: FiberDerivatives, twist_shear: bool = True
) -> Invariants:
    r"""Return I1 and I2 of the wall and their first two derivatives in the stretch.

    With :math:`g = \lambda_2 \omega`, :math:`a = \lambda_1 \lambda_2` and
    :math:`T = \lambda_1^2 + \lambda_2^2 + g^2` (without g if the twist's shear is left out):

    .. math:: I_1 = T + a^{-2}, \qquad I_2 = a^2 + T a^{-2}

    Args:
        stretch: axial stretch, > 0.
        derivatives: hoop stretch and shear at that stretch.
        twist_shear: whether g counts.

    Source: ``docs/derivations/actuator.md``, "Energy".

    Example:
        >>> import math
        >>> from spiral_core.actuator.fibers import FiberAngles
        >>> derivatives = fiber_derivatives(FiberAngles(alpha=math.pi / 2, beta=math.pi / 3), 1.1)
        >>> result = invariants_from_derivatives(1.1, derivatives)
        >>> round(result.first, 6), round(result.second, 6)
        (3.040256, 3.039595)
    """
    hoop, hoop_1, hoop_2, shear, shear_1, shear_2 = derivatives
    t = stretch * stretch + hoop * hoop
    t_1 = 2.0 * (stretch + hoop * hoop_1)
    t_2 = 2.0 * (1.0 + hoop_1 * hoop_1 + hoop * hoop_2)
    if twist_shear:
        t += shear * shear
        t_1 += 2.0 * shear * shear_1
        t_2 += 2.0 * (shear_1 * shear_1 + shear * shear_2)
    a = stretch * hoop
    a_1 = hoop + stretch * hoop_1
    a_2 = 2.0 * hoop_1 + stretch * hoop_2
    q = 1.0 / (a * a)
    q_1 = -2.0 * q * a_1 / a
    q_2 = -2.0 * q * a_2 / a + 6.0 * q * q * a_1 * a_1
    return Invariants(
        t + q,
        t_1 + q_1,
        t_2 + q_2,
        a * a + t * q,
        2.0 * a * a_1 + t_1 * q + t * q_1,
        2.0 * (a_1 * a_1 + a * a_2) + t_2 * q + 2.0 * t_1 * q_1 + t * q_2,
    )


def energy_from_stretch(actuator: Actuator, stretch: float) -> float:
    """Return the elastic energy of the whole tube by the uniform law [J], zero at rest.

    Args:
        actuator: the actuator, whatever its own law.
        stretch: axial stretch, positive and below fiber locking.

    Raises:
        InvalidInputError: the stretch is not positive and finite.
        ActuationLimitError: fiber locking, or the elastomer's limit, is reached.

    Source: ``docs/derivations/actuator.md``, "Energy".

    Example:
        >>> import math
        >>> from spiral_core import FiberAngles, NeoHookean, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=NeoHookean(c1=145.0e3),
        ... )
        >>> round(energy_from_stretch(actuator, 1.1), 6)
        0.077412
    """
    require_positive("stretch", stretch)
    derivatives = fiber_derivatives(actuator.fiber_pair, stretch)
    values = invariants_from_derivatives(stretch, derivatives, actuator.twist_shear)
    density = actuator.material.energy_density(values.first, values.second)
    return density * actuator.tube.wall_area * actuator.tube.length


def pressure_point(actuator: Actuator, stretch: float) -> PressurePoint:
    r"""Return the pressure and its derivative at a stretch that is known to be valid.

    .. math:: P = c \frac{u'}{v'}, \qquad P' = c \frac{u'' v' - u' v''}{v'^2}, \qquad
        c = \frac{(r + t)^2 - r^2}{r^2}

    The hot path of the inverse: no checks. :func:`pressure_from_stretch` makes them.

    Args:
        actuator: an actuator that extends.
        stretch: axial stretch, between 1 and the first of fiber locking and largest volume.

    Raises:
        ActuationLimitError: fiber locking, or the elastomer's limit, is reached.
    """
    derivatives = fiber_derivatives(actuator.fiber_pair, stretch)
    i1, i1_1, i1_2, i2, i2_1, i2_2 = invariants_from_derivatives(
        stretch, derivatives, actuator.twist_shear
    )
    u_1, u_2, u_11, u_12, u_22 = actuator.material.invariant_derivatives(i1, i2)
    energy_1 = u_1 * i1_1 + u_2 * i2_1
    energy_2 = (
        u_1 * i1_2 + u_2 * i2_2 + i1_1 * (u_11 * i1_1 + 2.0 * u_12 * i2_1) + u_22 * i2_1 * i2_1
    )
    _, volume_1, volume_2 = volume_ratio_from_derivatives(stretch, derivatives)
    tube = actuator.tube
    relative_wall = tube.wall_thickness / tube.inner_radius
    scale = relative_wall * (2.0 + relative_wall) / volume_1
    pressure = scale * energy_1
    return PressurePoint(pressure, scale * energy_2 - pressure * volume_2 / volume_1)


def pressure_from_stretch(actuator: Actuator, stretch: float) -> float:
    """Return the gauge pressure that holds the actuator at an axial stretch, by its own law.

    Equilibria past a limit point, where the pressure falls as the tube balloons, are answered too:
    whether a state can be reached by pressure is for :class:`spiral_core.FreeActuation` to say.

    Args:
        actuator: the actuator.
        stretch: axial stretch, >= 1.

    Returns:
        The pressure [Pa]; 0 at ``stretch`` = 1.

    Raises:
        InvalidInputError: ``stretch`` is below 1, or the fibers make the tube shorten.
        ActuationLimitError: fiber locking, the largest volume or the elastomer's limit is reached.

    Source: ``docs/derivations/actuator.md``, "Pressure".

    Example:
        >>> import math
        >>> from spiral_core import FiberAngles, MooneyRivlin, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=MooneyRivlin(c1=130.0e3, c2=15.0e3),
        ... )
        >>> round(pressure_from_stretch(actuator, 1.1))
        56477
        >>> from dataclasses import replace
        >>> even = replace(actuator, pressure_law=PressureLaw.UNIFORM)
        >>> round(pressure_from_stretch(even, 1.1))
        39787
    """
    return pressures_from_stretches(actuator, (stretch,))[0]


def pressures_from_stretches(actuator: Actuator, stretches: Sequence[float]) -> list[float]:
    """Return the gauge pressure [Pa] at each stretch: :func:`pressure_from_stretch` for many."""
    for stretch in stretches:
        if not require_finite("stretch", stretch) >= 1.0:
            raise InvalidInputError("stretch", stretch, "at least 1 (pressure extends the tube)")
    if isinstance(actuator.fibers, OneFamily):
        states = one_family_path(actuator)
        return _section_pressures(states, states, stretches)
    require_extending(actuator.fiber_pair)
    if actuator.pressure_law is PressureLaw.UNIFORM:
        return [_uniform_pressure(actuator, stretch) for stretch in stretches]
    path = section_path(actuator.fiber_set)
    return _section_pressures(path, SectionEnergy(actuator, path), stretches)


def _section_pressures(
    path: ShapePath, energy: SectionEnergy | OneFamilyPath, stretches: Sequence[float]
) -> list[float]:
    """Return the pressure at each stretch of a section's path."""
    limit = path.stretch_at(energy.strain_limit)
    for stretch in stretches:
        if not stretch <= limit:
            raise ActuationLimitError(energy.limit, "stretch", stretch, limit)
    sizes = [path.strain_from_stretch(stretch) for stretch in stretches]
    return [energy.pressure_with_slope(size)[0] for size in sizes]


def _uniform_pressure(actuator: Actuator, stretch: float) -> float:
    derivatives = fiber_derivatives(actuator.fiber_pair, stretch)
    if not volume_ratio_from_derivatives(stretch, derivatives).prime > 0.0:
        raise ActuationLimitError(
            ActuationLimit.VOLUME_MAXIMUM,
            "stretch",
            stretch,
            largest_volume_stretch(actuator.fiber_pair) or stretch,
        )
    return pressure_point(actuator, stretch).pressure
