"""From a rod's orientations to its positions and moments, to the order of the discretization."""

import math

import numpy as np

from spiral_core.numerics.kernel import compiled, inlined
from spiral_core.rod._algebra import (
    Quat,
    add,
    cross,
    dot,
    scale,
    to_base,
    to_material,
)
from spiral_core.rod._element import element_derivatives, element_frame, imbalance, strain_factor
from spiral_core.rod._newton import TANGENT, Array, quaternion_at, vector_at

# Below this sine of an element's half angle the closed form of `arc_shortening` loses digits to
# cancellation, while the series of the element's strain is exact to 1e-13 of its length.
SMALL_SINE = 0.1


@inlined
def arc_shortening(square: float) -> float:
    """Return (1 - z / asin(z)) / z^2 for z^2 = ``square``: how an arc's chord is shortened.

    With x = sin(angle / 2) n of the arc's rotation, its chord is h (t + arc_shortening(x.x) x x (x
    x t)), seen from the frame halfway.
    """
    if square < SMALL_SINE * SMALL_SINE:
        factor, _, _ = strain_factor(square)
        excess = 1.0 / 6.0 + square * (3.0 / 40.0 + square * (5.0 / 112.0))
        return excess / factor
    sine = math.sqrt(square)
    return (1.0 - sine / math.asin(min(1.0, sine))) / square


@inlined
def middle(q0: Quat, q1: Quat) -> Quat:
    """Return the orientation halfway between q0 and q1."""
    s = (q0[0] + q1[0], q0[1] + q1[1], q0[2] + q1[2], q0[3] + q1[3])
    c = 1.0 / math.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + s[3] * s[3])
    return (c * s[0], c * s[1], c * s[2], c * s[3])


@compiled
def shape_from_orientations(
    q: Array, force: Array, distributed: Array, elements: Array, h: float
) -> tuple[Array, Array]:
    """Return positions [m] in the base frame and internal moments [N m] in the material frame.

    Both (N + 1, 3).

    Positions: each element adds the chord of its helical arc and the displacement by the strain's
    variation inside it, h^3/12 (K^-1 G) x t: the same terms as in the element's energy, whose
    derivative by a force this is. Moments: what an element's energy pushes its node with (the
    momentum of the discrete action principle); in equilibrium an inner node's two elements push
    alike, so that each node needs one.
    """
    n = elements.shape[0]
    positions = np.zeros((n + 1, 3))
    moments = np.zeros((n + 1, 3))
    at = (0.0, 0.0, 0.0)
    push = (0.0, 0.0, 0.0)
    q1 = quaternion_at(q, 0)
    a1 = to_material(q1, vector_at(force, 0))
    for i in range(n):
        q0, a0 = q1, a1
        q1 = quaternion_at(q, i + 1)
        a1 = to_material(q1, vector_at(force, i + 1))
        x, w, strain = element_frame(q0, q1, h)
        g = imbalance(strain, elements[i], scale(0.5, add(a0, a1)))
        relaxed = (g[0] / elements[i, 0], g[1] / elements[i, 1], g[2] / elements[i, 1])
        arc = scale(h * arc_shortening(dot(x, x)), cross(x, cross(x, TANGENT)))
        bend = scale(h * h * h / 12.0, cross(relaxed, TANGENT))
        at = add(at, to_base(middle(q0, q1), add(scale(h, TANGENT), add(arc, bend))))
        g0, g1, _, _, _ = element_derivatives(x, w, strain, a0, a1, elements[i], h)
        share = scale(h * h / 12.0, to_material(q0, vector_at(distributed, i)))
        pull = add(scale(0.5 * h, a0), scale(-1.0, share))
        m = scale(-1.0, add(g0, cross(pull, TANGENT)))
        push = g1
        for k in range(3):
            positions[i + 1, k] = at[k]
            moments[i, k] = m[k]
    share = scale(h * h / 12.0, to_material(q1, vector_at(distributed, n)))
    m = add(push, cross(add(scale(0.5 * h, a1), share), TANGENT))
    for k in range(3):
        moments[n, k] = m[k]
    return positions, moments


@compiled
def discrete_strain_scale(angle: float) -> float:
    """Return by what factor an element sees a strain that turns it by ``angle`` [rad]."""
    if angle == 0.0:
        return 1.0
    sine = math.sin(0.5 * angle)
    factor, _, _ = strain_factor(sine * sine)
    return 2.0 * factor * sine / angle
