# SPDX-License-Identifier: Apache-2.0
"""The laws of contact and friction at one node after the other: their part of a Newton step.

Derived in ``docs/derivations/contact.md``, sections 3 and 4. With gap g, normal N, normal force
lambda and slip s of the contact point from its anchor:

- contact, softly: lambda sigma = mu, with the slack sigma = g (an interior-point method), or
  sharply: either g = 0 or lambda = 0 (an active-set method); in either, a step changes the gap by
  a compliance times the change of lambda, which vanishes at the solution;
- friction: tau = mu_f lambda s / w, with w = eps / (1 - |s| / (4 eps)) while the node sticks,
  |s| < 2 eps, and w = |s| when it slides: Coulomb's law with an elastic slip eps that is a
  millionth of the rod's radius at the end. The equation w tau = mu_f lambda s is linearized in both
  tau and s, and symmetrized, as for the total variation (Chan, Golub, Mulet, SIAM J. Sci. Comput.
  20, 1999): it converges from afar and never is indefinite.
"""

import math

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod.contact._algebra import Array, rotation

# A node sticks while its slip is below this many elastic slips.
STICK_SLIPS = 2.0
# A step goes at most this fraction of the way to where a slack or a normal force vanishes.
TO_BOUNDARY = 0.99
TINY = 1e-300
# What a node's row of results holds: stiffness and excess of the normal force, whether it is active
# and sticks, friction, what friction is to become, its direction, its derivative (3, 6), and slip.
STIFFNESS, EXCESS, ACTIVE, STICKS, TAU, TARGET, HEADING, GRIP, SLIP = 0, 1, 2, 3, 4, 7, 10, 13, 31
RESULTS = 34
# What a law holds.
SHARP, BARRIER, ELASTIC, CHOICE, COMPLIANCE, COUPLED, FRICTION, LEVER = range(8)


@compiled
def normal_terms(
    law: Array,
    gap: float,
    normal: Array,
    bend: Array,
    force: float,
    slack: float,
    row: Array,
    true: Array,
    drive: Array,
    tangent: Array,
) -> None:
    """Add the normal force of a node to its gradient, what drives the step, and its Hessian."""
    if law[SHARP] > 0.0:
        active = force > law[CHOICE] * gap
        row[STIFFNESS] = 1.0 / law[COMPLIANCE] if active else 0.0
        row[EXCESS] = gap / law[COMPLIANCE] if active else force
    else:
        active = force > law[CHOICE] * slack
        # A pair lambda sigma of an impact is stiffer than positions resolve without the compliance.
        width = slack + law[COMPLIANCE] * force
        row[STIFFNESS] = force / width
        row[EXCESS] = (force * gap - law[BARRIER]) / width
    row[ACTIVE] = 1.0 if active else 0.0
    for i in range(3):
        true[3 + i] -= force * normal[i]
        drive[3 + i] += (row[EXCESS] - force) * normal[i]
        for k in range(3):
            tangent[3 + i, 3 + k] += row[STIFFNESS] * normal[i] * normal[k] - force * bend[i, k]


@compiled
def friction_law(law: Array, limit: float, row: Array, grip: Array) -> None:
    """Write friction's target, direction and stiffness from its force and slip in a row."""
    size = math.sqrt(row[TAU] ** 2 + row[TAU + 1] ** 2 + row[TAU + 2] ** 2)
    shrink = limit / max(size, limit, TINY)
    size = math.sqrt(row[SLIP] ** 2 + row[SLIP + 1] ** 2 + row[SLIP + 2] ** 2)
    sticks = size < STICK_SLIPS * law[ELASTIC]
    yielded = 1.0 - 0.25 * min(size / law[ELASTIC], STICK_SLIPS)
    width = law[ELASTIC] / yielded if sticks else size
    rate = 0.25 / yielded**2 if sticks else 1.0
    row[STICKS] = 1.0 if sticks else 0.0
    for i in range(3):
        row[TAU + i] *= shrink
        row[HEADING + i] = row[SLIP + i] / width
        row[TARGET + i] = limit * row[HEADING + i]
    most, far = max(limit, TINY), max(size, TINY)
    for i in range(3):
        for k in range(3):
            one = (row[TAU + i] / most) * (row[SLIP + k] / far)
            other = (row[SLIP + i] / far) * (row[TAU + k] / most)
            same = 1.0 if i == k else 0.0
            grip[i, k] = limit / width * (same - 0.5 * rate * (one + other))


