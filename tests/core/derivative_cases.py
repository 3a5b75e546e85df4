# SPDX-License-Identifier: Apache-2.0
"""Random rods at rest, moved along a way through their parameters, and solved again."""

import math
from dataclasses import dataclass, replace

import numpy as np
from core.rod_cases import stiffness_at
from scipy.spatial.transform import Rotation

from spiral_core import (
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
# Steps of the differences, in units, largest first: one of them is large against what a solve
# leaves (1e-8 of the scales) and small against the curvature of the state over the parameter.
STEPS = (1e-2, 3e-3, 2e-2, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
# Derivatives smaller than this, without units, are compared with it: a solve ends at 1e-8.
SMALL = 1.0
# Contacts nearer to changing their kind than this cannot be resolved by such steps.
NEAR = {"gap": 1e-4, "force": 1e-2, "stick": 0.1, "slip": 1e3}


@dataclass(frozen=True, eq=False)
class Raised:
    """A shape whose surface is moved outward; it passes for the shape: a state may go on to it."""

    shape: object
    by: float

    def __eq__(self, other):
        return True

    __hash__ = None

    def distance(self, points):
        distance, *slopes = self.shape.distance(points)
        return distance - self.by, *slopes

    @property
    def feature_radius(self):
        return self.shape.feature_radius


@dataclass(frozen=True)
class Case:
    """A problem, on so many elements, and what a state of it is solved from."""

    problem: RodProblem
    elements: int
    element: RodElement | None = None
    start: object = None

    def solved(self, start=None):
        return solve_rod(
            self.problem, element=self.element, start=start, estimate_error=False,
            elements=self.elements if start is None else len(start.positions) - 1,
        )  # fmt: skip

    def moved(self, way, size):
        """Return the case moved along a way: names, components and weights in units."""
        problem = self.problem
        for name, component, weight in way:
            problem = changed(problem, name, component, size * weight * UNITS[name])
        return replace(self, problem=problem)


def plus(given, component, size):
    """Return a vector, or a profile of vectors, with one component changed."""
    step = size * np.eye(3)[component]
    return (lambda s: given(s) + step) if callable(given) else tuple(np.add(given, step).tolist())


def stretched(profile, ratio):
    """Return a profile of a rod that is so many times as long: the same at each fraction of it."""
    return (lambda s: profile(s / ratio)) if callable(profile) else profile


def changed_rod(rod, name, component, size):
    """Return a rod with one component of a parameter changed."""
    if name == "rest_strain":
        return replace(rod, rest_strain=plus(rod.rest_strain, component, size))
    if name == "length":
        ratio = 1.0 + size
        profiles = {key: stretched(getattr(rod, key), ratio) for key in ("section", "rest_strain")}
        breaks = tuple(ratio * place for place in rod.breaks)
        return replace(rod, length=rod.length * ratio, breaks=breaks, **profiles)
    root = np.ones(len(stiffness_at(rod.section, np.zeros(1))[0]))
    root[component] = math.sqrt(1.0 + size)

    def scaled(sites):
        return root[:, None] * stiffness_at(rod.section, sites) * root

    section = scaled if callable(rod.section) else Section(scaled(np.zeros(1))[0])
    return replace(rod, section=section)


def changed(problem, name, component, size):
    """Return a problem with one component of a parameter changed."""
    load, base, obstacles = problem.load, problem.base, list(problem.obstacles)
    if hasattr(load, name):
        value = plus(getattr(load, name), component, size)
        return replace(problem, load=replace(load, **{name: value}))
    if name in ("rest_strain", "length", "stiffness"):
        return replace(problem, rod=changed_rod(problem.rod, name, component, size))
    if name == "base_position":
        return replace(problem, base=replace(base, position=plus(base.position, component, size)))
    if name == "base_rotation":
        turn = Rotation.from_rotvec(size * np.eye(3)[component])
        turned = turn * Rotation.from_quat(base.orientation)
        return replace(problem, base=replace(base, orientation=tuple(turned.as_quat())))
    which, component = divmod(component, 3) if name == "obstacle_position" else (component, 0)
    one = obstacles[which]
    if name == "obstacle_position":
        one = replace(one, position=plus(one.position, component, size))
    elif name == "friction":
        one = replace(one, friction=one.friction + size)
    else:
        one = replace(one, shape=Raised(one.shape, size))
    obstacles[which] = one
    return replace(problem, obstacles=tuple(obstacles))


def turn_between(first, second):
    """Return rotation vectors (n, 3), base frame, from orientations to others."""
    return (Rotation.from_quat(second) * Rotation.from_quat(first).inv()).as_rotvec()


def figures(state, base, force):
    """Return what is differentiated, without units; ``force`` is one of forces [N]."""
    return (
        state.positions / LENGTH,
        turn_between(base.orientations, state.orientations),
        state.base_reaction / np.repeat((force, force * LENGTH), 3),
        state.contact_forces.sum(axis=0) / force,
    )


def way_error(case, found, state, way):
    """Return the error of the derivative along a way, against the step that agrees best.

    None where every step changes what touches or sticks.
    """
    force = max(FORCE, float(np.abs(state.forces).max()))
    scales = (LENGTH, 1.0, np.repeat((force, force * LENGTH), 3), force)
    arrays = (found.positions, found.rotations, found.base_reaction, found.contact_forces)
    parts = [
        sum(array[found.columns[name].start + k] * UNITS[name] * w for name, k, w in way) / scale
        for array, scale in zip(arrays, scales, strict=True)
    ]
    best = None
    for step in STEPS:
        ways = []
        for times in (1.0, -1.0, 2.0, -2.0):
            try:
                other = case.moved(way, times * step).solved(case.start)
            except SolverError:
                break
            alike = (other.touching == state.touching) & (other.sticking == state.sticking)
            if not alike.all():
                break
            ways.append(figures(other, state, force))
        if len(ways) < 4:
            continue
        error = 0.0
        for part, one, two, three, four in zip(parts, *ways, strict=True):
            slope = (8.0 * (one - two) - (three - four)) / (12.0 * step)
            scale = max(float(np.abs(part).max(initial=0.0)), SMALL)
            error = max(error, float(np.abs(slope - part).max(initial=0.0)) / scale)
        best = error if best is None else min(best, error)
        if best < 3e-7:
            break
    return best


def random_section(generator, kind):
    """Return a section: plain, coupled, or full."""
    moduli = BENDING * generator.uniform((0.4, 0.8, 0.8), (1.2, 1.2, 1.2))
    if kind == 0:
        return Section(tuple(moduli))
    if kind == 1:
        coupling = 0.3 * math.sqrt(moduli[0] * moduli[2])
        return Section.inextensible(moduli[2], moduli[0], moduli[1], coupling)
    scale = np.sqrt(np.concatenate((moduli, generator.uniform(10.0, 40.0, 3))))
    mix = generator.normal(size=(6, 6))
    mix = mix @ mix.T
    mix /= np.sqrt(np.outer(np.diag(mix), np.diag(mix)))
    mix = 0.8 * np.eye(6) + 0.2 * mix
    return Section((scale[:, None] * mix * scale).tolist())


def free_case(seed):
    """Return a free rod: every third symmetric on purpose, some with few elements, or varying."""
    generator = np.random.default_rng(seed)
    kind = seed % 6
    section = random_section(generator, seed % 2)
    rest = 7.0 * generator.normal(size=3)
    weight, force = generator.normal(size=3) * FORCE / LENGTH * 20.0, 0.5 * generator.normal(size=3)
    moment = 0.3 * generator.normal(size=3) * (seed % 4 == 0)
    if kind == 1:  # upright, light enough to stand
        rest, force, moment = np.zeros((3, 3))
        weight = (-2.0 * FORCE / LENGTH, 0.0, 0.0)
    elif kind == 3:  # planar
        rest[:2], force[2], moment[:2] = 0.0, 0.0, 0.0
        weight[2] = 0.0
    elif kind == 5:  # nothing loads it
        weight, force, moment = np.zeros((3, 3))
    load = RodLoad(tuple(weight), tuple(FORCE * force), tuple(FORCE * LENGTH * moment))
    rod = Rod(LENGTH, section, rest_strain=tuple(rest))
    if seed % 7 == 2:
        rod = replace(
            rod,
            section=Section.varying(lambda s: BENDING * (1.0 + s), 0.7 * BENDING),
            rest_strain=lambda s: rest + np.outer(20.0 * s, (1.0, 0.0, -1.0)),
            breaks=(0.1,),
        )
    elements = (60, 24 if seed % 7 == 2 else 8, 12, 24)[seed % 4]
    mixed = seed % 5 == 4
    element = RodElement.MIXED if mixed else None
    if mixed:
        elements = 40
        if seed % 2 and not callable(rod.section):
            rod = replace(rod, section=random_section(generator, 2))
    return Case(RodProblem(rod, load), elements, element)


def contact_case(seed):
    """Return a rod that its weight presses on one or two obstacles; with friction it was moved.

    Every second one with friction sticks: it is loaded a little more. The others slide.
    """
    generator = np.random.default_rng(1000 + seed)
    section = random_section(generator, (0, 0, 2)[seed % 3])
    rest = generator.uniform((-0.5, 0.0, -1.0), (0.5, 0.5, 1.0))
    weight = np.array((0.02, 0.01, -0.3)) if seed % 4 else np.array((0.0, 0.0, -0.3))
    friction = (0.0, 0.3, 0.6)[seed % 3]
    tilt = 0.2 * generator.normal(size=2)
    shape, axis = (Cylinder(0.02), Sphere(0.025))[seed % 2], (tilt[0], 1.0, tilt[1])
    obstacles = (Obstacle.along(shape, (0.15, 0.0, -0.033), axis, friction),)
    if seed % 2:
        far = Obstacle.along(Cylinder(0.015), (0.3, 0.0, -0.06), (0.0, 1.0, 0.1), friction)
        obstacles += (far,)
    rod = Rod(LENGTH, section, radius=3e-3, rest_strain=tuple(rest))
    case = Case(RodProblem(rod, RodLoad(tuple(weight)), obstacles=obstacles), 36)
    if not friction:
        return case
    way = ("tip_force", 1, 1e-3) if seed % 4 < 2 else ("base_position", 0, 6e-3)
    return replace(case.moved([way], 1.0), start=case.solved())


def components_of(case, found, state):
    """Return the components that a case can be changed in: name and number."""
    pairs = []
    for name, part in found.columns.items():
        if name.startswith("base") and state.element is RodElement.INEXTENSIBLE:
            continue  # its base stays where it is: see the test of a moved base
        count = part.stop - part.start
        if name == "stiffness":
            count = len(stiffness_at(case.problem.rod.section, np.zeros(1))[0])
        pairs += [(name, component) for component in range(count)]
    return pairs


def prepared(case):
    """Return a case that goes on from its state, the state and its derivatives.

    None where a contact is next to changing its kind.
    """
    state = case.solved(case.start)
    case = case if case.start else replace(case, start=state)
    found = differentiate(state)
    if any(found.margins[key] < near for key, near in NEAR.items()):
        return None
    return case, state, found


def random_error(case, seed):
    """Return the error along one random way through all parameters, and the state; or None."""
    ready = prepared(case)
    if ready is None:
        return None
    case, state, found = ready
    generator = np.random.default_rng(seed)
    pairs = components_of(case, found, state)
    way = [(*pair, float(generator.normal())) for pair in pairs]
    return way_error(case, found, state, way), state
