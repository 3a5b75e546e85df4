# SPDX-License-Identifier: Apache-2.0
"""One Newton pass: elements assembled, their forces condensed, nodes eliminated from base to tip.

Unknowns are a rotation and a displacement per node and a force per element. With D the element's
compliance to its force (and a little more, which keeps D positive where the rod is rigid), and r
the mismatch of its chord, the force's step is D^-1 (r + B dx); what is left of the element is
H + B^T D^-1 B between its two nodes. The blocks that the elimination divides by are the pivots of
the Hessian.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled
from spiral_core.rod.contact._element import SLOTS, VECTORS, element
from spiral_core.rod.contact._slots import Array

# Rows exchanged in a factorization.
Order: TypeAlias = NDArray[np.int64]


@compiled
def factor(block: Array, order: Order, exchange: bool) -> float:
    """Replace a square block by its LU factors and return the smallest pivot.

    Without ``exchange`` of rows the elimination stops at a pivot that is not positive.
    """
    smallest: float = np.inf
    size = block.shape[0]
    for k in range(size):
        best = k
        if exchange:
            for i in range(k + 1, size):
                if abs(block[i, k]) > abs(block[best, k]):
                    best = i
            for j in range(size):
                block[k, j], block[best, j] = block[best, j], block[k, j]
        order[k] = best
        pivot: float = abs(block[k, k]) if exchange else block[k, k]
        if not pivot > 0.0:
            return pivot
        smallest = min(smallest, pivot)
        for i in range(k + 1, size):
            ratio = block[i, k] / block[k, k]
            block[i, k] = ratio
            for j in range(k + 1, size):
                block[i, j] -= ratio * block[k, j]
    return smallest


@compiled
def solve_factored(block: Array, order: Order, rhs: Array) -> None:
    """Solve block x = rhs in place with the factors of :func:`factor`; rhs (size, m)."""
    size = block.shape[0]
    for c in range(rhs.shape[1]):
        for i in range(size):
            k = order[i]
            rhs[i, c], rhs[k, c] = rhs[k, c], rhs[i, c]
        for i in range(size):
            for k in range(i):
                rhs[i, c] -= block[i, k] * rhs[k, c]
        for i in range(size - 1, -1, -1):
            for k in range(i + 1, size):
                rhs[i, c] -= block[i, k] * rhs[k, c]
            rhs[i, c] /= block[i, i]


@compiled
def condense(
    hess: Array, mismatch: Array, compliance: float, unit: float, pull: Array, whole: Array
) -> float:
    """Eliminate an element's force: pull = D^-1 [B | r], whole = H + B^T D^-1 [B | r].

    ``pull`` (3, 13) and ``whole`` (12, 13) over rotation and displacement, in units of ``unit``, of
    both nodes; returns the smallest pivot of D.
    """
    inner = np.empty((3, 3))
    order = np.empty(3, np.int64)
    change = np.zeros((3, 12))
    for i in range(3):
        for k in range(3):
            inner[i, k] = -hess[6 + i, 6 + k] + (compliance if i == k else 0.0)
            change[i, k] = hess[6 + i, k]
            change[i, 6 + k] = hess[6 + i, 3 + k]
        change[i, 3 + i] = -unit
        change[i, 9 + i] = unit
        for k in range(12):
            pull[i, k] = change[i, k]
        pull[i, 12] = mismatch[i]
    pivot = factor(inner, order, False)
    if not pivot > 0.0:
        return pivot
    solve_factored(inner, order, pull)
    for i in range(12):
        for k in range(13):
            whole[i, k] = 0.0
            for j in range(3):
                whole[i, k] += change[j, i] * pull[j, k]
    for i in range(3):
        for k in range(3):
            whole[i, k] += hess[i, k]
            whole[i, 6 + k] += hess[i, 3 + k]
            whole[6 + i, k] += hess[3 + i, k]
            whole[6 + i, 6 + k] += hess[3 + i, 3 + k]
    return pivot


@compiled
def hold(system: Array, free: Array) -> None:
    """Keep the free motions F of an end in its rows [block | coupling | rhs] (6, 13).

    The block becomes F block F + s (1 - F) with s its largest diagonal entry.
    """
    scale = 0.0
    for i in range(6):
        scale = max(scale, abs(system[i, i]))
    row = np.empty(6)
    for i in range(6):
        for k in range(6):
            row[k] = 0.0
            for j in range(6):
                row[k] += system[i, j] * free[j, k]
        for k in range(6):
            system[i, k] = row[k]
    for k in range(13):
        for i in range(6):
            row[i] = 0.0
            for j in range(6):
                row[i] += free[i, j] * system[j, k]
        for i in range(6):
            system[i, k] = row[i]
            if k < 6:
                system[i, k] += scale * ((1.0 if i == k else 0.0) - free[i, k])


@compiled
def hold_columns(system: Array, free: Array) -> None:
    """Keep the free motions of the last node in its predecessor's coupling."""
    row = np.empty(6)
    for i in range(6):
        for k in range(6):
            row[k] = 0.0
            for j in range(6):
                row[k] += system[i, 6 + j] * free[j, k]
        for k in range(6):
            system[i, 6 + k] = row[k]


