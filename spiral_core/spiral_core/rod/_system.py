# SPDX-License-Identifier: Apache-2.0
"""A rod under load on N elements, as the compiled kernels take it, what they answer, and its shape.

Positions, moments and strains follow from orientations, all of fourth order.
"""

import math
from typing import NamedTuple

import numpy as np

from spiral_core.numerics.kernel import compiled, inlined
from spiral_core.rod._algebra import (
    TANGENT,
    Array,
    Quat,
    Vec,
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
from spiral_core.rod._profiles import UniformRod


class System(NamedTuple):
    """A rod under load on N elements; values that jump at a node are one-sided.

    Attributes:
        force: (N + 1, 3) force of everything beyond a node, base frame [N].
        distributed: (N, 6) load per length at each element's two ends, base frame [N/m].
        tip_moment: (3,) base frame [N m].
        elements: (N, 14), a :class:`spiral_core.rod._element.Section` each.
        steps: (N,) lengths of the elements [m].
        sections: (N + 1, 7) at the nodes: the four numbers of K [N m^2], and K u* [N m]; where a
            property jumps, its value on the tip's side.
        rest_energy: elastic energy of the rod without strain [J], which the elements leave out.
    """

    force: Array
    distributed: Array
    tip_moment: Array
    elements: Array
    steps: Array
    sections: Array
    rest_energy: float


class Ending(NamedTuple):
    """When a minimization ends.

    Attributes:
        tolerance: bounds the moment imbalance at every node, as a fraction of EI/L, and, ten times
            that, the Newton step that is left [rad], unless rounding errors are larger.
        iterations: Newton iterations at most.
        strict: end (``LEFT_BRANCH``) as soon as the Hessian is indefinite: for following a branch
            of stable states.
    """

    tolerance: float
    iterations: int
    strict: bool


class Solution(NamedTuple):
    """How a minimization ended.

    Attributes:
        outcome: one of the outcomes of :mod:`spiral_core.rod._newton`.
        iterations: Newton iterations.
        energy: potential energy [J].
        residual: largest moment imbalance at a node [N m].
        pivot: smallest pivot of the Hessian [N m]; without the neutral mode, if there is one.
        step: largest rotation of a node in the Newton step that is left [rad].
        neutral: neutral modes of the Hessian: 1 if the rod may turn freely about the base's axis.
    """

    outcome: int
    iterations: int
    energy: float
    residual: float
    pivot: float
    step: float
    neutral: int


@compiled
def discrete_strain_scale(angle: float) -> float:
    """Return by what factor an element sees a strain that turns it by ``angle`` [rad]."""
    if angle == 0.0:
        return 1.0
    sine = math.sin(0.5 * angle)
    factor, _, _ = strain_factor(sine * sine)
    return 2.0 * factor * sine / angle


@compiled
def uniform_system(count: int, rod: UniformRod) -> System:
    """Return a uniform rod on ``count`` elements."""
    h = rod.length / count
    rest, weight = rod.rest_strain, rod.weight
    stiffness = Stiffness(rod.torsional, rod.sideways, rod.bending, rod.coupling)
    force = np.empty((count + 1, 3))
    distributed = np.empty((count, 6))
    moment = np.empty(3)
    elements = np.zeros((count, 14))
    steps, sections = np.empty(count), np.empty((count + 1, 7))
    square = rest[0] * rest[0] + rest[1] * rest[1] + rest[2] * rest[2]
    scale = discrete_strain_scale(h * math.sqrt(square))
    product = times(stiffness, rest)
    for k in range(3):
        moment[k] = rod.tip_moment[k]
    for i in range(count + 1):
        for k in range(4):
            sections[i, k] = stiffness[k]
        for k in range(3):
            force[i, k] = rod.tip_force[k] + weight[k] * h * (count - i)
            sections[i, 4 + k] = product[k]
    for i in range(count):
        steps[i] = h
        for k in range(4):
            elements[i, k] = stiffness[k]
        for k in range(3):
            elements[i, 4 + k] = scale * sections[i, 4 + k]
            distributed[i, k] = weight[k]
            distributed[i, 3 + k] = weight[k]
    energy = 0.0
    for k in range(3):
        energy += 0.5 * rod.length * scale * scale * sections[0, 4 + k] * rest[k]
    return System(force, distributed, moment, elements, steps, sections, energy)


@compiled
def constant_strain_energy(elements: Array, steps: Array) -> float:
    """Return the energy [J] that takes each element from its mean rest strain to none."""
    energy = 0.0
    for i in range(elements.shape[0]):
        section = section_of(elements[i])
        soft = compliance_of(section.stiffness)
        energy += 0.5 * steps[i] * dot(section.rest, times(soft, section.rest))
    return energy


@compiled
def blended_rows(start: Array, end: Array, at: float) -> Array:
    """Return the rows (n, k) at the fraction ``at`` of the way from one array to another."""
    rows = np.empty_like(start)
    for i in range(start.shape[0]):
        for k in range(start.shape[1]):
            rows[i, k] = (1.0 - at) * start[i, k] + at * end[i, k]
    return rows


@compiled
def blended(start: System, end: System, at: float) -> System:
    """Return the rod at the fraction ``at`` of the way between two on as many elements.

    Lengths, stiffnesses, their products with rest strain, and loads are blended; the rest energy
    follows from them.
    """
    moment = np.empty(3)
    for k in range(3):
        moment[k] = (1.0 - at) * start.tip_moment[k] + at * end.tip_moment[k]
    steps = np.empty(start.steps.shape[0])
    for i in range(steps.shape[0]):
        steps[i] = (1.0 - at) * start.steps[i] + at * end.steps[i]
    elements = blended_rows(start.elements, end.elements, at)
    varying = (1.0 - at) * (
        start.rest_energy - constant_strain_energy(start.elements, start.steps)
    ) + at * (end.rest_energy - constant_strain_energy(end.elements, end.steps))
    return System(
        blended_rows(start.force, end.force, at),
        blended_rows(start.distributed, end.distributed, at),
        moment,
        elements,
        steps,
        blended_rows(start.sections, end.sections, at),
        varying + constant_strain_energy(elements, steps),
    )


@compiled
def without_rest_strain(system: System, moment_fraction: float) -> System:
    """Return the same rod straight when unloaded, under a fraction of its tip moment."""
    elements = system.elements.copy()
    sections = system.sections.copy()
    moment = np.empty(3)
    for k in range(3):
        moment[k] = moment_fraction * system.tip_moment[k]
        for i in range(elements.shape[0]):
            elements[i, 4 + k] = 0.0
            elements[i, 11 + k] = 0.0
        for i in range(sections.shape[0]):
            sections[i, 4 + k] = 0.0
    return System(system.force, system.distributed, moment, elements, system.steps, sections, 0.0)


@compiled
def with_torsion_no_stiffer(system: System, ratio: float) -> System:
    """Return the same rod with a torsional stiffness of at most ``ratio`` times the bending one.

    The coupling falls in proportion, so that the section stays positive definite.
    """
    elements = np.empty_like(system.elements)
    for i in range(elements.shape[0]):
        for k in range(elements.shape[1]):
            elements[i, k] = system.elements[i, k]
        softer = ratio * elements[i, 1] / elements[i, 0]
        if softer < 1.0:
            elements[i, 0] = ratio * elements[i, 1]
            elements[i, 7] = ratio * elements[i, 8]
            elements[i, 3] *= softer
            elements[i, 10] *= softer
    return System(
        system.force,
        system.distributed,
        system.tip_moment,
        elements,
        system.steps,
        system.sections,
        system.rest_energy,
    )


# Below this sine of an element's half angle the closed form of `arc_shortening` loses digits to
# cancellation, while the series of the element's strain is exact to 1e-13 of its length.
SMALL_SINE = 0.1


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
