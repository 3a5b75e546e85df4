"""Follow a branch of stable rod states while the rod's data change (compiled).

The states of a rod under load are many; the one seen on the bench is the one reached along the
loading path. So the path is walked: data are blended from a start to an end, each step a Newton
solve from the last state that must stay on stable ground. Where no step is small enough the branch
has ended in a fold: the rod snaps to another state, by descent of its energy, and the fold's place
is recorded.
"""

import math

import numpy as np

from spiral_core.numerics.kernel import compiled, inlined
from spiral_core.rod._algebra import dot, quaternion_product, rotated, scale
from spiral_core.rod._newton import (
    CONVERGED,
    LEFT_BRANCH,
    UNSTABLE,
    Array,
    Solution,
    System,
    minimize,
    quaternion_at,
    turn_nodes,
)

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
# Kick off an unstable state: rotation at the tip [rad], growing fourfold with each try.
KICK = 0.01
KICKS = 6
# The loading path is walked on this many elements at the least, and with at most this angle in one
# at its end [rad].
PATH_ELEMENTS = 24
PATH_ANGLE = 0.6
# A path with more folds than this is given up.
MAX_FOLDS = 32
# Inside the path an equilibrium need not be as sharp as at its end.
LOOSENING = 1e4
# A state nearby is reached in a few iterations; a start far away may take this many.
WARM_ITERATIONS = 60


@compiled
def descend(q: Array, system: System, tolerance: float) -> Solution:
    """Minimize from q in place; kick the rod off a stationary state that is not stable.

    The kick's direction is arbitrary but fixed, so that the result is reproducible.
    """
    n = q.shape[0] - 1
    kick = np.empty((n, 3))
    for i in range(n):
        reach = (i + 1) / n
        kick[i, 0] = 0.3 * reach
        kick[i, 1] = 0.8 * reach
        kick[i, 2] = reach
    size = KICK
    total = 0
    outcome, iterations, energy, residual, pivot = minimize(
        q, system, tolerance, DESCENT_ITERATIONS, False
    )
    for _ in range(KICKS):
        total += iterations
        if outcome != UNSTABLE:
            break
        turn_nodes(q, kick, size, q)
        size *= 4.0
        outcome, iterations, energy, residual, pivot = minimize(
            q, system, tolerance, DESCENT_ITERATIONS, False
        )
    return outcome, total, energy, residual, pivot


@compiled
def largest_turn(q: Array, previous: Array) -> float:
    """Return the largest angle [rad] by which a node turned relative to the node before it."""
    largest = 0.0
    for i in range(q.shape[0] - 1):
        a = quaternion_at(previous, i)
        b = quaternion_at(previous, i + 1)
        c = quaternion_at(q, i)
        d = quaternion_at(q, i + 1)
        before = quaternion_product((-a[0], -a[1], -a[2], a[3]), b)
        after = quaternion_product((-c[0], -c[1], -c[2], c[3]), d)
        change = quaternion_product((-before[0], -before[1], -before[2], before[3]), after)
        axis = (change[0], change[1], change[2])
        largest = max(largest, 2.0 * math.asin(min(1.0, math.sqrt(dot(axis, axis)))))
    return largest


@compiled
def blend(start: System, end: System, at: float) -> System:
    """Return the system at ``at`` in [0, 1] between two with as many elements."""
    return (
        (1.0 - at) * start[0] + at * end[0],
        (1.0 - at) * start[1] + at * end[1],
        (1.0 - at) * start[2] + at * end[2],
        (1.0 - at) * start[3] + at * end[3],
        (1.0 - at) * start[4] + at * end[4],
    )


@compiled
def advance(
    q: Array, start: System, end: System, at: float, tolerance: float
) -> tuple[float, Solution]:
    """Follow the stable branch from ``at`` between two systems, where q rests, as far as it goes.

    Returns how far that is, 1 unless a fold ends the branch, and the last solution tried; q is left
    at the last state of the branch.
    """
    trial = q.copy()
    step = FIRST_STEP
    total = 0
    energy, residual, pivot = 0.0, 0.0, 0.0
    while at < 1.0:
        target = at + step if at + step < 1.0 - 1e-9 else 1.0
        system = blend(start, end, target)
        trial[:, :] = q
        accuracy = tolerance if target == 1.0 else LOOSENING * tolerance
        outcome, iterations, energy, residual, pivot = minimize(
            trial, system, accuracy, PATH_ITERATIONS, True
        )
        total += iterations
        if outcome == CONVERGED and largest_turn(trial, q) < LARGEST_TURN:
            q[:, :] = trial
            at = target
            if iterations <= 3:
                step *= 2.0
        elif step > SMALLEST_STEP:
            step *= 0.5
        else:
            return at, (LEFT_BRANCH, total, energy, residual, pivot)
    return 1.0, (CONVERGED, total, energy, residual, pivot)


