# SPDX-License-Identifier: Apache-2.0
"""The mixed rod element: its energy, gradient and Hessian in two rotations and its mean force.

Derived in ``docs/derivations/contact.md``. It is the element of ``docs/derivations/rod.md`` for any
symmetric stiffness K of twist and bending, any compliance C to the internal force, and any
coupling B of the two. With W the load on the element, the forces n_0 = n + W/2 and n_1 = n - W/2 at
its ends, a = R^T n, b = R^T W / h, c = K u*, v = t + C a - B^T (u - u*), m = Ku - c + mean of Ba:

    E = h (u.Ku / 2 - c.u) + h/2 (f_0 + f_1) + h^2/12 (f_0' - f_1') - h^3/24 G.K^-1 G,
    f = -(t + C a / 2 - B^T (u - u*)).a,   f' = v.(u x a + b),
    G = K'u - c' + u x m + mean of v x a - B (u x a + b)

E is the least energy over the paths between two orientations for a given force, up to O(h^5); its
derivative by n is the chord between the ends, reversed.

Small matrices live in slots of a workspace, and products are listed in tables: one compiled loop
instead of twenty copies of it, which would take long to compile.
"""

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._element import strain_factor
from spiral_core.rod.contact._coupling import couple_hessian, couple_strains, couple_turns

# fmt: off
from spiral_core.rod.contact._algebra import (  # isort: skip
    A0, A0T, A00, A01, A1, A1T, A11, ACB, AP0, AP1, B0, CB, COUPLING, CROSS0, CROSS1, CU, CY,
    E0, EU, FX, GX, INVERSE, JA0, JA1, JP, JPJ, JT, KY, LOAD0, LOAD1, PULL, R0, R1, RATE, REST,
    SKEW_A0, SKEW_A1, SKEW_B, SKEW_E, SKEW_M, SKEW_U, SKEW_V0, SKEW_Y, SLOPE, STRAIN0, STRAIN1,
    TANGENT, TURN0, TURN1, TX0, TX1, X0, X0T, X00, X01, X1, X1T, X11, XV, C, F, G, J, K, M, P,
    PLAIN, T, TRANSPOSED, U, X, Y, Z, Array, cross, multiply, product, rotation, skew, transpose,
)
# fmt: on

# Products (first, second, result), by stage.
FIRST = ((SKEW_U, K, J), (SKEW_A0, C, A0), (SKEW_A1, C, A1))
SECOND = (
    (JT, P, JP), (JP, J, JPJ), (K, SKEW_Y, KY), (C, SKEW_Y, CY), (C, SKEW_U, CU),
    (JP, A0, JA0), (JP, A1, JA1), (A0T, P, AP0), (AP0, A0, A00), (AP0, A1, A01),
    (A1T, P, AP1), (AP1, A1, A11), (F, X, FX), (T, X0, TX0), (T, X1, TX1),
    (X0T, TX0, X00), (X0T, TX1, X01), (X1T, TX1, X11),
)  # fmt: skip


