# SPDX-License-Identifier: Apache-2.0
"""Newton's method on the rod's energy: the globalized iteration, and how it can end."""

import math
from typing import NamedTuple

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    Array,
    dot,
    quaternion_at,
    to_material,
    turn_nodes,
    vector_at,
)
from spiral_core.rod._elimination import Pass, Scales, back_substitute, newton_pass, scales_of
from spiral_core.rod._system import Ending, Solution, System
from spiral_core.rod._turns import copy_nodes

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


class Workspace(NamedTuple):
    """Arrays of a minimization.

    Attributes:
        gains, offsets: (N - 1, 9) and (N, 3), what a pass leaves for the substitution.
        step: (N, 3) Newton step [rad].
        trial: (N + 1, 4) orientations after a fraction of it.
    """

    gains: Array
    offsets: Array
    step: Array
    trial: Array


@compiled
def line_search(
    q: Array,
    system: System,
    scales: Scales,
    here: Pass,
    space: Workspace,
    fraction: float,
    shortest: float,
) -> tuple[bool, Pass]:
    """Halve a fraction of Newton's step until it lowers the energy, or is below ``shortest``.

    Returns whether the energy is lower at ``space.trial``, and the pass there.
    """
    n = system.elements.shape[0]
    moment = (system.tip_moment[0], system.tip_moment[1], system.tip_moment[2])
    work = dot(to_material(quaternion_at(q, n), moment), vector_at(space.step, n - 1))
    noise = ENERGY_NOISE * scales.moment + RELATIVE_ENERGY_NOISE * abs(here.energy)
    while True:
        turn_nodes(q, space.step, fraction, space.trial)
        there = newton_pass(space.trial, system, 0.0, scales, space.gains, space.offsets)
        change = there.energy - here.energy - fraction * work
        is_lower = change <= -ARMIJO * fraction * here.decrement or (
            change <= noise and there.residual < here.residual
        )
        fraction *= 0.5
        if is_lower or fraction < shortest:
            return is_lower, there


@compiled
def minimize(q: Array, system: System, ending: Ending) -> Solution:
    """Minimize the rod's energy from q, in place.

    Newton's method with a shifted Hessian where it is indefinite and a backtracking line search on
    the energy.
    """
    tolerance, max_iterations, strict = ending
    n = system.elements.shape[0]
    gains, offsets = np.empty((n - 1, 9)), np.empty((n, 3))
    space = Workspace(gains, offsets, np.empty((n, 3)), np.empty((n + 1, 4)))
    scales = scales_of(system)
    unit, threshold = scales.moment, scales.pivot
    here = newton_pass(q, system, 0.0, scales, gains, offsets)
    unshifted, modes = here.pivot, here.neutral
    shift, size = 0.0, np.inf
    iteration, outcome = 0, ITERATION_LIMIT
    for iteration in range(max_iterations + 1):
        unshifted, modes = here.pivot, here.neutral
        definite = here.pivot > threshold
        balanced = here.residual <= tolerance * unit
        if not math.isfinite(here.pivot):
            outcome = NOT_FINITE
        elif strict and not definite:
            outcome = LEFT_BRANCH
        elif not definite and here.residual <= SADDLE_LOOSENING * tolerance * unit:
            outcome = UNSTABLE
        if outcome != ITERATION_LIMIT:
            break
        shift = shift / 16.0
        while not here.pivot > threshold and iteration < max_iterations:
            shift = max(4.0 * shift, 1e-3 * unit)
            here = newton_pass(q, system, shift, scales, gains, offsets)
            if not math.isfinite(here.pivot):
                outcome, unshifted, modes = NOT_FINITE, here.pivot, 0
                break
        if outcome != ITERATION_LIMIT:
            break
        if here.pivot > threshold:
            size = back_substitute(gains, offsets, space.step)
        at_rest = definite and balanced
        if at_rest and (size <= STEP_LOOSENING * tolerance or iteration == max_iterations):
            outcome = CONVERGED
        if outcome != ITERATION_LIMIT or iteration == max_iterations:
            break
        fraction = min(1.0, MAX_NODE_ROTATION / size)
        shortest = SHORTEST_LAST_STEP if at_rest else SHORTEST_STEP
        is_lower, there = line_search(q, system, scales, here, space, fraction, shortest)
        if not is_lower:
            outcome = CONVERGED if at_rest else LINE_SEARCH_FAILED
            break
        copy_nodes(space.trial, q)
        here = there
    return Solution(
        outcome, iteration, here.energy, here.residual / unit, unshifted / unit, size, modes
    )
