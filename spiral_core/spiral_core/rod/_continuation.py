# SPDX-License-Identifier: Apache-2.0
"""Follow a branch of stable rod states while the rod's data change (compiled).

A rod under load has many equilibria. The one observed on the bench is reached along the loading
path, so that path is followed: data are blended from a start to an end. Each step is a Newton solve
from the last state, and its result must be stable. Where no step is small enough, the branch has
ended in a fold: the rod snaps to another state, which is found by descent of its energy, and the
fold's place is recorded.
"""

import math
from typing import NamedTuple

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    TANGENT,
    Array,
    copy_nodes,
    largest_turn,
    put_vector,
    quaternion_at,
    quaternion_product,
    resample,
    scale,
    seen_turn,
    to_base,
    turn_nodes,
)
from spiral_core.rod._element import section_at
from spiral_core.rod._newton import (
    CONVERGED,
    FOLD_LIMIT,
    LEFT_BRANCH,
    UNRESOLVED,
    UNSTABLE,
    minimize,
    scales_of,
)
from spiral_core.rod._profiles import UniformRod
from spiral_core.rod._system import (
    Ending,
    Solution,
    System,
    blended,
    shape_from_orientations,
    uniform_system,
    with_torsion_no_stiffer,
    without_rest_strain,
)
from spiral_core.rod.types import DEFAULT_TOLERANCE

# A step along the path may need this many Newton iterations; more means that it was too long.
PATH_ITERATIONS = 6
# Steps of the blend parameter in [0, 1]: the first tried, and the one below which a fold is
# declared.
FIRST_STEP = 0.125
SMALLEST_STEP = 1.0 / 4096.0
# A node may turn by this much relative to its predecessor's turn in one step [rad]; more is a jump,
# not a step.
LARGEST_TURN = 1.0
# Iterations for the descent after a fold, and for a first state.
DESCENT_ITERATIONS = 400
# Disturb an unstable state: rotation at the tip [rad], growing fourfold with each try, to the one
# side and the other: behind a fold one of them leads back.
DISTURBANCE = 0.01
DISTURBANCES = 6
# Below this fraction of EI/L, what acts across the base's axis moves a rod less than a disturbance.
NEARLY_AXIAL = 0.01
# The rest strain's first increment turns a straight rod that buckled under its load about the
# load's axis; by more than this [rad] and the path starts after that increment.
LARGEST_FIRST_TURN = 0.1
# A torsional stiffness of more than this many times the bending one hardly changes how a rod
# without rest strain hangs, but keeps Newton's steps short: the rod is first brought to rest with
# this much.
EASY_TORSION = 4.0
# A path with more folds than this is given up.
MAX_FOLDS = 32
# Inside the path an equilibrium need not be as sharp as at its end.
LOOSENING = 1e4
# A state nearby is reached in a few iterations; a start far away may take this many.
WARM_ITERATIONS = 60
# The energy of an element is that of a rod that bends little within it: past this turn [rad] its
# ends no longer tell what happens between them.
LARGEST_ELEMENT_TURN = 2.0


class SolvedRod(NamedTuple):
    """A state and what was found on the way to it; arrays as in ``RodState``."""

    solution: Solution
    folds: int
    forces: Array
    positions: Array
    moments: Array
    strains: Array


@compiled
def turn_about_base_axis(q: Array, system: System) -> float:
    """Turn the bent rod q, in place, about the base's axis to where its energy is least.

    A bent isotropic rod under an axial load may point anywhere; rest strain and a tilt of the load,
    however small, choose. In a turn by phi the energy is E(phi) = E + B cos phi + C sin phi, but
    for the small terms of an element's supplement. Returns phi [rad].
    """
    n = system.steps.shape[0]
    cosine, sine = 0.0, 0.0
    for i in range(n):
        h, rest = system.steps[i], section_at(system.elements, i).rest
        a, b = quaternion_at(q, i), quaternion_at(q, i + 1)
        _, y, z, _ = seen_turn(a, b)
        t = to_base(b, TANGENT)
        cosine -= 2.0 * (rest[1] * y + rest[2] * z)
        sine -= 2.0 * (rest[2] * y - rest[1] * z)
        if i == n - 1:
            h *= 0.5
        cosine -= h * (system.force[i + 1, 1] * t[1] + system.force[i + 1, 2] * t[2])
        sine -= h * (system.force[i + 1, 2] * t[1] - system.force[i + 1, 1] * t[2])
    if cosine == 0.0 and sine == 0.0:
        return 0.0
    angle = math.atan2(-sine, -cosine)
    s, c = math.sin(0.5 * angle), math.cos(0.5 * angle)
    for i in range(n + 1):
        p = quaternion_product((s, 0.0, 0.0, c), quaternion_at(q, i))
        put_vector(q[i], 0, quaternion_product(p, (-s, 0.0, 0.0, c)))
    return angle


