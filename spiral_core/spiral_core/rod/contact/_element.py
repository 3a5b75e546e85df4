# SPDX-License-Identifier: Apache-2.0
"""The mixed rod element: its energy, gradient and Hessian in two rotations and its mean force.

Derived in ``docs/derivations/contact.md``, section 1; its symbols are used here. It is the element
of ``docs/derivations/rod.md`` for any symmetric stiffness K of twist and bending, any compliance C
to the internal force, and any coupling B of the two. With W the load on the element, the forces
n_0 = n + W/2 and n_1 = n - W/2 at its ends, a = R^T n, b = R^T W / h, c = K u*, v = t + C a -
B^T (u - u*), m = Ku - c + mean of Ba:

    E = h (u.Ku / 2 - c.u) + h/2 (f_0 + f_1) + h^2/12 (f_0' - f_1') - h^3/24 G.K^-1 G,
    f = -(t + C a / 2 - B^T (u - u*)).a,   f' = v.(u x a + b),
    G = K'u - c' + u x m + mean of v x a - B (u x a + b)

E is the least energy over the paths between two orientations for a given force, up to O(h^5); its
derivative by n is the chord between the ends, reversed.

The derivatives are those stated there: ``[v]`` is the matrix of x -> v x x, P = h^3/12 K^-1, y =
P G, and k = h^2/12 at the first end, -h^2/12 at the second, is the weight of f'.
"""

from typing import NamedTuple

from spiral_core.numerics.kernel import inlined
from spiral_core.rod._algebra import (
    TANGENT,
    Array,
    Mat,
    Quat,
    Vec,
    add,
    cross,
    dot,
    matadd,
    matmul,
    matmul_skew,
    matmul_t,
    matrix_at,
    matscale,
    matsubtract,
    matvec,
    matvec_t,
    scale,
    skew,
    skew_matmul,
    subtract,
    to_material_matrix,
    transpose,
    vector_at,
    with_transpose,
)
from spiral_core.rod._element import (
    Turn,
    element_frame,
    frame_derivatives,
    pushed_back,
    rotated_load_hessian,
    rotation_derivatives,
)


class Elements(NamedTuple):
    """The N elements of a rod, and the load on each.

    Attributes:
        steps: (N,) lengths h [m].
        stiffness: (N, 3, 3) mean K [N m^2].
        stiffness_slope: (N, 3, 3) its derivative K' along the rod [N m].
        flexibility: (N, 3, 3) K^-1 of what bends inside of an element [1/(N m^2)].
        compliance: (N, 3, 3) mean C [1/N].
        coupling: (N, 3, 3) mean B [m].
        rest: (N, 3) mean rest moment c [N m].
        rest_slope: (N, 3) its derivative c' [N].
        rest_stretch: (N, 3) mean B^T u*.
        half_load: (N, 3) W/2 in the base frame [N].
    """

    steps: Array
    stiffness: Array
    stiffness_slope: Array
    flexibility: Array
    compliance: Array
    coupling: Array
    rest: Array
    rest_slope: Array
    rest_stretch: Array
    half_load: Array


class Section(NamedTuple):
    """One of the :class:`Elements`, less its load."""

    step: float
    stiffness: Mat
    stiffness_slope: Mat
    flexibility: Mat
    compliance: Mat
    coupling: Mat
    rest: Vec
    rest_slope: Vec
    rest_stretch: Vec


class End(NamedTuple):
    """One end of an element, in its node's material frame.

    Attributes:
        frame: R^T.
        weight: k, of f' here.
        a: internal force [N].
        b: load per length [N/m].
        v: how the section moves per length.
        bent: u x a + b.
    """

    frame: Mat
    weight: float
    a: Vec
    b: Vec
    v: Vec
    bent: Vec


