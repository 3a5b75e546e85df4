# SPDX-License-Identifier: Apache-2.0
"""The rod solver as a solver of cosseratbench, a benchmark of rod simulators.

Scenarios of one rod are answered, at rest or in motion: ends free, pinned or clamped, loads at the
ends, cylinders and planes with friction. Everything else is declared unsupported. Rods bend, twist
and stretch but do not shear, and friction acts at the centerline, as the references of these
scenarios have it: with friction at its surface the capstan's rope slides at 0.95 to 0.99 of theirs.
"""

from __future__ import annotations

import math
from importlib.metadata import version
from typing import TypeAlias

import cosseratbench.scenario as posed
import numpy as np
from cosseratbench import Capability, Trajectory
from cosseratbench.solver import Diverged
from numpy.typing import NDArray

from spiral_core import (
    Clamped,
    Cylinder,
    Free,
    Inertia,
    Obstacle,
    Pinned,
    Plane,
    PointLoad,
    Rod,
    RodLoad,
    RodProblem,
    RodState,
    RodStatus,
    Section,
    solve_motion,
)
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.motion.inertia import UNDAMPED
from spiral_core.rod.motion.motion import MotionStatus

Array: TypeAlias = NDArray[np.float64]
# A normal across every element is its own parallel transport; rounding leaves this.
ACROSS = 1e-9
# Motion is computed on so many elements for one, and in steps of at most this time [s].
REFINED, LONGEST_STEP = 2, 0.0072


class SpiralSolver:
    """Static equilibria with a certificate: all frames but the first one, which is the start.

    A rod that finds none, because it slides off, passes through the states of the search.

    Example:
        >>> from cosseratbench.experiment import run
        >>> from cosseratbench.registry import load_experiment
        >>> result = run(load_experiment("cantilever"), SpiralSolver())
        >>> result.outcome, result.metrics["tip_deflection_error"] < 1e-3
        ('completed', True)
    """

    name = "spiral"
    backend_version = version("spiral-gripper")
    capabilities = frozenset(
        {
            Capability.STRETCH,
            Capability.CYLINDER_CONTACT,
            Capability.PLANE_CONTACT,
        }
    )

    def run(self, scenario: posed.Scenario, *, n_elements: int, n_frames: int) -> Trajectory:
        """Return the start and the equilibrium that is reached from it.

        Raises:
            NotImplementedError: the scenario asks for more than statics of one rod.
            Diverged: the solver found no answer.
        """
        _refuse_unsupported(scenario)
        (rod,) = scenario.rods
        if not scenario.quasi_static:
            return _moved(scenario, n_elements, n_frames)
        nodes, directors = rod.nodes(n_elements), _directors(rod, n_elements)
        state = solve_contact(
            problem_of(scenario, nodes, directors), start=nodes, elements=n_elements, throw=False
        )
        if state.status is RodStatus.SELF_CONTACT:
            raise NotImplementedError("contact of a rod with itself")
        if state.status not in (RodStatus.CONVERGED, RodStatus.NOT_HELD):
            raise Diverged(state.status.value)
        _refuse_beyond_the_ends(scenario, state)
        held = rod.start is posed.EndCondition.CLAMPED
        across = np.repeat(_turned(state, directors, held)[None], n_frames, axis=0)
        positions = np.repeat(state.positions[None], n_frames, axis=0)
        if state.status is RodStatus.NOT_HELD:
            passed = np.linspace(0, len(state.trail) - 1, n_frames)
            positions = state.trail[np.rint(passed).astype(int)]
        positions[0], across[0] = nodes, directors
        times = np.linspace(0.0, scenario.duration, n_frames)
        return Trajectory(times, (positions,), (across,))


def _moved(scenario: posed.Scenario, n_elements: int, n_frames: int) -> Trajectory:
    """Return how a rod moves, without damping, on twice as many elements."""
    (rod,) = scenario.rods
    count = REFINED * n_elements
    nodes, directors = rod.nodes(count), _directors(rod, count)
    problem = problem_of(scenario, nodes, directors)
    times = np.linspace(0.0, scenario.duration, n_frames)
    motion = solve_motion(
        lambda _: problem,
        Inertia.round(rod.material.density, rod.radius),
        times.tolist(),
        damping=UNDAMPED,
        start=nodes,
        longest_step=LONGEST_STEP,
    )
    if motion.status is not MotionStatus.COMPLETED:
        raise Diverged(motion.status.value)
    for frame in motion.frames:
        _refuse_beyond_the_ends(scenario, frame.state)
    held = rod.start is posed.EndCondition.CLAMPED
    across = np.array([_turned(frame.state, directors, held) for frame in motion.frames])
    kept = across[:, ::REFINED]
    kept[0] = _directors(rod, n_elements)
    return Trajectory(times, (motion.positions[:, ::REFINED],), (kept,))


