# SPDX-License-Identifier: Apache-2.0
"""Newton's method for a rod with obstacles, from one state to the equilibrium next to it.

First quickly, with the contacts that the start has; if that does not settle within a few passes,
from the start again by an interior-point method, whose barrier sinks as the iteration converges.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from spiral_core.rod.contact._algebra import matrices, skews, turn_nodes
from spiral_core.rod.contact._contact import (
    Anchors,
    Contact,
    Iterate,
    Law,
    NodalTerms,
    Reach,
    widen,
)
from spiral_core.rod.contact._elimination import assemble, eliminate
from spiral_core.rod.contact._laws import TINY
from spiral_core.rod.contact._mesh import Arrays, last_slip
from spiral_core.rod.types import DEFAULT_TOLERANCE, Array

# Outcomes.
CONVERGED, ITERATION_LIMIT, NOT_FINITE, UNSTABLE = range(4)

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


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """What an iteration found.

    Args:
        outcome: as numbered above.
        passes: assemblies of the system.
        energy: of elements and their load [J].
        residual: largest imbalance, as a fraction of the scales of forces, moments and L/10.
        pivot: smallest pivot [N m].
        gradient: (N + 1, 6) imbalance; at the ends, what holds them.
        moments: (N + 1, 3) in the material frame [N m].
        contacts: one for each obstacle.
    """

    outcome: int
    passes: int
    energy: float
    residual: float
    pivot: float
    gradient: Array
    moments: Array
    contacts: tuple[Contact, ...]


class Newton:
    """One solve of a problem, from an iterate that is changed in place."""

    def __init__(
        self, arrays: Arrays, x: Iterate, anchors: Anchors, added: NodalTerms | None = None
    ) -> None:
        self.arrays, self.x, self.anchors, self.added = arrays, x, anchors, added
        self.tolerance, self.rounded = DEFAULT_TOLERANCE, ROUNDED
        count, h = arrays.count, arrays.step
        self.force = arrays.force_scale
        self.moment = max(arrays.bending / arrays.length, self.force * h)
        own = 12.0 * arrays.bending / h**3
        self.last_barrier = LAST_BARRIER * self.force * arrays.length / count
        self.last_slip = last_slip(arrays)
        self.law = self.first = Law(
            sharp=True,
            barrier=self.last_barrier,
            slip=self.last_slip,
            stiffness=CONTACT_STIFFNESS * own,
            compliance=CONTACT_COMPLIANCE / own,
            coupled=False,
        )
        self.compliance = (
            CHORD_COMPLIANCE * np.diff(arrays.arc_lengths) ** 3 / (12.0 * arrays.bending)
        )
        self.mass = np.array((h * h, h * h, h * h, 1.0, 1.0, 1.0))
        self.rubs = any(obstacle.friction > 0.0 for obstacle in arrays.obstacles)
        self.touchable, self.shift, self.polished = self._hold_ends(), 0.0, False
        self.step, self.force_step = np.zeros((count + 1, 6)), np.zeros((count, 3))
        self.gradient, self.chord = np.zeros((count + 1, 6)), np.zeros((count, 3))
        self.moments = np.zeros((count + 1, 3))
        self.hessians, self.gradients = np.empty((count, 9, 9)), np.empty((count, 9))

    def _hold_ends(self) -> Array:
        """Put the ends where they are held; return 1 for nodes that may touch (N + 1,)."""
        arrays, x = self.arrays, self.x
        free = np.ones(arrays.count + 1)
        for side, node in ((0, 0), (1, -1)):
            hold = arrays.end_free[side]
            if not hold[:3, :3].any():
                x.q[node] = arrays.end_orientations[side]
            away = arrays.end_positions[side] - x.p[node]
            x.p[node] += away - hold[3:, 3:] @ away
            free[node] = hold[3:, 3:].any()
        return free

    def run(self, max_move: float, reach: Reach | None = None) -> Solution:
        """Iterate to the equilibrium; nodes move at most ``max_move`` [m] in a step."""
        start = self.x.copy()
        quick, blocked, patience, best = True, 0, 0, np.inf
        solution = self._pass()
        first = self._first_guess(solution)
        for passes in range(1, MAX_PASSES):
            if not np.isfinite(solution.residual):
                return replace(solution, outcome=NOT_FINITE, passes=passes)
            if self._settled(solution):
                solution = self._certified(solution)
                if solution.pivot > 0.0:
                    return replace(solution, outcome=CONVERGED, passes=passes)
            patience = QUICK_PASSES if solution.residual < 0.5 * best else patience - 1
            best = min(best, solution.residual)
            lost = not solution.pivot > 0.0 or (reach is not None and reach.left(self.x.p))
            if quick and (lost or patience == 0) and self.arrays.obstacles:
                quick = False
                self._restart(start, *first)
            elif not lost:
                primal, dual = self._advance(solution, max_move)
                if self.law.sharp:
                    self.law = replace(self.law, stiffness=QUICK_STIFFNESS * self.first.stiffness)
                else:
                    blocked = blocked + 1 if min(primal, dual) < BLOCKED else 0
                    blocked = self._sink(min(primal, dual), blocked, first)
                self._couple(solution)
            else:
                return replace(solution, outcome=UNSTABLE, passes=passes)
            solution = self._pass()
        return replace(solution, outcome=ITERATION_LIMIT, passes=MAX_PASSES)

    def _settled(self, solution: Solution) -> bool:
        """Return whether the equations hold, with the contact's last barrier and elastic slip."""
        law = self.law
        last = law.slip == self.last_slip and (law.sharp or law.barrier == self.last_barrier)
        if not (last and self.shift == 0.0 and solution.residual < self.tolerance):
            return False
        again, self.polished = self.polished, True
        still = float(np.abs(self.step[:, 3:]).max()) < LAST_MOVE * self.arrays.length
        return again or still or any(contact.active.any() for contact in solution.contacts)

    def _couple(self, solution: Solution) -> None:
        """Let friction follow the normal force in the next pass, near the end and in motion."""
        near = solution.residual < COUPLING_RESIDUAL or self.added is not None
        last = self.law.slip == self.last_slip and self.shift == 0.0
        self.law = replace(self.law, coupled=self.rubs and near and last)

    def _certified(self, solution: Solution) -> Solution:
        """Return the solution with the smallest pivot of its symmetric Hessian."""
        if not self.law.coupled:
            return solution
        self.law = replace(self.law, coupled=False)
        drive, tangent = self._loads()
        for contact in solution.contacts:
            contact.add(self.law, drive.copy(), drive, tangent)
        step, force = self.step.copy(), self.force_step.copy()
        pivot = self._eliminate(drive, tangent)
        self.step[:], self.force_step[:] = step, force
        return replace(solution, pivot=pivot)

    def _first_guess(self, solution: Solution) -> tuple[float, float, float]:
        """Return width [m], barrier [N m] and slip [m] with which a thorough iteration begins."""
        length = self.arrays.length
        reach = 0.0
        for contact in solution.contacts:
            moved = np.einsum("ni,ni->n", contact.normal, self.step[:, 3:])
            reach = max(reach, float(-((contact.gap + moved) * self.touchable).min()))
        width = min(max(reach, 1e-5 * length), 0.05 * length)
        barrier = 0.01 * self.force * width * min(1.0, max(solution.residual, 0.1))
        move = float(np.sqrt(np.max(np.sum(self.step[:, 3:] ** 2, axis=1))))
        slip = max(0.1 * min(move, 0.01 * length), 10.0 * self.last_slip)
        for contact in solution.contacts:
            if contact.rubs:
                square = np.sum(contact.slip[contact.active] ** 2, axis=1)
                slip = max(slip, 0.1 * float(np.sqrt(square.max(initial=0.0))))
        return width, barrier, slip

    def _restart(self, start: Iterate, width: float, barrier: float, slip: float) -> None:
        """Go back to the start, with a wide barrier."""
        for name in Iterate.__slots__:
            getattr(self.x, name)[:] = getattr(start, name)
        self.law = replace(self.first, sharp=False, barrier=barrier, slip=slip)
        widen(self.x, self.arrays.obstacles, self.arrays.radius, width, self.law.barrier)

    def _sink(self, fraction: float, blocked: int, first: tuple[float, float, float]) -> int:
        """Set the barrier and slip of the next pass from how the last step went."""
        pairs = self.x.normal * self.x.slack * self.touchable
        mean = float(np.sum(pairs)) / (len(pairs) * float(np.sum(self.touchable)))
        law = self.law
        if blocked == 2:
            width = min(3.0 * first[0], 0.1 * self.arrays.length)
            self.law = replace(law, barrier=10.0 * mean)
            widen(self.x, self.arrays.obstacles, self.arrays.radius, width, self.law.barrier)
            return 0
        barrier = max(self.last_barrier, mean * max(0.02, (1.0 - fraction) ** 2))
        slip = law.slip
        if fraction > 0.3:
            slip = max(self.last_slip, slip * max(0.1, 1.0 - fraction))
        self.law = replace(law, barrier=barrier, slip=slip)
        return blocked

    def _pass(self) -> Solution:
        """Assemble and eliminate at the iterate; a Hessian that is not positive is shifted."""
        arrays, x, law = self.arrays, self.x, self.law
        drive, tangent = self._loads()
        true = drive.copy()
        contacts = tuple(
            Contact(x, j, obstacle, arrays.radius, self.touchable, self.anchors)
            for j, obstacle in enumerate(arrays.obstacles)
        )
        for contact in contacts:
            contact.add(law, true, drive, tangent)
        energy = assemble(
            x.q, x.p, x.n, arrays.half, arrays.own, self.hessians, self.gradients, self.chord,
            self.moments,
        )  # fmt: skip
        unit, diagonal = self.force / arrays.length / arrays.count, np.arange(6)
        self.shift = 0.1 * self.shift if self.shift > 1e-2 * unit else 0.0
        while True:
            shifted = tangent
            if self.shift:
                shifted = tangent.copy()
                shifted[:, diagonal, diagonal] += self.shift * self.mass
            pivot = self._eliminate(drive, shifted)
            done = pivot > 0.0 or not np.isfinite(pivot) or (law.sharp and contacts)
            if done or self.shift > 1e9 * unit:
                break
            self.shift = max(10.0 * self.shift, 1e-2 * unit)
        gradient = self.gradient - drive + true
        residual = self._residual(gradient, contacts)
        return Solution(
            UNSTABLE, 0, energy, residual, pivot, gradient, self.moments.copy(), contacts
        )

    def _eliminate(self, drive: Array, tangent: Array) -> float:
        """Write the steps that a gradient and a Hessian at the nodes give; return the pivot."""
        arrays = self.arrays
        return eliminate(
            self.hessians, self.gradients, self.x.n, arrays.half, self.chord, self.compliance,
            drive, tangent, arrays.end_free, arrays.step, self.law.coupled, self.step,
            self.force_step, self.gradient,
        )  # fmt: skip

    def _loads(self) -> tuple[Array, Array]:
        """Return gradient and Hessian of loads at the nodes and of what is added."""
        arrays, x, count = self.arrays, self.x, self.arrays.count
        gradient, tangent = np.zeros((count + 1, 6)), np.zeros((count + 1, 6, 6))
        gradient[:, 3:] = -arrays.nodal[:, 3:]
        if arrays.nodal[:, :3].any():
            moment = np.einsum("nji,nj->ni", matrices(x.q), arrays.nodal[:, :3])
            gradient[:, :3] = -moment
            tangent[:, :3, :3] = -0.5 * skews(moment)
        diagonal = np.arange(3)
        neutral = NEUTRAL * arrays.bending / arrays.length / count
        tangent[:, diagonal, diagonal] += neutral
        tangent[:, 3 + diagonal, 3 + diagonal] += neutral / arrays.length**2
        if self.added is not None:
            self.added.add(x, gradient, tangent)
        return gradient, tangent

    def _residual(self, gradient: Array, contacts: tuple[Contact, ...]) -> float:
        """Return the largest imbalance that is not a reaction at an end."""
        inner = gradient.copy()
        inner[0] = self.arrays.end_free[0] @ inner[0]
        inner[-1] = self.arrays.end_free[1] @ inner[-1]
        force = max(self.force, self.rounded * float(np.abs(self.x.n).max()))
        length = self.arrays.length / LENGTH_WEIGHT
        worst = [
            float(np.abs(inner[:, :3]).max()) / max(self.moment, force * self.arrays.step),
            float(np.abs(inner[:, 3:]).max()) / force,
            float(np.abs(self.chord).max()) / length,
        ]
        pair = 2.0 * self.last_barrier / self.tolerance
        worst += [contact.residual(length, force, pair) for contact in contacts]
        return float(np.max(worst))

    def _advance(self, solution: Solution, max_move: float) -> tuple[float, float]:
        """Take as much of the step as rotations, moves and the barrier allow."""
        x, step = self.x, self.step
        turn = float(np.abs(step[:, :3]).max())
        move = float(np.sqrt(np.max(np.sum(step[:, 3:] ** 2, axis=1))))
        limit = min(1.0, MAX_ROTATION / max(turn, TINY), max_move / max(move, TINY))
        primal = dual = limit
        for contact in solution.contacts:
            near, far = contact.fractions(step)
            primal, dual = min(primal, near), min(dual, far)
        turn_nodes(x.q, 0.5 * primal * step[:, :3])
        x.p += primal * step[:, 3:]
        x.n += dual * self.force_step
        for contact in solution.contacts:
            contact.update(self.law.coupled, step, primal, dual)
        return primal, dual
