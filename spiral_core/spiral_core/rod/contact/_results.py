# SPDX-License-Identifier: Apache-2.0
"""From an iterate and its evidence to the state that a user sees."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import matrices
from spiral_core.rod.contact._contact import TINY, Iterate
from spiral_core.rod.contact._continuation import Point, from_centerline, gaps_at
from spiral_core.rod.contact._mesh import Arrays
from spiral_core.rod.contact._newton import CONVERGED, ITERATION_LIMIT, NOT_FINITE
from spiral_core.rod.contact.problem import RodProblem
from spiral_core.rod.state import RodEvent, RodState, RodStatus, SelfContact
from spiral_core.rod.types import Array

# Two places closer than this along the rod, in its radii, are one place, not two that touch.
NEIGHBORS = math.pi
# Largest force on an element, times h^2 over its stiffness against bending inside: at ten that is
# lost, and on the way there an element bends by too much.
MOST_TENSION = 7.0
# Elements are parallel below this squared sine of the angle between them.
PARALLEL = 1e-14


def state_from_point(point: Point, iterations: int, status: RodStatus | None = None) -> RodState:
    """Return the state at a point of a path; ``status`` overrides how its solve ended."""
    arrays, x, solution = point.arrays, point.x, point.solution
    turn = matrices(x.q)
    clearance = self_clearance(x.p, arrays.arc_lengths, arrays.radius)
    if status is None:
        status = _status(solution.outcome)
        if status is RodStatus.CONVERGED and not clearance > 0.0:
            status = RodStatus.SELF_CONTACT
    normal_forces, gaps, contact_forces, sticking = _contacts(point)
    if status is RodStatus.CONVERGED and _held_inside(arrays, gaps):
        status = RodStatus.INSIDE_OBSTACLE
    if status is RodStatus.CONVERGED and _pulled_too_hard(arrays, x.n):
        status = RodStatus.NOT_HELD
    moments = solution.moments
    potential = float(np.sum(arrays.nodal[:, 3:] * x.p))
    return RodState(
        status=status,
        arc_lengths=arrays.arc_lengths,
        positions=x.p,
        orientations=x.q,
        forces=_nodal_forces(x.n - arrays.growing, arrays.elements.half_load),
        moments=moments,
        strains=np.empty((0, 3)),
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


def point_of_state(state: RodState) -> Point:
    """Return the point that a state stands for."""
    if not isinstance(state, RodState):
        raise InvalidInputError("start", state, "a RodState")
    if state.status is not RodStatus.CONVERGED:
        raise InvalidInputError("start", state.status, "a converged state")
    if state._point is None:
        requirement = "a state of the mixed element: solve_rod(..., element=RodElement.MIXED)"
        raise InvalidInputError("start", state.element.name, requirement)
    return replace(state._point, at=0.0, x=state._point.x.copy())


def from_shape(problem: RodProblem, arrays: Arrays, start: RodState | Array) -> Iterate:
    """Return a rod in the shape of a centerline or, on as many nodes, of a state."""
    if not isinstance(start, RodState):
        return from_centerline(problem, arrays, np.asarray(start, dtype=np.float64))
    x = from_centerline(problem, arrays, start.positions.copy())
    if start.orientations.shape == x.q.shape:
        x.q[:] = start.orientations
    return x


def _status(outcome: int) -> RodStatus:
    """Return the status of an outcome."""
    return {
        CONVERGED: RodStatus.CONVERGED,
        ITERATION_LIMIT: RodStatus.ITERATION_LIMIT,
        NOT_FINITE: RodStatus.NOT_FINITE,
    }.get(outcome, RodStatus.UNSTABLE)


def _contacts(point: Point) -> tuple[Array, Array, Array, Array]:
    """Return normal forces, gaps, contact forces on the rod, and which nodes stick."""
    arrays, x = point.arrays, point.x
    shape = (len(arrays.obstacles), arrays.count + 1)
    normal_forces, gaps = np.zeros(shape), np.zeros(shape)
    forces, sticking = np.zeros((*shape, 3)), np.zeros(shape, dtype=bool)
    if not point.solution.contacts:  # nothing was solved
        return normal_forces, np.array(gaps_at(point)).reshape(shape), forces, sticking
    for j, contact in enumerate(point.solution.contacts):
        gaps[j], normal = contact.gap, contact.normal
        normal_forces[j] = x.normal[j] * contact.touchable
        forces[j] = normal_forces[j][:, None] * normal
        if contact.rubs:
            forces[j] -= contact.touch.tau
            sticking[j] = contact.sticks
    return normal_forces, gaps, forces, sticking


def _held_inside(arrays: Arrays, gaps: Array) -> bool:
    """Return whether an end is held where its axis is inside of an obstacle: nothing pushes it."""
    least = -arrays.radius - 1e-3 * max(arrays.radius, 1e-3 * arrays.length)
    ends = ((0, 0), (1, -1))
    held = [node for side, node in ends if not arrays.end_free[side, 3:, 3:].any()]
    return bool((gaps[:, held] < least).any())


def _pulled_too_hard(arrays: Arrays, n: Array) -> bool:
    """Return whether an element bends inside as its force does not let it: take more elements."""
    square = np.sum(n * n, axis=1) * np.diff(arrays.arc_lengths) ** 4
    soft = arrays.elements.flexibility
    soft = np.maximum(soft[:, 1, 1], soft[:, 2, 2])
    return bool((square * soft**2 > MOST_TENSION**2).any())


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

    As :func:`nearest_places` measures it: at most two radii.
    """
    if not radius > 0.0 or arc_lengths[-1] <= NEIGHBORS * radius:
        return math.inf
    return float(nearest_places(positions, arc_lengths, radius)[0]) - 2.0 * radius


