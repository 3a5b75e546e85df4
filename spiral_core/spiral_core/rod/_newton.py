"""Newton's method on the rod's energy: assembly, elimination and the globalized iteration.

The Hessian is block-tridiagonal with 3x3 blocks, so that a Newton step costs O(N). Elimination runs
from the base to the tip; the blocks it divides by are the Hessian's pivots, and all of them
positive definite *is* the proof that the state is a strict local minimum of the discrete energy:
stable.
"""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled, inlined
from spiral_core.rod._algebra import (
    Vec,
    add,
    cross,
    diagonal,
    dot,
    inverse,
    matadd,
    matmul,
    matmul_t,
    matscale,
    matvec,
    matvec_t,
    rotated,
    scale,
    skew,
    smallest_pivot_and_inverse,
    to_material,
)
from spiral_core.rod._element import (
    element_derivatives,
    element_energy,
    element_frame,
    rotated_load_hessian,
)

Array: TypeAlias = NDArray[np.float64]
# A discretized rod under load: force (N + 1, 3), nodal (N + 1, 3), tip moment (3,), elements
# (N, 10) and h, as `RodArrays` documents them.
System: TypeAlias = tuple[Array, Array, Array, Array, float]
# Outcome, Newton iterations, energy [J], largest moment imbalance, smallest pivot [N m].
Solution: TypeAlias = tuple[int, int, float, float, float]

# Outcomes of `minimize`; `RodStatus` gives them names and advice.
CONVERGED = 0
ITERATION_LIMIT = 1
LINE_SEARCH_FAILED = 2
NOT_FINITE = 3
UNSTABLE = 4
LEFT_BRANCH = 5  # only in `strict` mode: the Hessian lost its positive pivots on the way

# Largest rotation of a node, and twice the largest of an element, in one Newton step [rad]: beyond
# it the quadratic model of the energy means nothing.
MAX_NODE_ROTATION = 0.7
# A pivot below this fraction of EI/h counts as not positive: a thousand times the rounding error of
# the elimination.
PIVOT_TOLERANCE = 1e-11
# Towards a saddle the shifted iteration creeps, linearly: it is near enough to call it one at this
# multiple of the tolerance.
SADDLE_LOOSENING = 1e4
# Sufficient decrease of the energy (Armijo), the usual small fraction.
ARMIJO = 1e-4
# Energy differences below these fractions of EI/L and of the energy itself are rounding error.
ENERGY_NOISE = 1e-11
RELATIVE_ENERGY_NOISE = 1e-12


TANGENT = (1.0, 0.0, 0.0)


@inlined
def vector_at(rows: Array, i: int) -> Vec:
    """Return row i of an (n, 3) array as a tuple."""
    return (rows[i, 0], rows[i, 1], rows[i, 2])


@inlined
def quaternion_at(rows: Array, i: int) -> tuple[float, float, float, float]:
    """Return row i of an (n, 4) array as a tuple."""
    return (rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3])


@inlined
def largest_component(a: Vec) -> float:
    """Return the largest absolute component of a."""
    return max(abs(a[0]), abs(a[1]), abs(a[2]))


@compiled
def energy_and_imbalance(q: Array, system: System) -> tuple[float, float]:
    """Return the energy at q [J] and the largest moment imbalance at a node [N m]."""
    force, nodal, tip_moment, elements, h = system
    energy = 0.0
    residual = 0.0
    gradient = (0.0, 0.0, 0.0)
    q1 = quaternion_at(q, 0)
    a1 = to_material(q1, vector_at(force, 0))
    for i in range(elements.shape[0]):
        q0, a0 = q1, a1
        q1 = quaternion_at(q, i + 1)
        a1 = to_material(q1, vector_at(force, i + 1))
        x, w, u = element_frame(q0, q1, h)
        energy += element_energy(u, a0, a1, elements[i], h)
        g0, g1, _, _, _ = element_derivatives(x, w, u, a0, a1, elements[i], h)
        if i > 0:
            residual = max(residual, largest_component(add(gradient, g0)))
        load = to_material(q1, vector_at(nodal, i + 1))
        energy -= load[0]
        gradient = add(g1, cross(load, TANGENT))
    moment = to_material(q1, (tip_moment[0], tip_moment[1], tip_moment[2]))
    gradient = add(gradient, scale(-1.0, moment))
    return energy, max(residual, largest_component(gradient))


