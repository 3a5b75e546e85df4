# SPDX-License-Identifier: Apache-2.0
"""Contact and friction at the nodes: what an obstacle adds to a Newton step.

With gap g, normal N, normal force lambda and slip s of the contact point from its anchor:

- contact, softly: lambda sigma = mu, with the slack sigma = g (an interior-point method), or
  sharply: either g = 0 or lambda = 0 (an active-set method);
- friction: tau = mu_f lambda s / w, with w = eps / (1 - |s| / (4 eps)) while the node sticks,
  |s| < 2 eps, and w = |s| when it slides: Coulomb's law with an elastic slip eps that is a
  millionth of the rod's radius at the end. The equation w tau = mu_f lambda s is linearized in both
  tau and s, and symmetrized, as for the total variation (Chan, Golub, Mulet, SIAM J. Sci. Comput.
  20, 1999): it converges from afar and never is indefinite.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spiral_core.rod.contact._quaternions import matrices, skews
from spiral_core.rod.contact.obstacles import Obstacle
from spiral_core.rod.types import Array

# A node sticks while its slip is below this many elastic slips.
STICK_SLIPS = 2.0
# A step goes at most this fraction of the way to where a slack or a normal force vanishes.
TO_BOUNDARY = 0.99
TINY = 1e-300


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
        sharp: whether contact was last solved sharply.
    """

    q: Array
    p: Array
    n: Array
    normal: Array
    slack: Array
    friction: Array
    sharp: bool = True

    def copy(self) -> Iterate:
        """Return an independent copy."""
        return Iterate(
            self.q.copy(),
            self.p.copy(),
            self.n.copy(),
            self.normal.copy(),
            self.slack.copy(),
            self.friction.copy(),
            self.sharp,
        )


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
    turn = matrices(np.array([obstacle.orientation]))[0]
    gap, normal, bend = obstacle.shape.distance((points - np.asarray(obstacle.position)) @ turn)
    return gap - radius, normal @ turn.T, turn @ bend @ turn.T


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
        first = matrices(np.array([old.orientation]))[0]
        second = matrices(np.array([new.orientation]))[0]
        local = (x.p + arm - lag - np.asarray(old.position)) @ first
        points[j] = local @ second.T + np.asarray(new.position)
        arms[j] = np.einsum("nji,nj->ni", turn, arm)
    return Anchors(points, arms, lever)