class EndSlopes(NamedTuple):
    """Derivatives at one end.

    Attributes:
        e_a, e_b: of E by a and b.
        g_a: of G by a.
        e_ua: second, of E by u and a, with G held.
        e_aa: second, of E by a, likewise.
    """

    e_a: Vec
    e_b: Vec
    g_a: Mat
    e_ua: Mat
    e_aa: Mat


class NodeSlopes(NamedTuple):
    """Derivatives by the rotation eta of one node; of E with G held.

    Attributes:
        e: of E but for the element's turn.
        g: of G.
        own: second, of E by eta, likewise.
        other: second, of E by the other node's rotation and this one, likewise.
        e_n: second, of E by eta and n.
    """

    e: Vec
    g: Mat
    own: Mat
    other: Mat
    e_n: Mat


class Derivatives(NamedTuple):
    """Energy of an element, its gradient and the upper half of its Hessian.

    By the rotations eta_0, eta_1 of its nodes in their material frames, and its mean force n.
    """

    energy: float
    g0: Vec
    g1: Vec
    gn: Vec
    h00: Mat
    h01: Mat
    h0n: Mat
    h11: Mat
    h1n: Mat
    hnn: Mat


@inlined
def section_at(elements: Elements, e: int) -> Section:
    """Return one of the elements."""
    return Section(
        elements.steps[e],
        matrix_at(elements.stiffness, e),
        matrix_at(elements.stiffness_slope, e),
        matrix_at(elements.flexibility, e),
        matrix_at(elements.compliance, e),
        matrix_at(elements.coupling, e),
        vector_at(elements.rest, e),
        vector_at(elements.rest_slope, e),
        vector_at(elements.rest_stretch, e),
    )


@inlined
def end_of(q: Quat, n: Vec, load: Vec, u: Vec, weight: float, section: Section) -> End:
    """Return an end whose node is turned by q, with the force n and the load w per length."""
    frame = to_material_matrix(q)
    a, b = matvec(frame, n), matvec(frame, load)
    free = subtract(add(TANGENT, section.rest_stretch), matvec_t(section.coupling, u))
    v = add(free, matvec(section.compliance, a))
    return End(frame, weight, a, b, v, add(cross(u, a), b))


@inlined
def moment(u: Vec, start: End, end: End, section: Section) -> Vec:
    """Return m = K u - c + mean of B a."""
    mean = scale(0.5, add(start.a, end.a))
    elastic = subtract(matvec(section.stiffness, u), section.rest)
    return add(elastic, matvec(section.coupling, mean))


@inlined
def mixed_imbalance(u: Vec, m: Vec, start: End, end: End, section: Section) -> Vec:
    """Return G = K'u - c' + u x m + mean of v x a - B (u x a + b)."""
    varying = subtract(matvec(section.stiffness_slope, u), section.rest_slope)
    sheared = add(cross(start.v, start.a), cross(end.v, end.a))
    coupled = matvec(section.coupling, add(start.bent, end.bent))
    return add(add(varying, cross(u, m)), scale(0.5, subtract(sheared, coupled)))


@inlined
def end_energy(end: End, u: Vec, section: Section) -> float:
    """Return h/2 f + k f' of an end, with f = -(v + t - B^T (u - u*)).a / 2."""
    free = subtract(add(TANGENT, section.rest_stretch), matvec_t(section.coupling, u))
    work: float = -0.25 * section.step * dot(add(end.v, free), end.a)
    return work + end.weight * dot(end.v, end.bent)


@inlined
def imbalance_by_strain(u: Vec, m: Vec, start: End, end: End, section: Section) -> Mat:
    """Return J = dG/du = K' - [m] + [u] K + mean of B [a] + [a] B^T."""
    turned = matmul_skew(section.coupling, scale(0.5, add(start.a, end.a)))
    bending = matsubtract(skew_matmul(u, section.stiffness), skew(m))
    # [a] B^T = -(B [a])^T
    return matadd(matadd(section.stiffness_slope, bending), matsubtract(turned, transpose(turned)))


