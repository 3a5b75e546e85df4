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
from spiral_core.message import Message, Quantity
from spiral_core.validation import keep_vector, require_finite, require_positive, require_vector

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
# A stiffness matrix may be asymmetric by this fraction of its largest entry: rounding.
ASYMMETRY = 1e-9


@dataclass(frozen=True, slots=True)
class Section:
    """Stiffness of a rod's cross section, in the material frame (x along the rod).

    Args:
        stiffness: symmetric positive definite 3x3 matrix of twist about x and bending about y and
            z [N m^2]; three numbers stand for its diagonal (GJ, EI_y, EI_z). Or the 6x6 matrix of
            these and of stretch and of shear in y and z: forces [N] in its last three rows, and
            what couples them [N m] beside them.
        extension: EA [N]; infinite for an inextensible rod. Not with a 6x6 matrix.
        shear: kappa GA in y and z [N]; infinite for an unshearable rod. Not with a 6x6 matrix.

    Raises:
        InvalidInputError: the matrix is not symmetric and positive definite, a stiffness is not
            positive, or one is given twice.

    Example:
        >>> Section.round(radius=1e-3, young=1e6, shear_modulus=4e5).extension  # doctest: +ELLIPSIS
        3.14159...
    """

    stiffness: tuple[float, float, float] | tuple[tuple[float, ...], ...]
    extension: float = math.inf
    shear: float = math.inf

    def __post_init__(self) -> None:
        values = as_floats(self.stiffness)
        if values.shape not in ((3,), (3, 3), (6, 6)) or not positive_definite(values[None]):
            requirement = (
                "three positive numbers or a symmetric positive definite 3x3 or 6x6 matrix"
            )
            raise InvalidInputError("stiffness", self.stiffness, requirement)
        for name in ("extension", "shear"):
            value = getattr(self, name)
            if value != math.inf:
                require_positive(name, value)
                if len(values) == 6:
                    raise InvalidInputError(name, value, "left out: a 6x6 stiffness holds it")
        rows = tuple(tuple(row) if isinstance(row, list) else row for row in values.tolist())
        object.__setattr__(self, "stiffness", rows)  # arrays could not be compared

    @classmethod
    def inextensible(
        cls,
        bending: float,
        torsional: float,
        sideways: float | None = None,
        coupling: float = 0.0,
    ) -> Section:
        """Return a section that neither stretches nor shears, and couples one bending with twist.

        Args:
            bending: EI [N m^2], > 0, of bending about the material z axis.
            torsional: GJ [N m^2], > 0.
            sideways: of bending about the material y axis, > 0; None is as ``bending``.
            coupling: moment about z per twist, which is the torque per curvature [N m^2]; its
                square is less than bending times torsional.

        Example:
            >>> Section.inextensible(bending=3.0e-4, torsional=2.0e-4).stiffness
            (0.0002, 0.0003, 0.0003)
        """
        require_positive("bending", bending)
        require_positive("torsional", torsional)
        sideways = bending if sideways is None else require_positive("sideways", sideways)
        # Roots: the product of two stiffnesses may be too small to be a number.
        largest = math.sqrt(bending) * math.sqrt(torsional)
        if not abs(require_finite("coupling", coupling)) < largest:
            raise InvalidInputError("coupling", coupling, COUPLING_REQUIREMENT)
        if coupling == 0.0:
            return cls((torsional, sideways, bending))
        return cls(((torsional, 0.0, coupling), (0.0, sideways, 0.0), (coupling, 0.0, bending)))

    @staticmethod
    def varying(
        bending: ScalarProfile,
        torsional: ScalarProfile,
        sideways: ScalarProfile | None = None,
        coupling: ScalarProfile = 0.0,
    ) -> Callable[[Array], Array]:
        """Return a rod's section as a function, from numbers and functions of the arc length.

        Arguments as of :meth:`inextensible`, each a number or a function from arc lengths (n,) [m]
        to values (n,).

        Raises:
            InvalidInputError: a number is not finite, or not positive where it must be.

        Example:
            >>> Section.varying(lambda s: 3e-4 * (1.0 + s), 2e-4)(np.array([0.0, 1.0])).tolist()
            [[0.0002, 0.0003, 0.0003], [0.0002, 0.0006, 0.0006]]
        """
        positive = {"bending": bending, "torsional": torsional, "sideways": sideways}
        for field, value in positive.items():
            if not (value is None or callable(value)):
                require_positive(field, value)
        if not callable(coupling):
            require_finite("coupling", coupling)

        def stiffness(sites: Array) -> Array:
            bent = _samples("bending", bending, sites)
            across = bent if sideways is None else _samples("sideways", sideways, sites)
            twisted = _samples("torsional", torsional, sites)
            coupled = _samples("coupling", coupling, sites)
            diagonal = np.column_stack((twisted, across, bent))
            if not coupled.any():
                return diagonal
            matrices = diagonal[:, :, None] * np.eye(3)
            matrices[:, 0, 2] = matrices[:, 2, 0] = coupled
            return matrices

        return stiffness

    @classmethod
    def round(cls, radius: float, young: float, shear_modulus: float, bore: float = 0.0) -> Section:
        """Return a solid or hollow round section, with stretch and shear.

        The shear coefficient is Cowper's (J. Appl. Mech. 33, 1966) for the Poisson's ratio that
        both moduli give.

        Args:
            radius: outer radius [m].
            young: Young's modulus [Pa].
            shear_modulus: [Pa].
            bore: inner radius [m].
        """
        outer, e, g = (
            require_positive("radius", radius),
            require_positive("young", young),
            require_positive("shear_modulus", shear_modulus),
        )
        if not 0.0 <= require_finite("bore", bore) < outer:
            raise InvalidInputError("bore", bore, "at least 0 and less than the radius")
        area = math.pi * (outer**2 - bore**2)
        inertia = 0.25 * math.pi * (outer**4 - bore**4)
        nu = 0.5 * e / g - 1.0
        hollow = (bore / outer) ** 2
        solid = (1.0 + hollow) ** 2
        kappa = 6.0 * (1.0 + nu) * solid
        kappa /= (7.0 + 6.0 * nu) * solid + (20.0 + 12.0 * nu) * hollow
        bending = e * inertia
        return cls((2.0 * g * inertia, bending, bending), e * area, kappa * g * area)

    @property
    def matrix(self) -> Array:
        """Stiffness of twist and bending (3, 3) [N m^2] under a given internal force."""
        return self.parts[0]

    @property
    def parts(self) -> tuple[Array, Array, Array]:
        """Stiffness, compliance to the internal force and moment by it, each (3, 3).

        As :func:`section_parts`; the compliance is zero where the rod is rigid.
        """
        given = np.array(self.stiffness)
        matrix, compliance, coupling = section_parts(np.diag(given) if given.ndim == 1 else given)
        if len(given) == 3:
            compliance = np.diag((1.0 / self.extension, 1.0 / self.shear, 1.0 / self.shear))
        return matrix, compliance, coupling

    @property
    def numbers(self) -> tuple[float, float, float, float]:
        """GJ, EI about y, EI about z, and the coupling of twist and bending about z [N m^2]."""
        if len(self.stiffness) == 3 and not isinstance(self.stiffness[0], tuple):
            return (*self.stiffness, 0.0)
        rows = self.matrix.tolist()
        return rows[0][0], rows[1][1], rows[2][2], rows[0][2]

    @property
    def plain(self) -> bool:
        """Whether it neither stretches nor shears, and couples twist with bending about z alone."""
        rows = self.stiffness
        if self.extension != math.inf or self.shear != math.inf or len(rows) != 3:
            return False
        return not isinstance(rows[0], tuple) or not (self.matrix[1, (0, 2)].any())

    @property
    def torsional(self) -> float:
        """Stiffness against twist [N m^2]."""
        return self.numbers[0]

    @property
    def sideways(self) -> float:
        """Stiffness against bending about the material y axis [N m^2]."""
        return self.numbers[1]

    @property
    def bending(self) -> float:
        """Stiffness against bending about the material z axis [N m^2]."""
        return self.numbers[2]

    @property
    def coupling(self) -> float:
        """Moment about z per twist, which is the torque per curvature [N m^2]."""
        return self.numbers[3]

    def scaled(self, factor: float) -> Section:
        """Return this section times ``factor`` > 0, as of a stiffer material."""
        rows = (factor * np.array(self.stiffness)).tolist()
        return Section(rows, factor * self.extension, factor * self.shear)