class Contact:
    """One obstacle's terms at an iterate, for the nodes that may touch."""

    def __init__(
        self,
        x: Iterate,
        j: int,
        obstacle: Obstacle,
        radius: float,
        touchable: NDArray[np.intp],
        anchors: Anchors,
        law: Law,
    ) -> None:
        gap, normal, bend = distances(obstacle, x.p, radius)
        self.obstacle, self.j, self.law = obstacle, j, law
        self.index = touchable
        self.gap, self.direction = gap[touchable], normal[touchable]
        self.force, self.slack = x.normal[j, touchable], x.slack[j, touchable]
        count = len(touchable)
        if law.sharp:
            self.active = self.force > law.stiffness * self.gap
            self.stiffness = np.where(self.active, 1.0 / law.compliance, 0.0)
            self.excess = np.where(self.active, self.gap / law.compliance, self.force)
        else:
            self.active = self.force > law.stiffness * self.slack
            self.stiffness = self.force / self.slack
            self.excess = self.force - law.barrier / self.slack
            self.excess += self.stiffness * (self.gap - self.slack)
        pairs = self.direction[:, :, None] * self.direction[:, None, :]
        self.gradient, self.drive = np.zeros((count, 6)), np.zeros((count, 6))
        self.tangent = np.zeros((count, 6, 6))
        self.gradient[:, 3:] = -self.force[:, None] * self.direction
        self.drive[:, 3:] = (self.excess - self.force)[:, None] * self.direction
        self.tangent[:, 3:, 3:] = self.stiffness[:, None, None] * pairs
        self.tangent[:, 3:, 3:] -= self.force[:, None, None] * bend[touchable]
        self.rubs = obstacle.friction > 0.0
        if self.rubs:
            self._add_friction(x, anchors, pairs)

    def _add_friction(self, x: Iterate, anchors: Anchors, pairs: Array) -> None:
        """Add friction's gradient, what it is to become, and its stiffness."""
        law, index, direction = self.law, self.index, self.direction
        turn, arm = matrices(x.q[index]), anchors.arms[self.j, index]
        away = np.einsum("nij,nj->ni", turn, arm) + x.p[index] - anchors.points[self.j, index]
        slip = away - direction * np.sum(away * direction, axis=1)[:, None]
        tau = x.friction[self.j, index]
        tau = tau - direction * np.sum(tau * direction, axis=1)[:, None]
        limit = self.obstacle.friction * np.maximum(self.force, 0.0)
        size = np.sqrt(np.sum(tau * tau, axis=1))
        tau = tau * (limit / np.maximum(np.maximum(size, limit), TINY))[:, None]
        size = np.sqrt(np.sum(slip * slip, axis=1))
        self.sticks = size < STICK_SLIPS * law.slip
        yielded = 1.0 - 0.25 * np.minimum(size / law.slip, STICK_SLIPS)
        width = np.where(self.sticks, law.slip / yielded, size)
        rate = np.where(self.sticks, 0.25 / yielded**2, 1.0)
        along = slip / np.maximum(size, TINY)[:, None]
        across = tau / np.maximum(limit, TINY)[:, None]
        outer = across[:, :, None] * (rate[:, None] * along)[:, None, :]
        heading = slip / width[:, None]
        plane = np.eye(3) - pairs
        self.friction, self.slip, self.heading = tau, slip, heading
        self.target = limit[:, None] * heading
        self.grip = (limit / width)[:, None, None] * (
            plane - 0.5 * (outer + outer.transpose(0, 2, 1))
        )
        # Friction acts where the rod touches now; what slips is the point that touched before.
        moved, pushed = np.zeros((len(index), 3, 6)), np.zeros((len(index), 3, 6))
        moved[:, :, 3:] = pushed[:, :, 3:] = plane
        here = -anchors.lever * np.einsum("nji,nj->ni", turn, direction)
        pushed[:, :, :3] = -plane @ turn @ skews(here)
        moved[:, :, :3] = -plane @ turn @ skews(arm) if law.coupled else pushed[:, :, :3]
        self.moved, levered = moved, pushed.transpose(0, 2, 1)
        self.gradient += np.einsum("nij,nj->ni", levered, tau)
        self.drive += np.einsum("nij,nj->ni", levered, self.target)
        self.tangent += levered @ self.grip @ moved
        if law.coupled:
            torque = np.einsum("nij,nj->ni", levered[:, :3], tau)
            self.tangent[:, :3, :3] += skews(torque)
            pull = self.obstacle.friction * np.einsum("nij,nj->ni", levered, heading)
            self.tangent[:, :, 3:] -= (
                self.stiffness[:, None, None] * pull[:, :, None] * direction[:, None, :]
            )
            self.drive -= self.excess[:, None] * pull

    def fractions(self, step: Array) -> tuple[float, float]:
        """Take a Newton step (N + 1, 6) and return how much of it slacks and forces allow."""
        approach = np.sum(self.direction * step[self.index, 3:], axis=1)
        self.force_step = -self.excess - self.stiffness * approach
        self.slack_step = approach + self.gap - self.slack
        if self.law.sharp or not len(self.index):
            return 1.0, 1.0
        primal = float(np.max(-self.slack_step / self.slack))
        dual = float(np.max(-self.force_step / self.force))
        return (
            min(1.0, TO_BOUNDARY / max(primal, TINY)),
            min(1.0, TO_BOUNDARY / max(dual, TINY)),
        )

    def update(self, x: Iterate, step: Array, primal: float, dual: float) -> None:
        """Write the contact's part of the step into x."""
        x.normal[self.j, self.index] = self.force + dual * self.force_step
        x.slack[self.j, self.index] = self.slack + primal * self.slack_step
        if self.rubs:
            new = self.target + np.einsum("nij,njk,nk->ni", self.grip, self.moved, step[self.index])
            if self.law.coupled:
                new += self.obstacle.friction * self.force_step[:, None] * self.heading
            x.friction[self.j, self.index] = self.friction + dual * (new - self.friction)

    def residual(self, length: float, force: float, barrier: float, tolerance: float) -> float:
        """Return how far the contact's laws are from holding, as a fraction of length and force."""
        if not len(self.index):
            return 0.0
        if self.law.sharp:
            worst = max(
                np.abs(self.gap[self.active]).max(initial=0.0) / length,
                np.abs(self.force[~self.active]).max(initial=0.0) / force,
                -self.gap.min() / length,
                -self.force.min() / force,
            )
        else:
            worst = max(
                np.abs(self.gap - self.slack).max() / length,
                0.5 * tolerance * np.max(self.force * self.slack) / barrier,
            )
        if self.rubs:
            off = np.abs(self.friction - self.target)[self.active]
            worst = max(worst, off.max(initial=0.0) / force)
        return float(worst)
