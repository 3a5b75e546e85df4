# SPDX-License-Identifier: Apache-2.0
"""What the derivatives of a state are assembled from (compiled).

Derived in ``docs/derivations/derivatives.md``; its symbols are used here. A change is a row of
numbers, in the order of ``COMPONENTS`` of :mod:`spiral_core.rod.derivatives`. Both ways are
differences: what is of second order in a change cancels.
"""

import math

import numpy as np

from spiral_core.numerics.kernel import compiled, inlined
from spiral_core.rod._algebra import (
    Array,
    Mat,
    add,
    add_vector,
    cross,
    diagonal,
    dot,
    inverse,
    matmul,
    matscale,
    matvec,
    matvec_t,
    put_vector,
    quaternion_at,
    scale,
    subtract,
    turn_nodes,
    vector_at,
    vector_from,
)
from spiral_core.rod._element import Elements, stiffness_at
from spiral_core.rod._newton import back_substitute, newton_pass, scales_of
from spiral_core.rod._system import System, discrete_strain_scale, shape_from_orientations
from spiral_core.rod.contact._contact import Iterate
from spiral_core.rod.contact._element import Elements as MixedElements
from spiral_core.rod.contact._element import Section, mixed_element
from spiral_core.rod.contact._element import section_at as mixed_section_at

# Strain and its slope, from a moment's mean and slope: their product is left out first.
SLOPE_ROUNDS = 4


@inlined
def changed_section(given: Section, change: Array) -> Section:
    """Return an element's section after a change of rest strain, moduli and length."""
    per = 1.0 / (1.0 + change[12])
    a, b, c = scale(0.5, vector_from(change, 6))
    stiff, loose = diagonal(1.0 + a, 1.0 + b, 1.0 + c), diagonal(1.0 - a, 1.0 - b, 1.0 - c)
    a, b, c = scale(-0.5, vector_from(change, 9))
    soft = diagonal(1.0 + a, 1.0 + b, 1.0 + c)
    back = inverse(given.stiffness)
    # Linear in an element, stiffness and strain have a moment of mean K u + h^2 K' u' / 12.
    square, growth = given.step * given.step / 12.0, (0.0, 0.0, 0.0)
    before = growth
    for _ in range(SLOPE_ROUNDS):
        of_slopes = scale(square, matvec(given.stiffness_slope, growth))
        before = matvec(back, subtract(given.rest, of_slopes))
        growth = matvec(back, subtract(given.rest_slope, matvec(given.stiffness_slope, before)))
    seen = scale(1.0 / discrete_strain_scale(given.step * math.sqrt(dot(before, before))), before)
    seen = add(seen, vector_from(change, 3))
    seen = scale(discrete_strain_scale(given.step / per * math.sqrt(dot(seen, seen))), seen)
    stiffness = matmul(stiff, matmul(given.stiffness, stiff))
    slope = matscale(per, matmul(stiff, matmul(given.stiffness_slope, stiff)))
    coupling = matmul(stiff, matmul(given.coupling, soft))
    return Section(
        given.step / per,
        stiffness,
        slope,
        matmul(loose, matmul(given.flexibility, loose)),
        matmul(soft, matmul(given.compliance, soft)),
        coupling,
        add(matvec(stiffness, seen), scale(square / per, matvec(slope, growth))),
        add(matvec(slope, seen), scale(per, matvec(stiffness, growth))),
        matvec_t(coupling, seen),
    )


@compiled
def element_columns(x: Iterate, elements: MixedElements, changes: Array) -> Array:
    """Return half the differences (k, N, 9) of mixed elements' gradients by changes (k, n)."""
    columns = np.zeros((len(changes), len(x.n), 9))
    for k in range(len(changes)):
        for side in range(2 if np.any(changes[k, :13]) else 0):
            sign = 1.0 - 2.0 * side
            change = sign * changes[k]
            for e in range(len(x.n)):
                section = mixed_section_at(elements, e)
                load = scale(1.0 + change[12], vector_at(elements.half_load, e))
                load = add(load, scale(0.5 * section.step, vector_from(change, 0)))
                q0, q1, n = quaternion_at(x.q, e), quaternion_at(x.q, e + 1), vector_at(x.n, e)
                d = mixed_element(q0, q1, n, load, changed_section(section, change))
                add_vector(columns[k, e], 0, scale(0.5 * sign, d.g0))
                add_vector(columns[k, e], 3, scale(0.5 * sign, d.g1))
                add_vector(columns[k, e], 6, scale(0.5 * sign, d.gn))
    return columns


