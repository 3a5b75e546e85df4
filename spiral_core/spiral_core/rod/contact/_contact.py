# SPDX-License-Identifier: Apache-2.0
"""Contact and friction at the nodes: the unknowns, and what an obstacle adds to a Newton step.

Derived in ``docs/derivations/contact.md``, sections 3 and 4; its symbols are used here. With gap g,
normal N, normal force lambda and slip s of the contact point from its anchor:

- contact, softly: lambda sigma = mu, with the slack sigma = g (an interior-point method), or
  sharply: either g = 0 or lambda = 0 (an active-set method); in either, a step changes the gap by
  a compliance times the change of lambda, which vanishes at the solution;
- friction: tau = mu_f lambda s / w, with w = eps / (1 - |s| / (4 eps)) while the node sticks,
  |s| < 2 eps, and w = |s| when it slides: Coulomb's law with an elastic slip eps that is a
  millionth of the rod's radius at the end. The equation w tau = mu_f lambda s is linearized in both
  tau and s, and symmetrized, as for the total variation (Chan, Golub, Mulet, SIAM J. Sci. Comput.
  20, 1999): it converges from afar and never is indefinite.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    Array,
    Mat,
    Vec,
    add,
    add_matrix,
    add_vector,
    block_at,
    diagonal,
    dot,
    in_space,
    largest_component,
    matadd,
    matmul,
    matmul_skew,
    matmul_t,
    matrices,
    matrix_at,
    matscale,
    matsubtract,
    matvec,
    matvec_t,
    norm,
    outer,
    put_matrix,
    put_vector,
    quaternion_at,
    scale,
    skew,
    skew_matmul,
    subtract,
    to_base,
    to_material_matrix,
    transpose,
    vector_at,
    vector_from,
    with_transpose,
)
from spiral_core.rod.contact._mesh import Arrays, last_slip
from spiral_core.rod.contact.obstacles import Obstacle, frame_of, in_base_frame, seen_from

# A node sticks while its slip is below this many elastic slips.
STICK_SLIPS = 2.0
# A step goes at most this fraction of the way to where a slack or a normal force vanishes.
TO_BOUNDARY = 0.99
TINY = 1e-300
# A node touches from some normal force on; below this part of it, friction is left out.
NEGLIGIBLE = 1e-9


class Iterate(NamedTuple):
    """The unknowns: orientations, positions, mean forces; per obstacle and node, the contact's.

    Attributes:
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
        return Iterate(*(array.copy() for array in self))


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


class Nodal(NamedTuple):
    """What acts at the nodes: loads, contact, inertia; by rotation in the material frame and place.

    Attributes:
        gradient: (N + 1, 6) of the energy.
        drive: (N + 1, 6) gradient that drives the step: with the contacts' own eliminated.
        tangent: (N + 1, 6, 6) Hessian.
    """

    gradient: Array
    drive: Array
    tangent: Array


class NodalTerms(Protocol):
    """What a step in time adds to the energy, a sum over the nodes."""

    def add(self, x: Iterate, gradient: Array, tangent: Array) -> None:
        """Add the gradient (N + 1, 6) and Hessian (N + 1, 6, 6) at x to the given ones."""


class Anchors(NamedTuple):
    """Where friction measures slip from, for each obstacle and node.

    Attributes:
        points: (m, N + 1, 3) anchors in the base frame [m].
        arms: (m, N + 1, 3) contact points seen from the node, in its material frame [m].
        lever: distance of contact points from the rod's axis [m].
    """

    points: Array
    arms: Array
    lever: float


class Law(NamedTuple):
    """How contact is treated in one pass.

    Attributes:
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


class Touch(NamedTuple):
    """What the laws give at each node, for each obstacle.

    A step dx of the node changes lambda by -(excess + stiffness N.dp).

    Attributes:
        active: (m, N + 1) whether it touches.
        sticks: (m, N + 1) whether it would stick.
        stiffness: (m, N + 1) of the normal force [N/m].
        excess: (m, N + 1) [N].
        tau: (m, N + 1, 3) friction [N].
        target: (m, N + 1, 3) what friction is to become, mu_f lambda s / w [N].
        heading: (m, N + 1, 3) s / w.
        grip: (m, N + 1, 3, 6) derivative of friction by the node's step.
        slip: (m, N + 1, 3) s [m].
        changes: (m, N + 1, 2) steps of normal force and slack.
    """

    active: NDArray[np.bool_]
    sticks: NDArray[np.bool_]
    stiffness: Array
    excess: Array
    tau: Array
    target: Array
    heading: Array
    grip: Array
    slip: Array
    changes: Array


def no_touch(obstacles: int, nodes: int) -> Touch:
    """Return the laws' results before any."""
    shape = (obstacles, nodes)
    off, vector = np.zeros(shape, dtype=np.bool_), (*shape, 3)
    return Touch(
        active=off,
        sticks=off.copy(),
        stiffness=np.zeros(shape),
        excess=np.zeros(shape),
        tau=np.zeros(vector),
        target=np.zeros(vector),
        heading=np.zeros(vector),
        grip=np.zeros((*vector, 6)),
        slip=np.zeros(vector),
        changes=np.empty((*shape, 2)),
    )