@compiled
def back_substitute(gains: Array, pulls: Array, unit: float, step: Array, force: Array) -> None:
    """Write the steps of nodes (N + 1, 6) and forces (N, 3) from the eliminated rows."""
    count = force.shape[0]
    for e in range(count - 1, -1, -1):
        for i in range(6):
            step[e, i] = -gains[e, i, 6]
            for k in range(6):
                step[e, i] -= gains[e, i, k] * step[e + 1, k]
        for i in range(3):
            force[e, i] = pulls[e, i, 12]
            for k in range(6):
                force[e, i] += pulls[e, i, k] * step[e, k] + pulls[e, i, 6 + k] * step[e + 1, k]
    for e in range(count + 1):
        for i in range(3, 6):
            step[e, i] *= unit


@compiled
def newton_pass(
    q: Array,
    p: Array,
    n: Array,
    half: Array,
    own: Array,
    compliance: Array,
    nodal: Array,
    tangent: Array,
    end_free: Array,
    unit: float,
    exchange: bool,
    step: Array,
    force: Array,
    gradient: Array,
    chord: Array,
    moments: Array,
) -> tuple[float, float]:
    """Assemble at (q, p, n) and solve for a Newton step; return energy [J] and smallest pivot.

    Args:
        q: (N + 1, 4) orientations.
        p: (N + 1, 3) positions [m].
        n: (N, 3) mean forces [N].
        half: (N, 3) half the load of each element [N].
        own: (N, 5, 3, 3) elements.
        compliance: (N,) added to the elements' own [m/N].
        nodal: (N + 1, 6) gradient added at the nodes.
        tangent: (N + 1, 6, 6) Hessian added at the nodes.
        end_free: (2, 6, 6) projections onto the ends' free motions.
        unit: length in whose units displacements are eliminated [m].
        exchange: whether rows may be exchanged in a block: for a system that is not symmetric.
        step: (N + 1, 6) result: rotation in the material frame and displacement.
        force: (N, 3) result: change of n.
        gradient: (N + 1, 6) result, before the ends are held.
        chord: (N, 3) result: mismatch of the chords [m].
        moments: (N + 1, 3) result: internal moment in the material frame [N m].
    """
    count = n.shape[0]
    slots, vectors, room = np.zeros((SLOTS, 3, 3)), np.zeros((VECTORS, 3)), np.zeros((3, 9, 9))
    g, hess = np.zeros(9), np.zeros((9, 9))
    pulls, gains = np.empty((count, 3, 13)), np.empty((count, 6, 7))
    whole, system = np.zeros((12, 13)), np.zeros((6, 13))
    carried, block, last = np.zeros((6, 7)), np.empty((6, 6)), np.empty((6, 7))
    order = np.empty(6, np.int64)
    energy, smallest = 0.0, np.inf
    gradient[:, :] = nodal
    for e in range(count + 1):
        for i in range(6):
            weight = unit if i > 2 else 1.0
            for k in range(6):
                system[i, k] = carried[i, k]
                system[i, k] += tangent[e, i, k] * weight * (unit if k > 2 else 1.0)
                system[i, 6 + k] = 0.0
            system[i, 12] = carried[i, 6] + nodal[e, i] * weight
        if e < count:
            energy += element(q[e], q[e + 1], n[e], half[e], own[e], slots, vectors, room, g, hess)
            for i in range(3):
                before, after = n[e, i] + half[e, i], n[e, i] - half[e, i]
                energy += after * p[e + 1, i] - before * p[e, i]
                chord[e, i] = g[6 + i] + p[e + 1, i] - p[e, i]
                moments[e, i] = -g[i]
                moments[e + 1, i] = g[3 + i]
                gradient[e, i] += g[i]
                gradient[e, 3 + i] -= before
                gradient[e + 1, i] += g[3 + i]
                gradient[e + 1, 3 + i] += after
            pivot = condense(hess, chord[e], compliance[e], unit, pulls[e], whole)
            if not pivot > 0.0:
                return energy, pivot
            for i in range(3):
                whole[i, 12] += g[i]
                whole[3 + i, 12] -= unit * (n[e, i] + half[e, i])
                whole[6 + i, 12] += g[3 + i]
                whole[9 + i, 12] += unit * (n[e, i] - half[e, i])
            for i in range(6):
                for k in range(13):
                    system[i, k] += whole[i, k]
        if e == 0:
            hold(system, end_free[0])
        if e == count:
            hold(system, end_free[1])
        if e == count - 1:
            hold_columns(system, end_free[1])
        for i in range(6):
            for k in range(6):
                block[i, k] = system[i, k]
            for k in range(7):
                last[i, k] = system[i, 6 + k]
        pivot = factor(block, order, exchange)
        smallest = min(smallest, pivot)
        if not pivot > 0.0:
            return energy, pivot
        solve_factored(block, order, last)
        if e < count:
            gains[e] = last
            for i in range(6):
                for k in range(7):
                    carried[i, k] = whole[6 + i, 6 + k]
                    for j in range(6):
                        carried[i, k] -= system[j, 6 + i] * last[j, k]
    for i in range(6):
        step[count, i] = -last[i, 6]
    back_substitute(gains, pulls, unit, step, force)
    return energy, smallest