@compiled
def disturb(q: Array, system: System, size: float) -> None:
    """Bend and twist q, in place: off a state that is stationary but not stable.

    The direction is arbitrary but fixed, so that results are reproducible; except about the base's
    axis where the rod may all but turn freely: there the energy chooses.
    """
    n = q.shape[0] - 1
    step = np.empty((n, 3))
    for i in range(n):
        put_vector(step[i], 0, scale((i + 1) / n, (0.3, 0.8, 1.0)))
    turn_nodes(q, step, size, q)
    if scales_of(system).across < NEARLY_AXIAL:
        turn_about_base_axis(q, system)


@compiled
def with_outcome(found: Solution, outcome: int) -> Solution:
    """Return the solution with another outcome."""
    _, iterations, energy, residual, pivot, step, neutral = found
    return Solution(outcome, iterations, energy, residual, pivot, step, neutral)


@compiled
def minimize_to_stable(q: Array, system: System, tolerance: float, spent: int) -> Solution:
    """Minimize from q in place; leave a stationary state that is not stable.

    ``spent`` iterations came before, here and below; the solution's include them.
    """
    size = DISTURBANCE
    while True:
        found = minimize(q, system, Ending(tolerance, DESCENT_ITERATIONS, False), spent)
        if found.outcome != UNSTABLE or abs(size) > DISTURBANCE * 4.0**DISTURBANCES:
            return found
        spent = found.iterations
        disturb(q, system, size)
        size *= -4.0


@compiled
def follow_branch(
    q: Array, start: System, end: System, at: float, tolerance: float, spent: int
) -> tuple[float, Solution]:
    """Follow the stable branch from ``at`` between two systems, where q rests, as far as it goes.

    Returns how far that is, 1 unless a fold ends the branch, and the last solution tried; q is left
    at the last state of the branch.
    """
    trial = np.empty_like(q)
    step = FIRST_STEP
    while True:
        target = at + step if at + step < 1.0 - 1e-9 else 1.0
        copy_nodes(q, trial)
        accuracy = tolerance if target == 1.0 else LOOSENING * tolerance
        ending = Ending(accuracy, PATH_ITERATIONS, True)
        found = minimize(trial, blended(start, end, target), ending, spent)
        taken, spent = found.iterations - spent, found.iterations
        if found.outcome == CONVERGED and largest_turn(trial, q) < LARGEST_TURN:
            copy_nodes(trial, q)
            at = target
            if at == 1.0:
                return at, found
            if taken <= 3:
                step *= 2.0
        elif step > SMALLEST_STEP:
            step *= 0.5
        else:
            return at, with_outcome(found, LEFT_BRANCH)


@compiled
def follow_over_folds(
    q: Array, start: System, end: System, at: float, tolerance: float, spent: int
) -> tuple[int, Solution]:
    """Follow the path from ``at``, where q rests, to ``end``, over its folds; q in place.

    Returns the number of folds and the solution at the end.
    """
    folds = 0
    while True:
        at, found = follow_branch(q, start, end, at, tolerance, spent)
        if found.outcome == LEFT_BRANCH:
            if folds == MAX_FOLDS:
                return folds, with_outcome(found, FOLD_LIMIT)
            folds += 1
            at = min(1.0, at + SMALLEST_STEP)
            found = minimize_to_stable(q, blended(start, end, at), tolerance, found.iterations)
        if found.outcome != CONVERGED or at == 1.0:
            return folds, found
        spent = found.iterations


