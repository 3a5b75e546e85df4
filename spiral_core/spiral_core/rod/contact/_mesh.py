# SPDX-License-Identifier: Apache-2.0
"""From a rod problem to the arrays of the solver."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.rod._algebra import quaternions_between
from spiral_core.rod._mesh import even_nodes, mean_of, sampled, slope_of
from spiral_core.rod._profiles import vector_samples
from spiral_core.rod.contact._element import Elements
from spiral_core.rod.contact.obstacles import Obstacle, Quaternion, obstacle_between
from spiral_core.rod.contact.problem import UPRIGHT, End, RodProblem
from spiral_core.rod.types import MAX_ELEMENTS, ZERO, Array, Vector

# Elements turn by at most this angle at rest [rad], and are at most this long, in radii of the
# tightest obstacle's arc.
ELEMENT_ANGLE = 0.2
ELEMENT_ARC = 0.25
FEWEST_ELEMENTS = 40
# On longer elements than this, in the same radii, a rod could pass through an obstacle.
LONGEST_ARC = 1.0
# Stiffness in F h^2 of what bends inside of an element: a tenth, for up to three times the loads.
TENSION = 0.3
# Elastic slip of friction, as a fraction of the rod's radius, or of a thousandth of its length.
LAST_SLIP = 1e-6
# Places are one if they are this near, as a fraction of the rod's length.
ON_A_NODE = 1e-9
# What is blended as it is between two problems.
LINEAR = ("nodal", "growing", "arc_lengths", "end_positions", "bending", "lever")


@dataclass(frozen=True, slots=True, eq=False)
class Arrays:
    """A rod problem on N elements.

    Args:
        elements: the elements and the load on each.
        nodal: (N + 1, 6) moments [N m] and forces [N] at the nodes, base frame.
        growing: (N, 3) what the growth of the load along each element is at its end, and, against
            it, at its beginning [N]; included in ``nodal``.
        arc_lengths: (N + 1,) [m].
        end_free: (2, 6, 6) projections onto the free motions of the two ends: rotation in the
            material frame, displacement in the base frame.
        end_orientations: (2, 4) where held.
        end_positions: (2, 3) where held [m].
        bending: smallest bending stiffness [N m^2], for scales.
        radius: the rod's outer radius [m].
        lever: distance from the axis at which friction acts [m].
        obstacles: what stands in the way.
        pieces: elements between one place where something jumps and the next.
    """

    elements: Elements
    nodal: Array
    growing: Array
    arc_lengths: Array
    end_free: Array
    end_orientations: Array
    end_positions: Array
    bending: float
    radius: float
    lever: float
    obstacles: tuple[Obstacle, ...]
    pieces: tuple[int, ...]

    @property
    def count(self) -> int:
        """Number of elements."""
        return len(self.elements.steps)

    @property
    def length(self) -> float:
        """The rod's length [m]."""
        return float(self.arc_lengths[-1])

    @property
    def step(self) -> float:
        """Mean length of an element [m]."""
        return self.length / self.count

    @property
    def force_scale(self) -> float:
        """What a small force is small to: EI/L^2 or the sum of the loads [N]."""
        return max(self.bending / self.length**2, total_force(self.elements.half_load, self.nodal))

    @property
    def rest_energy(self) -> float:
        """Energy that takes the rod from its rest strain to none [J]; the elements leave it out."""
        one, rest = self.elements, self.elements.rest[:, :, None]
        soft, square = np.linalg.inv(one.stiffness), one.steps[:, None, None] ** 2 / 12.0
        growth = one.stiffness_slope @ soft @ rest - one.rest_slope[:, :, None]
        density = np.sum(rest * (soft @ rest) + square * growth * (soft @ growth), axis=(1, 2))
        return 0.5 * float(one.steps @ density)


def last_slip(arrays: Arrays) -> float:
    """Return the elastic slip of friction in a solution [m]."""
    return LAST_SLIP * max(arrays.radius, 1e-3 * arrays.length)


def node_lengths(arc_lengths: Array) -> Array:
    """Return the length that each node stands for (N + 1,) [m]."""
    steps = np.diff(arc_lengths)
    lengths: Array = 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))
    return lengths


def smallest_arc(problem: RodProblem) -> float:
    """Return the tightest radius at which the rod's axis can go around an obstacle [m]."""
    radii = (obstacle.shape.feature_radius for obstacle in problem.obstacles)
    return min(radii, default=math.inf) + problem.rod.radius


