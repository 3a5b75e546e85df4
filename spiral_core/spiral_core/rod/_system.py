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
    norm,
    normalized,
    put_vector,
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
    scale_of_rest = discrete_strain_scale(h * norm(rest))
    product = times(stiffness, rest)
    seen = scale(scale_of_rest, product)
    force, load, moment = np.empty((count + 1, 3)), np.empty((count, 3)), np.empty(3)
    node_stiffness, node_rest = np.empty((count + 1, 4)), np.empty((count + 1, 3))
    steps, rest_moment = np.empty(count), np.empty((count, 3))
    put_vector(moment, 0, rod.tip_moment)
    for i in range(count + 1):
        put_vector(force[i], 0, add(rod.tip_force, scale(h * (count - i), weight)))
        put_vector(node_stiffness[i], 0, stiffness)
        put_vector(node_rest[i], 0, product)
    for i in range(count):
        steps[i] = h
        put_vector(rest_moment[i], 0, seen)
        put_vector(load[i], 0, weight)
    none = np.zeros((count, 4))
    elements = Elements(node_stiffness[:count], rest_moment, none, np.zeros((count, 3)))
    energy = 0.5 * rod.length * scale_of_rest * dot(seen, rest)
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
def mixed(start: Array, end: Array, at: float) -> Array:
    """Return the array at the fraction ``at`` of the way from one to another."""
    return (1.0 - at) * start + at * end


@compiled
def blended(start: System, end: System, at: float) -> System:
    """Return the rod at the fraction ``at`` of the way between two on as many elements.

    Lengths, stiffnesses, their products with rest strain, and loads are blended; the rest energy
    follows from them.
    """
    first, last, steps = start.elements, end.elements, mixed(start.steps, end.steps, at)
    elements = Elements(
        mixed(first.stiffness, last.stiffness, at),
        mixed(first.rest, last.rest, at),
        mixed(first.stiffness_slope, last.stiffness_slope, at),
        mixed(first.rest_slope, last.rest_slope, at),
    )
    varying = (1.0 - at) * (start.rest_energy - constant_strain_energy(first, start.steps))
    varying += at * (end.rest_energy - constant_strain_energy(last, end.steps))
    return System(
        mixed(start.force, end.force, at),
        mixed(start.load_start, end.load_start, at),
        mixed(start.load_end, end.load_end, at),
        mixed(start.tip_moment, end.tip_moment, at),
        elements,
        steps,
        mixed(start.node_stiffness, end.node_stiffness, at),
        mixed(start.node_rest, end.node_rest, at),
        varying + constant_strain_energy(elements, steps),
    )


@compiled
def with_elements(
    system: System, elements: Elements, tip_moment: Array, rest_energy: float
) -> System:
    """Return a system with other elements and another tip moment; nodes are as they were."""
    return System(
        system.force,
        system.load_start,
        system.load_end,
        tip_moment,
        elements,
        system.steps,
        system.node_stiffness,
        system.node_rest,
        rest_energy,
    )


@compiled
def without_rest_strain(system: System, moment_fraction: float) -> System:
    """Return the same rod straight when unloaded, under a fraction of its tip moment."""
    none = np.zeros_like(system.elements.rest)
    elements = Elements(system.elements.stiffness, none, system.elements.stiffness_slope, none)
    return with_elements(system, elements, moment_fraction * system.tip_moment, 0.0)


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
            put_vector(stiffness[i], 0, (ratio * k.y, k.y, k.z, softer * k.both))
            put_vector(slope[i], 0, (ratio * change.y, change.y, change.z, softer * change.both))
    elements = Elements(stiffness, system.elements.rest, slope, system.elements.rest_slope)
    return with_elements(system, elements, system.tip_moment, system.rest_energy)


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

    That is the turn from end to end, or to the middle and back, by what relaxes inside.

    Arrays (N + 1, 3); positions in the base frame, moments and strains in the material frame.

    Positions: each element adds the chord of its helical arc and the displacement by the strain's
    variation inside it, h^3/12 (K^-1 G) x t: the same terms as in the element's energy, whose
    derivative by a force this is. Moments: what an element's energy pushes its node with (the
    momentum of the discrete action principle); in equilibrium an inner node's two elements push
    alike, so that each node needs one. Strains: u* + K^-1 m.
    """
    n = len(system.steps)
    positions, moments = np.zeros((n + 1, 3)), np.zeros((n + 1, 3))
    strains = np.empty((n + 1, 3))
    at = (0.0, 0.0, 0.0)
    turn = 0.0
    q1 = quaternion_at(q, 0)
    a1 = to_material(q1, vector_at(system.force, 0))
    for i in range(n):
        q0, a0 = q1, a1
        q1 = quaternion_at(q, i + 1)
        a1 = to_material(q1, vector_at(system.force, i + 1))
        h, section = system.steps[i], section_at(system.elements, i)
        x, w, strain = element_frame(q0, q1, h)
        g = imbalance(strain, section, scale(0.5, add(a0, a1)))
        relaxed = times(compliance_of(section.stiffness), g)
        # Past half a turn the quaternion's real part changes its sign.
        ends = 2.0 * math.acos(max(-1.0, min(1.0, w)))
        turn = max(turn, ends, 0.25 * h * h * norm(relaxed))
        arc = scale(h * arc_shortening(dot(x, x)), cross(x, cross(x, TANGENT)))
        bend = scale(h * h * h / 12.0, cross(relaxed, TANGENT))
        at = add(at, to_base(middle(q0, q1), add(scale(h, TANGENT), add(arc, bend))))
        g0, g1, _, _, _ = element_derivatives(x, w, strain, a0, a1, section, h)
        pull0, pull1 = end_loads(system, i, q0, q1, a0, a1)
        put_vector(positions[i + 1], 0, at)
        put_vector(moments[i], 0, scale(-1.0, add(g0, cross(pull0, TANGENT))))
        put_vector(moments[i + 1], 0, add(g1, cross(pull1, TANGENT)))
    for i in range(n + 1):
        total = add(vector_at(moments, i), vector_at(system.node_rest, i))
        soft = compliance_of(stiffness_at(system.node_stiffness, i))
        put_vector(strains[i], 0, times(soft, total))
    return positions, moments, strains, turn
