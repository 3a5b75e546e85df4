# SPDX-License-Identifier: Apache-2.0
"""Newton's method on the rod's energy: the globalized iteration, and how it can end."""

import math

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import Array, dot, quaternion_at, to_material, vector_at
from spiral_core.rod._elimination import back_substitute, newton_pass, scales_of
from spiral_core.rod._system import Ending, Solution, System
from spiral_core.rod._turns import copy_nodes, turn_nodes

# Outcomes of `minimize` and of the paths; `RodStatus` gives them names and advice.
CONVERGED = 0
ITERATION_LIMIT = 1
LINE_SEARCH_FAILED = 2
NOT_FINITE = 3
UNSTABLE = 4
LEFT_BRANCH = 5  # only in `strict` mode: the Hessian lost its positive pivots on the way
FOLD_LIMIT = 6
UNRESOLVED = 7

# Largest rotation of a node, and twice the largest of an element, in one Newton step [rad]: beyond
# it the quadratic model of the energy means nothing.
MAX_NODE_ROTATION = 0.7
# Towards a saddle the shifted iteration converges linearly: at this multiple of the tolerance it is
# one. Much more, and the slow ground next to a fold would be taken for a saddle.
SADDLE_LOOSENING = 10.0
# The Newton step that is left [rad] may be this many times the tolerance: a soft rod moves far
# under a small imbalance.
STEP_LOOSENING = 10.0
# The line search gives up below these fractions of Newton's step: in general, and where the forces
# are in balance already.
SHORTEST_STEP = 1e-10
SHORTEST_LAST_STEP = 1e-3
# Sufficient decrease of the energy (Armijo), the usual small fraction.
ARMIJO = 1e-4
# Energy differences below these fractions of EI/L and of the energy itself are rounding error.
ENERGY_NOISE = 1e-11
RELATIVE_ENERGY_NOISE = 1e-12


@compiled
def minimize(q: Array, system: System, ending: Ending) -> Solution:
    """Minimize the rod's energy from q, in place.

    Newton's method with a shifted Hessian where it is indefinite and a backtracking line search on
    the energy.
    """
    tolerance, max_iterations, strict = ending
    n = system.elements.shape[0]
    gains = np.empty((n - 1, 9))
    offsets = np.empty((n, 3))
    step = np.empty((n, 3))
    trial = np.empty((n + 1, 4))
    scales = scales_of(system)
    unit, threshold = scales.moment, scales.pivot
    moment = (system.tip_moment[0], system.tip_moment[1], system.tip_moment[2])
    energy, residual, decrement, pivot, neutral = newton_pass(
        q, system, 0.0, scales, gains, offsets
    )
    unshifted, modes = pivot, neutral
    shift, size = 0.0, np.inf
    iteration, outcome = 0, ITERATION_LIMIT
    for iteration in range(max_iterations + 1):
        unshifted, modes = pivot, neutral
        definite = pivot > threshold
        balanced = residual <= tolerance * unit
        if not math.isfinite(pivot):
            outcome = NOT_FINITE
        elif strict and not definite:
            outcome = LEFT_BRANCH
        elif not definite and residual <= SADDLE_LOOSENING * tolerance * unit:
            outcome = UNSTABLE
        if outcome != ITERATION_LIMIT:
            break
        shift = shift / 16.0
        while not pivot > threshold and iteration < max_iterations:
            shift = max(4.0 * shift, 1e-3 * unit)
            energy, residual, decrement, pivot, _ = newton_pass(
                q, system, shift, scales, gains, offsets
            )
            if not math.isfinite(pivot):
                return Solution(
                    NOT_FINITE, iteration, energy, residual / unit, pivot / unit, size, 0
                )
        if pivot > threshold:
            size = back_substitute(gains, offsets, step)
        if (
            definite
            and balanced
            and (size <= STEP_LOOSENING * tolerance or iteration == max_iterations)
        ):
            outcome = CONVERGED
        if outcome != ITERATION_LIMIT or iteration == max_iterations:
            break
        fraction = min(1.0, MAX_NODE_ROTATION / size)
        tip = to_material(quaternion_at(q, n), moment)
        work = dot(tip, vector_at(step, n - 1))
        slope = decrement
        while True:
            turn_nodes(q, step, fraction, trial)
            trial_energy, trial_residual, decrement, pivot, neutral = newton_pass(
                trial, system, 0.0, scales, gains, offsets
            )
            change = trial_energy - energy - fraction * work
            if change <= -ARMIJO * fraction * slope:
                break
            noise = ENERGY_NOISE * unit + RELATIVE_ENERGY_NOISE * abs(energy)
            if change <= noise and trial_residual < residual:
                break
            fraction *= 0.5
            if fraction < (SHORTEST_LAST_STEP if definite and balanced else SHORTEST_STEP):
                outcome = CONVERGED if definite and balanced else LINE_SEARCH_FAILED
            if outcome != ITERATION_LIMIT:
                return Solution(
                    outcome, iteration, energy, residual / unit, unshifted / unit, size, modes
                )
        copy_nodes(trial, q)
        energy, residual = trial_energy, trial_residual
    return Solution(outcome, iteration, energy, residual / unit, unshifted / unit, size, modes)
