# SPDX-License-Identifier: Apache-2.0
"""The contact problem: a rod, its ends, its loads and the obstacles around it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.rod.contact.obstacles import Obstacle, Quaternion
from spiral_core.rod.types import ZERO, Array, RodLoad, Vector, VectorProfile
from spiral_core.validation import (
    require_all,
    require_finite,
    require_positive,
    require_unit_vector,
    require_vector,
)

UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)
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
        matrix = self._given
        requirement = "three positive numbers or a symmetric positive definite 3x3 or 6x6 matrix"
        if matrix.shape not in ((3, 3), (6, 6)) or not np.all(np.isfinite(matrix)):
            raise InvalidInputError("stiffness", self.stiffness, requirement)
        diagonal = np.diag(matrix)
        if not diagonal.min() > 0.0:
            raise InvalidInputError("stiffness", self.stiffness, requirement)
        plain = matrix / np.sqrt(np.outer(diagonal, diagonal))  # its entries have no units
        if not np.abs(plain - plain.T).max() <= ASYMMETRY:
            raise InvalidInputError("stiffness", self.stiffness, requirement)
        if not np.linalg.eigvalsh(plain).min() > 0.0:
            raise InvalidInputError("stiffness", self.stiffness, requirement)
        for name in ("extension", "shear"):
            value = getattr(self, name)
            if value != math.inf:
                require_positive(name, value)
                if len(matrix) == 6:
                    raise InvalidInputError(name, value, "left out: a 6x6 stiffness holds it")
        values = np.asarray(self.stiffness, dtype=np.float64).tolist()
        rows = tuple(tuple(row) if isinstance(row, list) else row for row in values)
        object.__setattr__(self, "stiffness", rows)  # arrays could not be compared

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
    def _given(self) -> Array:
        """The stiffness as a matrix (3, 3) or (6, 6)."""
        try:
            values: Array = np.asarray(self.stiffness, dtype=np.float64)
        except (TypeError, ValueError):
            values = np.zeros(0)
        return np.diag(values) if values.shape == (3,) else values

    @property
    def matrix(self) -> Array:
        """Stiffness of twist and bending (3, 3) [N m^2] under a given internal force."""
        given = self._given
        return given[:3, :3] - self.coupling @ given[3:, :3] if len(given) == 6 else given

    @property
    def compliance(self) -> Array:
        """Compliance to the internal force (3, 3) [1/N]: zero where the rod is rigid."""
        given = self._given
        if len(given) == 6:
            return np.asarray(np.linalg.inv(given[3:, 3:]), dtype=np.float64)
        return np.diag((1.0 / self.extension, 1.0 / self.shear, 1.0 / self.shear))

    @property
    def coupling(self) -> Array:
        """Moment by the internal force, at given twist and bending (3, 3) [m]."""
        given = self._given
        if len(given) == 6:
            coupling: Array = given[:3, 3:] @ self.compliance
            return coupling
        return np.zeros((3, 3))


SectionProfile: TypeAlias = Section | Callable[[float], Section]


@dataclass(frozen=True, slots=True)
class ElasticRod:
    """A rod of round outside with a shape of its own.

    Args:
        length: L [m], > 0, unstretched.
        section: its stiffness, or a function from an arc length [m] to it.
        radius: outer radius, where it touches [m], >= 0.
        rest_strain: strain vector of the unloaded rod in the material frame [1/m] (twist, bending
            about y, about z), or a function from arc lengths (n,) to (n, 3).
        friction_radius: distance from the axis at which friction acts [m]; None is the outer
            radius, so that friction may roll the rod. Codes that let friction act on the axis, and
            so exclude rolling, are matched with 0.
        breaks: arc lengths at which a property jumps [m], increasing, inside the rod; elements end
            there.

    Raises:
        InvalidInputError: a value is out of range.
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
            raise InvalidInputError("section", self.section, "a Section or a function giving one")
        if not require_finite("radius", self.radius) >= 0.0:
            raise InvalidInputError("radius", self.radius, "a finite number >= 0")
        if self.friction_radius is not None and not (
            0.0 <= require_finite("friction_radius", self.friction_radius) <= self.radius
        ):
            raise InvalidInputError("friction_radius", self.friction_radius, "from 0 to the radius")
        if not callable(self.rest_strain):
            require_vector("rest_strain", self.rest_strain, 3)
        breaks = require_all("breaks", self.breaks, (int, float), "arc lengths")
        sites = (0.0, *(require_finite("breaks", site) for site in breaks), self.length)
        if any(not b > a for a, b in pairwise(sites)):
            raise InvalidInputError("breaks", self.breaks, "increasing, inside the rod's length")


