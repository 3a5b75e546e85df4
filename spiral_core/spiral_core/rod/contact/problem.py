# SPDX-License-Identifier: Apache-2.0
"""The contact problem: a rod, its ends, its loads and the obstacles around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.rod.contact.obstacles import Obstacle, Quaternion
from spiral_core.rod.types import ZERO, Rod, RodLoad, Vector
from spiral_core.validation import (
    keep_unit_vector,
    keep_vector,
    require_all,
    require_finite,
    require_kind,
)

UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)


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
        keep_vector(self, "position", 3)


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
        keep_vector(self, "position", 3)
        keep_unit_vector(self, "orientation", 4)


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
        keep_vector(self, "position", 3)
        keep_unit_vector(self, "direction")
        if self.orientation is not None:
            keep_unit_vector(self, "orientation", 4)


End: TypeAlias = Free | Pinned | Clamped | Guided


@dataclass(frozen=True, slots=True)
class PointLoad:
    """A dead force and moment at a place along the rod.

    Args:
        at: arc length [m], inside the rod; a node is put there. Nearer to a break, another load or
            an end than 2e-4 of the length, but not there, forces may be rounding errors.
        force: in the base frame [N].
        moment: in the base frame [N m].
    """

    at: float
    force: Vector = ZERO
    moment: Vector = ZERO

    def __post_init__(self) -> None:
        require_finite("at", self.at)
        keep_vector(self, "force", 3)
        keep_vector(self, "moment", 3)


@dataclass(frozen=True, slots=True)
class RodProblem:
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

    rod: Rod
    load: RodLoad = field(default_factory=RodLoad)
    base: End = field(default_factory=Clamped)
    tip: End = field(default_factory=Free)
    obstacles: tuple[Obstacle, ...] = ()
    point_loads: tuple[PointLoad, ...] = ()

    def __post_init__(self) -> None:
        require_kind("rod", self.rod, Rod)
        require_kind("load", self.load, RodLoad)
        for name in ("base", "tip"):
            require_kind(name, getattr(self, name), Free, Pinned, Clamped, Guided)
        require_all("obstacles", self.obstacles, (Obstacle,), "Obstacle values")
        for load in require_all("point_loads", self.point_loads, (PointLoad,), "PointLoad values"):
            if not 0.0 <= load.at <= self.rod.length:
                raise InvalidInputError("at", load.at, "an arc length inside the rod")


def _kind(problem: RodProblem) -> list[object]:
    """Return what may not change on a path: of an end its type, and whether it may turn."""
    ends = (problem.base, problem.tip)
    held = [(type(end), getattr(end, "orientation", None) is None) for end in ends]
    return [problem.rod.radius, held, [obstacle.shape for obstacle in problem.obstacles]]


def require_alike(problems: Sequence[RodProblem]) -> None:
    """Refuse stations between which no path leads."""
    for problem in problems[1:]:
        if _kind(problem) != _kind(problems[0]):
            requirement = "stations with one rod radius, kinds of ends and obstacle shapes"
            raise InvalidInputError("problems", problem, requirement)
