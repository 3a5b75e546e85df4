# SPDX-License-Identifier: Apache-2.0
"""The rod element: its energy, and that energy's exact gradient and Hessian (compiled).

The discretization is derived in ``docs/derivations/rod.md``; its symbols are used here. A rod of N
elements of length h has N + 1 nodes; node i carries a unit quaternion q_i, the force n_i of
everything beyond it, and element e between two nodes carries one strain u. Energy of an element,
with t = x axis, a = R^T n, D = a_1 - a_0, abar = (a_0 + a_1) / 2:

    W = h (u.Ku / 2 - c.u) + h^2/12 u.(t x D) - h^3/24 G.K^-1 G,      G = K'u - c' + u x (Ku - c) +
    t x abar

The first term is the elastic energy at constant strain, the second the Hermite correction of the
load's trapezoidal rule, the third the energy released by the strain's variation inside the element:
together the error is O(h^4).

The elements of a rod are :class:`Elements`, one of them a :class:`Section`.
"""

from typing import NamedTuple

from spiral_core.numerics.kernel import inlined
from spiral_core.rod._algebra import (
    Array,
    Mat,
    Quat,
    Vec,
    add,
    cross,
    diagonal,
    dot,
    matadd,
    matmul,
    matmul_skew,
    matscale,
    matsubtract,
    matvec,
    matvec_t,
    outer,
    scale,
    seen_turn,
    skew,
    skew_matmul,
    subtract,
    transpose,
    vector_at,
    with_transpose,
)


class Stiffness(NamedTuple):
    """Stiffness of a section, or its inverse: K = [[twist, 0, both], [0, y, 0], [both, 0, z]].

    Attributes:
        twist: to twist [N m^2].
        y: to bending about y.
        z: to bending about z.
        both: coupling of twist with bending about z.
    """

    twist: float
    y: float
    z: float
    both: float


class Section(NamedTuple):
    """The section in the middle of an element, and how it changes along the rod.

    Attributes:
        stiffness: mean K.
        rest: mean rest moment c = K u* [N m].
        stiffness_slope, rest_slope: their derivatives along the rod.
    """

    stiffness: Stiffness
    rest: Vec
    stiffness_slope: Stiffness
    rest_slope: Vec


class Turn(NamedTuple):
    """An element's turn, and how its strain u follows: u = c f x, du/dx = c f + s x x^T.

    Attributes:
        x: Im(conj(q0) q1).
        w: Re(conj(q0) q1).
        stretch: c f [1/m].
        bend: s w / 2 [1/m].
    """

    x: Vec
    w: float
    stretch: float
    bend: float


class Elements(NamedTuple):
    """The sections of N elements.

    Attributes:
        stiffness: (N, 4), a :class:`Stiffness` each.
        rest: (N, 3).
        stiffness_slope: (N, 4).
        rest_slope: (N, 3).
    """

    stiffness: Array
    rest: Array
    stiffness_slope: Array
    rest_slope: Array


@inlined
def stiffness_at(rows: Array, i: int) -> Stiffness:
    """Return row i of an (n, 4) array."""
    return Stiffness(rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3])


@inlined
def section_at(elements: Elements, i: int) -> Section:
    """Return the section of element i."""
    return Section(
        stiffness_at(elements.stiffness, i),
        vector_at(elements.rest, i),
        stiffness_at(elements.stiffness_slope, i),
        vector_at(elements.rest_slope, i),
    )


@inlined
def times(k: Stiffness, u: Vec) -> Vec:
    """Return K u."""
    return (k.twist * u[0] + k.both * u[2], k.y * u[1], k.z * u[2] + k.both * u[0])


@inlined
def compliance_of(k: Stiffness) -> Stiffness:
    """Return K^-1."""
    square = k.twist * k.z - k.both * k.both
    per = 1.0 / (k.y * square)
    return Stiffness(per * k.y * k.z, per * square, per * k.y * k.twist, -per * k.y * k.both)


@inlined
def moment_of(u: Vec, k: Stiffness, rest: Vec) -> Vec:
    """Return K u - c."""
    return subtract(times(k, u), rest)


@inlined
def strain_factor(sine_squared: float) -> tuple[float, float, float]:
    """Return f, f', f'' of f(z^2) = asin(z) / z, by its series to z^6.

    With z = sin(angle / 2) of an element's rotation, u = (2 f / h) Im(conj(q_0) q_1) is its
    rotation vector over h. The series' error is O(h^8); the rest strain goes through the same
    series (``discrete_strain_scale``), so that the uniform helix stays exact.
    """
    s = sine_squared
    value = 1.0 + s * (1.0 / 6.0 + s * (3.0 / 40.0 + s * (5.0 / 112.0)))
    first = 1.0 / 6.0 + s * (3.0 / 20.0 + s * (15.0 / 112.0))
    second = 3.0 / 20.0 + s * (15.0 / 56.0)
    return value, first, second