class Contacts(NamedTuple):
    """The obstacles as the nodes see them at an iterate, and what the laws give there.

    Attributes:
        friction: (m,) mu_f.
        touchable: (N + 1,) whether a node may touch them.
        gap: (m, N + 1) g [m].
        normal: (m, N + 1, 3) N.
        bend: (m, N + 1, 3, 3) Hessian d'' of the distance [1/m].
        touch: what the laws give.
    """

    friction: Array
    touchable: NDArray[np.bool_]
    gap: Array
    normal: Array
    bend: Array
    touch: Touch

    @property
    def active(self) -> NDArray[np.bool_]:
        """Whether a node touches (m, N + 1)."""
        return self.touch.active

    @property
    def sticks(self) -> NDArray[np.bool_]:
        """Whether a node touches and sticks (m, N + 1)."""
        sticks: NDArray[np.bool_] = self.touch.active & self.touch.sticks
        return sticks


def contacts_at(x: Iterate, arrays: Arrays, touchable: NDArray[np.bool_]) -> Contacts:
    """Return the contacts at an iterate, their laws not yet evaluated."""
    shape = (len(arrays.obstacles), len(x.p))
    gap, normal, bend = np.empty(shape), np.empty((*shape, 3)), np.empty((*shape, 3, 3))
    for j, obstacle in enumerate(arrays.obstacles):
        gap[j], normal[j], bend[j] = distances(obstacle, x.p, arrays.radius)
    friction = np.array([obstacle.friction for obstacle in arrays.obstacles], dtype=np.float64)
    return Contacts(friction, touchable, gap, normal, bend, no_touch(*shape))


@compiled
def normal_terms(law: Law, contacts: Contacts, x: Iterate, j: int, e: int, at: Nodal) -> None:
    """Add the normal force of a node to its gradient, what drives the step, and its Hessian."""
    force, slack = x.normal[j, e], x.slack[j, e]
    gap, normal, touch = contacts.gap[j, e], vector_at(contacts.normal[j], e), contacts.touch
    if law.sharp:
        active = force > law.stiffness * gap
        stiffness = 1.0 / law.compliance if active else 0.0
        excess = gap / law.compliance if active else force
    else:
        active = force > law.stiffness * slack
        # A pair lambda sigma of an impact is stiffer than positions resolve without the compliance.
        width = slack + law.compliance * force
        stiffness = force / width
        excess = (force * gap - law.barrier) / width
    touch.active[j, e], touch.stiffness[j, e], touch.excess[j, e] = active, stiffness, excess
    add_vector(at.gradient[e], 3, scale(-force, normal))
    add_vector(at.drive[e], 3, scale(excess - force, normal))
    bent = matscale(-force, matrix_at(contacts.bend[j], e))
    add_matrix(at.tangent[e], 3, 3, matadd(matscale(stiffness, outer(normal, normal)), bent))


@compiled
def friction_law(slip: Vec, tau: Vec, limit: float, elastic: float) -> tuple[bool, Vec, Vec, Mat]:
    """Return whether a node sticks, tau within the limit, s / w and the derivative by the slip."""
    tau = scale(limit / max(norm(tau), limit, TINY), tau)
    size = norm(slip)
    sticks = size < STICK_SLIPS * elastic
    yielded = 1.0 - 0.25 * min(size / elastic, STICK_SLIPS)
    width = elastic / yielded if sticks else size
    rate = 0.25 / yielded**2 if sticks else 1.0
    along = outer(scale(1.0 / max(limit, TINY), tau), scale(1.0 / max(size, TINY), slip))
    softened = matscale(-0.5 * rate, with_transpose(along))
    grip = matscale(limit / width, matadd(diagonal(1.0, 1.0, 1.0), softened))
    return sticks, tau, scale(1.0 / width, slip), grip


