# SPDX-License-Identifier: Apache-2.0
"""From a rod's orientations to its positions, moments and strains, all of fourth order."""

import math

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    TANGENT,
    Array,
    Quat,
    add,
    cross,
    dot,
    normalized,
    quaternion_at,
    scale,
    to_base,
    to_material,
    vector_at,
)
from spiral_core.rod._element import (
    Stiffness,
    compliance_of,
    element_derivatives,
    element_frame,
    imbalance,
    section_of,
    strain_factor,
    times,
)
from spiral_core.rod._elimination import end_loads
from spiral_core.rod._system import System

# Below this sine of an element's half angle the closed form of `arc_shortening` loses digits to
# cancellation, while the series of the element's strain is exact to 1e-13 of its length.
SMALL_SINE = 0.1


@compiled
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


@compiled
def middle(q0: Quat, q1: Quat) -> Quat:
    """Return the orientation halfway between q0 and q1."""
    return normalized((q0[0] + q1[0], q0[1] + q1[1], q0[2] + q1[2], q0[3] + q1[3]))


@compiled
def shape_from_orientations(q: Array, system: System) -> tuple[Array, Array, Array, float]:
    """Return positions [m], moments [N m], strains [1/m] and the largest turn of an element [rad].

    Arrays (N + 1, 3); positions in the base frame, moments and strains in the material frame.

    Positions: each element adds the chord of its helical arc and the displacement by the strain's
    variation inside it, h^3/12 (K^-1 G) x t: the same terms as in the element's energy, whose
    derivative by a force this is. Moments: what an element's energy pushes its node with (the
    momentum of the discrete action principle); in equilibrium an inner node's two elements push
    alike, so that each node needs one. Strains: u* + K^-1 m.
    """
    n = system.elements.shape[0]
    positions = np.zeros((n + 1, 3))
    moments = np.zeros((n + 1, 3))
    strains = np.empty((n + 1, 3))
    at = (0.0, 0.0, 0.0)
    push = (0.0, 0.0, 0.0)
    largest = 0.0
    q1 = quaternion_at(q, 0)
    a1 = to_material(q1, vector_at(system.force, 0))
    for i in range(n):
        q0, a0 = q1, a1
        q1 = quaternion_at(q, i + 1)
        a1 = to_material(q1, vector_at(system.force, i + 1))
        h, section = system.steps[i], section_of(system.elements[i])
        x, w, strain = element_frame(q0, q1, h)
        # Past half a turn the quaternion's real part changes its sign.
        largest = max(largest, 1.0 - w)
        g = imbalance(strain, section, scale(0.5, add(a0, a1)))
        relaxed = times(compliance_of(section.stiffness), g)
        arc = scale(h * arc_shortening(dot(x, x)), cross(x, cross(x, TANGENT)))
        bend = scale(h * h * h / 12.0, cross(relaxed, TANGENT))
        at = add(at, to_base(middle(q0, q1), add(scale(h, TANGENT), add(arc, bend))))
        g0, g1, _, _, _ = element_derivatives(x, w, strain, a0, a1, section, h)
        pull0, pull1 = end_loads(system, i, q0, q1, a0, a1)
        m = scale(-1.0, add(g0, cross(pull0, TANGENT)))
        push = add(g1, cross(pull1, TANGENT))
        for k in range(3):
            positions[i + 1, k] = at[k]
            moments[i, k] = m[k]
    for k in range(3):
        moments[n, k] = push[k]
    for i in range(n + 1):
        node = system.sections[i]
        stiffness = Stiffness(node[0], node[1], node[2], node[3])
        total = add(vector_at(moments, i), (node[4], node[5], node[6]))
        strain = times(compliance_of(stiffness), total)
        for k in range(3):
            strains[i, k] = strain[k]
    return positions, moments, strains, 2.0 * math.acos(max(-1.0, 1.0 - largest))