@compiled
def newton_pass(
    q: Array, system: System, shift: float, gains: Array, offsets: Array
) -> tuple[float, float, float, float]:
    """Assemble energy, gradient and Hessian at q and eliminate from base to tip.

    ``gains`` (N - 1, 9) and ``offsets`` (N, 3) receive what :func:`back_substitute` needs. Returns
    the energy [J], the largest moment imbalance at a node [N m], the Newton decrement g.H^-1.g [J]
    and the smallest pivot [N m]; the elimination stops at a pivot that is not positive (``shift``
    [N m] is added to the diagonal).
    """
    force, nodal, tip_moment, elements, h = system
    n = elements.shape[0]
    energy = 0.0
    residual = 0.0
    decrement = 0.0
    smallest = np.inf
    block = diagonal(shift, shift, shift)
    reduced = (0.0, 0.0, 0.0)
    gradient = (0.0, 0.0, 0.0)
    q1 = quaternion_at(q, 0)
    a1 = to_material(q1, vector_at(force, 0))
    for i in range(n):
        q0, a0 = q1, a1
        q1 = quaternion_at(q, i + 1)
        a1 = to_material(q1, vector_at(force, i + 1))
        x, w, u = element_frame(q0, q1, h)
        energy += element_energy(u, a0, a1, elements[i], h)
        g0, g1, h00, h01, h11 = element_derivatives(x, w, u, a0, a1, elements[i], h)
        carried = (0.0, 0.0, 0.0)
        fill = diagonal(shift, shift, shift)
        if i > 0:
            gradient = add(gradient, g0)
            residual = max(residual, largest_component(gradient))
            block = matadd(block, h00)
            reduced = add(reduced, g0)
            pivot, s_inverse = smallest_pivot_and_inverse(block)
            smallest = min(smallest, pivot)
            if not pivot > 0.0:
                energy, residual = energy_and_imbalance(q, system)
                return energy, residual, 0.0, pivot
            gain = matmul(s_inverse, h01)
            offset = matvec(s_inverse, reduced)
            decrement += dot(reduced, offset)
            for k in range(9):
                gains[i - 1, k] = gain[k]
            for k in range(3):
                offsets[i - 1, k] = offset[k]
            fill = matadd(fill, matscale(-1.0, matmul_t(h01, gain)))
            carried = scale(-1.0, matvec_t(h01, offset))
        load = to_material(q1, vector_at(nodal, i + 1))
        energy -= load[0]
        torque = cross(load, TANGENT)
        gradient = add(g1, torque)
        reduced = add(add(carried, g1), torque)
        block = matadd(matadd(fill, h11), matscale(-1.0, rotated_load_hessian(TANGENT, load)))
    moment = to_material(q1, (tip_moment[0], tip_moment[1], tip_moment[2]))
    gradient = add(gradient, scale(-1.0, moment))
    residual = max(residual, largest_component(gradient))
    pivot, _ = smallest_pivot_and_inverse(block)
    smallest = min(smallest, pivot)
    if not pivot > 0.0:
        return energy, residual, 0.0, pivot
    # A moment fixed in the base frame does circulatory work: its tangent is skew and enters only
    # the last block.
    reduced = add(reduced, scale(-1.0, moment))
    last = matvec(inverse(matadd(block, matscale(-0.5, skew(moment)))), reduced)
    for k in range(3):
        offsets[n - 1, k] = last[k]
    return energy, residual, decrement + dot(last, reduced), smallest


@inlined
def matvec_row(rows: Array, i: int, v: Vec) -> Vec:
    """Return the 3x3 matrix stored in row i times v."""
    return (
        rows[i, 0] * v[0] + rows[i, 1] * v[1] + rows[i, 2] * v[2],
        rows[i, 3] * v[0] + rows[i, 4] * v[1] + rows[i, 5] * v[2],
        rows[i, 6] * v[0] + rows[i, 7] * v[1] + rows[i, 8] * v[2],
    )


