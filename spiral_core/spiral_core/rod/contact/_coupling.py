# SPDX-License-Identifier: Apache-2.0
"""What a coupling of bending with stretch adds to an element, where a section has one.

The parts of the energy of :mod:`spiral_core.rod.contact._element` in which B is, and derivatives.
"""

from spiral_core.numerics.kernel import compiled

# fmt: off
from spiral_core.rod.contact._algebra import (  # isort: skip
    A0, A1, B0, BA0, BA1, BB0, BU, BY, COUPLING, SKEW_A0, SKEW_A1, SKEW_B, SKEW_U, SKEW_Y,
    SKEW_Z, TURN0, TURN1, UB, YB, G, J, P, Z, Array, multiply, skew,
)
# fmt: on

# Products (first, second, result), by stage.
COUPLED_FIRST = (
    (SKEW_U, COUPLING, UB), (COUPLING, SKEW_U, BU),
    (COUPLING, SKEW_A0, BA0), (COUPLING, SKEW_A1, BA1),
)  # fmt: skip
COUPLED_SECOND = ((COUPLING, SKEW_Y, BY), (SKEW_Y, COUPLING, YB))


@compiled
def couple_strains(slots: Array, vectors: Array) -> None:
    """Add what couples bending with stretch to G, J and A_i."""
    for job in range(len(COUPLED_FIRST)):
        multiply(slots, COUPLED_FIRST[job][0], COUPLED_FIRST[job][1], COUPLED_FIRST[job][2])
    for i in range(3):
        for k in range(3):
            turn = vectors[TURN0, k] + vectors[TURN1, k]
            vectors[G, i] -= 0.5 * slots[COUPLING, i, k] * turn
            for at in range(2):
                ba = slots[BA0 + at]
                slots[J, i, k] += 0.5 * (ba[i, k] - ba[k, i])
                slots[A0 + at, i, k] += 0.5 * (slots[UB, i, k] - slots[BU, i, k])


@compiled
def couple_hessian(h: float, slots: Array, vectors: Array, inner: Array) -> None:
    """Add what couples bending with stretch to the upper half of the inner Hessian."""
    square = h * h / 12.0
    skew(slots, SKEW_Z, vectors, Z)
    for job in range(len(COUPLED_SECOND)):
        multiply(slots, COUPLED_SECOND[job][0], COUPLED_SECOND[job][1], COUPLED_SECOND[job][2])
    for i in range(3):
        for k in range(3):
            bend = slots[BY, i, k] - slots[YB, i, k] + slots[SKEW_Z, i, k]
            for at in range(2):
                s = square * (1.0 - 2.0 * at)
                ba = slots[BA0 + at]
                inner[i, k] += s * (ba[i, k] + ba[k, i])
                inner[i, 3 + 3 * at + k] += (
                    0.5 * h * slots[COUPLING, i, k]
                    + s * (slots[UB, i, k] - 2.0 * slots[BU, i, k])
                    - 0.5 * bend
                )


@compiled
def couple_turns(h: float, slots: Array, vectors: Array, room: Array, hess: Array) -> None:
    """Add what turning b does to G, and to the work of b along what bending couples with it.

    With D the derivative of G by turns through b alone, and dG the rest of it by all unknowns,
    these are -(D^T P (dG + D / 2) - 2 k D^T du) and its transpose.
    """
    change, work = room[1], room[2]
    for at in range(2):
        skew(slots, SKEW_B, vectors, B0 + at)
        multiply(slots, COUPLING, SKEW_B, BB0 + at)
    for i in range(3):
        for j in range(9):
            half = -0.25 * slots[BB0 + j // 3, i, j % 3] if j < 6 else 0.0
            work[i, j] = half
            for k in range(3):
                work[i, j] += slots[J, i, k] * change[k, j]
                work[i, j] += slots[A0, i, k] * change[3 + k, j]
                work[i, j] += slots[A1, i, k] * change[6 + k, j]
    for at in range(2):
        s = h * h / 6.0 * (1.0 - 2.0 * at)
        for i in range(3):
            for j in range(9):
                work[3 + i, j] = s * change[i, j]
                for k in range(3):
                    work[3 + i, j] -= slots[P, i, k] * work[k, j]
        for i in range(3):
            for j in range(9):
                value = 0.0
                for k in range(3):
                    value -= 0.5 * slots[BB0 + at, k, i] * work[3 + k, j]
                hess[3 * at + i, j] += value
                hess[j, 3 * at + i] += value
