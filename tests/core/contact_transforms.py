# SPDX-License-Identifier: Apache-2.0
"""A contact problem moved, mirrored or read from its other end, and the balance of its answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from spiral_core import (
    Clamped,
    ContactProblem,
    ContactState,
    Free,
    Guided,
    Obstacle,
    Pinned,
    RodLoad,
    Section,
)

Array = NDArray[np.float64]
Map = Callable[[Array], Array]
End = Free | Pinned | Clamped | Guided
# The mirror image has y of the other sign.
MIRROR = np.diag((1.0, -1.0, 1.0))
# Half a turn about y takes the material frame to the one of the rod read backwards.
BACKWARDS = Rotation.from_quat((0.0, 1.0, 0.0, 0.0))


def triple(values: Array) -> tuple[float, float, float]:
    """Return three numbers as the tuple that problems are written with."""
    x, y, z = np.asarray(values).tolist()
    return (x, y, z)


def quaternion(turn: Rotation) -> tuple[float, float, float, float]:
    """Return a rotation as the tuple that problems are written with."""
    x, y, z, w = turn.as_quat().tolist()
    return (x, y, z, w)


def mapped(
    problem: ContactProblem,
    place: Map,
    vector: Map,
    axial: Map,
    turn: Callable[[Rotation], Rotation],
) -> ContactProblem:
    """Return the problem with places, vectors, moments and orientations mapped."""

    def pose(thing: Obstacle | End) -> dict[str, object]:
        found: dict[str, object] = {"position": triple(place(np.asarray(thing.position)))}
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


def moved(problem: ContactProblem, shift: Array, turn: Rotation) -> ContactProblem:
    """Return the problem turned about the origin and then shifted, with everything in it."""
    return mapped(
        problem, lambda p: turn.apply(p) + shift, turn.apply, turn.apply, lambda q: turn * q
    )


def mirrored(problem: ContactProblem) -> ContactProblem:
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


def backwards(problem: ContactProblem) -> ContactProblem:
    """Return the same rod read from its tip to its base; without loads at its tip."""

    def read(end: End) -> End:
        if getattr(end, "orientation", None) is None:
            return end
        turned = Rotation.from_quat(end.orientation) * BACKWARDS
        return replace(end, orientation=quaternion(turned))

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


def _conjugated(section: Section, signs: Array, stretch: float = 1.0) -> Section:
    """Return a section whose axes change their signs, and stretch against bending by one more."""
    rows = np.asarray(section.stiffness)
    rows = np.diag(rows) if rows.ndim == 1 else rows
    if len(rows) == 6:
        signs = np.kron(np.diag((1.0, stretch)), signs)
    return replace(section, stiffness=tuple(tuple(row) for row in (signs @ rows @ signs).tolist()))


def imbalance(problem: ContactProblem, state: ContactState) -> tuple[float, float]:
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
    section, inner = problem.rod.section, turn.inv().apply(state.forces)
    bent = np.linalg.solve(section.matrix, (state.moments - inner @ section.coupling.T).T).T
    strain = inner @ section.compliance - bent @ section.coupling
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