def problem_of(scenario: posed.Scenario, nodes: Array, directors: Array) -> RodProblem:
    """Return the problem that a scenario of one rod poses.

    Args:
        scenario: one rod.
        nodes: where it starts (n + 1, 3) [m].
        directors: across its elements (n, 3), unit vectors; clamps hold those at the ends.
    """
    (rod,) = scenario.rods
    material, inertia = rod.material, rod.second_moment_of_area
    bending = material.youngs_modulus * inertia
    weight = material.density * rod.area * np.asarray(scenario.gravity)
    loads = [
        PointLoad(0.0 if load.at is posed.End.START else rod.length, load.force)
        for load in rod.loads
    ]
    return RodProblem(
        Rod(
            rod.length,
            Section(
                (2.0 * material.shear_modulus * inertia, bending, bending),
                extension=material.youngs_modulus * rod.area,
            ),
            rod.radius,
            friction_radius=0.0,
        ),
        RodLoad(distributed=tuple(weight.tolist())),
        base=_end(rod.start, nodes[0], nodes[1] - nodes[0], directors[0]),
        tip=_end(rod.end, nodes[-1], nodes[-1] - nodes[-2], directors[-1]),
        obstacles=tuple(_obstacle(one, rod.friction) for one in scenario.obstacles),
        point_loads=tuple(loads),
    )


def _refuse_unsupported(scenario: posed.Scenario) -> None:
    """Raise NotImplementedError for what a solver of one rod does not model."""
    if not scenario.quasi_static and scenario.self_contact:
        raise NotImplementedError("dynamics with contact of a rod with itself")
    if len(scenario.rods) != 1:
        raise NotImplementedError("several rods")
    if any(scenario.rods[0].motion(end) is not None for end in posed.End):
        raise NotImplementedError("ends that are driven")


def _refuse_beyond_the_ends(scenario: posed.Scenario, state: RodState) -> None:
    """Raise NotImplementedError where the rod touches a cylinder beyond its ends: ours has none."""
    for one, touching in zip(scenario.obstacles, state.touching, strict=True):
        if isinstance(one, posed.Cylinder):
            along = (state.positions[touching] - np.asarray(one.center)) @ one.unit_axis
            if np.abs(along).max(initial=0.0) > 0.5 * one.length:
                raise NotImplementedError("contact with the end of a cylinder")


def _end(
    condition: posed.EndCondition, position: Array, chord: Array, director: Array
) -> Free | Pinned | Clamped:
    """Return how an end is held."""
    if condition is posed.EndCondition.FREE:
        return Free()
    x, y, z = position.tolist()
    if condition is posed.EndCondition.PINNED:
        return Pinned((x, y, z))
    return Clamped((x, y, z), _quaternion(chord, director))


def _quaternion(chord: Array, director: Array) -> tuple[float, float, float, float]:
    """Return the turn that takes x along the chord and y along the director.

    It is the eigenvector of a symmetric matrix (Bar-Itzhack, J. Guidance 23, 2000).
    """
    tangent = chord / np.linalg.norm(chord)
    turn = np.column_stack((tangent, director, np.cross(tangent, director)))
    matrix = np.empty((4, 4))
    matrix[:3, :3] = turn + turn.T - np.trace(turn) * np.eye(3)
    matrix[3, :3] = matrix[:3, 3] = (
        turn[2, 1] - turn[1, 2],
        turn[0, 2] - turn[2, 0],
        turn[1, 0] - turn[0, 1],
    )
    matrix[3, 3] = np.trace(turn)
    x, y, z, w = np.linalg.eigh(matrix)[1][:, -1].tolist()
    return x, y, z, w


def _obstacle(one: posed.Obstacle, friction: float) -> Obstacle:
    """Return an obstacle; of two coefficients of friction the larger one applies."""
    friction = max(friction, one.friction)
    if isinstance(one, posed.Cylinder):
        return Obstacle.along(Cylinder(one.radius), one.center, one.axis, friction)
    return Obstacle.along(Plane(), one.point, one.normal, friction)


def _directors(rod: posed.Rod, n_elements: int) -> Array:
    """Return the directors at the start (n, 3), without cosseratbench's loop where it can be."""
    normal = np.asarray(rod.normal, dtype=np.float64)
    legs = np.diff(np.asarray(rod.centerline, dtype=np.float64), axis=0)
    size = np.linalg.norm(normal)
    if np.abs(legs @ normal).max() <= ACROSS * size * np.linalg.norm(legs[0]):
        return np.tile(normal / size, (n_elements, 1))
    directors: Array = rod.directors(n_elements)
    return directors


def _turned(state: RodState, directors: Array, held: bool) -> Array:
    """Return the directors of a state (n, 3), perpendicular to its elements.

    Nothing resists the spin of a rod whose start is not held: the one is shown that
    leaves the first director nearest to where it was.
    """
    q = state.orientations[:-1] + state.orientations[1:] * np.sign(
        np.sum(state.orientations[:-1] * state.orientations[1:], axis=1, keepdims=True)
    )
    x, y, z, w = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    across = np.column_stack((2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)))
    chords = np.diff(state.positions, axis=0)
    chords /= np.linalg.norm(chords, axis=1, keepdims=True)
    across -= np.sum(across * chords, axis=1, keepdims=True) * chords
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    if not held:
        cosine, sine = across[0] @ directors[0], chords[0] @ np.cross(across[0], directors[0])
        spin = math.atan2(sine, cosine)
        across = math.cos(spin) * across + math.sin(spin) * np.cross(chords, across)
    return across
