# SPDX-License-Identifier: Apache-2.0
"""One Newton pass: elements assembled, their forces condensed, nodes eliminated from base to tip.

Unknowns are a rotation and a displacement per node and a force per element. With D the element's
compliance to its force (and a little more, which keeps D positive where the rod is rigid), and r
the mismatch of its chord, the force's step is D^-1 (r + B dx); what is left of the element is
H + B^T D^-1 B between its two nodes. The blocks that the elimination divides by are the pivots of
the Hessian.
"""

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod.contact._algebra import SLOTS, VECTORS, Array, numbers
from spiral_core.rod.contact._element import element

# Where the columns of an eliminated node and of the next one begin.
HERE, NEXT = numbers(0, 7)[::6]


@compiled
def assemble(
    q: Array,
    p: Array,
    n: Array,
    half: Array,
    own: Array,
    hessians: Array,
    gradients: Array,
    chord: Array,
    moments: Array,
) -> float:
    """Write the elements at (q, p, n); return their energy and that of their load [J].

    Args:
        q: (N + 1, 4) orientations.
        p: (N + 1, 3) positions [m].
        n: (N, 3) mean forces [N].
        half: (N, 3) half the load of each element [N].
        own: (N, 7, 3, 3) elements.
        hessians: (N, 9, 9) result, by rotations and force.
        gradients: (N, 9) result.
        chord: (N, 3) result: mismatch of the chords [m].
        moments: (N + 1, 3) result: internal moment in the material frame [N m].
    """
    slots, vectors, room = np.zeros((SLOTS, 3, 3)), np.zeros((VECTORS, 3)), np.zeros((3, 9, 9))
    energy = 0.0
    for e in range(n.shape[0]):
        g = gradients[e]
        energy += element(
            q[e], q[e + 1], n[e], half[e], own[e], slots, vectors, room, g, hessians[e]
        )
        for i in range(3):
            before, after = n[e, i] + half[e, i], n[e, i] - half[e, i]
            energy += after * p[e + 1, i] - before * p[e, i]
            chord[e, i] = g[6 + i] + p[e + 1, i] - p[e, i]
            moments[e, i] = -g[i]
            moments[e + 1, i] = g[3 + i]
    return energy


@compiled
def factor(block: Array, order: Array, exchange: bool) -> float:
    """Replace a block (6, 6) by its LU factors and return the smallest pivot.

    Without ``exchange`` of rows the elimination stops at a pivot that is not positive.
    """
    smallest: float = np.inf
    for k in range(6):
        best = k
        if exchange:
            for i in range(k + 1, 6):
                if abs(block[i, k]) > abs(block[best, k]):
                    best = i
            for j in range(6):
                block[k, j], block[best, j] = block[best, j], block[k, j]
        order[k] = best
        pivot: float = abs(block[k, k]) if exchange else block[k, k]
        if not pivot > 0.0:
            return pivot
        smallest = min(smallest, pivot)
        for i in range(k + 1, 6):
            block[i, k] /= block[k, k]
            for j in range(k + 1, 6):
                block[i, j] -= block[i, k] * block[k, j]
    return smallest


@compiled
def solve_factored(block: Array, order: Array, rhs: Array) -> None:
    """Solve block x = rhs (6, 7) in place with the factors of :func:`factor`."""
    for i in range(6):
        k = int(order[i])
        for c in range(7):
            rhs[i, c], rhs[k, c] = rhs[k, c], rhs[i, c]
    for i in range(6):
        for k in range(i):
            for c in range(7):
                rhs[i, c] -= block[i, k] * rhs[k, c]
    for j in range(6):
        i = 5 - j
        for k in range(i + 1, 6):
            for c in range(7):
                rhs[i, c] -= block[i, k] * rhs[k, c]
        for c in range(7):
            rhs[i, c] /= block[i, i]


@compiled
def condense(
    hess: Array, mismatch: Array, compliance: float, unit: float, pull: Array, whole: Array
) -> float:
    """Eliminate an element's force: pull = D^-1 [B | r], whole = H + B^T D^-1 [B | r].

    ``pull`` (3, 13) and ``whole`` (12, 13) over rotation and displacement, in units of ``unit``, of
    both nodes. By a displacement B is the negative unit matrix at the first node, the unit one at
    the second. The sign that is returned is positive if D is.
    """
    a: float = compliance - hess[6, 6]
    b, c = -hess[7, 6], -hess[8, 6]
    d, e, f = compliance - hess[7, 7], -hess[8, 7], compliance - hess[8, 8]
    minor = a * d - b * b
    det = f * minor - e * (a * e - b * c) + c * (b * e - c * d)
    if not (a > 0.0 and minor > 0.0 and det > 0.0):
        return -1.0
    for i in range(3):
        x = (d * f - e * e, c * e - b * f, b * e - c * d)[i] / det
        y = (c * e - b * f, a * f - c * c, b * c - a * e)[i] / det
        z = (b * e - c * d, b * c - a * e, minor)[i] / det
        for k in range(3):
            pull[i, k] = x * hess[6, k] + y * hess[7, k] + z * hess[8, k]
            pull[i, 6 + k] = x * hess[6, 3 + k] + y * hess[7, 3 + k] + z * hess[8, 3 + k]
        pull[i, 9], pull[i, 10], pull[i, 11] = unit * x, unit * y, unit * z
        pull[i, 3], pull[i, 4], pull[i, 5] = -unit * x, -unit * y, -unit * z
        pull[i, 12] = x * mismatch[0] + y * mismatch[1] + z * mismatch[2]
    for i in range(3):
        for k in range(13):
            whole[3 + i, k] = -unit * pull[i, k]
            whole[9 + i, k] = unit * pull[i, k]
            whole[i, k] = 0.0
            whole[6 + i, k] = 0.0
            for j in range(3):
                whole[i, k] += hess[6 + j, i] * pull[j, k]
                whole[6 + i, k] += hess[6 + j, 3 + i] * pull[j, k]
        for k in range(3):
            whole[i, k] += hess[i, k]
            whole[i, 6 + k] += hess[i, 3 + k]
            whole[6 + i, k] += hess[3 + i, k]
            whole[6 + i, 6 + k] += hess[3 + i, 3 + k]
    return 1.0


