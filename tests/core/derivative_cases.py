# SPDX-License-Identifier: Apache-2.0
"""Random rods at rest, moved along a way through their parameters, and solved again."""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from core.rod_cases import stiffness_at, vectors_at
from scipy.spatial.transform import Rotation

from spiral_core import (
    Clamped,
    Cylinder,
    Obstacle,
    Rod,
    RodElement,
    RodLoad,
    RodProblem,
    Section,
    SolverError,
    Sphere,
    differentiate,
    solve_rod,
)

LENGTH, BENDING = 0.36, 2.5e-4
FORCE = BENDING / LENGTH**2
# A unit of each parameter: one that changes a rod by about as much as it is long.
UNITS = {
    "distributed": FORCE / LENGTH, "tip_force": FORCE, "tip_moment": FORCE * LENGTH,
    "base_position": LENGTH, "base_rotation": 1.0, "rest_strain": 1.0 / LENGTH, "stiffness": 1.0,
    "length": 1.0, "obstacle_position": LENGTH, "obstacle_radius": 0.01, "friction": 0.1,
}  # fmt: skip
# Steps of the differences, largest first: one of them is large against what a solve leaves (1e-8
# of the scales) and small against the curvature of the state over the parameter.
STEPS = (1e-2, 3e-3, 2e-2, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
# Contacts nearer to changing their kind than this cannot be resolved by such steps.
NEAR = {"gap": 1e-4, "force": 1e-2, "stick": 0.1, "slip": 1e3}


@dataclass(eq=False)
class Raised:
    """A shape whose surface is moved outward; it passes for the shape: a state may go on to it."""

    shape: object
    by: float
    feature_radius = 0.015

    def __eq__(self, other):
        return True

    __hash__ = None

    def distance(self, points):
        distance, *slopes = self.shape.distance(points)
        return distance - self.by, *slopes


def remade(rod, ratio, stiffness, strain):
    """Return a rod so many times as long, with these functions of what it has at each fraction."""

    def section(s):
        return stiffness(stiffness_at(rod.section, s / ratio))

    def rest(s):
        return strain(vectors_at(rod.rest_strain, s / ratio))

    length, *breaks = ratio * np.array((rod.length, *rod.breaks))
    if not callable(rod.section):
        section, rest = Section(section(np.zeros(1))[0]), rest(np.zeros(1))[0]
    return Rod(length, section, rod.radius, rest, breaks=(*breaks,))


def moved(problem, columns, way):
    """Return the problem with its parameters changed by a way, of one number a column."""
    by = {"friction": (0.0, 0.0)} | {name: way[at] for name, at in columns.items()}
    rod, load, base = problem.rod, problem.load, problem.base
    moduli = np.sqrt(np.outer(1.0 + by["stiffness"], 1.0 + by["stiffness"]))
    turned = Rotation.from_rotvec(by["base_rotation"]) * Rotation.from_quat(base.orientation)
    obstacles = [
        replace(
            one,
            position=(*(one.position + by["obstacle_position"][3 * j : 3 * j + 3]),),
            friction=one.friction + by["friction"][j],
            shape=Raised(one.shape, by["obstacle_radius"][j]),
        )
        for j, one in enumerate(problem.obstacles)
    ]
    return RodProblem(
        remade(
            rod,
            1.0 + by["length"][0],
            lambda k: k * moduli[: k.shape[1], : k.shape[1]],
            lambda strain: strain + by["rest_strain"],
        ),
        RodLoad(*(getattr(load, name) + by[name] for name in [*UNITS][:3])),
        Clamped((*(base.position + by["base_position"]),), (*turned.as_quat(),)),
        obstacles=(*obstacles,),
    )


def prepared(problem, **given):
    """Return the problem, its state, the state's derivatives, and how one nearby is solved.

    None where a contact is next to changing its kind.
    """
    state = solve_rod(problem, estimate_error=False, **given)
    found = differentiate(state)
    if any(found.margins[key] < near for key, near in NEAR.items()):
        return None
    given = {"start": state} | given | {"elements": len(state.positions) - 1}
    return problem, state, found, partial(solve_rod, estimate_error=False, **given)


def units_of(problem, state, found):
    """Return a unit of each column; 0 of what the rod does not have."""
    units = np.zeros(len(found.positions))
    for name, at in found.columns.items():
        # The inextensible element's base stays where it is: both elements are compared for it.
        if not (name.startswith("base") and state.element is RodElement.INEXTENSIBLE):
            units[at] = UNITS[name]
    at = found.columns["stiffness"]
    units[at][stiffness_at(problem.rod.section, np.zeros(1)).shape[1] :] = 0.0
    return units


def way_error(problem, state, found, solved, way):
    """Return the error of the derivative along a way, against the step that agrees best.

    Infinite where every step changes what touches or sticks. Derivatives smaller than 1, without
    units, are compared with it: a solve ends at 1e-8.
    """
    force = max(FORCE, float(np.abs(state.forces).max()))
    scales = (LENGTH, 1.0, np.repeat((force, force * LENGTH), 3), force)

    def figures(other):
        turns = (
            Rotation.from_quat(other.orientations) * Rotation.from_quat(state.orientations).inv()
        )
        pushes = other.contact_forces.sum(axis=0)
        return other.positions, turns.as_rotvec(), other.base_reaction, pushes

    arrays = found.positions, found.rotations, found.base_reaction, found.contact_forces
    best = math.inf
    for step in STEPS:
        try:
            near = [solved(moved(problem, found.columns, k * step * way)) for k in (1, -1, 2, -2)]
        except SolverError:
            continue
        if any(
            ((one.touching != state.touching) | (one.sticking != state.sticking)).any()
            for one in near
        ):
            continue
        error = 0.0
        for array, scale, *four in zip(arrays, scales, *map(figures, near), strict=True):
            slope = np.tensordot(way, array, 1)
            off = np.tensordot((8.0, -8.0, -1.0, 1.0), four, 1) / (12.0 * step) - slope
            most, off = (np.abs(each / scale).max() for each in (slope, off))
            error = max(error, off / max(most, 1.0))
        best = min(best, error)
        if best < 3e-7:
            break
    return best


def random_section(rng, kind):
    """Return a section: plain, coupled, or full."""
    moduli = BENDING * rng.uniform((0.4, 0.8, 0.8), 1.2)
    twist, sideways, bending = moduli
    if kind < 2:
        coupling = 0.3 * kind * math.sqrt(twist * bending)
        return Section.inextensible(bending, twist, sideways, coupling)
    roots = np.sqrt((*moduli, *rng.uniform(10.0, 40.0, 3)))
    mixed = 0.8 * np.eye(6) + 0.2 * np.corrcoef(rng.normal(size=(6, 9)))
    return Section(np.outer(roots, roots) * mixed)


def free_case(seed):
    """Return a free rod: of every six one upright, one planar and one unloaded; some that vary."""
    rng, kind, full = np.random.default_rng(seed), seed % 6, seed % 5 == 4
    rest, weight, force = rng.normal(size=(3, 3)) * ((7.0,), (20.0,), (0.5,))
    moment = 0.3 * rng.normal(size=3) * (seed % 4 == 0)
    if kind == 1:  # light enough to stand
        rest[:] = force[:] = 0.0
        weight[:] = -2.0, 0.0, 0.0
    elif kind == 3:
        rest[:2] = force[2] = weight[2] = moment[:2] = 0.0
    elif kind == 5:
        weight[:] = force[:] = moment[:] = 0.0
    rod = Rod(LENGTH, random_section(rng, (seed % 2) * (1 + full)), rest_strain=rest)
    if seed % 7 == 2:
        # Where twist and bending are coupled, the slopes' product is part of a moment's mean.
        section = Section.varying(
            lambda s: BENDING * (1.2 + 2.0 * s),
            0.7 * BENDING,
            coupling=lambda s: BENDING * (0.25 - s),
        )
        bent = lambda s: rest + np.outer(20.0 * s, (1.0, 0.0, -1.0))  # noqa: E731
        rod = Rod(LENGTH, section, rest_strain=bent, breaks=(0.1,))
    load = RodLoad(FORCE / LENGTH * weight, FORCE * force, FORCE * LENGTH * moment)
    element = RodElement.MIXED if full else None
    elements = 40 if full else 24 if seed % 7 == 2 else (60, 8, 12, 24)[seed % 4]
    return prepared(RodProblem(rod, load), elements=elements, element=element)


def contact_case(seed):
    """Return a rod that its weight presses on one or two obstacles; with friction it was moved.

    Every second one with friction sticks: it is loaded a little more. The others slide.
    """
    rng = np.random.default_rng(1000 + seed)
    rest = rng.uniform((-0.5, 0.0, -1.0), (0.5, 0.5, 1.0))
    load = RodLoad((0.02, 0.01, -0.3) if seed % 4 else (0.0, 0.0, -0.3))
    friction, (x, y) = (0.0, 0.3, 0.6)[seed % 3], 0.2 * rng.normal(size=2)
    shape = (Cylinder(0.02), Sphere(0.025))[seed % 2]
    near = Obstacle.along(shape, (0.15, 0.0, -0.033), (x, 1.0, y), friction)
    far = Obstacle.along(Cylinder(0.015), (0.3, 0.0, -0.06), (0.0, 1.0, 0.1), friction)
    rod = Rod(LENGTH, random_section(rng, (0, 0, 2)[seed % 3]), radius=3e-3, rest_strain=rest)
    problem = RodProblem(rod, load, obstacles=(near, far)[: 1 + seed % 2])
    if not friction:
        return prepared(problem, elements=36)
    start = solve_rod(problem, elements=36)
    sticks = replace(problem, load=replace(load, tip_force=(0.0, 1e-3 * FORCE, 0.0)))
    slides = replace(problem, base=Clamped((6e-3 * LENGTH, 0.0, 0.0)))
    return prepared(sticks if seed % 4 < 2 else slides, start=start, elements=36)