@compiled
def back_substitute(gains: Array, offsets: Array, step: Array) -> float:
    """Write the Newton step (rotation vector of each free node [rad]) and return its size.

    The size is the largest component of a node's rotation, or twice that of an element's, whichever
    is larger.
    """
    n = offsets.shape[0]
    following = scale(-1.0, vector_at(offsets, n - 1))
    largest = 0.0
    for k in range(3):
        step[n - 1, k] = following[k]
        largest = max(largest, abs(following[k]))
    for i in range(n - 2, -1, -1):
        here = scale(-1.0, add(vector_at(offsets, i), matvec_row(gains, i, following)))
        for k in range(3):
            step[i, k] = here[k]
            largest = max(largest, abs(here[k]), 2.0 * abs(here[k] - following[k]))
        following = here
    for k in range(3):
        largest = max(largest, 2.0 * abs(step[0, k]))
    return largest


@compiled
def turn_nodes(q: Array, step: Array, fraction: float, turned: Array) -> None:
    """Write into ``turned`` the nodes of q, the free ones turned by ``fraction`` of their step."""
    for k in range(4):
        turned[0, k] = q[0, k]
    for i in range(step.shape[0]):
        r = rotated(quaternion_at(q, i + 1), scale(fraction, vector_at(step, i)))
        for k in range(4):
            turned[i + 1, k] = r[k]


@compiled
def minimize(
    q: Array, system: System, tolerance: float, max_iterations: int, strict: bool
) -> Solution:
    """Minimize the rod's energy from q, in place.

    Newton's method with a shifted Hessian where it is indefinite and a backtracking line search on
    the energy. ``tolerance`` [N m] bounds the moment imbalance at every node. Returns outcome,
    iterations, energy [J], residual [N m] and the smallest pivot [N m] of the unshifted Hessian at
    the returned state. ``strict`` gives up (``LEFT_BRANCH``) as soon as the Hessian is indefinite:
    for following a branch of stable states.
    """
    _, _, tip_moment, elements, h = system
    n = elements.shape[0]
    gains = np.empty((n - 1, 9))
    offsets = np.empty((n, 3))
    step = np.empty((n, 3))
    trial = np.empty_like(q)
    bending = elements[:, 1].min()
    noise = ENERGY_NOISE * bending / (n * h)
    moment = (tip_moment[0], tip_moment[1], tip_moment[2])
    energy, residual, decrement, pivot = newton_pass(q, system, 0.0, gains, offsets)
    shift = 0.0
    for iteration in range(max_iterations):
        unshifted = pivot
        shift = shift / 16.0
        while not pivot > PIVOT_TOLERANCE * bending / h:
            if not math.isfinite(pivot):
                return NOT_FINITE, iteration, energy, residual, pivot
            if strict:
                return LEFT_BRANCH, iteration, energy, residual, pivot
            shift = max(4.0 * shift, 1e-3 * bending / (n * h))
            energy, residual, decrement, pivot = newton_pass(q, system, shift, gains, offsets)
        if unshifted > PIVOT_TOLERANCE * bending / h:
            if residual <= tolerance:
                return CONVERGED, iteration, energy, residual, unshifted
        elif residual <= SADDLE_LOOSENING * tolerance:
            return UNSTABLE, iteration, energy, residual, unshifted
        largest = back_substitute(gains, offsets, step)
        slope = decrement
        fraction = min(1.0, MAX_NODE_ROTATION / largest)
        tip = to_material(quaternion_at(q, n), moment)
        work = dot(tip, vector_at(step, n - 1))
        while True:
            turn_nodes(q, step, fraction, trial)
            trial_energy, trial_residual, decrement, pivot = newton_pass(
                trial, system, 0.0, gains, offsets
            )
            change = trial_energy - energy - fraction * work
            if change <= -ARMIJO * fraction * slope:
                break
            if change <= noise + RELATIVE_ENERGY_NOISE * abs(energy) and trial_residual < residual:
                break
            fraction *= 0.5
            if fraction < 1e-10:
                return LINE_SEARCH_FAILED, iteration, energy, residual, unshifted
        q[:] = trial
        energy, residual = trial_energy, trial_residual
    return ITERATION_LIMIT, max_iterations, energy, residual, pivot
