# SPDX-License-Identifier: Apache-2.0
"""Rods, loads and solved states: the values that every solver here takes and returns."""

from __future__ import annotations

import math
from collections.abc import Callable, Sized
from dataclasses import dataclass
from enum import Enum
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


class RodStatus(Enum):
    """How a solve ended; the value is advice to the user. Only ``CONVERGED`` is an answer."""

    CONVERGED = "converged to a stable equilibrium"
    ITERATION_LIMIT = (
        "the iteration limit was reached; use more elements, or approach the load in smaller steps"
    )
    LINE_SEARCH_FAILED = (
        "the energy could not be lowered although forces are out of balance; the tolerance is "
        "below rounding error, or the tip moment does work that no energy describes: loosen the "
        "tolerance or reduce the moment"
    )
    NOT_FINITE = "a number overflowed; check lengths, stiffnesses and loads for their units"
    UNSTABLE = (
        "the equilibrium is not stable: the rod would leave it; start elsewhere or reduce the load"
    )
    LEFT_BRANCH = "the branch of stable states ends before this load: the rod would snap"
    FOLD_LIMIT = (
        "the rod snaps more than 32 times on its loading path, which was given up there; use more "
        "elements, or approach the load in stations with follow_path"
    )
    UNRESOLVED = (
        "an element turns by more than 2 rad, which its ends cannot tell; use more elements"
    )


class RodCertificate(Enum):
    """What is proved about a state's stability; the value is the text."""

    NONE = "not certified"
    STRICT_MINIMUM = "a strict local minimum of the energy: stable"
    STABLE_UP_TO_ROTATION = (
        "one of a circle of equal minima: stable up to a rotation about the load's axis"
    )


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


@dataclass(frozen=True, slots=True, eq=False)
class RodState:
    """A rod's static shape, with residual and certificate.

    Args:
        status: how the solve ended; the arrays are an answer only if it is ``CONVERGED``.
        arc_lengths: (n,) of the nodes [m], from 0 at the base to L at the tip.
        positions: (n, 3) of the nodes in the base frame [m]; the base is the origin.
        orientations: (n, 4) unit quaternions, scalar last, material frame to base frame.
        forces: (n, 3) internal force in the base frame [N].
        moments: (n, 3) internal moment in the material frame [N m].
        strains: (n, 3) strain vector in the material frame [1/m].
        energy: potential energy [J]; zero for the unloaded rod at rest.
        residual: largest moment imbalance at a node, as a fraction of EI/L.
        smallest_pivot: smallest pivot of the energy's Hessian, as a fraction of EI/L: the
            certificate. Positive proves that the state is a strict minimum of the discrete energy,
            up to the neutral mode if there is one.
        iterations: Newton iterations spent.
        folds: how often the rod snapped on the way: along the loading path, or from the start.
        discretization_error: estimated largest error of a position [m]; None where it was not asked
            for. With a neutral mode it is the error up to the free rotation.
        last_step: largest rotation of a node in the Newton step that was left [rad].
        neutral_modes: 1 if the whole rod may turn about the base's axis at no cost (an isotropic
            rod, straight at rest, that buckled under a load along that axis), else 0.

    The arrays are read-only.
    """

    __repr__ = brief_repr

    status: RodStatus
    arc_lengths: Array
    positions: Array
    orientations: Array
    forces: Array
    moments: Array
    strains: Array
    energy: float
    residual: float
    smallest_pivot: float
    iterations: int
    folds: int = 0
    discretization_error: float | None = None
    last_step: float = 0.0
    neutral_modes: int = 0

    def __post_init__(self) -> None:
        self.arc_lengths.setflags(write=False)
        self.positions.setflags(write=False)
        self.orientations.setflags(write=False)
        self.forces.setflags(write=False)
        self.moments.setflags(write=False)
        self.strains.setflags(write=False)

    @property
    def certificate(self) -> RodCertificate:
        """What is proved about the state's stability."""
        if not self.stable:
            return RodCertificate.NONE
        if self.neutral_modes:
            return RodCertificate.STABLE_UP_TO_ROTATION
        return RodCertificate.STRICT_MINIMUM

    @property
    def stable(self) -> bool:
        """Whether the state is an equilibrium with a certificate of stability."""
        return self.status is RodStatus.CONVERGED and self.smallest_pivot > 0.0

    @property
    def tangents(self) -> Array:
        """Unit tangents (n, 3) in the base frame."""
        x, y, z, w = self.orientations.T
        return np.column_stack(
            (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w))
        )

    @property
    def tip_position(self) -> Array:
        """Position of the tip in the base frame (3,) [m]."""
        tip: Array = self.positions[-1]
        return tip


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