@compiled
def turned_friction(
    lever: float,
    normal: Array,
    bend: Array,
    turn: Array,
    row: Array,
    pushed: Array,
    tangent: Array,
) -> None:
    """Add what turning the rod, and the normal, does to friction and its couple."""
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        couple = 0.0
        for m in range(3):
            couple += pushed[m, k] * row[TAU + m]
        # The matrix of v -> couple x v, entry by entry.
        tangent[b, a] += couple
        tangent[a, b] -= couple
        bent = 0.0
        for m in range(3):
            bent += bend[k, m] * row[TAU + m]
        for i in range(3):
            tangent[3 + i, 3 + k] -= normal[i] * bent
            value = 0.0
            for m in range(3):
                c, d = (m + 1) % 3, (m + 2) % 3
                value += turn[m, i] * (row[TAU + c] * bend[d, k] - row[TAU + d] * bend[c, k])
            tangent[i, 3 + k] += lever * value


@compiled
def friction_terms(
    law: Array,
    normal: Array,
    bend: Array,
    turn: Array,
    arm: Array,
    away: Array,
    force: float,
    row: Array,
    room: Array,
    true: Array,
    drive: Array,
    tangent: Array,
) -> None:
    """Add the friction of a node; ``away`` is its contact point seen from its anchor.

    Friction acts where the rod touches now; what slips is the point that touched before. Coupled,
    friction follows the normal force and the normal's direction within the step: the derivative is
    complete, and not symmetric.
    """
    coupled = law[COUPLED] > 0.0
    grip, moved, pushed = room[0:3, 0:3], room[3:6], room[6:9]
    lever, mu = law[LEVER], law[FRICTION]
    outward = normal[0] * away[0] + normal[1] * away[1] + normal[2] * away[2]
    along = normal[0] * row[TAU] + normal[1] * row[TAU + 1] + normal[2] * row[TAU + 2]
    for i in range(3):
        row[SLIP + i] = away[i] - outward * normal[i]
        row[TAU + i] -= along * normal[i]
    friction_law(law, mu * max(force, 0.0), row, grip)
    for i in range(3):
        for k in range(3):
            plane = (1.0 if i == k else 0.0) - normal[i] * normal[k]
            pushed[i, 3 + k] = plane
            moved[i, 3 + k] = plane - (outward * bend[i, k] if coupled else 0.0)
            # Columns of R e_k x arm in space, arm at the contact point: R (e_k x R^T a).
            a, b = (k + 1) % 3, (k + 2) % 3
            here_a = here_b = 0.0
            for m in range(3):
                here_a -= lever * turn[m, a] * normal[m]
                here_b -= lever * turn[m, b] * normal[m]
            pushed[i, k] = here_a * turn[i, b] - here_b * turn[i, a]
            moved[i, k] = arm[a] * turn[i, b] - arm[b] * turn[i, a] if coupled else pushed[i, k]
    for k in range(3):
        for block in range(3, 9, 3):
            along = 0.0
            for i in range(3):
                along += normal[i] * room[block + i, k]
            for i in range(3):
                room[block + i, k] -= along * normal[i]
    for i in range(3):
        for k in range(6):
            value = 0.0
            for m in range(3):
                value += grip[i, m] * moved[m, k]
            row[GRIP + 6 * i + k] = value
    for i in range(6):
        pull = 0.0
        for m in range(3):
            true[i] += pushed[m, i] * row[TAU + m]
            drive[i] += pushed[m, i] * row[TARGET + m]
            pull += mu * pushed[m, i] * row[HEADING + m]
            for k in range(6):
                tangent[i, k] += pushed[m, i] * row[GRIP + 6 * m + k]
        if coupled:
            drive[i] -= row[EXCESS] * pull
            for k in range(3):
                tangent[i, 3 + k] -= row[STIFFNESS] * pull * normal[k]
    if coupled:
        turned_friction(lever, normal, bend, turn, row, pushed, tangent)


