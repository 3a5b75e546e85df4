# SPDX-License-Identifier: Apache-2.0
"""From an iterate and its evidence to the state that a user sees."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from spiral_core.errors import InvalidInputError
from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    add,
    dot,
    matrices,
    norm,
    put_vector,
    scale,
    subtract,
    vector_at,
)
from spiral_core.rod.contact._contact import TINY, Iterate
from spiral_core.rod.contact._continuation import Point, from_centerline
from spiral_core.rod.contact._mesh import Arrays
from spiral_core.rod.contact._newton import NEUTRAL
from spiral_core.rod.contact.problem import RodProblem
from spiral_core.rod.state import STATUSES, RodEvent, RodState, RodStatus, SelfContact
from spiral_core.rod.types import Array
from spiral_core.validation import require_kind

# Two places closer than this along the rod, in its radii, are one place, not two that touch.
NEIGHBORS = math.pi
# Largest force on an element, times h^2 over its stiffness against bending inside: at ten that is
# lost, and on the way there an element bends by too much.
MOST_TENSION = 7.0
# How near a thin rod's places may be to count, as a fraction of what they may come nearer.
LOOK = 0.05
# Elements are parallel below this squared sine of the angle between them.
PARALLEL = 1e-14
# Pivots below this are those of the stiffness against motions that nothing resists, and rounding.
UNRESISTED = 10.0 * NEUTRAL


def state_from_point(point: Point, iterations: int, status: RodStatus | None = None) -> RodState:
    """Return the state at a point of a path; ``status`` overrides how its solve ended."""
    arrays, x, solution = point.arrays, point.x, point.solution
    turn = matrices(x.q)
    clearance = self_clearance(x.p, arrays.arc_lengths, arrays.radius)
    if status is None:
        status = STATUSES[solution.outcome]
        if status is RodStatus.CONVERGED and not clearance > 0.0:
            status = RodStatus.SELF_CONTACT
    normal_forces, gaps, contact_forces, sticking = _contacts(point)
    if status is RodStatus.CONVERGED and _held_inside(arrays, gaps):
        status = RodStatus.INSIDE_OBSTACLE
    if status is RodStatus.CONVERGED and _pulled_too_hard(arrays, x.n):
        status = RodStatus.NOT_HELD
    potential = float(np.sum(arrays.nodal[:, 3:] * x.p))
    pivot = solution.pivot * arrays.length / arrays.bending
    return RodState(  # of copies: others go on from the point
        status=status,
        arc_lengths=arrays.arc_lengths.copy(),
        positions=x.p.copy(),
        orientations=x.q.copy(),
        forces=_nodal_forces(x.n - arrays.growing, arrays.elements.half_load),
        moments=solution.moments.copy(),
        strains=np.empty((0, 3)),
        contact_forces=contact_forces,
        normal_forces=normal_forces,
        gaps=gaps,
        sticking=sticking,
        base_reaction=_reaction(solution.gradient[0], turn[0]),
        tip_reaction=_reaction(solution.gradient[-1], turn[-1]),
        energy=solution.energy + arrays.rest_energy - potential,
        residual=solution.residual,
        smallest_pivot=pivot,
        iterations=iterations,
        neutral_modes=int(0.0 < pivot < UNRESISTED),
        self_clearance=clearance,
        _point=point,
    )


def point_of_state(state: RodState) -> Point:
    """Return the point that a state stands for."""
    require_kind("start", state, RodState)
    if state.status is not RodStatus.CONVERGED:
        raise InvalidInputError("start", state.status, "a converged state")
    if state._point is None:
        requirement = "a state of the mixed element: solve_rod(..., element=RodElement.MIXED)"
        raise InvalidInputError("start", state.element.name, requirement)
    return state._point


def shape_of(start: RodState | Array) -> Array:
    """Return a copy of the nodes of a state, or of the points of a centerline (n, 3) [m].

    Raises:
        InvalidInputError: it is neither a state nor two or more different finite points.
    """
    points: Array = np.zeros(0)
    with suppress(TypeError, ValueError):
        points = np.array(getattr(start, "positions", start), dtype=np.float64)
    fits = points.ndim == 2 and points.shape[1] == 3 and len(points) > 1
    if not (fits and np.all(np.isfinite(points)) and np.diff(points, axis=0).any(axis=1).all()):
        requirement = "a centerline of two or more different finite points (n, 3)"
        raise InvalidInputError("start", start, requirement)
    return points


def from_shape(problem: RodProblem, arrays: Arrays, start: RodState | Array) -> Iterate:
    """Return a rod in the shape of a centerline or, on as many nodes, of a state."""
    x = from_centerline(problem, arrays, shape_of(start))
    if isinstance(start, RodState) and start.orientations.shape == x.q.shape:
        x.q[:] = start.orientations
    return x


def _contacts(point: Point) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Return normal forces, gaps, contact forces on the rod, and which nodes stick."""
    contacts = point.solution.contacts
    normal_forces = point.x.normal * contacts.touchable
    forces = normal_forces[:, :, None] * contacts.normal - contacts.touch.tau
    return normal_forces, contacts.gap.copy(), forces, contacts.sticks


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
    forces: Array = 0.5 * (np.vstack((after[:1], before)) + np.vstack((after, before[-1:])))
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
    return float(nearest_places(positions, arc_lengths, radius, 4.0 * radius)[0]) - 2.0 * radius