def element_count(problem: RodProblem) -> int:
    """Return how many elements resolve the rod's own shape and its obstacles."""
    rod = problem.rod
    sites = np.linspace(0.0, rod.length, 65)
    turn = np.linalg.norm(vector_samples("rest_strain", rod.rest_strain, sites), axis=1).max()
    needed = rod.length * max(
        float(turn) / ELEMENT_ANGLE, 1.0 / (ELEMENT_ARC * smallest_arc(problem))
    )
    if not needed <= MAX_ELEMENTS:
        requirement = (
            f"at most {MAX_ELEMENTS} for this rod and its obstacles; are they in SI units?"
        )
        raise InvalidInputError("elements", needed, requirement)
    return max(FEWEST_ELEMENTS, math.ceil(needed))


def discretize(problem: RodProblem, count: int) -> Arrays:
    """Return the arrays of a problem on about ``count`` elements (a few more with breaks).

    Raises:
        InvalidInputError: as :func:`on_nodes`.
    """
    pieces = shared(problem, count)
    return on_nodes(problem, even_nodes(_sites(problem), pieces), pieces)


def discretize_like(problem: RodProblem, before: Arrays) -> Arrays:
    """Return the arrays of a problem on the elements of another one.

    Nodes keep their fractions of the rod or, where it would have none at a break or point load, of
    their piece between those.

    Raises:
        InvalidInputError: as :func:`on_nodes`; the obstacles have other shapes, or there are more
            or fewer pieces.
    """
    if [o.shape for o in problem.obstacles] != [o.shape for o in before.obstacles]:
        raise InvalidInputError(
            "problems", problem, "the obstacle shapes of the state they start from"
        )
    nodes = before.arc_lengths * (problem.rod.length / before.length)
    apart = np.abs(nodes - np.array(_sites(problem))[:, None]).min(axis=1)
    if not apart.max() <= ON_A_NODE * problem.rod.length:
        if len(_sites(problem)) != len(before.pieces) + 1:
            requirement = "as many breaks and point loads in all of them, or loads at nodes"
            raise InvalidInputError("problems", problem, requirement)
        nodes = even_nodes(_sites(problem), before.pieces)
    return on_nodes(problem, nodes, before.pieces)


def on_nodes(problem: RodProblem, nodes: Array, pieces: tuple[int, ...]) -> Arrays:
    """Return the arrays of a problem whose elements end at the arc lengths ``nodes`` [m].

    Raises:
        InvalidInputError: a profile's values are not valid, or the elements are too long to see an
            obstacle.
    """
    longest = LONGEST_ARC * smallest_arc(problem)
    if not np.diff(nodes).max() <= longest:
        fewest = math.ceil(problem.rod.length / longest)
        requirement = f"at least {fewest} to see the obstacles"
        raise InvalidInputError("elements", len(nodes) - 1, requirement)
    rod, steps, at = problem.rod, np.diff(nodes), sampled(problem.rod, nodes)
    moment, stiffness = at.moment, mean_of(at.stiffness)
    bending = float(np.linalg.eigvalsh(stiffness[:, 1:, 1:]).min())
    weight = vector_samples("distributed", problem.load.distributed, at.sites.ravel())
    weight = weight.reshape(-1, 3, 3)
    free, orientations, places = zip(_end(problem.base), _end(problem.tip), strict=True)
    half_load, nodal = 0.5 * steps[:, None] * mean_of(weight), _nodal(problem, nodes)
    # The part of a load that grows along its element has no sum, but a moment.
    growing = steps[:, None] * (weight[:, 2] - weight[:, 0]) / 12.0
    nodal[:-1, 3:] -= growing
    nodal[1:, 3:] += growing
    # Under a tension F the curve that an element relaxes into has a potential energy as if its
    # bending stiffness were F h^2 / 10 larger. Elements shorter than sqrt(EI / 3F) are left alone.
    stiffer = TENSION * total_force(half_load, nodal) * steps**2 - 0.1 * bending
    across = np.maximum(stiffer, 0.0)[:, None, None] * np.diag((0.0, 1.0, 1.0))
    elements = Elements(
        steps=steps,
        stiffness=stiffness,
        stiffness_slope=slope_of(at.stiffness, steps),
        flexibility=np.linalg.inv(stiffness + across),
        compliance=mean_of(at.compliance),
        coupling=mean_of(at.coupling),
        rest=mean_of(moment),
        rest_slope=slope_of(moment, steps),
        rest_stretch=mean_of(np.sum(at.coupling * at.seen[:, :, :, None], axis=2)),  # B^T u*
        half_load=half_load,
    )
    return Arrays(
        elements=elements,
        nodal=nodal,
        growing=growing,
        arc_lengths=nodes,
        end_free=np.array(free),
        end_orientations=np.array(orientations, dtype=np.float64),
        end_positions=np.array(places, dtype=np.float64),
        bending=bending,
        radius=float(rod.radius),
        lever=float(rod.radius if rod.friction_radius is None else rod.friction_radius),
        obstacles=problem.obstacles,
        pieces=pieces,
    )