@compiled
def first_state(
    q: Array, start: System, end: System, tolerance: float, spent: int
) -> tuple[float, Solution]:
    """Bring the straight rod q to rest, in place, at the start of its loading path.

    A rod that buckles under an axial load may do so in any direction about it. Which one the path
    takes is decided by the first increment of the rest strain: there it starts then. Returns where.
    """
    eased = with_torsion_no_stiffer(start, EASY_TORSION)
    found = minimize_to_stable(q, eased, tolerance, spent)
    found = minimize_to_stable(q, start, tolerance, found.iterations)
    turned = np.empty_like(q)
    copy_nodes(q, turned)
    next_to_it = blended(start, end, SMALLEST_STEP)
    angle = turn_about_base_axis(turned, next_to_it)
    if found.outcome == CONVERGED and not abs(angle) > LARGEST_FIRST_TURN:
        return 0.0, found
    copy_nodes(turned, q)
    return SMALLEST_STEP, minimize_to_stable(q, next_to_it, tolerance, found.iterations)


@compiled
def follow_loading(system: System, tolerance: float, spent: int) -> tuple[Array, int, Solution]:
    """Follow the loading path of a rod, from the one without rest strain that hangs in its loads.

    A dead tip moment may be more than the straight rod bears: should the path fail with it, it is
    followed again with the moment growing along with the rest strain.
    Returns the orientations, the number of folds and the solution.
    """
    q = np.empty((len(system.steps) + 1, 4))
    folds, found = 0, Solution(UNSTABLE, spent, 0.0, 0.0, 0.0, 0.0, 0)
    for attempt in range(2):
        start = without_rest_strain(system, 1.0 - attempt)
        for i in range(len(q)):
            put_vector(q[i], 0, (0.0, 0.0, 0.0, 1.0))
        at, found = first_state(q, start, system, tolerance, found.iterations)
        if found.outcome == CONVERGED:
            folds, found = follow_over_folds(q, start, system, at, tolerance, found.iterations)
        if found.outcome == CONVERGED:
            break
    return q, folds, found


@compiled
def solve_from(q: Array, system: System, tolerance: float, spent: int) -> tuple[int, Solution]:
    """Minimize from q, in place, on its branch; where it ends, find another state: one fold."""
    found = minimize(q, system, Ending(tolerance, WARM_ITERATIONS, True), spent)
    if found.outcome == CONVERGED:
        return 0, found
    return 1, minimize_to_stable(q, system, tolerance, found.iterations)


@compiled
def loaded(q: Array, coarse: System, fine: System) -> tuple[int, Solution]:
    """Follow the loading path on few elements and refine at its end; on all if that fails.

    Writes the orientations on all elements into q; returns the number of folds and the solution.
    """
    spent = 0
    system, on_all = coarse, len(coarse.steps) == len(fine.steps)
    while True:
        end, folds, found = follow_loading(system, DEFAULT_TOLERANCE, spent)
        if on_all:
            break
        if found.outcome == CONVERGED:
            end = resample(end, coarse.steps, fine.steps)
            snaps, found = solve_from(end, fine, DEFAULT_TOLERANCE, found.iterations)
            if found.outcome == CONVERGED and snaps == 0:
                break
        spent, system, on_all = found.iterations, fine, True
    copy_nodes(end, q)
    return folds, found


@compiled
def evaluated(q: Array, system: System, folds: int, found: Solution) -> SolvedRod:
    """Return the state with orientations q; not an answer if an element turns too far."""
    positions, moments, strains, turn = shape_from_orientations(q, system)
    if found.outcome == CONVERGED and turn > LARGEST_ELEMENT_TURN:
        found = with_outcome(found, UNRESOLVED)
    return SolvedRod(found, folds, system.force.copy(), positions, moments, strains)


@compiled
def solve_system(q: Array, coarse: System, fine: System, is_start: bool) -> SolvedRod:
    """Return the state that q comes to rest in, or the one at the end of the loading path."""
    if is_start:
        folds, found = solve_from(q, fine, DEFAULT_TOLERANCE, 0)
    else:
        folds, found = loaded(q, coarse, fine)
    return evaluated(q, fine, folds, found)


@compiled
def solve_uniform(q: Array, rod: UniformRod, few: int) -> SolvedRod:
    """Return the state of a uniform rod on N elements, its orientations in q (N + 1, 4).

    With ``few`` elements to begin with, it is the one at the end of the loading path; with none,
    the one that q comes to rest in.
    """
    fine = uniform_system(len(q) - 1, rod)
    coarse = uniform_system(few, rod) if few > 0 else fine
    return solve_system(q, coarse, fine, few == 0)