@inlined
def element_frame(q0: Quat, q1: Quat, h: float) -> tuple[Vec, float, Vec]:
    """Return x = Im(conj(q0) q1), w = Re(conj(q0) q1) and the element's strain u [1/m]."""
    a, b, c, w = seen_turn(q0, q1)
    x = (a, b, c)
    factor, _, _ = strain_factor(dot(x, x))
    return x, w, scale(2.0 * factor / h, x)


@inlined
def imbalance(u: Vec, section: Section, mean_load: Vec) -> Vec:
    """Return G, the moment imbalance per length in the middle of an element of strain u [N]."""
    m = moment_of(u, section.stiffness, section.rest)
    varying = moment_of(u, section.stiffness_slope, section.rest_slope)
    return add(add(varying, cross(u, m)), (0.0, -mean_load[2], mean_load[1]))


@inlined
def element_energy(u: Vec, a0: Vec, a1: Vec, section: Section, h: float) -> float:
    """Return W of one element [J] (see the module's head)."""
    elastic = 0.5 * dot(u, times(section.stiffness, u)) - dot(section.rest, u)
    change = (0.0, -(a1[2] - a0[2]), a1[1] - a0[1])
    g = imbalance(u, section, scale(0.5, add(a0, a1)))
    released = dot(g, times(compliance_of(section.stiffness), g))
    energy: float = h * elastic + h * h / 12.0 * dot(u, change) - h * h * h / 24.0 * released
    return energy


@inlined
def strain_derivatives(
    u: Vec, a0: Vec, a1: Vec, section: Section, h: float
) -> tuple[Vec, Mat, Mat, Vec]:
    """Return dW/du, d2W/du2, and h^3/12 times J^T K^-1 and K^-1 G, with J = dG/du."""
    kt, ky, kz, kc = section.stiffness
    slope, soft = section.stiffness_slope, compliance_of(section.stiffness)
    third = h * h * h / 12.0
    square = h * h / 12.0
    m = moment_of(u, section.stiffness, section.rest)
    g = imbalance(u, section, scale(0.5, add(a0, a1)))
    p = Stiffness(third * soft.twist, third * soft.y, third * soft.z, third * soft.both)
    y = times(p, g)
    j = (
        (slope.twist + kc * u[1], m[2] - ky * u[2], slope.both + kz * u[1] - m[1]),
        (kt * u[2] - kc * u[0] - m[2], slope.y, m[0] + kc * u[2] - kz * u[0]),
        (slope.both + m[1] - kt * u[1], ky * u[0] - m[0], slope.z - kc * u[1]),
    )
    j_t = transpose(j)
    jc = (times(p, j_t[0]), times(p, j_t[1]), times(p, j_t[2]))
    pull = (0.0, square * (a0[2] - a1[2]), square * (a1[1] - a0[1]))
    w_u = subtract(add(scale(h, m), pull), matvec(j_t, y))
    # h K - J^T P J and what the curvature of G adds, [y] K - K [y].
    tilt = h * kc - (kt - kz) * y[1]
    twist = (kt - ky) * y[2] - kc * y[0]
    bend = (ky - kz) * y[0] + kc * y[2]
    lean = 2.0 * kc * y[1]
    curved = ((h * kt + lean, twist, tilt), (twist, h * ky, bend), (tilt, bend, h * kz - lean))
    w_uu = matsubtract(curved, matmul(jc, j))
    return w_u, w_uu, jc, y


@inlined
def turned_load(n: Mat, a: Vec) -> Mat:
    """Return N (a t^T - (t.a) I): a node's rotation turns its load, N takes that to the strain."""
    (x, b, c), (y, d, e), (z, f, g) = matscale(-a[0], n)
    turned = matvec(n, a)
    return ((x + turned[0], b, c), (y + turned[1], d, e), (z + turned[2], f, g))


@inlined
def pushed_back(m: Mat, turn: Turn, sign: float) -> Mat:
    """Return U^T m, with U = c f (sign w + [x]) / 2 + sign bend x x^T.

    U is du/deta of node 1 (``sign`` = 1) or node 0 (-1).
    """
    x, w, stretch, bend = turn
    flat = matsubtract(matscale(sign * w, m), skew_matmul(x, m))
    return matadd(matscale(0.5 * stretch, flat), outer(scale(sign * bend, x), matvec_t(m, x)))


@inlined
def rotated_load_hessian(p: Vec, a: Vec) -> Mat:
    """Return the Hessian of eta -> p . a(eta), a(eta) = exp(-eta) a, at eta = 0."""
    d = dot(p, a)
    return matsubtract(matscale(0.5, with_transpose(outer(p, a))), diagonal(d, d, d))


@inlined
def load_pair(y: float, z: float, a: Vec, b: Vec) -> Mat:
    """Return -(T [a])^T diag(0, y, z) (T [b]), T = [t]: two nodes' loads on the energy released."""
    return (
        (-y * a[1] * b[1] - z * a[2] * b[2], y * a[1] * b[0], z * a[2] * b[0]),
        (y * a[0] * b[1], -y * a[0] * b[0], 0.0),
        (z * a[0] * b[2], 0.0, -z * a[0] * b[0]),
    )