def between(first: Arrays, last: Arrays, at: float) -> Arrays:
    """Return the arrays at the fraction ``at`` of the way between two problems on one mesh."""
    if at == 1.0:
        return last
    linear: dict[str, Any] = {
        name: (1.0 - at) * getattr(first, name) + at * getattr(last, name) for name in LINEAR
    }
    pairs = zip(first.elements, last.elements, strict=True)
    elements = Elements(*((1.0 - at) * one + at * other for one, other in pairs))
    soft, other = first.elements.flexibility, last.elements.flexibility
    if not np.array_equal(soft, other):
        stiffness = (1.0 - at) * np.linalg.inv(soft) + at * np.linalg.inv(other)
        elements = elements._replace(flexibility=np.linalg.inv(stiffness))
    obstacles = zip(first.obstacles, last.obstacles, strict=True)
    return replace(
        last,
        elements=elements,
        end_free=np.array([*map(free_between, first.end_free, last.end_free, (at, at))]),
        end_orientations=quaternions_between(first.end_orientations, last.end_orientations, at),
        obstacles=tuple(obstacle_between(x, y, at) for x, y in obstacles),
        **linear,
    )


def free_between(first: Array, last: Array, at: float) -> Array:
    """Return the free motions of an end of one kind; the line of a guided one turns."""
    if np.array_equal(first, last):
        return last
    free = last.copy()
    line = np.linalg.eigh((1.0 - at) * first[3:, 3:] + at * last[3:, 3:])[1][:, -1]
    free[3:, 3:] = np.outer(line, line)
    return free


def total_force(half_load: Array, nodal: Array) -> float:
    """Return the sum of the sizes of all loads on elements and nodes [N]."""
    parts = (np.sqrt(np.sum(force * force, axis=1)) for force in (2.0 * half_load, nodal[:, 3:]))
    return float(sum(np.sum(part) for part in parts))


def _sites(problem: RodProblem) -> list[float]:
    """Return where something jumps, and the rod's ends [m]."""
    rod = problem.rod
    inner = sorted({*rod.breaks, *(load.at for load in problem.point_loads)})
    sites = [0.0]
    for site in inner:  # those that differ by rounding are one
        if min(site - sites[-1], rod.length - site) > ON_A_NODE * rod.length:
            sites.append(site)
    return [*sites, rod.length]


def shared(problem: RodProblem, count: int) -> tuple[int, ...]:
    """Return how many of about ``count`` elements lie in each piece between those places."""
    step = problem.rod.length / count
    return tuple(max(1, math.ceil((b - a) / step - 1e-9)) for a, b in pairwise(_sites(problem)))


def _nodal(problem: RodProblem, nodes: Array) -> Array:
    """Return moments and forces at the nodes."""
    nodal = np.zeros((len(nodes), 6))
    nodal[-1, :3] = problem.load.tip_moment
    nodal[-1, 3:] = problem.load.tip_force
    for load in problem.point_loads:
        node = int(np.argmin(np.abs(nodes - load.at)))
        nodal[node, :3] += load.moment
        nodal[node, 3:] += load.force
    return nodal


def _end(end: End) -> tuple[Array, Quaternion, Vector]:
    """Return the projection onto an end's free motions, its orientation and position."""
    free, orientation = np.eye(6), getattr(end, "orientation", None)
    position = getattr(end, "position", None)
    if position is not None:
        line = getattr(end, "direction", ZERO)
        free[3:, 3:] = np.outer(line, line)
    if orientation is not None:
        free[:3, :3] = 0.0
    return free, orientation or UPRIGHT, position or ZERO
