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
    Elements,
    Stiffness,
    compliance_of,
    element_derivatives,
    element_frame,
    imbalance,
    section_at,
    stiffness_at,
    strain_factor,
    times,
)
from spiral_core.rod._profiles import UniformRod

# Below this sine of an element's half angle the closed form of `arc_shortening` loses digits to
# cancellation, while the series of the element's strain is exact to 1e-13 of its length.
SMALL_SINE = 0.1


class System(NamedTuple):
    """A rod under load on N elements; values that jump at a node are one-sided.

    Attributes:
        force: (N + 1, 3) force of everything beyond a node, base frame [N].
        load_start, load_end: (N, 3) load per length at each element's two ends, base frame [N/m].
        tip_moment: (3,) base frame [N m].
        elements: their sections.
        steps: (N,) lengths of the elements [m].
        node_stiffness: (N + 1, 4) K at the nodes, a :class:`~spiral_core.rod._element.Stiffness`
            each; where a property jumps, its value on the tip's side.
        node_rest: (N + 1, 3) K u* at the nodes [N m], likewise.
        rest_energy: elastic energy of the rod without strain [J], which the elements leave out.
    """

    force: Array
    load_start: Array
    load_end: Array
    tip_moment: Array
    elements: Elements
    steps: Array
    node_stiffness: Array
    node_rest: Array
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
    force, load = np.empty((count + 1, 3)), np.empty((count, 3))
    moment, steps = np.empty(3), np.empty(count)
    rest_moment, node_rest = np.empty((count, 3)), np.empty((count + 1, 3))
    node_stiffness = np.empty((count + 1, 4))
    square = rest[0] * rest[0] + rest[1] * rest[1] + rest[2] * rest[2]
    scale = discrete_strain_scale(h * math.sqrt(square))
    product = times(stiffness, rest)
    energy = 0.0
    for k in range(3):
        moment[k] = rod.tip_moment[k]
        energy += 0.5 * rod.length * scale * scale * product[k] * rest[k]
    for i in range(count + 1):
        for k in range(4):
            node_stiffness[i, k] = stiffness[k]
        for k in range(3):
            force[i, k] = rod.tip_force[k] + weight[k] * h * (count - i)
            node_rest[i, k] = product[k]
    for i in range(count):
        steps[i] = h
        for k in range(3):
            rest_moment[i, k] = scale * product[k]
            load[i, k] = weight[k]
    elements = Elements(
        node_stiffness[:count], rest_moment, np.zeros((count, 4)), np.zeros((count, 3))
    )
    return System(force, load, load, moment, elements, steps, node_stiffness, node_rest, energy)


@compiled
def constant_strain_energy(elements: Elements, steps: Array) -> float:
    """Return the energy [J] that takes each element from its mean rest strain to none."""
    energy = 0.0
    for i in range(steps.shape[0]):
        section = section_at(elements, i)
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
    first, last = start.elements, end.elements
    elements = Elements(
        blended_rows(first.stiffness, last.stiffness, at),
        blended_rows(first.rest, last.rest, at),
        blended_rows(first.stiffness_slope, last.stiffness_slope, at),
        blended_rows(first.rest_slope, last.rest_slope, at),
    )
    varying = (1.0 - at) * (
        start.rest_energy - constant_strain_energy(start.elements, start.steps)
    ) + at * (end.rest_energy - constant_strain_energy(end.elements, end.steps))
    return System(
        blended_rows(start.force, end.force, at),
        blended_rows(start.load_start, end.load_start, at),
        blended_rows(start.load_end, end.load_end, at),
        moment,
        elements,
        steps,
        blended_rows(start.node_stiffness, end.node_stiffness, at),
        blended_rows(start.node_rest, end.node_rest, at),
        varying + constant_strain_energy(elements, steps),
    )


@compiled
def without_rest_strain(system: System, moment_fraction: float) -> System:
    """Return the same rod straight when unloaded, under a fraction of its tip moment."""
    moment, none = np.empty(3), np.zeros_like(system.elements.rest)
    for k in range(3):
        moment[k] = moment_fraction * system.tip_moment[k]
    elements = Elements(system.elements.stiffness, none, system.elements.stiffness_slope, none)
    return System(
        system.force,
        system.load_start,
        system.load_end,
        moment,
        elements,
        system.steps,
        system.node_stiffness,
        np.zeros_like(system.node_rest),
        0.0,
    )


@compiled
def with_torsion_no_stiffer(system: System, ratio: float) -> System:
    """Return the same rod with a torsional stiffness of at most ``ratio`` times the bending one.

    The coupling falls in proportion, so that the section stays positive definite.
    """
    stiffness = system.elements.stiffness.copy()
    slope = system.elements.stiffness_slope.copy()
    for i in range(stiffness.shape[0]):
        k, change = stiffness_at(stiffness, i), stiffness_at(slope, i)
        softer = ratio * k.y / k.twist
        if softer < 1.0:
            for rows, soft in (
                (stiffness, Stiffness(ratio * k.y, k.y, k.z, softer * k.both)),
                (slope, Stiffness(ratio * change.y, change.y, change.z, softer * change.both)),
            ):
                for column in range(4):
                    rows[i, column] = soft[column]
    elements = Elements(stiffness, system.elements.rest, slope, system.elements.rest_slope)
    return System(
        system.force,
        system.load_start,
        system.load_end,
        system.tip_moment,
        elements,
        system.steps,
        system.node_stiffness,
        system.node_rest,
        system.rest_energy,
    )


@inlined
def end_loads(system: System, i: int, q0: Quat, q1: Quat, a0: Vec, a1: Vec) -> tuple[Vec, Vec]:
    """Return an element's share of the load at its two nodes, material frame [N m]."""
    h = system.steps[i]
    square = h * h / 12.0
    start = to_material(q0, vector_at(system.load_start, i))
    end = to_material(q1, vector_at(system.load_end, i))
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
    n = system.steps.shape[0]
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
        h, section = system.steps[i], section_at(system.elements, i)
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
        total = add(vector_at(moments, i), vector_at(system.node_rest, i))
        strain = times(compliance_of(stiffness_at(system.node_stiffness, i)), total)
        for k in range(3):
            strains[i, k] = strain[k]
    return positions, moments, strains, 2.0 * math.acos(max(-1.0, 1.0 - largest))