@inlined
def frame_derivatives(x: Vec, w: float, w_u: Vec, w_uu: Mat, h: float) -> tuple[Vec, Mat, Turn]:
    """Return dW/dx, d2W/dx2, and the element's turn."""
    f, f1, f2 = strain_factor(dot(x, x))
    c = 2.0 / h
    cf = c * f
    s = 2.0 * c * f1
    along = dot(w_u, x)
    g_x = add(scale(cf, w_u), scale(s * along, x))
    v = matvec(w_uu, x)
    z = add(
        scale(s, add(scale(cf, v), w_u)), scale(0.5 * s * s * dot(x, v) + 2.0 * c * f2 * along, x)
    )
    flat = matadd(matscale(cf * cf, w_uu), diagonal(s * along, s * along, s * along))
    return g_x, matadd(flat, with_transpose(outer(x, z))), Turn(x, w, cf, 0.5 * s * w)


@inlined
def rotation_derivatives(turn: Turn, g_x: Vec, h_x: Mat) -> tuple[Vec, Vec, Mat, Mat, Mat]:
    """Return g0, g1, H00, H01, H11 of a function of x by the rotations eta of both nodes.

    ``g_x`` and ``h_x`` are its derivatives by x, and dx/deta_1 = A1 = (w + [x]) / 2, A0 = -A1^T.
    """
    x, w = turn.x, turn.w
    h_w, h_skew = matscale(w, h_x), matmul_skew(h_x, x)
    p0, p1 = matscale(0.5, matsubtract(h_w, h_skew)), matscale(0.5, matadd(h_w, h_skew))
    p1_w, p1_skew = matscale(w, p1), skew_matmul(x, p1)
    # Second derivatives of x itself.
    bow = -0.25 * dot(g_x, x)
    bowed = diagonal(bow, bow, bow)
    twist = matscale(0.25, matadd(matscale(w, skew(g_x)), with_transpose(outer(g_x, x))))
    h00 = matadd(matscale(0.5, matadd(matscale(w, p0), skew_matmul(x, p0))), bowed)
    h11 = matadd(matscale(0.5, matsubtract(p1_w, p1_skew)), bowed)
    h01 = matadd(matadd(matscale(-0.5, matadd(p1_w, p1_skew)), bowed), twist)
    turned, along = cross(x, g_x), scale(w, g_x)
    return scale(-0.5, add(along, turned)), scale(0.5, subtract(along, turned)), h00, h01, h11


@inlined
def load_derivatives(
    u: Vec, y: Vec, jc: Mat, a0: Vec, a1: Vec, h: float
) -> tuple[Vec, Vec, Mat, Mat]:
    """Return dW/da0, dW/da1, and d2W/du da = N (a t^T - (t.a) I) of each node's load."""
    square = h * h / 12.0
    mean = (0.0, -0.5 * y[2], 0.5 * y[1])
    lean = (0.0, square * u[2], -square * u[1])
    half, across = matscale(-0.5, jc), diagonal(square, square, square)
    load0 = turned_load(matsubtract(half, across), a0)
    load1 = turned_load(matadd(half, across), a1)
    return subtract(mean, lean), add(mean, lean), load0, load1


@inlined
def element_derivatives(
    x: Vec, w: float, u: Vec, a0: Vec, a1: Vec, section: Section, h: float
) -> tuple[Vec, Vec, Mat, Mat, Mat]:
    """Return gradient and Hessian of W for rotations eta of both nodes: g0, g1, H00, H01, H11."""
    w_u, w_uu, jc, y = strain_derivatives(u, a0, a1, section, h)
    g_x, h_x, turn = frame_derivatives(x, w, w_u, w_uu, h)
    q0, q1, load0, load1 = load_derivatives(u, y, jc, a0, a1, h)
    t0, t1, x00, x01, x11 = rotation_derivatives(turn, g_x, h_x)
    soft, quarter = compliance_of(section.stiffness), 0.25 * h * h * h / 12.0
    ky, kz = quarter * soft.y, quarter * soft.z
    both0 = with_transpose(pushed_back(load0, turn, -1.0))
    both1 = with_transpose(pushed_back(load1, turn, 1.0))
    cross01 = pushed_back(load1, turn, -1.0)
    cross10 = transpose(pushed_back(load0, turn, 1.0))
    turned0 = matadd(rotated_load_hessian(q0, a0), load_pair(ky, kz, a0, a0))
    turned1 = matadd(rotated_load_hessian(q1, a1), load_pair(ky, kz, a1, a1))
    h00 = matadd(x00, matadd(turned0, both0))
    h11 = matadd(x11, matadd(turned1, both1))
    h01 = matadd(x01, matadd(load_pair(ky, kz, a0, a1), matadd(cross01, cross10)))
    return add(t0, cross(q0, a0)), add(t1, cross(q1, a1)), h00, h01, h11
