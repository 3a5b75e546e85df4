# SPDX-License-Identifier: Apache-2.0
"""Newton's method for a rod with obstacles, from one state to the equilibrium next to it.

One pass assembles the elements, condenses their forces and eliminates the nodes from base to tip.
Unknowns are a rotation and a displacement per node and a force per element. With D the element's
compliance to its force (and a little more, which keeps D positive where the rod is rigid), and r
the mismatch of its chord, the force's step is D^-1 (r + B dx); what is left of the element is
H + B^T D^-1 B between its two nodes. The blocks that the elimination divides by are the pivots of
the Hessian.

The iteration goes on quickly at first, with the contacts that the start has; if that does not
settle within a few passes, from the start again by an interior-point method, whose barrier sinks as
the iteration converges.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled, inlined
from spiral_core.rod._algebra import (
    Array,
    Vec,
    add,
    add_matrix,
    add_vector,
    block_at,
    diagonal,
    dot,
    matmul,
    matrices,
    matscale,
    matsubtract,
    matvec,
    matvec_t,
    put_matrix,
    put_vector,
    quaternion_at,
    scale,
    skews,
    smallest_pivot_and_inverse,
    subtract,
    turn_nodes,
    vector_at,
    vector_from,
)
from spiral_core.rod._newton import CONVERGED, ITERATION_LIMIT, NOT_FINITE, UNSTABLE
from spiral_core.rod.contact._contact import (
    TINY,
    Anchors,
    Contacts,
    Iterate,
    Law,
    Nodal,
    NodalTerms,
    contact_residual,
    contact_step,
    contact_terms,
    contacts_at,
    follow_step,
    widen,
)
from spiral_core.rod.contact._element import Elements, mixed_element, section_at
from spiral_core.rod.contact._mesh import Arrays, last_slip
from spiral_core.rod.types import DEFAULT_TOLERANCE

MAX_PASSES = 60
# The quick attempt goes on for so many passes after the residual was last halved.
QUICK_PASSES = 6
# Largest rotation of a node in one step [rad].
MAX_ROTATION = 0.7
# Compliances left to what is rigid, as fractions of an element's own; they change the way to the
# solution, not the solution.
CHORD_COMPLIANCE = 1e-5
CONTACT_COMPLIANCE = 1e-4
# A node touches where its normal force exceeds its gap times this fraction of its own stiffness,
# 12 EI / h^3. The quick attempt goes on with a fraction of that: it lets a node go for a force that
# pulls, not for a gap that the next step closes.
CONTACT_STIFFNESS = 1e-3
QUICK_STIFFNESS = 1e-6
# Slack times normal force at the end, per element, as a fraction of force scale times length: what
# this leaves at nodes that do not touch is below the tolerance.
LAST_BARRIER = 1e-14
# A soft rod that touches nothing may move on where forces hardly balance: if by more than this
# fraction of the length, one more step is taken.
LAST_MOVE = 1e-9
# Stiffness against motions that nothing resists (a rod spinning about itself), in EI/L.
NEUTRAL = 1e-9
# At rest, friction follows the normal force within a step, which converges quadratically, below
# this residual. In motion always: an impact is many times the scale of forces, and friction that
# lags behind its normal force by a pass makes the iteration go in circles.
COUPLING_RESIDUAL = 5.0
# Steps shorter than this fraction are blocked by the barrier: it is widened.
BLOCKED = 0.2
# Positions weigh ten times as much as their fraction of the length in the residual.
LENGTH_WEIGHT = 10.0
# A coil bears more inside than its loads: this part counts as a load, its imbalance is rounding.
ROUNDED = 0.1
# A Hessian that is not positive is shifted by at least and at most so many times a small stiffness.
SHIFT, MOST_SHIFT = 1e-2, 1e9
# Where the columns of an eliminated node and of the next one begin.
HERE, NEXT = 0, 6


class Assembled(NamedTuple):
    """The elements at an iterate.

    Attributes:
        hessians: (N, 9, 9) by rotations of both nodes and force.
        gradient: (N + 1, 6) of their energy and that of their load, by the nodes' motions.
        chord: (N, 3) mismatch of the chords [m].
        moments: (N + 1, 3) internal moment in the material frame [N m].
    """

    hessians: Array
    gradient: Array
    chord: Array
    moments: Array


class Bearing(NamedTuple):
    """How the nodes are held, and what keeps their elimination regular.

    Attributes:
        end_free: (2, 6, 6) projections onto the ends' free motions.
        compliance: (N,) added to the elements' own [m/N].
        unit: length in whose units displacements are eliminated [m].
    """

    end_free: Array
    compliance: Array
    unit: float


class Step(NamedTuple):
    """A Newton step.

    Attributes:
        nodes: (N + 1, 6) rotation in the material frame [rad] and displacement [m].
        forces: (N, 3) change of n [N].
    """

    nodes: Array
    forces: Array


def no_elements(count: int) -> Assembled:
    """Return room for so many assembled elements."""
    nodes, forces = no_step(count)
    return Assembled(np.empty((count, 9, 9)), nodes, forces, np.empty((count + 1, 3)))


def no_step(count: int) -> Step:
    """Return a step of zero for so many elements."""
    return Step(np.zeros((count + 1, 6)), np.zeros((count, 3)))


@compiled
def assemble(x: Iterate, elements: Elements, found: Assembled) -> float:
    """Write the elements at an iterate; return their energy and that of their load [J]."""
    energy = 0.0
    found.gradient[:] = 0.0
    for e in range(len(x.n)):
        n, half_load = vector_at(x.n, e), vector_at(elements.half_load, e)
        q0, q1 = quaternion_at(x.q, e), quaternion_at(x.q, e + 1)
        d = mixed_element(q0, q1, n, half_load, section_at(elements, e))
        hessian = found.hessians[e]
        put_matrix(hessian, 0, 0, d.h00)
        put_matrix(hessian, 0, 3, d.h01)
        put_matrix(hessian, 0, 6, d.h0n)
        put_matrix(hessian, 3, 3, d.h11)
        put_matrix(hessian, 3, 6, d.h1n)
        put_matrix(hessian, 6, 6, d.hnn)
        for i in range(9):
            for k in range(i):
                hessian[i, k] = hessian[k, i]
        before, after = add(n, half_load), subtract(n, half_load)
        p0, p1 = vector_at(x.p, e), vector_at(x.p, e + 1)
        energy += d.energy + dot(after, p1) - dot(before, p0)
        put_vector(found.chord[e], 0, add(d.gn, subtract(p1, p0)))
        add_vector(found.gradient[e], 0, d.g0)
        add_vector(found.gradient[e], 3, scale(-1.0, before))
        add_vector(found.gradient[e + 1], 0, d.g1)
        add_vector(found.gradient[e + 1], 3, after)
        put_vector(found.moments[e], 0, scale(-1.0, d.g0))
        put_vector(found.moments[e + 1], 0, d.g1)
    return energy


@compiled
def reduce_rows(rows: Array, exchange: bool) -> float:
    """Replace rows [block | others] (6, 13) by [. | block^-1 others]; return the smallest pivot.

    Without ``exchange`` of rows the elimination stops at a pivot that is not positive.
    """
    smallest: float = np.inf
    for k in range(6):
        if exchange:
            best = k
            for i in range(k + 1, 6):
                if abs(rows[i, k]) > abs(rows[best, k]):
                    best = i
            for c in range(k, 13):
                rows[k, c], rows[best, c] = rows[best, c], rows[k, c]
        pivot: float = abs(rows[k, k]) if exchange else rows[k, k]
        if not pivot > 0.0:
            return pivot
        smallest = min(smallest, pivot)
        for i in range(k + 1, 6):
            factor = rows[i, k] / rows[k, k]
            for c in range(k + 1, 13):
                rows[i, c] -= factor * rows[k, c]
    for i in range(5, -1, -1):
        for c in range(6, 13):
            for k in range(i + 1, 6):
                rows[i, c] -= rows[i, k] * rows[k, c]
            rows[i, c] /= rows[i, i]
    return smallest


@compiled
def condense(
    hess: Array, mismatch: Vec, compliance: float, unit: float, pull: Array, whole: Array
) -> float:
    """Eliminate an element's force: pull = D^-1 [B | r], whole = H + B^T D^-1 [B | r].

    ``pull`` (3, 13) and ``whole`` (12, 13) over rotation and displacement, in units of ``unit``, of
    both nodes. By a displacement B is the negative unit matrix at the first node, the unit one at
    the second. Returns the smallest pivot of D.
    """
    rigid = diagonal(compliance, compliance, compliance)
    pivot, soft = smallest_pivot_and_inverse(matsubtract(rigid, block_at(hess, 6, 6)))
    if not pivot > 0.0:
        return pivot
    start, end = block_at(hess, 6, 0), block_at(hess, 6, 3)
    put_matrix(pull, 0, 0, matmul(soft, start))
    put_matrix(pull, 0, 3, matscale(-unit, soft))
    put_matrix(pull, 0, 6, matmul(soft, end))
    put_matrix(pull, 0, 9, matscale(unit, soft))
    pull[0, 12], pull[1, 12], pull[2, 12] = matvec(soft, mismatch)
    for k in range(13):
        by = (pull[0, k], pull[1, k], pull[2, k])
        turn0, turn1 = matvec_t(start, by), matvec_t(end, by)
        for i in range(3):
            whole[i, k], whole[3 + i, k] = turn0[i], -unit * by[i]
            whole[6 + i, k], whole[9 + i, k] = turn1[i], unit * by[i]
    for i in range(0, 6, 3):
        for k in range(0, 6, 3):
            add_matrix(whole, 2 * i, 2 * k, block_at(hess, i, k))
    return pivot


@compiled
def hold_columns(rows: Array, first: int, free: Array) -> None:
    """Keep the free motions of a node in six columns."""
    before = rows.copy()
    for i in range(6):
        for k in range(6):
            rows[i, first + k] = 0.0
            for j in range(6):
                rows[i, first + k] += before[i, first + j] * free[j, k]


@compiled
def hold(rows: Array, free: Array) -> None:
    """Keep the free motions F of an end in its rows [block | coupling | rhs] (6, 13).

    The block becomes F block F + s (1 - F) with s its largest diagonal entry.
    """
    largest = 0.0
    for i in range(6):
        largest = max(largest, abs(rows[i, i]))
    hold_columns(rows, HERE, free)
    before = rows.copy()
    for i in range(6):
        for k in range(13):
            rows[i, k] = 0.0
            if k < 6:
                rows[i, k] = largest * ((1.0 if i == k else 0.0) - free[i, k])
            for j in range(6):
                rows[i, k] += free[i, j] * before[j, k]


@compiled
def back_substitute(rows: Array, pulls: Array, unit: float, step: Step) -> None:
    """Write the steps of nodes and forces from the eliminated rows."""
    nodes, forces, count = step.nodes, step.forces, len(pulls)
    following = np.zeros(6)
    for e in range(count, -1, -1):
        for i in range(6):
            nodes[e, i] = -rows[e, i, 12]
            for k in range(6):
                nodes[e, i] -= rows[e, i, NEXT + k] * following[k]
        for i in range(3 if e < count else 0):
            forces[e, i] = pulls[e, i, 12]
            for k in range(6):
                forces[e, i] += pulls[e, i, k] * nodes[e, k] + pulls[e, i, NEXT + k] * following[k]
        following = nodes[e]
    for e in range(count + 1):
        for i in range(3, 6):
            nodes[e, i] *= unit


@compiled
def eliminate(
    found: Assembled, nodal: Nodal, bearing: Bearing, exchange: bool, step: Step
) -> float:
    """Write a Newton step from the assembled elements and what acts at the nodes.

    Rows may be exchanged in a block (``exchange``) where the system is not symmetric. Returns the
    smallest pivot.
    """
    count, unit = len(found.chord), bearing.unit
    pulls, every = np.empty((count, 3, 13)), np.zeros((count + 1, 6, 13))
    whole, carried, coupling = np.empty((12, 13)), np.zeros((6, 7)), np.empty((6, 6))
    smallest = np.inf
    for e in range(count + 1):
        rows = every[e]
        for i in range(6):
            weight = unit if i > 2 else 1.0
            for k in range(6):
                own = nodal.tangent[e, i, k] * weight * (unit if k > 2 else 1.0)
                rows[i, k] = carried[i, k] + own
            rows[i, 12] = carried[i, 6] + (found.gradient[e, i] + nodal.drive[e, i]) * weight
        if e < count:
            mismatch, soft = vector_at(found.chord, e), bearing.compliance[e]
            pivot = condense(found.hessians[e], mismatch, soft, unit, pulls[e], whole)
            if not pivot > 0.0:
                return pivot
            for i in range(6):
                for k in range(13):
                    rows[i, k] += whole[i, k]
        if e == 0:
            hold(rows, bearing.end_free[0])
        if e == count:
            hold(rows, bearing.end_free[1])
        if e == count - 1:
            hold_columns(rows, NEXT, bearing.end_free[1])
        for i in range(6):
            for k in range(6):
                coupling[i, k] = rows[i, NEXT + k]
        pivot = reduce_rows(rows, exchange)
        smallest = min(smallest, pivot)
        if not pivot > 0.0:
            return pivot
        for i in range(6):
            for k in range(7):
                carried[i, k] = whole[6 + i, 6 + k]
                for j in range(6):
                    carried[i, k] -= coupling[j, i] * rows[j, 6 + k]
    back_substitute(every, pulls, unit, step)
    return smallest


@compiled
def largest_imbalance(
    gradient: Array, chord: Array, end_free: Array, n: Array
) -> tuple[float, float, float, float]:
    """Return the largest components of couples, forces, gaps between elements and forces inside.

    What holds an end is none of them. NaN where one is.
    """
    count = len(n)
    own = np.empty(6)
    couple = force = apart = within = 0.0
    for e in range(count + 1):
        own[:] = gradient[e]
        if e in (0, count):
            free = end_free[0 if e == 0 else 1]
            for i in range(6):
                own[i] = 0.0
                for k in range(6):
                    own[i] += free[i, k] * gradient[e, k]
        for i in range(3):
            couple, force = larger(couple, own[i]), larger(force, own[3 + i])
            if e < count:
                apart, within = larger(apart, chord[e, i]), larger(within, n[e, i])
    return couple, force, apart, within


@inlined
def larger(size: float, value: float) -> float:
    """Return the larger one of a size and that of a value; NaN if one is."""
    own = abs(value)
    return own if own > size or own != own else size


@compiled
def largest_motion(step: Array) -> tuple[float, float]:
    """Return the largest component of a rotation [rad] and the longest displacement [m]."""
    turn = square = 0.0
    for e in range(len(step)):
        for i in range(3):
            turn = larger(turn, step[e, i])
        away = vector_from(step[e], 3)
        square = larger(square, dot(away, away))
    return turn, np.sqrt(square)


class Scales(NamedTuple):
    """What is large and small in a problem.

    Attributes:
        force: [N].
        moment: [N m], at that force.
        length: [m]; positions weigh ten times as much as their fraction of the rod's.
        step: mean length of an element [m].
        pair: product of a slack and a force that counts as one [N m].
        rounded: part of the forces inside that counts as a load.
        shift: stiffness of a node's displacement that is small [N/m].
    """

    force: float
    moment: float
    length: float
    step: float
    pair: float
    rounded: float
    shift: float


@compiled
def residual_at(
    law: Law,
    contacts: Contacts,
    x: Iterate,
    found: Assembled,
    nodal: Nodal,
    free: Array,
    size: Scales,
) -> float:
    """Return the largest imbalance that is not a reaction at an end; NaN where one is."""
    couple, push, apart, within = largest_imbalance(nodal.gradient, found.chord, free, x.n)
    force = max(size.force, size.rounded * within)
    contact = contact_residual(law, contacts, x, size.length, force, size.pair)
    worst = 0.0
    for one in (
        couple / max(size.moment, force * size.step),
        push / force,
        apart / size.length,
        contact,
    ):
        worst = larger(worst, one)
    return worst


@compiled
def linearize(
    law: Law,
    contacts: Contacts,
    x: Iterate,
    anchors: Anchors,
    elements: Elements,
    bearing: Bearing,
    size: Scales,
    shift: float,
    nodal: Nodal,
    found: Assembled,
    step: Step,
) -> tuple[float, float, float, float]:
    """Write imbalance, elements and Newton step at an iterate, from the loads at the nodes.

    ``nodal`` has the loads and gets the contacts, its gradient the elements too. A Hessian that is
    not positive is shifted, unless an active set chooses contacts: that goes on by another method.
    Returns energy [J], residual, smallest pivot and shift.
    """
    for j in range(len(contacts.gap)):
        contact_terms(law, contacts, x, anchors, j, nodal)
    energy = assemble(x, elements, found)
    shift = 0.1 * shift if shift > SHIFT * size.shift else 0.0
    tangent = nodal.tangent.copy()
    while True:
        for e in range(len(tangent)):
            for i in range(6):
                inertia = size.step * size.step if i < 3 else 1.0
                nodal.tangent[e, i, i] = tangent[e, i, i] + shift * inertia
        pivot = eliminate(found, nodal, bearing, law.coupled, step)
        chosen = law.sharp and len(contacts.gap) > 0
        if pivot > 0.0 or not math.isfinite(pivot) or chosen or shift > MOST_SHIFT * size.shift:
            break
        shift = max(10.0 * shift, SHIFT * size.shift)
    nodal.gradient[:] += found.gradient
    residual = residual_at(law, contacts, x, found, nodal, bearing.end_free, size)
    return energy, residual, pivot, shift


@compiled
def take_step(
    law: Law, contacts: Contacts, x: Iterate, step: Step, max_move: float
) -> tuple[float, float]:
    """Take as much of the step as rotations, moves and the barrier allow.

    Returns the smaller fraction taken, of positions or forces, and the mean pair of slack and force
    after it [N m].
    """
    turn, move = largest_motion(step.nodes)
    limit = min(1.0, MAX_ROTATION / max(turn, TINY), max_move / max(move, TINY))
    primal, dual = contact_step(law, contacts, x, step.nodes)
    primal, dual = min(primal, limit), min(dual, limit)
    turn_nodes(x.q, step.nodes, primal, x.q)
    x.p[:] += primal * step.nodes[:, 3:]
    x.n[:] += dual * step.forces
    follow_step(law, contacts, x, step.nodes, primal, dual)
    pairs, count = 0.0, 0
    for j in range(len(contacts.gap)):
        for e in range(len(contacts.touchable)):
            if contacts.touchable[e]:
                pairs, count = pairs + x.normal[j, e] * x.slack[j, e], count + 1
    return min(primal, dual), pairs / max(count, 1)


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """What an iteration found.

    Args:
        outcome: as numbered in :mod:`spiral_core.rod._newton`.
        passes: assemblies of the system.
        energy: of elements and their load [J].
        residual: largest imbalance, as a fraction of the scales of forces, moments and L/10.
        pivot: smallest pivot [N m].
        gradient: (N + 1, 6) imbalance; at the ends, what holds them.
        moments: (N + 1, 3) in the material frame [N m].
        contacts: with the obstacles.
    """

    outcome: int
    passes: int
    energy: float
    residual: float
    pivot: float
    gradient: Array
    moments: Array
    contacts: Contacts


def bearing_of(arrays: Arrays) -> Bearing:
    """Return how the nodes of a problem are held."""
    lengths = np.diff(arrays.arc_lengths)
    compliance = CHORD_COMPLIANCE * lengths**3 / (12.0 * arrays.bending)
    return Bearing(arrays.end_free, compliance, arrays.step)


def load_terms(arrays: Arrays, x: Iterate) -> Nodal:
    """Return gradient and Hessian of loads at the nodes, and the stiffness of neutral motions."""
    count = arrays.count
    gradient, tangent = np.zeros((count + 1, 6)), np.zeros((count + 1, 6, 6))
    gradient[:, 3:] = -arrays.nodal[:, 3:]
    if arrays.nodal[:, :3].any():
        moment = np.einsum("nji,nj->ni", matrices(x.q), arrays.nodal[:, :3])
        gradient[:, :3] = -moment
        tangent[:, :3, :3] = -0.5 * skews(moment)
    neutral = NEUTRAL * arrays.bending / arrays.length / count
    every = np.arange(6)
    tangent[:, every, every] += np.repeat((neutral, neutral / arrays.length**2), 3)
    return Nodal(gradient, gradient.copy(), tangent)


class Newton:
    """One solve of a problem, from an iterate that is changed in place."""

    def __init__(
        self,
        arrays: Arrays,
        x: Iterate,
        anchors: Anchors,
        added: NodalTerms | None = None,
        *,
        tolerance: float = DEFAULT_TOLERANCE,
        rounded: float = ROUNDED,
    ) -> None:
        self.arrays, self.x, self.anchors, self.added = arrays, x, anchors, added
        self.tolerance = tolerance
        count, h, length, force = arrays.count, arrays.step, arrays.length, arrays.force_scale
        own = 12.0 * arrays.bending / h**3
        self.last_barrier = LAST_BARRIER * force * length / count
        self.size = Scales(
            force=force,
            moment=max(arrays.bending / length, force * h),
            length=length / LENGTH_WEIGHT,
            step=h,
            pair=2.0 * self.last_barrier / tolerance,
            rounded=rounded,
            shift=force / length / count,
        )
        self.last_slip = last_slip(arrays)
        self.law = self.first = Law(
            sharp=True,
            barrier=self.last_barrier,
            slip=self.last_slip,
            stiffness=CONTACT_STIFFNESS * own,
            compliance=CONTACT_COMPLIANCE / own,
            coupled=False,
        )
        self.bearing = bearing_of(arrays)
        self.loads, self.follows = load_terms(arrays, x), bool(arrays.nodal[:, :3].any())
        self.rubs = any(obstacle.friction > 0.0 for obstacle in arrays.obstacles)
        self.touchable, self.shift, self.polished = self._hold_ends(), 0.0, False
        self.step, self.elements = no_step(count), no_elements(count)

    def _hold_ends(self) -> NDArray[np.bool_]:
        """Put the ends where they are held; return which nodes may touch (N + 1,)."""
        arrays, x = self.arrays, self.x
        free = np.ones(arrays.count + 1, dtype=np.bool_)
        for side, node in ((0, 0), (1, -1)):
            hold = arrays.end_free[side]
            if not hold[:3, :3].any():
                held = arrays.end_orientations[side]
                x.q[node] = held if held @ x.q[node] >= 0.0 else -held  # q and -q are one rotation
            away = arrays.end_positions[side] - x.p[node]
            x.p[node] += away - hold[3:, 3:] @ away
            free[node] = hold[3:, 3:].any()
        return free

    def run(self, max_move: float, too_far: Callable[[Array], bool] | None = None) -> Solution:
        """Iterate to the equilibrium; nodes move at most ``max_move`` [m] in a step.

        Given up where ``too_far`` says so of the positions.
        """
        start = self.x.copy()
        quick, blocked, patience, best = True, 0, 0, np.inf
        solution = self._pass()
        first = self._first_guess(solution)
        for passes in range(1, MAX_PASSES):
            if not math.isfinite(solution.residual):
                return replace(solution, outcome=NOT_FINITE, passes=passes)
            if self._settled(solution):
                solution = self._certified(solution)
                if solution.pivot > 0.0:
                    return replace(solution, outcome=CONVERGED, passes=passes)
            patience = QUICK_PASSES if solution.residual < 0.5 * best else patience - 1
            best = min(best, solution.residual)
            lost = not solution.pivot > 0.0 or (too_far is not None and too_far(self.x.p))
            if quick and (lost or patience == 0) and self.arrays.obstacles:
                quick = False
                self._restart(start, *first)
            elif lost:
                return replace(solution, outcome=UNSTABLE, passes=passes)
            else:
                fraction, mean = take_step(self.law, solution.contacts, self.x, self.step, max_move)
                if self.law.sharp:
                    self.law = self.law._replace(stiffness=QUICK_STIFFNESS * self.first.stiffness)
                else:
                    blocked = blocked + 1 if fraction < BLOCKED else 0
                    blocked = self._sink(fraction, mean, blocked, first)
                # friction follows the normal force, near the end and in motion
                near = solution.residual < COUPLING_RESIDUAL or self.added is not None
                last = self.law.slip == self.last_slip and self.shift == 0.0
                self.law = self.law._replace(coupled=self.rubs and near and last)
            solution = self._pass()
        return replace(solution, outcome=ITERATION_LIMIT, passes=MAX_PASSES)

    def _settled(self, solution: Solution) -> bool:
        """Return whether the equations hold, with the contact's last barrier and elastic slip."""
        law = self.law
        last = law.slip == self.last_slip and (law.sharp or law.barrier == self.last_barrier)
        if not (last and self.shift == 0.0 and solution.residual < self.tolerance):
            return False
        again, self.polished = self.polished, True
        still = float(np.abs(self.step.nodes[:, 3:]).max()) < LAST_MOVE * self.arrays.length
        return again or still or bool(solution.contacts.active.any())

    def _certified(self, solution: Solution) -> Solution:
        """Return the solution with the smallest pivot of its symmetric Hessian."""
        if not self.law.coupled:
            return solution
        self.law = self.law._replace(coupled=False)
        nodal, step = self._loads(), no_step(self.arrays.count)
        for j in range(len(self.arrays.obstacles)):
            contact_terms(self.law, solution.contacts, self.x, self.anchors, j, nodal)
        pivot = eliminate(self.elements, nodal, self.bearing, False, step)
        return replace(solution, pivot=pivot)

    def _first_guess(self, solution: Solution) -> tuple[float, float, float]:
        """Return width [m], barrier [N m] and slip [m] with which a thorough iteration begins."""
        length, contacts = self.arrays.length, solution.contacts
        moved = np.einsum("jni,ni->jn", contacts.normal, self.step.nodes[:, 3:])
        reach = float((-(contacts.gap + moved) * self.touchable).max(initial=0.0))
        width = min(max(reach, 1e-5 * length), 0.05 * length)
        barrier = 0.01 * self.size.force * width * min(1.0, max(solution.residual, 0.1))
        _, move = largest_motion(self.step.nodes)
        square = np.sum(contacts.touch.slip[contacts.active] ** 2, axis=1)
        slip = max(0.1 * min(move, 0.01 * length), 10.0 * self.last_slip)
        return width, barrier, max(slip, 0.1 * math.sqrt(square.max(initial=0.0)))

    def _restart(self, start: Iterate, width: float, barrier: float, slip: float) -> None:
        """Go back to the start, with a wide barrier."""
        for array, before in zip(self.x, start, strict=True):
            array[:] = before
        self.law = self.first._replace(sharp=False, barrier=barrier, slip=slip)
        widen(self.x, self.arrays.obstacles, self.arrays.radius, width, self.law.barrier)

    def _sink(
        self, fraction: float, mean: float, blocked: int, first: tuple[float, float, float]
    ) -> int:
        """Set the barrier and slip of the next pass from how the last step went."""
        law = self.law
        if blocked == 2:
            width = min(3.0 * first[0], 0.1 * self.arrays.length)
            self.law = law._replace(barrier=10.0 * mean)
            widen(self.x, self.arrays.obstacles, self.arrays.radius, width, self.law.barrier)
            return 0
        barrier = max(self.last_barrier, mean * max(0.02, (1.0 - fraction) ** 2))
        slip = law.slip
        if fraction > 0.3:
            slip = max(self.last_slip, slip * max(0.1, 1.0 - fraction))
        self.law = law._replace(barrier=barrier, slip=slip)
        return blocked

    def _pass(self) -> Solution:
        """Return what is found at the iterate, and write the step from there."""
        nodal, contacts = self._loads(), contacts_at(self.x, self.arrays, self.touchable)
        energy, residual, pivot, self.shift = linearize(
            self.law,
            contacts,
            self.x,
            self.anchors,
            self.arrays.elements,
            self.bearing,
            self.size,
            self.shift,
            nodal,
            self.elements,
            self.step,
        )
        moments = self.elements.moments.copy()
        return Solution(UNSTABLE, 0, energy, residual, pivot, nodal.gradient, moments, contacts)

    def _loads(self) -> Nodal:
        """Return gradient and Hessian of loads at the nodes and of what is added."""
        if self.follows:
            nodal = load_terms(self.arrays, self.x)
        else:
            nodal = Nodal(*map(np.copy, self.loads))
        if self.added is not None:
            self.added.add(self.x, nodal.gradient, nodal.tangent)
            nodal.drive[:] = nodal.gradient
        return nodal