@inlined
def end_slopes(end: End, u: Vec, y: Vec, section: Section) -> EndSlopes:
    """Return the derivatives at one end.

    dG/da = ([v] - [a] C + [u] B - B [u]) / 2,
    dE/da = -h/2 v + k (v x u + C (u x a + b)) - dG/da^T y,   dE/db = k v + B^T y / 2,
    d2E/du da = k ([a] C - [v] - B [u]) + h/2 B - (B [y] - [y] B + [B^T y]) / 2,
    d2E/da da = k (C [u] + (C [u])^T) + (C [y] + (C [y])^T) / 2 - h/2 C.
    """
    h, k, compliance, coupling = section.step, end.weight, section.compliance, section.coupling
    z = matvec_t(coupling, y)
    sheared = matsubtract(skew(end.v), skew_matmul(end.a, compliance))
    turned = matmul_skew(coupling, u)
    g_a = matscale(0.5, matadd(sheared, matsubtract(skew_matmul(u, coupling), turned)))
    moved = add(cross(end.v, u), matvec(compliance, end.bent))
    e_a = subtract(subtract(scale(k, moved), scale(0.5 * h, end.v)), matvec_t(g_a, y))
    e_b = add(scale(k, end.v), scale(0.5, z))
    leaning = matadd(matsubtract(matmul_skew(coupling, y), skew_matmul(y, coupling)), skew(z))
    e_ua = matsubtract(
        matscale(-k, matadd(sheared, turned)),
        matscale(0.5, matsubtract(leaning, matscale(h, coupling))),
    )
    around = matmul_skew(compliance, add(scale(k, u), scale(0.5, y)))
    e_aa = matsubtract(with_transpose(around), matscale(0.5 * h, compliance))
    return EndSlopes(e_a, e_b, g_a, e_ua, e_aa)


@inlined
def turned_by_own_node(end: End, slopes: EndSlopes, section: Section) -> tuple[Mat, Mat, Mat]:
    """Return dG/deta and d2E/du deta by turning a and b alone, and what that adds to d2E/deta deta.

    A node's rotation eta changes a by [a] eta and b by [b] eta.
    """
    a, b, k = end.a, end.b, end.weight
    b_turned = matmul_skew(section.coupling, b)
    g_turn = matsubtract(matmul_skew(slopes.g_a, a), matscale(0.5, b_turned))
    e_u_turn = matsubtract(matmul_skew(slopes.e_ua, a), matscale(k, b_turned))
    # [a]^T (d2E/da da [a] + 2 k C [b]), its symmetric part
    both = matadd(
        matmul_skew(slopes.e_aa, a), matscale(2.0 * k, matmul_skew(section.compliance, b))
    )
    curved = matscale(-0.5, with_transpose(skew_matmul(a, both)))
    second = matadd(rotated_load_hessian(slopes.e_a, a), rotated_load_hessian(slopes.e_b, b))
    return g_turn, e_u_turn, matadd(curved, second)


@inlined
def turned_with_force(end: End, slopes: EndSlopes, section: Section) -> Mat:
    """Return d2E/deta dn = (-[a] d2E/da da - k [b] C + [dE/da]) R^T by turning a and b alone."""
    stretched = skew_matmul(scale(end.weight, end.b), section.compliance)
    by_force = matadd(skew_matmul(end.a, slopes.e_aa), stretched)
    return matmul(matsubtract(skew(slopes.e_a), by_force), end.frame)


@inlined
def of_both(by_start: Mat, by_end: Mat, start: End, end: End) -> Mat:
    """Return the derivative by n of what depends on a_0 and a_1."""
    return matadd(matmul(by_start, start.frame), matmul(by_end, end.frame))