@compiled
def friction_terms(
    law: Law, contacts: Contacts, x: Iterate, anchors: Anchors, j: int, e: int, at: Nodal
) -> None:
    """Add the friction of a node.

    Friction acts where the rod touches now; what slips is the point that touched before. Coupled,
    friction follows the normal force and the normal's direction within the step: the derivative is
    complete, and not symmetric.
    """
    lever, mu, touch = anchors.lever, contacts.friction[j], contacts.touch
    normal, bend = vector_at(contacts.normal[j], e), matrix_at(contacts.bend[j], e)
    q = quaternion_at(x.q, e)
    turn = transpose(to_material_matrix(q))
    arm, anchor = vector_at(anchors.arms[j], e), vector_at(anchors.points[j], e)
    away = add(subtract(vector_at(x.p, e), anchor), to_base(q, arm))
    outward = dot(normal, away)
    slip = subtract(away, scale(outward, normal))
    tau = vector_at(x.friction[j], e)
    tau = subtract(tau, scale(dot(normal, tau), normal))
    limit = mu * max(x.normal[j, e], 0.0)
    sticks, tau, heading, grip = friction_law(slip, tau, limit, law.slip)
    target = scale(limit, heading)
    # What a step moves in the tangent plane: the point that touches, and the one that touched.
    plane = matsubtract(diagonal(1.0, 1.0, 1.0), outer(normal, normal))
    here = scale(-lever, matvec_t(turn, normal))
    pushed_turn, pushed = matmul(plane, matscale(-1.0, matmul_skew(turn, here))), plane
    moved_turn, moved = pushed_turn, pushed
    if law.coupled:
        moved_turn = matmul(plane, matscale(-1.0, matmul_skew(turn, arm)))
        moved = matmul(plane, matsubtract(plane, matscale(outward, bend)))
    grip_turn, grip_move = matmul(grip, moved_turn), matmul(grip, moved)
    goal, by_move = target, grip_move
    if law.coupled:  # what the step changes in the normal force
        excess, stiffness = mu * touch.excess[j, e], mu * touch.stiffness[j, e]
        goal = subtract(target, scale(excess, heading))
        by_move = matsubtract(grip_move, matscale(stiffness, outer(heading, normal)))
    gradient, drive, tangent = at.gradient[e], at.drive[e], at.tangent[e]
    couple = matvec_t(pushed_turn, tau)
    add_vector(gradient, 0, couple)
    add_vector(gradient, 3, matvec(pushed, tau))
    add_vector(drive, 0, matvec_t(pushed_turn, goal))
    add_vector(drive, 3, matvec(pushed, goal))
    add_matrix(tangent, 0, 0, matmul_t(pushed_turn, grip_turn))
    add_matrix(tangent, 0, 3, matmul_t(pushed_turn, by_move))
    add_matrix(tangent, 3, 0, matmul(pushed, grip_turn))
    add_matrix(tangent, 3, 3, matmul(pushed, by_move))
    if law.coupled:  # what turning the rod, and the normal, does to friction and its couple
        add_matrix(tangent, 0, 0, matscale(0.5, skew(couple)))
        add_matrix(tangent, 0, 3, matscale(lever, matmul_t(turn, skew_matmul(tau, bend))))
        add_matrix(tangent, 3, 3, matscale(-1.0, outer(normal, matvec(bend, tau))))
    touch.sticks[j, e] = sticks
    put_vector(touch.tau[j, e], 0, tau)
    put_vector(touch.target[j, e], 0, target)
    put_vector(touch.heading[j, e], 0, heading)
    put_vector(touch.slip[j, e], 0, slip)
    put_matrix(touch.grip[j, e], 0, 0, grip_turn)
    put_matrix(touch.grip[j, e], 0, 3, grip_move)


@compiled
def contact_terms(
    law: Law, contacts: Contacts, x: Iterate, anchors: Anchors, j: int, at: Nodal
) -> None:
    """Add one obstacle's terms at all nodes that may touch it."""
    for e in range(len(x.p)):
        if contacts.touchable[e]:
            normal_terms(law, contacts, x, j, e, at)
            near = contacts.gap[j, e] if law.sharp else x.slack[j, e]
            least = NEGLIGIBLE * law.stiffness * near
            if contacts.friction[j] > 0.0 and x.normal[j, e] > least:
                friction_terms(law, contacts, x, anchors, j, e, at)


@compiled
def contact_step(law: Law, contacts: Contacts, x: Iterate, step: Array) -> tuple[float, float]:
    """Write the steps of normal forces and slacks that go with a step (N + 1, 6) of the nodes.

    Returns how much of the step slacks and forces allow.
    """
    touch = contacts.touch
    primal = dual = TINY
    for j in range(len(contacts.gap)):
        for e in range(len(step)):
            if not contacts.touchable[e]:
                touch.changes[j, e] = 0.0
                continue
            force, slack, gap = x.normal[j, e], x.slack[j, e], contacts.gap[j, e]
            approach = dot(vector_at(contacts.normal[j], e), vector_from(step[e], 3))
            pressed = -(touch.excess[j, e] + touch.stiffness[j, e] * approach)
            opened = approach + gap - slack + law.compliance * pressed
            touch.changes[j, e, 0], touch.changes[j, e, 1] = pressed, opened
            if not law.sharp:
                primal = max(primal, -opened / slack)
                dual = max(dual, -pressed / max(force, TINY))
    return min(1.0, TO_BOUNDARY / primal), min(1.0, TO_BOUNDARY / dual)


