# SPDX-License-Identifier: Apache-2.0
"""Contact and friction at the nodes: the unknowns, and what an obstacle adds to a Newton step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled
from spiral_core.rod.contact._algebra import in_space, matrices
from spiral_core.rod.contact._laws import (
    ACTIVE,
    RESULTS,
    SLIP,
    STICK_SLIPS,
    STICKS,
    TARGET,
    TAU,
    contact_step,
    contact_terms,
    take_step,
)
from spiral_core.rod.contact.obstacles import Obstacle, frame_of, seen_from
from spiral_core.rod.types import Array


@dataclass(slots=True, eq=False)
class Iterate:
    """The unknowns: orientations, positions, mean forces; per obstacle and node, the contact's.

    Args:
        q: (N + 1, 4).
        p: (N + 1, 3) [m].
        n: (N, 3) [N].
        normal: (m, N + 1) normal forces lambda [N].
        slack: (m, N + 1) sigma [m].
        friction: (m, N + 1, 3) friction tau [N].
    """

    q: Array
    p: Array
    n: Array
    normal: Array
    slack: Array
    friction: Array

    def copy(self) -> Iterate:
        """Return an independent copy."""
        return Iterate(*(getattr(self, name).copy() for name in self.__slots__))


def empty(count: int, obstacles: int, q: Array, p: Array) -> Iterate:
    """Return an iterate without forces."""
    return Iterate(
        q=q,
        p=p,
        n=np.zeros((count, 3)),
        normal=np.zeros((obstacles, count + 1)),
        slack=np.ones((obstacles, count + 1)),
        friction=np.zeros((obstacles, count + 1, 3)),
    )


class NodalTerms(Protocol):
    """What a step in time adds to the energy, a sum over the nodes."""

    def add(self, x: Iterate, gradient: Array, tangent: Array) -> None:
        """Add the gradient (N + 1, 6) and Hessian (N + 1, 6, 6) at x to the given ones."""


@dataclass(frozen=True, slots=True, eq=False)
class Anchors:
    """Where friction measures slip from, for each obstacle and node.

    Args:
        points: (m, N + 1, 3) anchors in the base frame [m].
        arms: (m, N + 1, 3) contact points seen from the node, in its material frame [m].
        lever: distance of contact points from the rod's axis [m].
    """

    points: Array
    arms: Array
    lever: float


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """How far nodes may go from where they were before an iteration is given up.

    Args:
        origin: (N + 1, 3) where they were [m].
        limits: (N + 1,) [m].
    """

    origin: Array
    limits: Array

    def left(self, positions: Array) -> bool:
        """Return whether a node is beyond its limit."""
        moves = np.sum((positions - self.origin) ** 2, axis=1)
        return bool(np.any(moves > self.limits**2))


@dataclass(frozen=True, slots=True)
class Law:
    """How contact is treated in one pass.

    Args:
        sharp: active set instead of interior point.
        barrier: mu of the interior point [N m].
        slip: elastic slip of friction [m].
        stiffness: of a node's contact, for choosing the active set [N/m].
        compliance: of an active contact [m/N].
        coupled: whether friction follows the normal force within the step (not symmetric).
    """

    sharp: bool
    barrier: float
    slip: float
    stiffness: float
    compliance: float
    coupled: bool


def distances(obstacle: Obstacle, points: Array, radius: float) -> tuple[Array, Array, Array]:
    """Return gap (n,) [m], normal (n, 3) and curvature (n, 3, 3) [1/m] in the base frame."""
    gap, normal, bend = obstacle.shape.distance(seen_from(obstacle, points))
    normal, bend = in_space(frame_of(obstacle), normal, bend)
    return gap - radius, normal, bend


def widen(
    x: Iterate, obstacles: tuple[Obstacle, ...], radius: float, width: float, barrier: float
) -> None:
    """Put slacks and normal forces well inside the barrier of this width [m]."""
    for j, obstacle in enumerate(obstacles):
        gap, _, _ = distances(obstacle, x.p, radius)
        x.slack[j] = np.maximum(gap, width)
        x.normal[j] = np.maximum(x.normal[j], barrier / x.slack[j])


def slip_of(x: Iterate, anchors: Anchors, j: int, normal: Array) -> Array:
    """Return the slip (N + 1, 3) of the contact points from their anchors, tangential [m]."""
    away = np.einsum("nij,nj->ni", matrices(x.q), anchors.arms[j]) + x.p - anchors.points[j]
    tangential: Array = away - normal * np.sum(away * normal, axis=1)[:, None]
    return tangential


def carried(
    x: Iterate,
    anchors: Anchors | None,
    before: tuple[Obstacle, ...],
    after: tuple[Obstacle, ...],
    lever: float,
    slip: float,
) -> Anchors:
    """Return the next increment's anchors: at most the elastic slip behind, and carried along.

    A node that sticks keeps its elastic slip, so that a state that rests stays where it is.
    """
    shape = (len(before), *x.p.shape)
    points, arms = np.zeros(shape), np.zeros(shape)
    turn = matrices(x.q)
    for j, (old, new) in enumerate(zip(before, after, strict=True)):
        if not max(old.friction, new.friction) > 0.0:
            continue
        _, normal, _ = distances(old, x.p, lever)
        arm = -lever * normal
        lag = np.zeros_like(x.p)
        if anchors is not None and old.friction > 0.0:
            lag = slip_of(x, anchors, j, normal)
            size = np.sqrt(np.sum(lag * lag, axis=1))
            most = STICK_SLIPS * slip
            lag *= (most / np.maximum(size, most))[:, None]
        local = seen_from(old, x.p + arm - lag)
        points[j] = local @ frame_of(new).T + np.asarray(new.position)
        arms[j] = np.einsum("nji,nj->ni", turn, arm)
    return Anchors(points, arms, lever)


@compiled
def contact_residual(
    sharp: bool,
    touchable: Array,
    gaps: Array,
    rows: Array,
    forces: Array,
    slacks: Array,
    length: float,
    force: float,
    pair: float,
) -> float:
    """Return how far contact and friction are from holding, as a fraction of length and force.

    ``pair`` is the product of a slack and a force that counts as one.
    """
    worst: float = 0.0
    for e in range(len(gaps)):
        if touchable[e] == 0.0:
            continue
        active = rows[e, ACTIVE] > 0.0
        if sharp:
            broken = abs(gaps[e]) / length if active else abs(forces[e]) / force
            broken = max(broken, -gaps[e] / length, -forces[e] / force)
        else:
            broken = max(abs(gaps[e] - slacks[e]) / length, forces[e] * slacks[e] / pair)
        for i in range(3):
            off = abs(rows[e, TAU + i] - rows[e, TARGET + i]) / force
            broken = max(broken, off if active else 0.0)
        if broken != broken:
            return np.nan
        worst = max(worst, broken)
    return worst


class Contact:
    """One obstacle's terms at an iterate."""

    def __init__(
        self,
        x: Iterate,
        j: int,
        obstacle: Obstacle,
        radius: float,
        touchable: Array,
        anchors: Anchors,
    ) -> None:
        self.x, self.j, self.anchors, self.touchable = x, j, anchors, touchable
        self.gap, self.normal, self.bend = distances(obstacle, x.p, radius)
        self.mu = obstacle.friction
        self.rubs = obstacle.friction > 0.0
        self.rows, self.changes = np.zeros((len(x.p), RESULTS)), np.empty((2, len(x.p)))

    def add(self, law: Law, true: Array, drive: Array, tangent: Array) -> None:
        """Add to the gradient, to what drives the step, and to the Hessian."""
        x, j, anchors = self.x, self.j, self.anchors
        self.law = law
        numbers = (law.sharp, law.barrier, law.slip, law.stiffness, law.compliance, law.coupled)
        contact_terms(
            np.array((*numbers, self.mu, anchors.lever)), self.touchable, self.gap, self.normal,
            self.bend, x.q, x.p, anchors.arms[j], anchors.points[j], x.normal[j], x.slack[j],
            x.friction[j], self.rows, true, drive, tangent,
        )  # fmt: skip

    @property
    def active(self) -> NDArray[np.bool_]:
        """Whether a node touches (N + 1,)."""
        active: NDArray[np.bool_] = self.rows[:, ACTIVE] > 0.0
        return active

    @property
    def sticks(self) -> NDArray[np.bool_]:
        """Whether a node touches and sticks (N + 1,)."""
        sticks: NDArray[np.bool_] = self.active & (self.rows[:, STICKS] > 0.0)
        return sticks

    @property
    def slip(self) -> Array:
        """Slip of the contact points since the increment began (N + 1, 3) [m]."""
        return self.rows[:, SLIP:]

    def fractions(self, step: Array) -> tuple[float, float]:
        """Take a Newton step (N + 1, 6) and return how much of it slacks and forces allow."""
        x, j = self.x, self.j
        return contact_step(
            self.law.sharp, self.law.compliance, self.touchable, self.gap, self.normal, self.rows,
            step, x.normal[j], x.slack[j], self.changes,
        )  # fmt: skip

    def update(self, coupled: bool, step: Array, primal: float, dual: float) -> None:
        """Write the contact's part of the step into the iterate."""
        x, j = self.x, self.j
        take_step(
            self.mu, coupled, primal, dual, self.changes, self.rows, step, x.normal[j],
            x.slack[j], x.friction[j],
        )  # fmt: skip

    def residual(self, length: float, force: float, pair: float) -> float:
        """Return how far the contact's laws are from holding, as a fraction of length and force.

        ``pair`` is the product of a slack and a force that counts as one [N m].
        """
        x, j = self.x, self.j
        return contact_residual(
            self.law.sharp, self.touchable, self.gap, self.rows, x.normal[j], x.slack[j], length,
            force, pair,
        )  # fmt: skip
