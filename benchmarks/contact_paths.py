# SPDX-License-Identifier: Apache-2.0
"""Random paths among several obstacles; problems moved, mirrored or read from their other end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.cases import SEED
from spiral_core import (
    Capsule,
    Clamped,
    Cone,
    Cylinder,
    Free,
    Guided,
    Obstacle,
    Pinned,
    Plane,
    Rod,
    RodLoad,
    RodProblem,
    RodState,
    Section,
    Sphere,
)
from spiral_core.rod.types import SectionProfile

Array = NDArray[np.float64]
Map = Callable[[Array], Array]
End = Free | Pinned | Clamped | Guided
# The mirror image has y of the other sign.
MIRROR = np.diag((1.0, -1.0, 1.0))
# Half a turn about y takes the material frame to the one of the rod read backwards.
BACKWARDS = Rotation.from_quat((0.0, 1.0, 0.0, 0.0))


# Elements on which the random paths are followed.
PATH_ELEMENTS = 60


def random_path(index: int) -> list[RodProblem]:
    """Return a rod that sinks onto two to six obstacles with friction, and is drawn over them.

    It is loaded in two steps, pulled sideways at its tip, bent by its rest strain, and at last one
    of the obstacles moves. Every second rod couples bending, shear and stretch.
    """
    rng = np.random.default_rng((SEED, index))
    length, bending = rng.uniform(0.2, 0.6), rng.uniform(1e-4, 1e-2)
    radius = length * rng.uniform(0.004, 0.015)
    stiffness = bending * rng.uniform(0.6, 1.5, 3)
    section = Section(triple(stiffness))
    if rng.uniform() < 0.5:
        shear = rng.uniform(1e3, 1e4, 3) * bending / length**2
        root = np.diag(np.sqrt(np.concatenate((stiffness, shear))))
        mixed = 0.05 * rng.normal(size=(6, 6))
        full = root @ (np.eye(6) + mixed + mixed.T) @ root
        section = Section(tuple(tuple(row) for row in full.tolist()))
    strain = 0.5 * rng.normal(size=3) / length
    obstacles = _random_obstacles(rng, length, radius)
    weight = bending / length**3 * rng.uniform(5.0, 30.0)
    load = weight * (np.array((0.0, 0.0, -1.0)) + 0.1 * rng.normal(size=3))
    pull = 0.02 * weight * length * rng.normal(size=3)
    last, shift = int(rng.integers(len(obstacles))), 0.015 * length * rng.normal(size=3)

    def station(loaded: float, pulled: float, bent: float, shifted: float) -> RodProblem:
        place = triple(np.asarray(obstacles[last].position) + shifted * shift)
        moving = replace(obstacles[last], position=place)
        return RodProblem(
            Rod(length, section, radius, triple(bent * strain)),
            RodLoad(triple(loaded * load), triple(pulled * pull)),
            obstacles=(*obstacles[:last], moving, *obstacles[last + 1 :]),
        )

    steps = ((0, 0, 0, 0), (0.5, 0, 0, 0), (1, 0, 0, 0), (1, 1, 0, 0), (1, 1, 1, 0), (1, 1, 1, 1))
    return [station(*step) for step in steps]


def _random_obstacles(rng: np.random.Generator, length: float, radius: float) -> list[Obstacle]:
    """Return obstacles side by side below a straight rod, and for every second rod a floor."""
    count, slope = int(rng.integers(2, 6)), rng.uniform(0.03, 0.2)
    found = []
    for number in range(count):
        s = length * (number + 1.0 + rng.uniform(-0.3, 0.3)) / (count + 0.5)
        size = length * rng.uniform(0.03, 0.1)
        depth = length * (rng.uniform(0.01, 0.04) + slope * (s / length) ** 2) + radius + size
        place = (s, length * rng.uniform(-0.02, 0.02), -depth)
        axis = triple(np.array((0.0, 1.0, 0.0)) + rng.normal(size=3) * (0.3, 0.2, 0.05))
        shapes = (Sphere(size), Cylinder(size), Capsule(size, 2.0 * size), Cone(size, 0.1))
        shape = shapes[int(rng.integers(len(shapes)))]
        found.append(Obstacle.along(shape, place, axis, rng.uniform(0.05, 0.6)))
    if rng.uniform() < 0.5:
        normal = triple(np.array((0.0, 0.0, 1.0)) + 0.1 * rng.normal(size=3))
        place = (0.0, 0.0, -length * rng.uniform(0.3, 0.5))
        found.append(Obstacle.along(Plane(), place, normal, rng.uniform(0.05, 0.6)))
    return found


def triple(values: Array) -> tuple[float, float, float]:
    """Return three numbers as the tuple that problems are written with."""
    x, y, z = np.asarray(values).tolist()
    return (x, y, z)


def quaternion(turn: Rotation) -> tuple[float, float, float, float]:
    """Return a rotation as the tuple that problems are written with."""
    x, y, z, w = turn.as_quat().tolist()
    return (x, y, z, w)


def mapped(
    problem: RodProblem,
    place: Map,
    vector: Map,
    axial: Map,
    turn: Callable[[Rotation], Rotation],
) -> RodProblem:
    """Return the problem with places, vectors, moments and orientations mapped."""

    def pose(given: Obstacle | End) -> dict[str, Any]:
        thing: Any = given
        found: dict[str, Any] = {"position": triple(place(np.asarray(thing.position)))}
        orientation = getattr(thing, "orientation", None)
        if orientation is not None:
            found["orientation"] = quaternion(turn(Rotation.from_quat(orientation)))
        if isinstance(thing, Guided):
            found["direction"] = triple(vector(np.asarray(thing.direction)))
        return found

    def end(held: End) -> End:
        return held if isinstance(held, Free) else replace(held, **pose(held))

    load = problem.load
    return replace(
        problem,
        load=RodLoad(
            triple(vector(np.asarray(load.distributed))),
            triple(vector(np.asarray(load.tip_force))),
            triple(axial(np.asarray(load.tip_moment))),
        ),
        base=end(problem.base),
        tip=end(problem.tip),
        obstacles=tuple(replace(o, **pose(o)) for o in problem.obstacles),
        point_loads=tuple(
            replace(
                p,
                force=triple(vector(np.asarray(p.force))),
                moment=triple(axial(np.asarray(p.moment))),
            )
            for p in problem.point_loads
        ),
    )


def moved(problem: RodProblem, shift: Array, turn: Rotation) -> RodProblem:
    """Return the problem turned about the origin and then shifted, with everything in it."""
    return mapped(
        problem, lambda p: turn.apply(p) + shift, turn.apply, turn.apply, lambda q: turn * q
    )


def mirrored(problem: RodProblem) -> RodProblem:
    """Return the mirror image; obstacles must be symmetric to their own y axis."""

    def flip(v: Array) -> Array:
        return v @ MIRROR

    def turn(q: Rotation) -> Rotation:
        return Rotation.from_matrix(MIRROR @ q.as_matrix() @ MIRROR)

    image = mapped(problem, flip, flip, lambda v: -v @ MIRROR, turn)
    rod = image.rod
    strain = triple(-np.asarray(rod.rest_strain) @ MIRROR)
    section = _conjugated(rod.section, MIRROR, stretch=-1.0)
    return replace(image, rod=replace(rod, rest_strain=strain, section=section))


def backwards(problem: RodProblem) -> RodProblem:
    """Return the same rod read from its tip to its base; without loads at its tip."""

    def read(given: End) -> End:
        end: Any = given
        if getattr(end, "orientation", None) is None:
            return given
        turned = Rotation.from_quat(end.orientation) * BACKWARDS
        read_backwards: End = replace(end, orientation=quaternion(turned))
        return read_backwards

    rod = problem.rod
    section = _conjugated(rod.section, BACKWARDS.as_matrix())
    strain = triple(-np.asarray(rod.rest_strain) @ BACKWARDS.as_matrix())
    loads = tuple(replace(p, at=rod.length - p.at) for p in problem.point_loads)
    return replace(
        problem,
        rod=replace(rod, section=section, rest_strain=strain),
        base=read(problem.tip),
        tip=read(problem.base),
        point_loads=loads,
    )


def _conjugated(section: SectionProfile, signs: Array, stretch: float = 1.0) -> Section:
    """Return a section whose axes change their signs, and stretch against bending by one more."""
    even: Any = section
    rows: Any = np.asarray(even.stiffness)
    rows = np.diag(rows) if rows.ndim == 1 else rows
    both: Any = np.kron(np.diag((1.0, stretch)), signs) if len(rows) == 6 else signs
    changed = tuple(tuple(row) for row in (both @ rows @ both).tolist())
    turned: Section = replace(even, stiffness=changed)
    return turned


def imbalance(problem: RodProblem, state: RodState) -> tuple[float, float]:
    """Return the sums of all forces [N] and of all moments about the base [N m].

    From positions, tangents, contact forces and reactions alone, and the loads as they were asked.
    """
    p, base = state.positions, state.positions[0]
    steps = np.diff(state.arc_lengths)[:, None]
    weight = np.asarray(problem.load.distributed)
    nodal = np.zeros_like(p)
    nodal[1:] += 0.5 * steps * weight
    nodal[:-1] += 0.5 * steps * weight
    nodal[-1] += problem.load.tip_force
    couples = np.zeros_like(p)
    couples[-1] += problem.load.tip_moment
    # An element's weight acts on its arc, not on its chord.
    turn = Rotation.from_quat(state.orientations)
    section: Any = problem.rod.section
    inner = turn.inv().apply(state.forces)
    stiffness, compliance, coupling = section.parts
    bent = np.linalg.solve(stiffness, (state.moments - inner @ coupling.T).T).T
    strain = inner @ compliance - bent @ coupling
    slopes = turn.apply(strain + np.array((1.0, 0.0, 0.0)))
    couples[1:] += np.cross(steps**2 / 12.0 * -np.diff(slopes, axis=0), weight)
    for load in problem.point_loads:
        node = int(np.argmin(np.abs(state.arc_lengths - load.at)))
        nodal[node] += load.force
        couples[node] += load.moment
    lever = (
        problem.rod.radius if problem.rod.friction_radius is None else problem.rod.friction_radius
    )
    total, about = nodal.sum(axis=0), (np.cross(p - base, nodal) + couples).sum(axis=0)
    for obstacle, push in zip(problem.obstacles, state.contact_forces, strict=True):
        frame = Rotation.from_quat(obstacle.orientation)
        _, normal, _ = obstacle.shape.distance(frame.inv().apply(p - np.asarray(obstacle.position)))
        total = total + push.sum(axis=0)
        about = about + np.cross(p - lever * frame.apply(normal) - base, push).sum(axis=0)
    for reaction, node in ((state.base_reaction, 0), (state.tip_reaction, -1)):
        total = total + reaction[:3]
        about = about + reaction[3:] + np.cross(p[node] - base, reaction[:3])
    return float(np.linalg.norm(total)), float(np.linalg.norm(about))
