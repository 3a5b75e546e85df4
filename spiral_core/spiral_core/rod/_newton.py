# SPDX-License-Identifier: Apache-2.0
"""Newton's method on the rod's energy: its pass, the globalized iteration, and how it can end.

A pass assembles the Hessian and eliminates it from base to tip. The Hessian is block-tridiagonal
with 3x3 blocks, so that a Newton step costs O(N). The blocks that the elimination divides by are
the Hessian's pivots, and all of them positive definite *is* the proof that the state is a strict
local minimum of the discrete energy: stable. Where rod and load do not change in a turn about the
base's axis, a bent rod may turn freely: that neutral mode ends in the last block, where it is
recognized and held (section 6 of ``docs/derivations/rod.md``).
"""

import math
from typing import NamedTuple

import numpy as np

from spiral_core.numerics.kernel import compiled, inlined
from spiral_core.rod._algebra import (
    TANGENT,
    Array,
    Mat,
    Quat,
    add,
    copy_nodes,
    cross,
    diagonal,
    dot,
    inverse,
    largest_component,
    matadd,
    matmul,
    matmul_t,
    matrix_at,
    matscale,
    matsubtract,
    matvec,
    matvec_t,
    outer,
    put_matrix,
    put_vector,
    quaternion_at,
    scale,
    skew,
    smallest_pivot_and_inverse,
    subtract,
    to_material,
    turn_nodes,
    vector_at,
    vector_from,
)
from spiral_core.rod._element import (
    compliance_of,
    element_derivatives,
    element_energy,
    element_frame,
    rotated_load_hessian,
    section_at,
)
from spiral_core.rod._system import Ending, Solution, System, end_loads

# A pivot below this fraction of EI/h counts as not positive: a thousand times the rounding error of
# the elimination.
PIVOT_TOLERANCE = 1e-11
# Rest moments and loads across the base's axis below this fraction of EI/L, and bending stiffnesses
# that differ by less than it, leave a rod free to turn about that axis: what moves it then is an
# imbalance within the tolerance.
AXIAL_TOLERANCE = 1e-8
# What resists that turn is then no larger; in the last block of a heavy rod, where the shape at the
# base counts for little, rounding errors reach this fraction of EI/L.
SOFTEST = 1e-3
# A tip that leans less than this from the base's axis [rad] has no neutral mode worth the name.
SMALLEST_LEAN = 1e-7


class Scales(NamedTuple):
    """What is large and small for a rod: EI/L, and the largest pivot that is rounding error [N m].

    ``across`` is the largest rest moment or load across the base's axis, as a fraction of EI/L, and
    ``unlike`` the largest difference of two bending stiffnesses, of EI: without any, a turn about
    that axis changes neither rod nor load.
    """

    moment: float
    pivot: float
    across: float
    unlike: float


class Pass(NamedTuple):
    """What one pass finds at a state of the rod.

    Attributes:
        energy: [J].
        residual: largest moment imbalance at a node [N m].
        decrement: Newton's, g.H^-1.g [J].
        pivot: the smallest [N m], or the first that is not positive.
        neutral: number of neutral modes.
    """

    energy: float
    residual: float
    decrement: float
    pivot: float
    neutral: int


@inlined
def scales_of(system: System) -> Scales:
    """Return the scales of a rod, with its smallest bending stiffness where it may twist."""
    bending, length, shortest, across, unlike = np.inf, 0.0, np.inf, 0.0, 0.0
    for i, step in enumerate(system.steps):
        section = section_at(system.elements, i)
        soft = compliance_of(section.stiffness)
        sideways, upwards = 1.0 / soft.y, 1.0 / soft.z
        bending, unlike = min(bending, sideways, upwards), max(unlike, abs(sideways - upwards))
        length, shortest = length + step, min(shortest, step)
        across = max(across, abs(section.rest[1]), abs(section.rest[2]))
    for i in range(len(system.force)):
        across = max(across, length * abs(system.force[i, 1]), length * abs(system.force[i, 2]))
    across = max(across, abs(system.tip_moment[1]), abs(system.tip_moment[2]))
    unit = bending / length
    return Scales(unit, PIVOT_TOLERANCE * bending / shortest, across / unit, unlike / bending)


@inlined
def held_about_axis(block: Mat, q: Quat) -> tuple[Mat, float, float]:
    """Return the last block with the rod's turn about the base's axis held at the tip.

    Also the block's curvature in that direction [N m], and the tip's lean from the axis, squared: a
    turn about e_x moves a node by R^T e_x - e_x.
    """
    e = to_material(q, TANGENT)
    mode = (e[0] - 1.0, e[1], e[2])
    lean = dot(mode, mode)
    per = 1.0 / max(lean, SMALLEST_LEAN * SMALLEST_LEAN)
    stiffness = block[0][0] + block[1][1] + block[2][2]
    held = matadd(block, matscale(stiffness * per, outer(mode, mode)))
    return held, per * dot(mode, matvec(block, mode)), lean


@inlined
def last_pivot(
    block: Mat, q: Quat, scales: Scales, softest: float, shift: float, smallest: float
) -> tuple[Mat, float, int]:
    """Return the last block, its pivot [N m], and how many neutral modes were held in it.

    Args:
        block: what is left for the tip.
        q: the tip's orientation.
        scales: of the rod.
        softest: curvature [N m] that an imbalance off equilibrium adds along a circle.
        shift: what was added to the Hessian's diagonal [N m].
        smallest: pivot of the nodes before [N m].
    """
    pivot, _ = smallest_pivot_and_inverse(block)
    axial = max(scales.across, scales.unlike) <= AXIAL_TOLERANCE
    if axial and shift == 0.0 and smallest > scales.pivot:
        held, curvature, lean = held_about_axis(block, q)
        held_pivot, _ = smallest_pivot_and_inverse(held)
        softest += max(scales.pivot * lean, SOFTEST * scales.moment)
        if (
            not pivot * lean > softest
            and abs(curvature) * lean <= softest
            and held_pivot > scales.pivot
            and lean > SMALLEST_LEAN**2
        ):
            return held, held_pivot, 1
    return block, pivot, 0