@compiled
def relative_turn(q0: Array, q1: Array, h: float, x: Array, u: Array) -> tuple[float, ...]:
    """Write x = Im(conj(q0) q1) and the strain u; return w, then f, f' and f'' of its series."""
    x[0] = q0[3] * q1[0] - q0[0] * q1[3] - q0[1] * q1[2] + q0[2] * q1[1]
    x[1] = q0[3] * q1[1] + q0[0] * q1[2] - q0[1] * q1[3] - q0[2] * q1[0]
    x[2] = q0[3] * q1[2] - q0[0] * q1[1] + q0[1] * q1[0] - q0[2] * q1[3]
    w = q0[0] * q1[0] + q0[1] * q1[1] + q0[2] * q1[2] + q0[3] * q1[3]
    factor, first, second = strain_factor(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    for i in range(3):
        u[i] = 2.0 / h * factor * x[i]
    return w, factor, first, second


@compiled
def strains_and_loads(
    n: Array, half: Array, h: float, coupled: bool, slots: Array, vectors: Array
) -> float:
    """Write loads, moments, G, their matrices J and A_i, and y = h^3/12 K^-1 G; return E."""
    third, square = h * h * h / 12.0, h * h / 12.0
    u, m, g, y = vectors[U], vectors[M], vectors[G], vectors[Y]
    for i in range(3):
        for at in range(2):
            vectors[LOAD0 + at, i] = 0.0
            vectors[B0 + at, i] = 0.0
            for k in range(3):
                end = n[k] + (half[k] if at == 0 else -half[k])
                vectors[LOAD0 + at, i] += slots[R0 + at, k, i] * end
                vectors[B0 + at, i] += slots[R0 + at, k, i] * half[k] * 2.0 / h
    for i in range(3):
        m[i] = -vectors[REST, i]
        for at in range(2):
            vectors[STRAIN0 + at, i] = vectors[TANGENT, i]
        for k in range(3):
            m[i] += slots[K, i, k] * u[k]
            for at in range(2):
                vectors[STRAIN0 + at, i] += slots[C, i, k] * vectors[LOAD0 + at, k]
    if coupled:
        for i in range(3):
            for k in range(3):
                m[i] += 0.5 * slots[COUPLING, i, k] * (vectors[LOAD0, k] + vectors[LOAD1, k])
                vectors[STRAIN0, i] -= slots[COUPLING, k, i] * u[k]
                vectors[STRAIN1, i] -= slots[COUPLING, k, i] * u[k]
    for at in range(2):
        cross(vectors, LOAD0 + at, STRAIN0 + at, CROSS0 + at)
        cross(vectors, U, LOAD0 + at, TURN0 + at)
        for i in range(3):
            vectors[TURN0 + at, i] += vectors[B0 + at, i]
        skew(slots, SKEW_A0 + at, vectors, LOAD0 + at)
        skew(slots, SKEW_V0 + at, vectors, STRAIN0 + at)
    cross(vectors, U, M, G)
    skew(slots, SKEW_U, vectors, U)
    skew(slots, SKEW_M, vectors, M)
    for job in range(len(FIRST)):
        multiply(slots, FIRST[job][0], FIRST[job][1], FIRST[job][2])
    energy = 0.0
    for i in range(3):
        g[i] -= vectors[RATE, i] + 0.5 * (vectors[CROSS0, i] + vectors[CROSS1, i])
        for k in range(3):
            g[i] += slots[SLOPE, i, k] * u[k]
            slots[P, i, k] = third * slots[INVERSE, i, k]
            slots[J, i, k] += slots[SLOPE, i, k] - slots[SKEW_M, i, k]
            for at in range(2):
                a = slots[A0 + at]
                a[i, k] = 0.5 * (slots[SKEW_V0 + at, i, k] - a[i, k])
    if coupled:
        couple_strains(slots, vectors)
    for i in range(3):
        y[i] = slots[P, i, 0] * g[0] + slots[P, i, 1] * g[1] + slots[P, i, 2] * g[2]
        energy += 0.5 * h * (m[i] - vectors[REST, i]) * u[i] - 0.5 * y[i] * g[i]
        for at in range(2):
            sign = 1.0 - 2.0 * at
            a, v, b = vectors[LOAD0 + at, i], vectors[STRAIN0 + at, i], vectors[B0 + at, i]
            energy += sign * square * (u[i] * vectors[CROSS0 + at, i] + v * b)
            energy -= 0.25 * h * a * (v + vectors[TANGENT, i])
    return energy


@compiled
def first_derivatives(h: float, coupled: bool, slots: Array, vectors: Array) -> None:
    """Write the derivatives of E by u and by the loads a_0, a_1, and z = B^T y."""
    square = h * h / 12.0
    y = vectors[Y]
    for at in range(2):
        cross(vectors, STRAIN0 + at, U, E0 + at)
        sign = 1.0 - 2.0 * at
        for i in range(3):
            bent = vectors[E0 + at, i]
            moved = 0.0
            for k in range(3):
                bent += slots[C, i, k] * vectors[TURN0 + at, k]
                moved += slots[A0 + at, k, i] * y[k]
            vectors[E0 + at, i] = sign * square * bent - 0.5 * h * vectors[STRAIN0 + at, i] - moved
    for i in range(3):
        value = h * vectors[M, i] + square * (vectors[CROSS0, i] - vectors[CROSS1, i])
        for k in range(3):
            value -= slots[J, k, i] * y[k]
        vectors[EU, i], vectors[Z, i] = value, 0.0
    if coupled:
        for i in range(3):
            for k in range(3):
                turn = vectors[TURN0, k] - vectors[TURN1, k]
                vectors[EU, i] -= square * slots[COUPLING, i, k] * turn
                vectors[Z, i] += slots[COUPLING, k, i] * y[k]


@compiled
def chain(h: float, turn: tuple[float, ...], slots: Array, vectors: Array) -> None:
    """Write F = du/dx, dx by both rotations, and the second derivative T of u.dE/du by x."""
    w, factor, first, second = turn
    scale = 2.0 / h
    s = 2.0 * scale * first
    x, eu = vectors[XV], vectors[EU]
    along = eu[0] * x[0] + eu[1] * x[1] + eu[2] * x[2]
    skew(slots, X, vectors, XV)
    for i in range(3):
        vectors[GX, i] = scale * factor * eu[i] + s * along * x[i]
        for k in range(3):
            same = 1.0 if i == k else 0.0
            slots[F, i, k] = s * x[i] * x[k] + scale * factor * same
            slots[T, i, k] = (
                s * (eu[i] * x[k] + x[i] * eu[k])
                + 4.0 * scale * second * along * x[i] * x[k]
                + s * along * same
            )
            slots[X0, i, k] = 0.5 * (slots[X, i, k] - w * same)
            slots[X1, i, k] = 0.5 * (slots[X, i, k] + w * same)
    skew(slots, SKEW_Y, vectors, Y)
    transpose(slots, J, JT)
    transpose(slots, A0, A0T)
    transpose(slots, A1, A1T)
    transpose(slots, X0, X0T)
    transpose(slots, X1, X1T)
    for job in range(len(SECOND)):
        multiply(slots, SECOND[job][0], SECOND[job][1], SECOND[job][2])


@compiled
def inner_hessian(h: float, coupled: bool, slots: Array, vectors: Array, inner: Array) -> None:
    """Write the Hessian (9, 9) of E by (u, a_0, a_1)."""
    square = h * h / 12.0
    ky, cy, cu = slots[KY], slots[CY], slots[CU]
    for i in range(3):
        for k in range(3):
            inner[i, k] = h * slots[K, i, k] - slots[JPJ, i, k] - ky[i, k] - ky[k, i]
            inner[i, 3 + k] = -2.0 * square * slots[A0, i, k] - slots[JA0, i, k]
            inner[i, 6 + k] = 2.0 * square * slots[A1, i, k] - slots[JA1, i, k]
            common = 0.5 * (cy[i, k] + cy[k, i]) - 0.5 * h * slots[C, i, k]
            bent = square * (cu[i, k] + cu[k, i])
            inner[3 + i, 3 + k] = common + bent - slots[A00, i, k]
            inner[6 + i, 6 + k] = common - bent - slots[A11, i, k]
            inner[3 + i, 6 + k] = -slots[A01, i, k]
    if coupled:
        couple_hessian(h, slots, vectors, inner)
    for i in range(9):
        for k in range(i):
            inner[i, k] = inner[k, i]


@compiled
def outer_map(w: float, slots: Array, change: Array) -> None:
    """Write the derivative (9, 9) of (u, a_0, a_1) by (eta_0, eta_1, n)."""
    for i in range(9):
        for k in range(9):
            change[i, k] = 0.0
    for i in range(3):
        for k in range(3):
            change[i, k] = 0.5 * (slots[FX, i, k] - w * slots[F, i, k])
            change[i, 3 + k] = 0.5 * (slots[FX, i, k] + w * slots[F, i, k])
            for at in range(2):
                change[3 + 3 * at + i, 3 * at + k] = slots[SKEW_A0 + at, i, k]
                change[3 + 3 * at + i, 6 + k] = slots[R0 + at, k, i]


@compiled
def turned_load(at: int, k: float, slots: Array, vectors: Array, g: Array, hess: Array) -> None:
    """Add what turning a node does to a and b: their second derivatives, and b's first.

    ``k`` is h^2/12 at the first node and -h^2/12 at the second: E holds (k v + z / 2).b.
    """
    e, a = vectors[E0 + at], vectors[LOAD0 + at]
    v, b = vectors[PULL], vectors[B0 + at]
    for i in range(3):
        v[i] = k * vectors[STRAIN0 + at, i] + 0.5 * vectors[Z, i]
    skew(slots, SKEW_B, vectors, B0 + at)
    skew(slots, SKEW_E, vectors, E0 + at)
    multiply(slots, C, SKEW_B, CB)
    multiply(slots, SKEW_A0 + at, CB, ACB)
    down = 0.0
    for i in range(3):
        down += e[i] * a[i] + v[i] * b[i]
    for i in range(3):
        j, l = (i + 1) % 3, (i + 2) % 3  # noqa: E741
        g[3 * at + i] += v[j] * b[l] - v[l] * b[j]
        for m in range(3):
            twice = e[i] * a[m] + a[i] * e[m] + v[i] * b[m] + b[i] * v[m]
            # [a]^T = -[a]
            both = slots[ACB, i, m] + slots[ACB, m, i]
            hess[3 * at + i, 3 * at + m] += 0.5 * twice - k * both - (down if i == m else 0.0)
            mixed = 0.0
            for p in range(3):
                turn = slots[R0 + at, m, p]
                mixed += turn * (slots[SKEW_E, i, p] + k * slots[CB, p, i])
            hess[3 * at + i, 6 + m] += mixed


@compiled
def element(
    q0: Array,
    q1: Array,
    n: Array,
    half: Array,
    own: Array,
    slots: Array,
    vectors: Array,
    room: Array,
    g: Array,
    hess: Array,
) -> float:
    """Write gradient (9,) and Hessian (9, 9) by (eta_0, eta_1, n) of an element; return its energy.

    ``half`` is half the load on it [N]; ``own`` (7, 3, 3) holds K, K', K^-1, C, rows c, c' and
    (h, 0, 0), B, and the row B^T u*; ``slots``, ``vectors`` and ``room`` (3, 9, 9) are workspace.
    """
    h, coupled = own[4, 2, 0], own[5, 0, 0] != 0.0
    for i in range(3):
        for k in range(3):
            for slot in range(4):
                slots[slot, i, k] = own[slot, i, k]
            slots[COUPLING, i, k] = own[5, i, k]
            coupled = coupled or own[5, i, k] != 0.0
        vectors[REST, i] = own[4, 0, i]
        vectors[RATE, i] = own[4, 1, i]
        vectors[TANGENT, i] = own[6, 0, i] + (1.0 if i == 0 else 0.0)
    rotation(q0, slots[R0])
    rotation(q1, slots[R1])
    turn = relative_turn(q0, q1, h, vectors[XV], vectors[U])
    energy = strains_and_loads(n, half, h, coupled, slots, vectors)
    first_derivatives(h, coupled, slots, vectors)
    chain(h, turn, slots, vectors)
    inner_hessian(h, coupled, slots, vectors, room[0])
    outer_map(turn[0], slots, room[1])
    product(room[0], room[1], PLAIN, room[2])
    product(room[1], room[2], TRANSPOSED, hess)
    x, gx = vectors[XV], vectors[GX]
    down = 0.25 * (gx[0] * x[0] + gx[1] * x[1] + gx[2] * x[2])
    for i in range(9):
        g[i] = 0.0
        for k in range(9):
            g[i] += room[1][k, i] * vectors[EU + k // 3, k % 3]
    skew(slots, SKEW_B, vectors, GX)
    for i in range(3):
        for k in range(3):
            same = down if i == k else 0.0
            hess[i, k] += slots[X00, i, k] - same
            hess[3 + i, 3 + k] += slots[X11, i, k] - same
            twist = turn[0] * slots[SKEW_B, i, k] + gx[i] * x[k] + x[i] * gx[k]
            hess[i, 3 + k] += slots[X01, i, k] + 0.25 * twist - same
    for at in range(2):
        turned_load(at, (1.0 - 2.0 * at) * h * h / 12.0, slots, vectors, g, hess)
    if coupled:
        couple_turns(h, slots, vectors, room, hess)
    for i in range(9):
        for k in range(i):
            hess[i, k] = hess[k, i]
    return energy