@compiled
def follow_step(
    law: Law, contacts: Contacts, x: Iterate, step: Array, primal: float, dual: float
) -> None:
    """Take the fraction ``primal`` of the slacks' step, ``dual`` of that of forces and friction."""
    touch = contacts.touch
    for j, mu in enumerate(contacts.friction):
        for e in range(len(step)):
            pressed, opened = touch.changes[j, e]
            x.normal[j, e] += dual * pressed
            x.slack[j, e] += primal * opened
            if mu > 0.0:
                grip, tau = touch.grip[j, e], vector_at(touch.tau[j], e)
                new = vector_at(touch.target[j], e)
                new = add(new, matvec(block_at(grip, 0, 0), vector_from(step[e], 0)))
                new = add(new, matvec(block_at(grip, 0, 3), vector_from(step[e], 3)))
                if law.coupled:
                    new = add(new, scale(mu * pressed, vector_at(touch.heading[j], e)))
                put_vector(x.friction[j, e], 0, add(tau, scale(dual, subtract(new, tau))))


@compiled
def contact_residual(
    law: Law, contacts: Contacts, x: Iterate, length: float, force: float, pair: float
) -> float:
    """Return how far contact and friction are from holding, as a fraction of length and force.

    ``pair`` is the product of a slack and a force that counts as one.
    """
    worst: float = 0.0
    touch = contacts.touch
    for j in range(len(contacts.gap)):
        for e in range(len(x.p)):
            if not contacts.touchable[e]:
                continue
            gap, pressed, slack = contacts.gap[j, e], x.normal[j, e], x.slack[j, e]
            active = touch.active[j, e]
            if law.sharp:
                broken = abs(gap) / length if active else abs(pressed) / force
                broken = max(broken, -gap / length, -pressed / force)
            else:
                broken = max(abs(gap - slack) / length, pressed * slack / pair)
            if active:
                lag = subtract(vector_at(touch.tau[j], e), vector_at(touch.target[j], e))
                broken = max(broken, largest_component(lag) / force)
            if broken != broken:
                return np.nan
            worst = max(worst, broken)
    return worst


def distances(obstacle: Obstacle, points: Array, radius: float) -> tuple[Array, Array, Array]:
    """Return gap (n,) [m], normal (n, 3) and curvature (n, 3, 3) [1/m] in the base frame."""
    gap, normal, bend = obstacle.shape.distance(seen_from(obstacle, points))
    normal, bend = in_space(frame_of(obstacle.orientation), normal, bend)
    return gap - radius, normal, bend


def widen(
    x: Iterate, obstacles: tuple[Obstacle, ...], radius: float, width: float, barrier: float
) -> None:
    """Put slacks and normal forces well inside the barrier of this width [m]."""
    for j, obstacle in enumerate(obstacles):
        gap, _, _ = distances(obstacle, x.p, radius)
        x.slack[j] = np.maximum(gap, width)
        x.normal[j] = np.maximum(x.normal[j], barrier / x.slack[j])


def carried(x: Iterate, anchors: Anchors | None, before: Arrays, after: Arrays) -> Anchors:
    """Return the next increment's anchors: at most the elastic slip behind, and carried along.

    A node that sticks keeps its elastic slip, so that a state that rests stays where it is.
    """
    shape = (len(before.obstacles), *x.p.shape)
    points, arms = np.zeros(shape), np.zeros(shape)
    turn, lever, most = matrices(x.q), after.lever, STICK_SLIPS * last_slip(after)
    for j, (old, new) in enumerate(zip(before.obstacles, after.obstacles, strict=True)):
        if not max(old.friction, new.friction) > 0.0:
            continue
        _, normal, _ = distances(old, x.p, lever)
        arm = -lever * normal
        lag = np.zeros_like(x.p)
        if anchors is not None and old.friction > 0.0:
            away = np.einsum("nij,nj->ni", turn, anchors.arms[j]) + x.p - anchors.points[j]
            lag = away - normal * np.sum(away * normal, axis=1)[:, None]
            size = np.sqrt(np.sum(lag * lag, axis=1))
            lag *= (most / np.maximum(size, most))[:, None]
        points[j] = in_base_frame(new, seen_from(old, x.p + arm - lag))
        arms[j] = np.einsum("nji,nj->ni", turn, arm)
    return Anchors(points, arms, lever)