@dataclass(frozen=True, slots=True)
class Free:
    """An end that nothing holds."""


@dataclass(frozen=True, slots=True)
class Pinned:
    """An end held at a place, free to turn.

    Args:
        position: in the base frame [m].
    """

    position: Vector = ZERO

    def __post_init__(self) -> None:
        require_vector("position", self.position, 3)


@dataclass(frozen=True, slots=True)
class Clamped:
    """An end held at a place and in an orientation.

    Args:
        position: in the base frame [m].
        orientation: unit quaternion, scalar last, material frame to base frame.
    """

    position: Vector = ZERO
    orientation: Quaternion = UPRIGHT

    def __post_init__(self) -> None:
        require_vector("position", self.position, 3)
        require_unit_vector("orientation", self.orientation, 4)


@dataclass(frozen=True, slots=True)
class Guided:
    """An end that slides along a line, free to turn or, with an orientation, held in it.

    Args:
        position: a point of the line, in the base frame [m].
        direction: along the line, a unit vector.
        orientation: unit quaternion, scalar last; None leaves the end free to turn.
    """

    position: Vector = ZERO
    direction: Vector = (1.0, 0.0, 0.0)
    orientation: Quaternion | None = None

    def __post_init__(self) -> None:
        require_vector("position", self.position, 3)
        require_unit_vector("direction", self.direction, 3)
        if self.orientation is not None:
            require_unit_vector("orientation", self.orientation, 4)


End: TypeAlias = Free | Pinned | Clamped | Guided


@dataclass(frozen=True, slots=True)
class PointLoad:
    """A dead force and moment at a place along the rod.

    Args:
        at: arc length [m], inside the rod; a node is put there.
        force: in the base frame [N].
        moment: in the base frame [N m].
    """

    at: float
    force: Vector = ZERO
    moment: Vector = ZERO

    def __post_init__(self) -> None:
        require_finite("at", self.at)
        require_vector("force", self.force, 3)
        require_vector("moment", self.moment, 3)


@dataclass(frozen=True, slots=True)
class ContactProblem:
    """A rod, how its ends are held, what loads it and what stands in its way.

    Args:
        rod: the rod.
        load: distributed load, and force and moment at the tip.
        base: how the end at arc length 0 is held.
        tip: how the other end is held.
        obstacles: several at once; each with its friction.
        point_loads: along the rod.

    Raises:
        InvalidInputError: an end is not one of the four kinds, or a load lies outside the rod.
    """

    __repr__ = brief_repr

    rod: ElasticRod
    load: RodLoad = field(default_factory=RodLoad)
    base: End = field(default_factory=Clamped)
    tip: End = field(default_factory=Free)
    obstacles: tuple[Obstacle, ...] = ()
    point_loads: tuple[PointLoad, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.rod, ElasticRod):
            raise InvalidInputError("rod", self.rod, "an ElasticRod")
        if not isinstance(self.load, RodLoad):
            raise InvalidInputError("load", self.load, "a RodLoad")
        for name in ("base", "tip"):
            if not isinstance(getattr(self, name), (Free, Pinned, Clamped, Guided)):
                raise InvalidInputError(
                    name, getattr(self, name), "Free(), Pinned(), Clamped() or Guided()"
                )
        require_all("obstacles", self.obstacles, (Obstacle,), "Obstacle values")
        for load in require_all("point_loads", self.point_loads, (PointLoad,), "PointLoad values"):
            if not 0.0 <= load.at <= self.rod.length:
                raise InvalidInputError("at", load.at, "an arc length inside the rod")


def _kind(end: End) -> tuple[type[End], bool]:
    """Return what may not change on a path: an end's type, and whether its orientation is held."""
    return type(end), getattr(end, "orientation", None) is None


def require_alike(problems: Sequence[ContactProblem]) -> None:
    """Refuse stations between which no path leads."""
    first = problems[0]
    for problem in problems[1:]:
        alike = (
            problem.rod.radius == first.rod.radius
            and _kind(problem.base) == _kind(first.base)
            and _kind(problem.tip) == _kind(first.tip)
            and [o.shape for o in problem.obstacles] == [o.shape for o in first.obstacles]
        )
        if not alike:
            requirement = "stations with one rod radius, kinds of ends and obstacle shapes"
            raise InvalidInputError("problems", problem, requirement)