@compiled
def hold_columns(system: Array, first: int, free: Array) -> None:
    """Keep the free motions of a node in six columns."""
    for i in range(6):
        row = np.zeros(6)
        for j in range(6):
            for k in range(6):
                row[k] += system[i, first + j] * free[j, k]
        for k in range(6):
            system[i, first + k] = row[k]


@compiled
def hold(system: Array, free: Array) -> None:
    """Keep the free motions F of an end in its rows [block | coupling | rhs] (6, 13).

    The block becomes F block F + s (1 - F) with s its largest diagonal entry.
    """
    scale = 0.0
    for i in range(6):
        scale = max(scale, abs(system[i, i]))
    hold_columns(system, HERE, free)
    row = np.empty(6)
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
def eliminate(
    hessians: Array,
    gradients: Array,
    n: Array,
    half: Array,
    chord: Array,
    compliance: Array,
    nodal: Array,
    tangent: Array,
    end_free: Array,
    unit: float,
    exchange: bool,
    step: Array,
    force: Array,
    gradient: Array,
) -> float:
    """Solve for a Newton step from what :func:`assemble` wrote; return the smallest pivot.

    Args:
        hessians: (N, 9, 9) of the elements.
        gradients: (N, 9) likewise.
        n: (N, 3) mean forces [N].
        half: (N, 3) half the load of each element [N].
        chord: (N, 3) mismatch [m].
        compliance: (N,) added to the elements' own [m/N].
        nodal: (N + 1, 6) gradient added at the nodes.
        tangent: (N + 1, 6, 6) Hessian added at the nodes.
        end_free: (2, 6, 6) projections onto the ends' free motions.
        unit: length in whose units displacements are eliminated [m].
        exchange: whether rows may be exchanged in a block: for a system that is not symmetric.
        step: (N + 1, 6) result: rotation in the material frame and displacement.
        force: (N, 3) result: change of n.
        gradient: (N + 1, 6) result, before the ends are held.
    """
    count = n.shape[0]
    pulls, gains = np.empty((count, 3, 13)), np.empty((count, 6, 7))
    whole, system = np.zeros((12, 13)), np.zeros((6, 13))
    carried, block, last = np.zeros((6, 7)), np.empty((6, 6)), np.empty((6, 7))
    order = np.empty(6)
    smallest = np.inf
    # One by one: numba's assignment of arrays takes seconds to compile.
    for e in range(count + 1):
        for i in range(6):
            gradient[e, i] = nodal[e, i]
    for e in range(count + 1):
        for i in range(6):
            weight = unit if i > 2 else 1.0
            for k in range(6):
                system[i, k] = carried[i, k]
                system[i, k] += tangent[e, i, k] * weight * (unit if k > 2 else 1.0)
                system[i, 6 + k] = 0.0
            system[i, 12] = carried[i, 6] + nodal[e, i] * weight
        if e < count:
            pivot = condense(hessians[e], chord[e], compliance[e], unit, pulls[e], whole)
            if not pivot > 0.0:
                return pivot
            for i in range(3):
                before, after = n[e, i] + half[e, i], n[e, i] - half[e, i]
                turn, end = gradients[e, i], gradients[e, 3 + i]
                gradient[e, i] += turn
                gradient[e, 3 + i] -= before
                gradient[e + 1, i] += end
                gradient[e + 1, 3 + i] += after
                whole[i, 12] += turn
                whole[3 + i, 12] -= unit * before
                whole[6 + i, 12] += end
                whole[9 + i, 12] += unit * after
            for i in range(6):
                for k in range(13):
                    system[i, k] += whole[i, k]
        if e == 0:
            hold(system, end_free[0])
        if e == count:
            hold(system, end_free[1])
        if e == count - 1:
            hold_columns(system, NEXT, end_free[1])
        for i in range(6):
            for k in range(6):
                block[i, k] = system[i, k]
            for k in range(7):
                last[i, k] = system[i, 6 + k]
        pivot = factor(block, order, exchange)
        smallest = min(smallest, pivot)
        if not pivot > 0.0:
            return pivot
        solve_factored(block, order, last)
        if e < count:
            for i in range(6):
                for k in range(7):
                    gains[e, i, k] = last[i, k]
                    carried[i, k] = whole[6 + i, 6 + k]
                for j in range(6):
                    for k in range(7):
                        carried[i, k] -= system[j, 6 + i] * last[j, k]
    for i in range(6):
        step[count, i] = -last[i, 6]
    back_substitute(gains, pulls, unit, step, force)
    return smallest


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
    """Assemble and eliminate, with their arguments; return the energy [J] and the pivot."""
    hessians, gradients = np.empty((len(n), 9, 9)), np.empty((len(n), 9))
    energy = assemble(q, p, n, half, own, hessians, gradients, chord, moments)
    pivot = eliminate(
        hessians, gradients, n, half, chord, compliance, nodal, tangent, end_free, unit, exchange,
        step, force, gradient,
    )  # fmt: skip
    return energy, pivot