def as_floats(value: object) -> Array:
    """Return a value as an array of floats; where it is none, an empty one for its shape."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        return np.empty(0)


def section_parts(stiffness: Array) -> tuple[Array, Array, Array]:
    """Return what stiffness matrices (..., 3, 3) or (..., 6, 6) are to a solver.

    That is the stiffness of twist and bending under a given internal force [N m^2], the compliance
    to that force [1/N], and the moment by it at given twist and bending [m], each (..., 3, 3).
    """
    if stiffness.shape[-1] == 3:
        return stiffness, np.zeros_like(stiffness), np.zeros_like(stiffness)
    compliance: Array = np.asarray(np.linalg.inv(stiffness[..., 3:, 3:]), dtype=np.float64)
    coupling: Array = stiffness[..., :3, 3:] @ compliance
    return stiffness[..., :3, :3] - coupling @ stiffness[..., 3:, :3], compliance, coupling


def positive_definite(stiffness: Array) -> bool:
    """Return whether diagonals (n, 3) or matrices (n, k, k) are finite and positive definite."""
    if not np.all(np.isfinite(stiffness)):
        return False
    if stiffness.ndim == 2:
        return bool(np.all(stiffness > 0.0))
    diagonal = np.diagonal(stiffness, axis1=1, axis2=2)
    if not np.all(diagonal > 0.0):
        return False
    root = np.sqrt(diagonal)
    plain = stiffness / root[:, :, None] / root[:, None, :]  # its entries have no units
    if not np.abs(plain - plain.transpose(0, 2, 1)).max() <= ASYMMETRY:
        return False
    return bool(np.linalg.eigvalsh(plain).min() > 0.0)


def _samples(field: str, profile: ScalarProfile, sites: Array) -> Array:
    """Return a profile's values at the sites (n,)."""
    if not callable(profile):
        return np.full(len(sites), float(profile))
    values = as_floats(profile(sites))
    if values.shape != sites.shape or not np.all(np.isfinite(values)):
        raise InvalidInputError(field, values, f"a function giving {len(sites)} finite values")
    return values