@compiled
def nearest_on(first: Array, last: Array, at: float, i: int, k: int) -> tuple[float, float, float]:
    """Return the least distance of elements i and k, and where on each of them, from 0 to 1.

    Their nodes are the fraction ``at`` of the way from ``first`` to ``last`` (n, 3). On parallel
    elements it is one of the places.
    """
    uu, vv, uv, ur, vr = TINY, TINY, 0.0, 0.0, 0.0
    for c in range(3):
        foot = (1.0 - at) * first[i, c] + at * last[i, c]
        base = (1.0 - at) * first[k, c] + at * last[k, c]
        u = (1.0 - at) * first[i + 1, c] + at * last[i + 1, c] - foot
        v = (1.0 - at) * first[k + 1, c] + at * last[k + 1, c] - base
        uu, vv, uv = uu + u * u, vv + v * v, uv + u * v
        ur, vr = ur + u * (foot - base), vr + v * (foot - base)
    skewness = uu * vv - uv * uv
    x, y = 0.0, 0.0
    if skewness > PARALLEL * uu * vv:
        x = min(max((uv * vr - ur * vv) / skewness, 0.0), 1.0)
    y = (uv * x + vr) / vv
    if not 0.0 <= y <= 1.0:
        y = min(max(y, 0.0), 1.0)
        x = min(max((uv * y - ur) / uu, 0.0), 1.0)
    square = 0.0
    for c in range(3):
        foot = (1.0 - x) * first[i, c] + x * first[i + 1, c]
        base = (1.0 - y) * first[k, c] + y * first[k + 1, c]
        moved = (1.0 - x) * last[i, c] + x * last[i + 1, c]
        moved -= (1.0 - y) * last[k, c] + y * last[k + 1, c]
        square += ((1.0 - at) * (foot - base) + at * moved) ** 2
    return math.sqrt(square), x, y


@compiled
def middles_apart(positions: Array, i: int, k: int) -> float:
    """Return the distance between the middles of elements i and k [m]."""
    square = 0.0
    for c in range(3):
        away = positions[k, c] + positions[k + 1, c] - positions[i, c] - positions[i + 1, c]
        square += 0.25 * away * away
    return math.sqrt(square)


@compiled
def nodes_apart(positions: Array, i: int, k: int) -> float:
    """Return the distance of nodes i and k [m]."""
    square = 0.0
    for c in range(3):
        square += (positions[k, c] - positions[i, c]) ** 2
    return math.sqrt(square)


@compiled
def lengths_along(positions: Array) -> Array:
    """Return the lengths along the rod as it is, stretched or compressed, up to its nodes (n,)."""
    along = np.zeros(len(positions))
    for i in range(1, len(positions)):
        along[i] = along[i - 1] + nodes_apart(positions, i - 1, i)
    return along


@compiled
def longest_element(positions: Array) -> float:
    """Return the length of the longest element [m]."""
    longest = 0.0
    for i in range(len(positions) - 1):
        longest = max(longest, nodes_apart(positions, i, i + 1))
    return longest