@compiled
def nearest_on(positions: Array, i: int, k: int) -> tuple[float, float, float]:
    """Return the least distance of elements i and k, and where on each of them, from 0 to 1.

    On parallel elements it is one of the places.
    """
    foot, base = vector_at(positions, i), vector_at(positions, k)
    u, v = subtract(vector_at(positions, i + 1), foot), subtract(vector_at(positions, k + 1), base)
    away = subtract(foot, base)
    uu, vv, uv = dot(u, u) + TINY, dot(v, v) + TINY, dot(u, v)
    ur, vr = dot(u, away), dot(v, away)
    skewness, x = uu * vv - uv * uv, 0.0
    if skewness > PARALLEL * uu * vv:
        x = min(max((uv * vr - ur * vv) / skewness, 0.0), 1.0)
    y = (uv * x + vr) / vv
    if not 0.0 <= y <= 1.0:
        y = min(max(y, 0.0), 1.0)
        x = min(max((uv * y - ur) / uu, 0.0), 1.0)
    return norm(add(away, subtract(scale(x, u), scale(y, v)))), x, y


@compiled
def nodes_apart(positions: Array, i: int, k: int) -> float:
    """Return the distance of nodes i and k [m]."""
    return norm(subtract(vector_at(positions, k), vector_at(positions, i)))


@compiled
def nearest_places(
    positions: Array, arc_lengths: Array, radius: float, reach: float
) -> tuple[float, float, float]:
    """Return the least distance of two places of the axis, and their arc lengths [m].

    Between elements that lie farther apart along the rod, as it is stretched or compressed, than
    neighbors; of nearer ones, between nodes that do. Distances from ``reach`` on count as that. So
    many elements on as another one is too far away, none can be near.
    """
    count, apart = len(positions) - 1, NEIGHBORS * radius
    along, longest, middles = np.zeros(count + 1), 0.0, np.empty((count, 3))
    for i in range(count):
        step = nodes_apart(positions, i, i + 1)
        along[i + 1], longest = along[i] + step, max(longest, step)
        middle = scale(0.5, add(vector_at(positions, i), vector_at(positions, i + 1)))
        put_vector(middles[i], 0, middle)
    least, place, other = reach, np.nan, np.nan
    first = 0
    for i in range(count):
        while first < count and not along[first + 1] - along[i] > apart:
            first += 1
        k = first
        while k < count:
            away = nodes_apart(middles, i, k)
            if away - longest < least:
                if along[k] - along[i + 1] > apart:
                    distance, x, y = nearest_on(positions, i, k)
                else:
                    distance, x, y = nodes_apart(positions, i, k + 1), 0.0, 1.0
                if distance < least:
                    least = distance
                    place = (1.0 - x) * arc_lengths[i] + x * arc_lengths[i + 1]
                    other = (1.0 - y) * arc_lengths[k] + y * arc_lengths[k + 1]
            k += max(1, int((away - least) / longest))
    return least, place, other


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
        """Note whether the rod touches itself at a place of the path, or passed itself before.

        Nodes moved straight from ``before`` to ``positions`` (n, 3).
        """
        if self.self_contact is not None or not arrays.radius > 0.0:
            return
        radius, at, touching = arrays.radius, 1.0, 2.0 * arrays.radius
        # Two places come nearer by at most this; before the end, axes passed each other if they
        # came nearer than a radius.
        nearer = 2.0 * math.sqrt(3.0) * float(np.abs(positions - before).max())
        reach = max(4.0 * radius, LOOK * nearer)
        while at > 0.0:
            here = at * positions + (1.0 - at) * before
            distance, first, second = nearest_places(here, arrays.arc_lengths, radius, reach)
            if distance <= touching:
                self.self_contact = SelfContact(position, (float(first), float(second)))
                return
            touching = radius
            at -= max(distance - radius, 0.1 * radius) / max(nearer, TINY)