@inlined
def node_slopes(
    end: End, slopes: EndSlopes, j_t: Mat, e_un: Mat, turn: Turn, sign: float, section: Section
) -> NodeSlopes:
    """Return the derivatives by the rotation of node 1 (``sign`` = 1) or node 0 (-1)."""
    g_turn, e_u_turn, own = turned_by_own_node(end, slopes, section)
    return NodeSlopes(
        add(cross(slopes.e_a, end.a), cross(slopes.e_b, end.b)),
        matadd(transpose(pushed_back(j_t, turn, sign)), g_turn),
        matadd(own, with_transpose(pushed_back(e_u_turn, turn, sign))),
        pushed_back(e_u_turn, turn, -sign),
        matadd(pushed_back(e_un, turn, sign), turned_with_force(end, slopes, section)),
    )


@inlined
def mixed_element(q0: Quat, q1: Quat, n: Vec, half_load: Vec, section: Section) -> Derivatives:
    """Return energy, gradient and Hessian of an element."""
    h = section.step
    square = h * h / 12.0
    x, w, u = element_frame(q0, q1, h)
    load = scale(2.0 / h, half_load)
    start = end_of(q0, add(n, half_load), load, u, square, section)
    end = end_of(q1, subtract(n, half_load), load, u, -square, section)
    m = moment(u, start, end, section)
    g = mixed_imbalance(u, m, start, end, section)
    p = matscale(h * square, section.flexibility)
    y = matvec(p, g)
    elastic = 0.5 * dot(u, matvec(section.stiffness, u)) - dot(section.rest, u)
    ends = end_energy(start, u, section) + end_energy(end, u, section)
    energy = h * elastic + ends - 0.5 * dot(y, g)

    # By u, a_0 and a_1; second derivatives with G held: its part is -dG^T P dG.
    j = imbalance_by_strain(u, m, start, end, section)
    slopes0, slopes1 = end_slopes(start, u, y, section), end_slopes(end, u, y, section)
    sheared = subtract(cross(start.a, start.v), cross(end.a, end.v))
    coupled = matvec(section.coupling, subtract(start.bent, end.bent))
    e_u = subtract(add(scale(h, m), scale(square, subtract(sheared, coupled))), matvec_t(j, y))
    turned = matmul_skew(section.coupling, scale(square, subtract(start.a, end.a)))
    e_uu = matadd(
        matscale(h, section.stiffness),
        with_transpose(matsubtract(turned, matmul_skew(section.stiffness, y))),
    )

    # By eta_0, eta_1 and n.
    g_x, h_x, turn = frame_derivatives(x, w, e_u, e_uu, h)
    t0, t1, x00, x01, x11 = rotation_derivatives(turn, g_x, h_x)
    e_un, j_t = of_both(slopes0.e_ua, slopes1.e_ua, start, end), transpose(j)
    node0 = node_slopes(start, slopes0, j_t, e_un, turn, -1.0, section)
    node1 = node_slopes(end, slopes1, j_t, e_un, turn, 1.0, section)
    g_n = of_both(slopes0.g_a, slopes1.g_a, start, end)
    p_g1, p_gn = matmul(p, node1.g), matmul(p, g_n)
    turned0, turned1 = matmul_t(start.frame, slopes0.e_aa), matmul_t(end.frame, slopes1.e_aa)
    return Derivatives(
        energy,
        add(t0, node0.e),
        add(t1, node1.e),
        add(matvec_t(start.frame, slopes0.e_a), matvec_t(end.frame, slopes1.e_a)),
        matsubtract(matadd(x00, node0.own), matmul_t(node0.g, matmul(p, node0.g))),
        matsubtract(
            matadd(x01, matadd(node1.other, transpose(node0.other))), matmul_t(node0.g, p_g1)
        ),
        matsubtract(node0.e_n, matmul_t(node0.g, p_gn)),
        matsubtract(matadd(x11, node1.own), matmul_t(node1.g, p_g1)),
        matsubtract(node1.e_n, matmul_t(node1.g, p_gn)),
        matsubtract(of_both(turned0, turned1, start, end), matmul_t(g_n, p_gn)),
    )