@compiled
def nearest_places(
    positions: Array, arc_lengths: Array, radius: float
) -> tuple[float, float, float]:
    """Return the least distance of two places of the axis, and their arc lengths [m].

    Between elements that lie farther apart along the rod, as it is stretched or compressed, than
    neighbors; of nearer ones, between nodes that do. Distances from 4 radii on count as 4. So many
    elements on as another one is too far away, none can be near.
    """
    count, apart, along = len(positions) - 1, NEIGHBORS * radius, lengths_along(positions)
    longest = longest_element(positions)
    least, place, other = 4.0 * radius, np.nan, np.nan
    first = 0
    for i in range(count):
        while first < count and not along[first + 1] - along[i] > apart:
            first += 1
        k = first
        while k < count:
            middles = middles_apart(positions, i, k)
            if middles - longest < least:
                if along[k] - along[i + 1] > apart:
                    distance, x, y = nearest_on(positions, positions, 0.0, i, k)
                else:
                    distance, x, y = nodes_apart(positions, i, k + 1), 0.0, 1.0
                if distance < least:
                    least = distance
                    place = (1.0 - x) * arc_lengths[i] + x * arc_lengths[i + 1]
                    other = (1.0 - y) * arc_lengths[k] + y * arc_lengths[k + 1]
            k += max(1, int((middles - least) / longest))
    return least, place, other


@compiled
def relative_move(first: Array, last: Array, i: int, k: int) -> float:
    """Return by how much two places of elements i and k can come nearer on a move [m]."""
    most = 0.0
    for a in range(i, i + 2):
        for b in range(k, k + 2):
            square = 0.0
            for c in range(3):
                square += (last[b, c] - first[b, c] - last[a, c] + first[a, c]) ** 2
            most = max(most, square)
    return math.sqrt(most)


@compiled
def crossing_places(
    first: Array, last: Array, arc_lengths: Array, radius: float
) -> tuple[float, float]:
    """Return the arc lengths of two places whose axes came nearer than a radius on a move [m].

    NaN if none did. Nodes move straight from ``first`` to ``last`` (n, 3): a rod that turns comes
    nearer to itself by that, though not by half. A pair advances by as much of the move as it
    cannot meet in, but by a tenth of a radius at least.
    """
    count, apart, along = len(first) - 1, NEIGHBORS * radius, lengths_along(last)
    longest = max(longest_element(first), longest_element(last))
    # The next element is nearer to another one by at most its length, and moves by so much more.
    moves = np.empty_like(first)
    for i in range(len(first)):
        for c in range(3):
            moves[i, c] = last[i, c] - first[i, c]
    further = longest + longest_element(moves)
    start = 0
    for i in range(count):
        while start < count and not along[start] - along[i + 1] > apart:
            start += 1
        k = start
        while k < count:
            move = relative_move(first, last, i, k)
            spare = middles_apart(last, i, k) - longest - move - radius
            at = 0.0 if spare < 0.0 else 1.0
            while at < 1.0:
                distance, x, y = nearest_on(first, last, at, i, k)
                if distance < radius:
                    place = (1.0 - x) * arc_lengths[i] + x * arc_lengths[i + 1]
                    return place, (1.0 - y) * arc_lengths[k] + y * arc_lengths[k + 1]
                at += max(distance - radius, 0.1 * radius) / max(move, TINY)
            k += max(1, int(1.0 + spare / further))
    return np.nan, np.nan


@dataclass(slots=True, eq=False)
class PathLog:
    """What happens on a path."""

    events: list[RodEvent] = field(default_factory=list)
    self_contact: SelfContact | None = None

    @property
    def status(self) -> RodStatus | None:
        """What states from here on are: no answers, once the rod has touched itself."""
        return RodStatus.SELF_CONTACT if self.self_contact else None

    def watch(self, position: float, before: Array, positions: Array, arrays: Arrays) -> None:
        """Note whether the rod touches itself at a place of the path, or passed itself before."""
        if self.self_contact is not None or not arrays.radius > 0.0:
            return
        arcs, radius = arrays.arc_lengths, arrays.radius
        distance, first, second = nearest_places(positions, arcs, radius)
        if distance > 2.0 * radius:
            nearer = 2.0 * math.sqrt(3.0) * float(np.abs(positions - before).max())
            if distance - nearer > radius:
                return
            first, second = crossing_places(before, positions, arcs, radius)
        if math.isfinite(first):
            self.self_contact = SelfContact(position, (float(first), float(second)))