@compiled
def newton_pass(
    q: Array, system: System, shift: float, scales: Scales, gains: Array, offsets: Array
) -> Pass:
    """Assemble energy, gradient and Hessian at q and eliminate from base to tip.

    ``gains`` (N - 1, 3, 3) and ``offsets`` (N, 3) receive what :func:`back_substitute` needs.
    ``shift`` [N m] is added to the diagonal.
    """
    n = system.steps.shape[0]
    energy, residual, decrement = system.rest_energy, 0.0, 0.0
    smallest = np.inf
    shifted = diagonal(shift, shift, shift)
    block = shifted
    gradient = reduced = (0.0, 0.0, 0.0)
    q1 = quaternion_at(q, 0)
    a1 = to_material(q1, vector_at(system.force, 0))
    for i in range(n):
        q0, a0 = q1, a1
        q1 = quaternion_at(q, i + 1)
        a1 = to_material(q1, vector_at(system.force, i + 1))
        h, section = system.steps[i], section_at(system.elements, i)
        x, w, u = element_frame(q0, q1, h)
        pull0, pull1 = end_loads(system, i, q0, q1, a0, a1)
        energy += element_energy(u, a0, a1, section, h) - pull0[0] - pull1[0]
        g0, g1, h00, h01, h11 = element_derivatives(x, w, u, a0, a1, section, h)
        g1 = add(g1, cross(pull1, TANGENT))
        carried = (0.0, 0.0, 0.0)
        fill = shifted
        if i > 0:
            g0 = add(g0, cross(pull0, TANGENT))
            gradient = add(gradient, g0)
            residual = max(residual, largest_component(gradient))
            block = matsubtract(matadd(block, h00), rotated_load_hessian(TANGENT, pull0))
            reduced = add(reduced, g0)
            pivot, s_inverse = smallest_pivot_and_inverse(block)
            if smallest > 0.0:  # the first pivot that is not positive stays
                smallest = pivot if not pivot > smallest else smallest
            gain = matmul(s_inverse, h01)
            offset = matvec(s_inverse, reduced)
            decrement += dot(reduced, offset)
            put_matrix(gains[i - 1], 0, 0, gain)
            put_vector(offsets[i - 1], 0, offset)
            fill = matsubtract(fill, matmul_t(h01, gain))
            carried = scale(-1.0, matvec_t(h01, offset))
        gradient = g1
        reduced = add(carried, g1)
        block = matsubtract(matadd(fill, h11), rotated_load_hessian(TANGENT, pull1))
    moment = to_material(q1, vector_from(system.tip_moment, 0))
    gradient = subtract(gradient, moment)
    residual = max(residual, largest_component(gradient))
    if not smallest > 0.0:
        return Pass(energy, residual, 0.0, smallest, 0)
    block, pivot, neutral = last_pivot(block, q1, scales, n * residual, shift, smallest)
    smallest = pivot if not pivot > smallest else smallest
    # A moment fixed in the base frame does circulatory work: its tangent is skew and enters only
    # the last block.
    reduced = subtract(reduced, moment)
    last = matvec(inverse(matsubtract(block, matscale(0.5, skew(moment)))), reduced)
    put_vector(offsets[n - 1], 0, last)
    return Pass(energy, residual, decrement + dot(last, reduced), smallest, neutral)


@compiled
def back_substitute(gains: Array, offsets: Array, step: Array) -> float:
    """Write the Newton step (rotation vector of each free node [rad]) and return its size.

    The size is the largest component of a node's rotation, or twice that of an element's, whichever
    is larger.
    """
    n = len(offsets)
    here = scale(-1.0, vector_at(offsets, n - 1))
    largest = largest_component(here)
    put_vector(step[n - 1], 0, here)
    for i in range(n - 2, -1, -1):
        following = here
        here = scale(-1.0, add(vector_at(offsets, i), matvec(matrix_at(gains, i), following)))
        put_vector(step[i], 0, here)
        turn = 2.0 * largest_component(subtract(here, following))
        largest = max(largest, largest_component(here), turn)
    return max(largest, 2.0 * largest_component(here))


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
        gains, offsets: (N - 1, 3, 3) and (N, 3), what a pass leaves for the substitution.
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
    n = system.steps.shape[0]
    moment = to_material(quaternion_at(q, n), vector_from(system.tip_moment, 0))
    work = dot(moment, vector_at(space.step, n - 1))
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
def minimize(q: Array, system: System, ending: Ending, spent: int) -> Solution:
    """Minimize the rod's energy from q, in place; ``spent`` iterations came before.

    Newton's method with a shifted Hessian where it is indefinite and a backtracking line search on
    the energy.
    """
    tolerance, max_iterations, strict = ending
    n = system.steps.shape[0]
    gains, offsets = np.empty((n - 1, 3, 3)), np.empty((n, 3))
    space = Workspace(gains, offsets, np.empty((n, 3)), np.empty((n + 1, 4)))
    scales = scales_of(system)
    unit, threshold = scales.moment, scales.pivot
    here = newton_pass(q, system, 0.0, scales, gains, offsets)
    unshifted, modes = here.pivot, here.neutral
    shift, size, outcome = 0.0, np.inf, ITERATION_LIMIT
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
        outcome,
        spent + iteration,
        here.energy,
        here.residual / unit,
        unshifted / unit,
        size,
        modes,
    )
