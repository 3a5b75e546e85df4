# SPDX-License-Identifier: Apache-2.0
"""A moved or mirrored problem has the moved or mirrored answer, with friction and its history."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from core.contact_cases import LENGTH, OUTER, grip
from scipy.spatial.transform import Rotation

from benchmarks.contact_paths import MIRROR, Array, imbalance, mirrored, moved
from benchmarks.rounding import followed as followed_otherwise
from spiral_core import (
    Capsule,
    Clamped,
    Cone,
    Cylinder,
    Obstacle,
    Plane,
    PointLoad,
    Rod,
    RodLoad,
    RodPath,
    RodProblem,
    RodState,
    Section,
    Sphere,
)
from spiral_core.rod.contact.solve import follow_contact

RADIUS, WEIGHT = 0.015, (0.05, 0.1, -0.03)
TURN = Rotation.from_rotvec((0.4, -1.1, 2.0))
SHIFT = np.array((0.3, -0.2, 0.15))


def pulled_out() -> list[RodProblem]:
    """Return a coil that closes under gravity, and the cylinder that is then pulled out of it.

    It closes without friction: with it the answer depends on the increments of the way.
    """
    closed = [grip(RADIUS, 1.1), grip(RADIUS, 1.1, 0.3)]
    away = [grip(RADIUS, 1.1, 0.3, shift) for shift in (-1e-3, -3e-3)]
    return [replace(station, load=RodLoad(WEIGHT)) for station in closed + away]


def among_many() -> list[RodProblem]:
    """Return a rod of coupled, unlike stiffnesses that sinks onto four obstacles above a floor.

    At 1.5 times this load it slips off them.
    """
    bending = ((3e-4, 2e-5, 0.0), (2e-5, 4e-4, 3e-5), (0.0, 3e-5, 9e-4))
    stretch = ((60.0, 3.0, -2.0), (3.0, 20.0, 1.0), (-2.0, 1.0, 25.0))
    between = np.array(((0.03, 0.01, -0.02), (0.02, -0.01, 0.03), (-0.05, 0.02, 0.01)))
    matrix = np.block([[np.array(bending), between], [between.T, np.array(stretch)]])
    section = Section(tuple(tuple(row) for row in matrix.tolist()))
    rod = Rod(0.5, section, 2e-3, rest_strain=(2.0, 1.0, -1.5))
    obstacles = (
        Obstacle.along(Cylinder(0.03), (0.12, 0.0, -0.06), (0.1, 1.0, 0.2), 0.3),
        Obstacle(Sphere(0.03), (0.25, -0.01, -0.09), friction=0.1),
        Obstacle.along(Capsule(0.02, 0.05), (0.36, 0.03, -0.14), (1.0, 1.0, 0.0), 0.2),
        Obstacle.along(Cone(0.03, 0.2), (0.44, 0.0, -0.18), (0.0, 1.0, 0.3), 0.4),
        Obstacle.along(Plane(), (0.0, 0.0, -0.2), (0.1, 0.0, 1.0), 0.5),
    )

    def loaded(part: float, sideways: float) -> RodProblem:
        return RodProblem(
            rod,
            RodLoad((0.0, 0.1 * part, -1.2 * part), (0.0, sideways, 0.0), (1e-3 * part, 0.0, 0.0)),
            base=Clamped((0.0, 0.0, 0.02), (0.0, 0.0, 0.1, np.sqrt(0.99))),
            obstacles=obstacles,
            point_loads=(PointLoad(0.2, (0.02 * part, 0.0, 0.0), (0.0, 0.0, 2e-4 * part)),),
        )

    return [loaded(0.0, 0.0), loaded(0.04, 0.0), loaded(0.08, 0.0), loaded(0.08, 7e-4)]


PATHS = {"pulled out": pulled_out, "among many": among_many}
# With friction the answer depends on the increments. These are so short that none is decided by how
# many passes the one before took, which rounding may change.
LARGEST_INCREMENT = {"pulled out": 1.0, "among many": 0.05}


def followed(name: str, stations: list[RodProblem]) -> RodState:
    """Return where a path ends, on which nothing snaps."""
    path = follow_contact(stations, elements=60, largest_increment=LARGEST_INCREMENT[name])
    assert not path.events
    return path.states[-1]


@cache
def last(name: str) -> RodState:
    """Return where a path ends."""
    return followed(name, PATHS[name]())


@pytest.mark.parametrize("name", PATHS)
def test_path_touches_slips_and_is_in_balance(name: str) -> None:
    state, problem = last(name), PATHS[name]()[-1]
    touching = state.touching
    assert touching.any(axis=1).sum() >= min(3, len(problem.obstacles))
    assert (touching & ~state.sticking).any()
    assert state.gaps[:, 1:].min() > -1e-3 * problem.rod.radius
    weight = np.linalg.norm(problem.load.distributed) * problem.rod.length
    force, moment = imbalance(problem, state)
    assert force < 1e-6 * weight
    # 60 elements: the sum for the weight's moment is of fourth order; the solve's is not at stake.
    assert moment < 4e-6 * weight * problem.rod.length


@pytest.mark.parametrize("name", PATHS)
def test_moved_problem_has_the_moved_answer(name: str) -> None:
    plain = last(name)
    stations = [moved(problem, SHIFT, TURN) for problem in PATHS[name]()]
    state = followed(name, stations)
    expected = TURN.apply(plain.positions) + SHIFT
    np.testing.assert_allclose(state.positions, expected, atol=1e-7 * LENGTH)
    scale = np.abs(plain.contact_forces).max()
    for got, was in zip(state.contact_forces, plain.contact_forces, strict=True):
        np.testing.assert_allclose(got, TURN.apply(was), atol=1e-5 * scale)
    np.testing.assert_allclose(
        state.moments, plain.moments, atol=1e-6 * np.abs(plain.moments).max()
    )
    np.testing.assert_array_equal(state.sticking, plain.sticking)
    assert state.energy == pytest.approx(plain.energy - _lifted(name), rel=1e-6)


def _lifted(name: str) -> float:
    """Return the work of the loads over the shift, which the potential energy has in it."""
    problem = moved(PATHS[name]()[-1], SHIFT, TURN)
    point = sum((np.asarray(p.force) for p in problem.point_loads), np.zeros(3))
    weight = np.asarray(problem.load.distributed) * problem.rod.length
    return float((weight + problem.load.tip_force + point) @ SHIFT)


@pytest.mark.parametrize("name", PATHS)
def test_mirrored_problem_has_the_mirrored_answer(name: str) -> None:
    plain = last(name)
    stations = [mirrored(problem) for problem in PATHS[name]()]
    state = followed(name, stations)
    np.testing.assert_allclose(state.positions, plain.positions @ MIRROR, atol=1e-7 * LENGTH)
    scale = np.abs(plain.contact_forces).max()
    np.testing.assert_allclose(
        state.contact_forces, plain.contact_forces @ MIRROR, atol=1e-5 * scale
    )
    turned = -plain.moments @ MIRROR
    np.testing.assert_allclose(state.moments, turned, atol=1e-6 * np.abs(turned).max())
    assert state.base_reaction[3:] == pytest.approx(-plain.base_reaction[3:] @ MIRROR, abs=1e-8)


def test_larger_rod_of_the_same_proportions_has_the_same_shape() -> None:
    """Lengths times 10, EI times 1e4: forces times 100; slips and tolerances scale along."""
    small, factor = pulled_out(), 10.0

    def grown(problem: RodProblem) -> RodProblem:
        (obstacle,) = problem.obstacles
        rod = problem.rod
        x, y, z = (factor * c for c in obstacle.position)
        u, v, w = (c / factor for c in rod.rest_strain)
        a, b, c = (factor**4 * k for k in rod.section.stiffness)
        f, g, h = (factor * k for k in WEIGHT)
        return replace(
            problem,
            rod=Rod(factor * LENGTH, Section((a, b, c)), factor * OUTER, (u, v, w)),
            load=RodLoad((f, g, h)),
            obstacles=(replace(obstacle, shape=Cylinder(factor * RADIUS), position=(x, y, z)),),
        )

    state = followed("pulled out", [grown(problem) for problem in small])
    plain = last("pulled out")
    np.testing.assert_allclose(state.positions, factor * plain.positions, atol=1e-6 * LENGTH)
    forces = factor**2 * plain.normal_forces
    np.testing.assert_allclose(state.normal_forces, forces, atol=1e-5 * forces.max())


@pytest.mark.parametrize("version", ["turned", "mirrored", "shifted", "perturbed"])
@pytest.mark.parametrize("index", [3, 29, 38])
def test_path_with_friction_ends_where_it_did_however_it_is_asked(index: int, version: str) -> None:
    """The increments of a path follow from its states, not from passes that rounding changes.

    ``python -m benchmarks.rounding`` asks 200 of them; 29 and 38 ended 3e-6 L apart.
    """
    plain, expected = plainly_followed(index)
    path, last = followed_otherwise(index, version)
    assert not plain.events
    assert not path.events
    length = float(plain.states[-1].arc_lengths[-1])
    np.testing.assert_allclose(last, expected, rtol=0.0, atol=1e-7 * length)


@cache
def plainly_followed(index: int) -> tuple[RodPath, Array]:
    """Return a random path as it is."""
    return followed_otherwise(index, "as is")
