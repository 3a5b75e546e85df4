# SPDX-License-Identifier: Apache-2.0
"""Rods and loads: the values that every solver here takes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sized
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_finite, require_positive, require_vector

Array: TypeAlias = NDArray[np.float64]
Vector: TypeAlias = tuple[float, float, float]
ScalarProfile: TypeAlias = float | Callable[[Array], Array]
VectorProfile: TypeAlias = Vector | Callable[[Array], Array]

ZERO: Vector = (0.0, 0.0, 0.0)
# Moment imbalance, as a fraction of EI/L, at which a state counts as in equilibrium; the tip is
# then right to about as small a fraction of the length. Rounding leaves 1e-12 or so.
DEFAULT_TOLERANCE = 1e-8
COUPLING_REQUIREMENT = "smaller than the root of bending times torsional stiffness"
MAX_ELEMENTS = 20_000


@dataclass(frozen=True, slots=True)
class RodStiffness:
    """Bending and torsional stiffness of a rod's section.

    Args:
        bending: EI [N m^2], > 0, of bending about the material z axis.
        torsional: GJ [N m^2], > 0.
        sideways: of bending about the material y axis, > 0; None is as ``bending``.
        coupling: moment about z per twist, which is the torque per curvature [N m^2]; its square
            is less than bending times torsional.

    Raises:
        InvalidInputError: a stiffness is not positive and finite, or the coupling too large.

    Example:
        >>> RodStiffness(bending=3.0e-4, torsional=2.0e-4).bending
        0.0003
    """

    bending: float
    torsional: float
    sideways: float | None = None
    coupling: float = 0.0

    def __post_init__(self) -> None:
        require_positive("bending", self.bending)
        require_positive("torsional", self.torsional)
        if self.sideways is not None:
            require_positive("sideways", self.sideways)
        _require_coupling("coupling", self.coupling, self.bending, self.torsional)

    @property
    def matrix(self) -> tuple[Vector, Vector, Vector]:
        """Stiffness of twist and of bending about y and z (3, 3) [N m^2]."""
        sideways = self.bending if self.sideways is None else self.sideways
        return (
            (self.torsional, 0.0, self.coupling),
            (0.0, sideways, 0.0),
            (self.coupling, 0.0, self.bending),
        )

    def scaled(self, factor: float) -> RodStiffness:
        """Return this stiffness times ``factor`` > 0, as of a stiffer material."""
        sideways = None if self.sideways is None else factor * self.sideways
        return RodStiffness(
            factor * self.bending, factor * self.torsional, sideways, factor * self.coupling
        )


@dataclass(frozen=True, slots=True)
class Rod:
    """An inextensible, unshearable elastic rod with a shape of its own.

    Each property may vary along the rod: give a function from arc lengths (n,) [m] to values (n,)
    or (n, 3). Where a property jumps (two tubes, a stiff connector), name the place in ``breaks``:
    elements end there, and each side is solved with its own values.

    Args:
        length: L [m], > 0.
        bending_stiffness: EI [N m^2], > 0, of bending about the material z axis.
        torsional_stiffness: GJ [N m^2], > 0.
        rest_strain: strain vector of the unloaded rod in the material frame [1/m]; (torsion, 0,
            curvature) bends it towards the material y axis. See ``docs/conventions.md``.
        breaks: arc lengths [m] at which a property, or the distributed load, may jump; increasing,
            between 0 and ``length``. A jump elsewhere is refused by the solver.
        sideways_stiffness: of bending about the material y axis [N m^2], > 0; None: as about z.
        coupling_stiffness: moment about z per twist, which is the torque per curvature [N m^2]; its
            square is less than that of bending and torsion multiplied.

    Raises:
        InvalidInputError: a constant value is not finite or not positive where it must be, or the
            breaks are not increasing between 0 and ``length``.

    Example:
        A stiff tip, 12 cm of 30:

        >>> rod = Rod(0.30, lambda s: np.where(s < 0.18, 2e-4, 4e-3), 1.5e-4, breaks=(0.18,))
        >>> rod.breaks
        (0.18,)
    """

    __repr__ = brief_repr

    length: float
    bending_stiffness: ScalarProfile
    torsional_stiffness: ScalarProfile
    rest_strain: VectorProfile = ZERO
    breaks: tuple[float, ...] = ()
    sideways_stiffness: ScalarProfile | None = None
    coupling_stiffness: ScalarProfile = 0.0

    def __post_init__(self) -> None:
        require_positive("length", self.length)
        if self.breaks != ():
            object.__setattr__(self, "breaks", _checked_breaks(self.breaks, self.length))
        numbers = {name: one for name, one in self.stiffness_profiles if not callable(one)}
        coupling = numbers.pop("coupling_stiffness", 0.0)
        for field, value in numbers.items():
            require_positive(field, value)
        most = [numbers.get(f"{name}_stiffness", math.inf) for name in ("bending", "torsional")]
        _require_coupling("coupling_stiffness", coupling, *most)
        if not callable(self.rest_strain):
            require_vector("rest_strain", self.rest_strain, 3)

    @property
    def stiffness_profiles(self) -> tuple[tuple[str, ScalarProfile], ...]:
        """Names and values of the stiffnesses that are given."""
        named = (
            ("bending_stiffness", self.bending_stiffness),
            ("torsional_stiffness", self.torsional_stiffness),
            ("coupling_stiffness", self.coupling_stiffness),
        )
        if self.sideways_stiffness is None:
            return named
        return (*named, ("sideways_stiffness", self.sideways_stiffness))


@dataclass(frozen=True, slots=True)
class RodLoad:
    """The loads on a rod: dead loads in the base frame, which do not turn with the rod.

    Args:
        distributed: force per length [N/m], such as weight per length times the direction of
            gravity; may vary along the rod (a function of arc length, as in :class:`Rod`).
        tip_force: force at the tip [N].
        tip_moment: moment at the tip [N m]. A moment fixed in space has no potential energy: the
            certificate then excludes a static loss of stability only, and under a strong one no
            stable state may be found.

    Raises:
        InvalidInputError: a component is not finite.
    """

    distributed: VectorProfile = ZERO
    tip_force: Vector = ZERO
    tip_moment: Vector = ZERO

    def __post_init__(self) -> None:
        if not callable(self.distributed):
            require_vector("distributed", self.distributed, 3)
        require_vector("tip_force", self.tip_force, 3)
        require_vector("tip_moment", self.tip_moment, 3)


def _require_coupling(field: str, coupling: object, bending: float, torsional: float) -> None:
    """Raise unless a section with this coupling resists every bend and twist."""
    # Roots: the product of two stiffnesses may be too small to be a number.
    if not abs(require_finite(field, coupling)) < math.sqrt(bending) * math.sqrt(torsional):
        raise InvalidInputError(field, coupling, COUPLING_REQUIREMENT)


def _checked_breaks(breaks: object, length: float) -> tuple[float, ...]:
    """Return the breaks as floats, increasing between 0 and ``length`` [m]."""
    requirement = f"increasing arc lengths between 0 and the length, {length:.9g} m"
    if not isinstance(breaks, Sized):
        raise InvalidInputError("breaks", breaks, requirement)
    places = require_vector("breaks", breaks, len(breaks))
    ends = (0.0, *places, length)
    if not all(a < b for a, b in pairwise(ends)):
        raise InvalidInputError("breaks", breaks, requirement)
    return places
