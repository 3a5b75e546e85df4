# SPDX-License-Identifier: Apache-2.0
"""From an iterate and its evidence to the state that a user sees."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod.contact._increments import Point
from spiral_core.rod.contact._mesh import Arrays
from spiral_core.rod.contact._newton import CONVERGED, ITERATION_LIMIT, NOT_FINITE
from spiral_core.rod.contact._quaternions import matrices
from spiral_core.rod.contact.state import ContactEvent, ContactState, ContactStatus, SelfContact
from spiral_core.rod.types import Array

# Two places closer than this along the rod, in its radii, are one place, not two that touch.
NEIGHBORS = math.pi


def state_from_point(
    point: Point, iterations: int, status: ContactStatus | None = None
) -> ContactState:
    """Return the state at a point of a path; ``status`` overrides how its solve ended."""
    arrays, x, solution = point.arrays, point.x, point.solution
    turn = matrices(x.q)
    clearance = self_clearance(x.p, arrays.arc_lengths, arrays.radius)
    if status is None:
        status = _status(solution.outcome)
        if status is ContactStatus.CONVERGED and not clearance > 0.0:
            status = ContactStatus.SELF_CONTACT
    normal_forces, gaps, contact_forces, sticking = _contacts(point)
    moments = solution.moments
    potential = float(np.sum(arrays.nodal[:, 3:] * x.p))
    return ContactState(
        status=status,
        arc_lengths=arrays.arc_lengths,
        positions=x.p,
        orientations=x.q,
        forces=_nodal_forces(x.n, arrays.half),
        moments=moments,
        contact_forces=contact_forces,
        normal_forces=normal_forces,
        gaps=gaps,
        sticking=sticking,
        base_reaction=_reaction(solution.gradient[0], turn[0]),
        tip_reaction=_reaction(solution.gradient[-1], turn[-1]),
        energy=solution.energy + arrays.rest_energy - potential,
        residual=solution.residual,
        smallest_pivot=solution.pivot * arrays.length / arrays.bending,
        iterations=iterations,
        self_clearance=clearance,
        _point=point,
    )


def _status(outcome: int) -> ContactStatus:
    """Return the status of an outcome."""
    return {
        CONVERGED: ContactStatus.CONVERGED,
        ITERATION_LIMIT: ContactStatus.ITERATION_LIMIT,
        NOT_FINITE: ContactStatus.NOT_FINITE,
    }.get(outcome, ContactStatus.UNSTABLE)


def _contacts(point: Point) -> tuple[Array, Array, Array, Array]:
    """Return normal forces, gaps, contact forces on the rod, and which nodes stick."""
    arrays, x = point.arrays, point.x
    shape = (len(arrays.obstacles), arrays.count + 1)
    normal_forces, gaps = np.zeros(shape), np.zeros(shape)
    forces, sticking = np.zeros((*shape, 3)), np.zeros(shape, dtype=bool)
    for j in range(len(arrays.obstacles)):
        contact = point.solution.contacts[j]
        gaps[j], normal = contact.gap, contact.normal
        normal_forces[j] = x.normal[j] * contact.touchable
        forces[j] = normal_forces[j][:, None] * normal
        if contact.rubs:
            forces[j] -= x.friction[j] * contact.touchable[:, None]
            sticking[j] = contact.sticks
    return normal_forces, gaps, forces, sticking


def _nodal_forces(n: Array, half: Array) -> Array:
    """Return the internal force at the nodes: the mean of both sides."""
    before, after = n - half, n + half
    forces = np.empty((len(n) + 1, 3))
    forces[0], forces[-1] = after[0], before[-1]
    forces[1:-1] = 0.5 * (before[:-1] + after[1:])
    return forces


def _reaction(gradient: Array, turn: Array) -> Array:
    """Return force and moment of a hold, in the base frame."""
    return np.concatenate((gradient[3:], turn @ gradient[:3]))


def self_clearance(positions: Array, arc_lengths: Array, radius: float) -> float:
    """Return the least distance between the surfaces of two places of the rod [m].

    Distances of the axis from 4 radii on count as 4.
    """
    if not radius > 0.0 or arc_lengths[-1] <= NEIGHBORS * radius:
        return math.inf
    longest = float(np.sqrt(np.max(np.sum(np.diff(positions, axis=0) ** 2, axis=1))))
    least = least_distance(positions, arc_lengths, NEIGHBORS * radius, longest, 4.0 * radius)
    return least - 2.0 * radius


def nearest_places(positions: Array, arc_lengths: Array, radius: float) -> tuple[float, float]:
    """Return the arc lengths of the two nodes that are nearest to each other, but no neighbors."""
    away = np.linalg.norm(positions[:, None] - positions, axis=2)
    away[np.abs(arc_lengths[:, None] - arc_lengths) <= NEIGHBORS * radius] = math.inf
    first, second = np.unravel_index(int(np.argmin(away)), away.shape)
    return float(arc_lengths[first]), float(arc_lengths[second])


@compiled
def least_distance(
    positions: Array, arc_lengths: Array, apart: float, longest: float, least: float
) -> float:
    """Return the least distance of two nodes that are farther apart along the rod than ``apart``.

    ``least`` is what is returned if none are nearer; ``longest`` is the longest element: so many
    nodes on as another one is too far away, no node can be near.
    """
    first = 0
    for i in range(len(positions)):
        while first < len(positions) and not arc_lengths[first] - arc_lengths[i] > apart:
            first += 1
        k = first
        while k < len(positions):
            square = 0.0
            for c in range(3):
                square += (positions[k, c] - positions[i, c]) ** 2
            distance = math.sqrt(square)
            least = min(least, distance)
            k += max(1, int((distance - least) / longest))
    return least


@dataclass(slots=True, eq=False)
class PathLog:
    """What happens on a path."""

    events: list[ContactEvent] = field(default_factory=list)
    self_contact: SelfContact | None = None

    def watch(self, position: float, positions: Array, arrays: Arrays) -> None:
        """Note whether the rod touches itself at a place of the path."""
        if self.self_contact is None:
            arcs, radius = arrays.arc_lengths, arrays.radius
            if not self_clearance(positions, arcs, radius) > 0.0:
                self.self_contact = SelfContact(position, nearest_places(positions, arcs, radius))