@compiled
def snap(
    q: Array, start: System, end: System, at: float, tolerance: float
) -> tuple[float, Solution]:
    """Descend from the end of a branch at ``at``; return where the next one is joined."""
    beyond = min(1.0, at + SMALLEST_STEP)
    return beyond, descend(q, blend(start, end, beyond), tolerance)


@compiled
def follow(q: Array, start: System, end: System, tolerance: float) -> tuple[int, Solution]:
    """Follow the path from ``start``, where q rests, to ``end``, over its folds; q in place.

    Returns the number of folds and the solution at the end.
    """
    at = 0.0
    folds = 0
    total = 0
    while True:
        at, solution = advance(q, start, end, at, tolerance)
        total += solution[1]
        if solution[0] == LEFT_BRANCH and folds < MAX_FOLDS:
            folds += 1
            at, solution = snap(q, start, end, at, tolerance)
            total += solution[1]
        if solution[0] != CONVERGED or at == 1.0:
            return folds, (solution[0], total, solution[2], solution[3], solution[4])


@compiled
def walk_from(first_moment: Array, system: System, tolerance: float) -> tuple[Array, int, Solution]:
    """Follow the loading path from a rod without rest strain under another tip moment [N m]."""
    force, nodal, _, elements, h = system
    straight = elements.copy()
    straight[:, 2:5] = 0.0
    straight[:, 7:10] = 0.0
    relaxed = (force, nodal, first_moment, straight, h)
    q = np.zeros((elements.shape[0] + 1, 4))
    q[:, 3] = 1.0
    first = descend(q, relaxed, tolerance)
    if first[0] != CONVERGED:
        return q, 0, first
    folds, last = follow(q, relaxed, system, tolerance)
    return q, folds, (last[0], first[1] + last[1], last[2], last[3], last[4])


@compiled
def walk(system: System, tolerance: float) -> tuple[Array, int, Solution]:
    """Follow the loading path of a rod, from the one without rest strain that hangs in its loads.

    A dead tip moment may be more than the straight rod bears: should the path fail with it, it is
    walked again with the moment coming on along with the rest strain.
    Returns the orientations, the number of folds and the solution.
    """
    q, folds, solution = walk_from(system[2], system, tolerance)
    if solution[0] == CONVERGED:
        return q, folds, solution
    return walk_from(np.zeros(3), system, tolerance)


@compiled
def resample(q: Array, count: int) -> Array:
    """Return ``count`` + 1 evenly spaced nodes of the rod that q samples, by geodesics."""
    n = q.shape[0] - 1
    fine = np.empty((count + 1, 4))
    for j in range(count + 1):
        place = j * n / count
        i = min(int(place), n - 1)
        q0 = quaternion_at(q, i)
        x0, x1, x2, w = quaternion_product((-q0[0], -q0[1], -q0[2], q0[3]), quaternion_at(q, i + 1))
        sine = math.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
        angle = (place - i) * math.atan2(sine, w)
        # `rotated` turns by 2 atan(|half|): give it the tangent of the half angle.
        factor = 2.0 * math.tan(angle) / sine if sine > 0.0 else 0.0
        r = rotated(q0, scale(factor, (x0, x1, x2)))
        for k in range(4):
            fine[j, k] = r[k]
    return fine


@compiled
def settle(q: Array, system: System, tolerance: float) -> tuple[int, Solution]:
    """Minimize from q, in place, on its branch; where that ends, descend and count one fold."""
    outcome, spent, energy, residual, pivot = minimize(q, system, tolerance, WARM_ITERATIONS, True)
    if outcome == CONVERGED:
        return 0, (outcome, spent, energy, residual, pivot)
    outcome, more, energy, residual, pivot = descend(q, system, tolerance)
    return 1, (outcome, spent + more, energy, residual, pivot)


@inlined
def path_elements(count: int, turn: float) -> int:
    """Return how many of ``count`` elements suffice to walk a path that turns by ``turn`` [rad]."""
    return min(count, max(PATH_ELEMENTS, math.ceil(turn / PATH_ANGLE)))


@compiled
def walk_and_refine(coarse: System, fine: System, tolerance: float) -> tuple[Array, int, Solution]:
    """Walk the loading path on few elements and refine at its end; walk it finely if that fails.

    Returns as :func:`walk`, on the fine elements.
    """
    q, folds, solution = walk(coarse, tolerance)
    spent = solution[1]
    if solution[0] == CONVERGED:
        q = resample(q, fine[3].shape[0])
        snaps, solution = settle(q, fine, tolerance)
        spent += solution[1]
        if snaps == 0 and solution[0] == CONVERGED:
            return q, folds, (solution[0], spent, solution[2], solution[3], solution[4])
    q, folds, solution = walk(fine, tolerance)
    return q, folds, (solution[0], spent + solution[1], solution[2], solution[3], solution[4])
