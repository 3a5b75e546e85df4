# SPDX-License-Identifier: Apache-2.0
"""A rod under load on N elements, as the compiled kernels take it, and what they answer."""

import math
from typing import NamedTuple

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import Array, dot
from spiral_core.rod._element import Stiffness, compliance_of, section_of, strain_factor, times
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