@compiled
def band_of(places: Array, hessians: Array, tangents: Array, width: int, size: int) -> Array:
    """Return the system of all unknowns as LAPACK's band (3 w + 1, size), w diagonals each side.

    A node's unknowns begin at ``places`` (N + 1,): rotation, displacement, its contacts' forces,
    the mean force of the element behind it.
    """
    band, middle = np.zeros((size, 3 * width + 1)), 2 * width
    for e in range(len(places)):
        here = places[e]
        for i in range(here, here + 6):
            for k in range(here, here + 6):
                band[k, middle + i - k] += tangents[e, i - here, k - here]
        if e == len(hessians):
            break
        there = places[e + 1]
        index = (here, there, there - 3)
        for i in range(9):
            row = index[i // 3] + i % 3
            for k in range(9):
                column = index[k // 3] + k % 3
                band[column, middle + row - column] += hessians[e, i, k]
        for row in range(there - 3, there):  # the chord ends at the next node
            for end, sign in ((row + here - there + 6, -1.0), (row + 6, 1.0)):
                band[end, middle + row - end] += sign
                band[row, middle + end - row] += sign
    return band.T


@inlined
def full(rows: Array, e: int) -> Mat:
    """Return the stiffness of a free rod's element as a matrix."""
    k = stiffness_at(rows, e)
    return ((k.twist, 0.0, k.both), (0.0, k.y, 0.0), (k.both, 0.0, k.z))


@compiled
def changed_system(given: System, change: Array) -> System:
    """Return a free rod's system after a change, seen from the base as that turns."""
    n, ratio, beyond = len(given.steps), 1.0 + change[12], 0.0
    back, more = scale(-1.0, vector_from(change, 22)), vector_from(change, 0)
    tip, rows = vector_at(given.force, n), given.elements
    force, start, end = np.empty((n + 1, 3)), np.empty((n, 3)), np.empty((n, 3))
    stiffness, slopes, none = np.empty((n, 4)), np.empty((n, 4)), diagonal(0.0, 0.0, 0.0)
    rest, rest_slopes, moment = np.empty((n, 3)), np.empty((n, 3)), np.empty(3)
    for i in range(n, -1, -1):
        load = add(subtract(vector_at(given.force, i), tip), scale(beyond, more))
        load = add(scale(ratio, load), add(tip, vector_from(change, 13)))
        put_vector(force[i], 0, add(load, cross(back, load)))
        if i > 0:
            beyond += given.steps[i - 1]
    for e in range(n):
        for before, after in ((given.load_start, start), (given.load_end, end)):
            load = add(vector_at(before, e), more)
            put_vector(after[e], 0, add(load, cross(back, load)))
        k, slope = full(rows.stiffness, e), full(rows.stiffness_slope, e)
        strain, growth = vector_at(rows.rest, e), vector_at(rows.rest_slope, e)
        section = Section(given.steps[e], k, slope, none, none, none, strain, growth, strain)
        section = changed_section(section, change)
        put_vector(rest[e], 0, section.rest)
        put_vector(rest_slopes[e], 0, section.rest_slope)
        for i, (row, column) in enumerate(((0, 0), (1, 1), (2, 2), (0, 2))):
            stiffness[e, i] = section.stiffness[row][column]
            slopes[e, i] = section.stiffness_slope[row][column]
    load = add(vector_from(given.tip_moment, 0), vector_from(change, 16))
    put_vector(moment, 0, add(load, cross(back, load)))
    return System(
        force, start, end, moment, Elements(stiffness, rest, slopes, rest_slopes),
        ratio * given.steps, given.node_stiffness, given.node_rest, 0.0,
    )  # fmt: skip


@compiled
def free_differences(q: Array, given: System, changes: Array) -> tuple[Array, Array, Array]:
    """Return half the differences by changes (k, 25) of a free rod at rest, after a Newton step.

    Returns:
        Rotations (k, N + 1, 3) of the nodes in their frames [rad], positions (k, N + 1, 3) [m], and
        force and moment at the base (k, 6) [N, N m], all seen from the base.
    """
    n, count = len(given.steps), len(changes)
    gains, offsets, turned = np.empty((n - 1, 3, 3)), np.empty((n, 3)), q.copy()
    turns, moved = np.zeros((count, n + 1, 3)), np.zeros((count, n + 1, 3))
    base = np.zeros((count, 6))
    for k in range(count):
        for side in range(2):
            half = 0.5 - side
            system = changed_system(given, 2.0 * half * changes[k])
            newton_pass(q, system, 0.0, scales_of(system), gains, offsets)
            step = np.empty((n, 3))
            back_substitute(gains, offsets, step)
            turn_nodes(q, step, 1.0, turned)
            positions, moments, _, _ = shape_from_orientations(turned, system)
            turns[k, 1:] += half * step
            moved[k] += half * positions
            add_vector(base[k], 0, scale(half, vector_at(system.force, 0)))
            add_vector(base[k], 3, scale(half, vector_at(moments, 0)))
    return turns, moved, base