SectionProfile: TypeAlias = Section | Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class Rod:
    """An elastic rod with a shape of its own.

    Section and rest strain may vary along the rod: give a function of arc lengths (n,) [m]. Where
    one jumps (two tubes, a stiff connector), name the place in ``breaks``: elements end there, and
    each side is solved with its own values.

    Args:
        length: L [m], > 0, unstretched.
        section: its stiffness, or a function from arc lengths (n,) to stiffness (n, 3), (n, 3, 3)
            or (n, 6, 6) as :class:`Section` takes it; :meth:`Section.varying` makes one.
        radius: outer radius, where it touches [m], >= 0; the outside is round.
        rest_strain: strain vector of the unloaded rod in the material frame [1/m] (twist, bending
            about y, about z): (torsion, 0, curvature) bends it towards the material y axis; or a
            function to (n, 3). See ``docs/conventions.md``.
        breaks: arc lengths [m] at which a property, or the distributed load, may jump; increasing,
            between 0 and ``length``.
        friction_radius: distance from the axis at which friction acts [m]; None is the outer
            radius, so that friction may roll the rod. Codes that let friction act on the axis, and
            so exclude rolling, are matched with 0.

    Raises:
        InvalidInputError: a value is out of range.

    Example:
        A stiff tip, 12 cm of 30:

        >>> section = Section.varying(lambda s: np.where(s < 0.18, 2e-4, 4e-3), 1.5e-4)
        >>> Rod(0.30, section, breaks=(0.18,)).breaks
        (0.18,)
    """

    __repr__ = brief_repr

    length: float
    section: SectionProfile
    radius: float = 0.0
    rest_strain: VectorProfile = ZERO
    breaks: tuple[float, ...] = ()
    friction_radius: float | None = None

    def __post_init__(self) -> None:
        require_positive("length", self.length)
        if not (callable(self.section) or isinstance(self.section, Section)):
            requirement = "a Section, or a function giving stiffness (n, 3), (n, 3, 3) or (n, 6, 6)"
            raise InvalidInputError("section", self.section, requirement)
        if not require_finite("radius", self.radius) >= 0.0:
            raise InvalidInputError("radius", self.radius, "a finite number >= 0")
        if self.friction_radius is not None and not (
            0.0 <= require_finite("friction_radius", self.friction_radius) <= self.radius
        ):
            raise InvalidInputError("friction_radius", self.friction_radius, "from 0 to the radius")
        object.__setattr__(self, "breaks", _checked_breaks(self.breaks, self.length))
        if not callable(self.rest_strain):
            keep_vector(self, "rest_strain", 3)


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
            keep_vector(self, "distributed", 3)
        keep_vector(self, "tip_force", 3)
        keep_vector(self, "tip_moment", 3)


def _checked_breaks(breaks: Sized, length: float) -> tuple[float, ...]:
    """Return the breaks as floats, increasing between 0 and ``length`` [m]."""
    try:
        places = require_vector("breaks", breaks, len(breaks))
    except TypeError:  # it has no length, and is refused below
        places = (0.0,)
    if not all(a < b for a, b in pairwise((0.0, *places, length))):
        requirement = "increasing arc lengths between 0 and the length, {}"
        raise InvalidInputError("breaks", breaks, Message(requirement, Quantity(length, "m")))
    return places
