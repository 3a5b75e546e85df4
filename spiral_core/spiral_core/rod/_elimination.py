# SPDX-License-Identifier: Apache-2.0
"""One pass of Newton's method: assembly of the Hessian and its elimination from base to tip.

The Hessian is block-tridiagonal with 3x3 blocks, so that a Newton step costs O(N). The blocks that
the elimination divides by are the Hessian's pivots, and all of them positive definite *is* the
proof that the state is a strict local minimum of the discrete energy: stable. Where rod and load do
not change in a turn about the base's axis, a bent rod may turn freely: that neutral mode ends in
the last block, where it is recognized and held (section 6 of ``docs/derivations/rod.md``).
"""

from typing import NamedTuple

import numpy as np

from spiral_core.numerics.kernel import compiled, inlined
from spiral_core.rod._algebra import (
    TANGENT,
    Array,
    Mat,
    Quat,
    Vec,
    add,
    cross,
    diagonal,
    dot,
    inverse,
    largest_component,
    matadd,
    matmul,
    matmul_t,
    matscale,
    matvec,
    matvec_t,
    outer,
    quaternion_at,
    scale,
    skew,
    smallest_pivot_and_inverse,
    to_material,
    vector_at,
)
from spiral_core.rod._element import (
    compliance_of,
    element_derivatives,
    element_energy,
    element_frame,
    rotated_load_hessian,
    section_of,
)
from spiral_core.rod._system import System

# A pivot below this fraction of EI/h counts as not positive: a thousand times the rounding error of
# the elimination.
PIVOT_TOLERANCE = 1e-11
# Rest moments and loads across the base's axis below this fraction of EI/L leave a rod free to turn
# about that axis, but for rounding errors.
AXIAL_TOLERANCE = 1e-6
# What resists that turn is then no larger; in the last block of a heavy rod, where the shape at the
# base counts for little, rounding errors reach this fraction of EI/L.
SOFTEST = 1e-3
# A tip that leans less than this from the base's axis [rad] has no neutral mode worth the name.
SMALLEST_LEAN = 1e-7


class Scales(NamedTuple):
    """What is large and small for a rod: EI/L, and the largest pivot that is rounding error [N m].

    ``across`` is the largest rest moment or load across the base's axis, as a fraction of EI/L:
    without any, a turn about that axis changes neither rod nor load.
    """

    moment: float
    pivot: float
    across: float


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
    bending, length, shortest, across = np.inf, 0.0, np.inf, 0.0
    for i in range(system.steps.shape[0]):
        section = section_of(system.elements[i])
        soft = compliance_of(section.stiffness)
        bending = min(bending, 1.0 / soft.y, 1.0 / soft.z)
        length += system.steps[i]
        shortest = min(shortest, system.steps[i])
        across = max(across, abs(section.rest[1]), abs(section.rest[2]))
    for i in range(system.force.shape[0]):
        across = max(across, length * abs(system.force[i, 1]), length * abs(system.force[i, 2]))
    across = max(across, abs(system.tip_moment[1]), abs(system.tip_moment[2]))
    unit = bending / length
    return Scales(unit, PIVOT_TOLERANCE * bending / shortest, across / unit)


@inlined
def end_loads(system: System, i: int, q0: Quat, q1: Quat, a0: Vec, a1: Vec) -> tuple[Vec, Vec]:
    """Return an element's share of the load at its two nodes, material frame [N m]."""
    h = system.steps[i]
    w = system.distributed[i]
    square = h * h / 12.0
    start = to_material(q0, (w[0], w[1], w[2]))
    end = to_material(q1, (w[3], w[4], w[5]))
    return (
        add(scale(0.5 * h, a0), scale(-square, start)),
        add(scale(0.5 * h, a1), scale(square, end)),
    )


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
    stiffness = block[0] + block[4] + block[8]
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
    if scales.across <= AXIAL_TOLERANCE and shift == 0.0 and smallest > scales.pivot:
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

    ``gains`` (N - 1, 9) and ``offsets`` (N, 3) receive what :func:`back_substitute` needs.
    ``shift`` [N m] is added to the diagonal.
    """
    n = system.elements.shape[0]
    energy, residual, decrement = system.rest_energy, 0.0, 0.0
    smallest = np.inf
    shifted = diagonal(shift, shift, shift)
    block = shifted
    reduced = (0.0, 0.0, 0.0)
    gradient = (0.0, 0.0, 0.0)
    q1 = quaternion_at(q, 0)
    a1 = to_material(q1, vector_at(system.force, 0))
    for i in range(n):
        q0, a0 = q1, a1
        q1 = quaternion_at(q, i + 1)
        a1 = to_material(q1, vector_at(system.force, i + 1))
        h, section = system.steps[i], section_of(system.elements[i])
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
            block = matadd(matadd(block, h00), matscale(-1.0, rotated_load_hessian(TANGENT, pull0)))
            reduced = add(reduced, g0)
            pivot, s_inverse = smallest_pivot_and_inverse(block)
            if smallest > 0.0:  # the first pivot that is not positive stays
                smallest = pivot if not pivot > smallest else smallest
            gain = matmul(s_inverse, h01)
            offset = matvec(s_inverse, reduced)
            decrement += dot(reduced, offset)
            for k in range(9):
                gains[i - 1, k] = gain[k]
            for k in range(3):
                offsets[i - 1, k] = offset[k]
            fill = matadd(fill, matscale(-1.0, matmul_t(h01, gain)))
            carried = scale(-1.0, matvec_t(h01, offset))
        gradient = g1
        reduced = add(carried, g1)
        block = matadd(matadd(fill, h11), matscale(-1.0, rotated_load_hessian(TANGENT, pull1)))
    moment = to_material(q1, vector_at(system.tip_moment.reshape(1, 3), 0))
    gradient = add(gradient, scale(-1.0, moment))
    residual = max(residual, largest_component(gradient))
    if not smallest > 0.0:
        return Pass(energy, residual, 0.0, smallest, 0)
    block, pivot, neutral = last_pivot(block, q1, scales, n * residual, shift, smallest)
    smallest = pivot if not pivot > smallest else smallest
    # A moment fixed in the base frame does circulatory work: its tangent is skew and enters only
    # the last block.
    reduced = add(reduced, scale(-1.0, moment))
    last = matvec(inverse(matadd(block, matscale(-0.5, skew(moment)))), reduced)
    for k in range(3):
        offsets[n - 1, k] = last[k]
    return Pass(energy, residual, decrement + dot(last, reduced), smallest, neutral)


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