@compiled
def contact_terms(
    law: Array,
    touchable: Array,
    gaps: Array,
    normals: Array,
    bends: Array,
    q: Array,
    p: Array,
    arms: Array,
    points: Array,
    forces: Array,
    slacks: Array,
    friction: Array,
    rows: Array,
    true: Array,
    drive: Array,
    tangent: Array,
) -> None:
    """Add one obstacle's terms at all nodes that may touch it.

    Args:
        law: as numbered above.
        touchable: (N + 1,) 1 where a node may touch.
        gaps: (N + 1,) [m].
        normals: (N + 1, 3).
        bends: (N + 1, 3, 3) Hessian of the distance [1/m].
        q: (N + 1, 4) orientations.
        p: (N + 1, 3) positions [m].
        arms: (N + 1, 3) contact points in the material frame [m].
        points: (N + 1, 3) their anchors [m].
        forces: (N + 1,) normal forces [N].
        slacks: (N + 1,) [m].
        friction: (N + 1, 3) [N].
        rows: (N + 1, RESULTS) result.
        true: (N + 1, 6) gradient, added to.
        drive: (N + 1, 6) gradient with the contact's own step eliminated, added to.
        tangent: (N + 1, 6, 6) Hessian, added to.
    """
    turn, away, room = np.empty((3, 3)), np.empty(3), np.empty((9, 6))
    for e in range(len(gaps)):
        if touchable[e] == 0.0:
            continue
        row = rows[e]
        normal_terms(
            law, gaps[e], normals[e], bends[e], forces[e], slacks[e], row, true[e], drive[e],
            tangent[e],
        )  # fmt: skip
        if law[FRICTION] > 0.0:
            rotation(q[e], turn)
            for i in range(3):
                row[TAU + i] = friction[e, i]
                away[i] = p[e, i] - points[e, i]
                for k in range(3):
                    away[i] += turn[i, k] * arms[e, k]
            friction_terms(
                law, normals[e], bends[e], turn, arms[e], away, forces[e], row, room, true[e],
                drive[e], tangent[e],
            )  # fmt: skip


@compiled
def contact_step(
    sharp: bool,
    compliance: float,
    touchable: Array,
    gaps: Array,
    normals: Array,
    rows: Array,
    step: Array,
    forces: Array,
    slacks: Array,
    changes: Array,
) -> tuple[float, float]:
    """Write the steps (2, N + 1) of normal forces and slacks that go with a step of the nodes.

    Returns how much of the step slacks and forces allow.
    """
    primal = dual = TINY
    for e in range(len(gaps)):
        approach = 0.0
        for i in range(3):
            approach += normals[e, i] * step[e, 3 + i]
        changes[0, e] = -(rows[e, EXCESS] + rows[e, STIFFNESS] * approach) * touchable[e]
        change = approach + gaps[e] - slacks[e] + compliance * changes[0, e]
        changes[1, e] = change * touchable[e]
        if not sharp and touchable[e] > 0.0:
            primal = max(primal, -changes[1, e] / slacks[e])
            dual = max(dual, -changes[0, e] / max(forces[e], TINY))
    return min(1.0, TO_BOUNDARY / primal), min(1.0, TO_BOUNDARY / dual)


@compiled
def take_step(
    friction: float,
    coupled: bool,
    primal: float,
    dual: float,
    changes: Array,
    rows: Array,
    step: Array,
    forces: Array,
    slacks: Array,
    rubbing: Array,
) -> None:
    """Take the fractions ``primal`` of the slacks' step and ``dual`` of the forces'."""
    for e in range(len(forces)):
        forces[e] += dual * changes[0, e]
        slacks[e] += primal * changes[1, e]
        if friction > 0.0:
            for i in range(3):
                new = rows[e, TARGET + i]
                for k in range(6):
                    new += rows[e, GRIP + 6 * i + k] * step[e, k]
                if coupled:
                    new += friction * changes[0, e] * rows[e, HEADING + i]
                old = rows[e, TAU + i]
                rubbing[e, i] = old + dual * (new - old)
