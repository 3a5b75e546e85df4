# SPDX-License-Identifier: Apache-2.0
"""What one step in time adds to the energy: inertia, damping of the material, drag.

Positions and the two directors across the rod are the coordinates y (N + 1, 9) of the nodes, and
their inertia is diagonal. Derived in ``docs/derivations/motion.md``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    Array,
    add,
    add_matrix,
    add_vector,
    cross,
    dot,
    matrices,
    matrix_at,
    matvec,
    matvec_t,
    put_vector,
    quaternion_at,
    scale,
    subtract,
    to_material,
    vector_at,
    vector_from,
)
from spiral_core.rod._element import element_frame
from spiral_core.rod.contact._contact import TINY, Iterate
from spiral_core.rod.contact._element import (
    Elements,
    end_of,
    mixed_imbalance,
    moment,
    section_at,
)
from spiral_core.rod.contact._mesh import Arrays, node_lengths
from spiral_core.rod.contact._newton import assemble, no_elements
from spiral_core.rod.motion.inertia import AIR_DENSITY, AIR_VISCOSITY, Inertia


def coordinates(x: Iterate) -> Array:
    """Return positions and directors across the rod (N + 1, 9)."""
    turn = matrices(x.q)
    return np.hstack((x.p, turn[:, :, 1], turn[:, :, 2]))


def masses(arrays: Arrays, inertia: Inertia) -> Array:
    """Return the inertia of the coordinates (N + 1, 9) [kg, kg m^2]."""
    per_length = np.repeat((inertia.mass, inertia.rotary), (3, 6))
    inertias: Array = node_lengths(arrays.arc_lengths)[:, None] * per_length
    return inertias


def strains(x: Iterate, arrays: Arrays, elastic: Arrays) -> Array:
    r"""Return the strains that an element's material remembers (N, 6) [1/m, 1/m^2].

    They are those at which the damping that :func:`stiffened` adds exerts nothing: with the
    element's own u and :math:`s = K^{-1} G` of :mod:`spiral_core.rod.contact._element`,

    .. math:: w = \tfrac{h^2}{12} (K (s \times u) + w \times s + K'^T s), \quad
        u - K^{-1} w, \quad s - K^{-1} (u \times w + K' K^{-1} w)
    """
    return remembered_strains(x, arrays.elements, elastic.elements)


def stiffened(arrays: Arrays, ratio: Array, strain: Array) -> Arrays:
    """Return the rod with ratio K (u - strain) added to its moments, ratio (N, 1) = T / duration.

    A Kelvin-Voigt material over a step is a stiffer elastic one with another rest strain.

    Args:
        arrays: the elastic rod.
        ratio: for each element.
        strain: mean strains and slopes (N, 6).
    """
    old, every = arrays.elements, 1.0 + ratio[:, :, None]
    rest = np.einsum("nij,nj->ni", old.stiffness, strain[:, :3])
    slope = np.einsum("nij,nj->ni", old.stiffness_slope, strain[:, :3])
    slope -= np.einsum("nij,nj->ni", old.stiffness, strain[:, 3:])
    elements = old._replace(
        stiffness=every * old.stiffness,
        stiffness_slope=every * old.stiffness_slope,
        flexibility=old.flexibility / every,
        rest=old.rest + ratio * rest,
        rest_slope=old.rest_slope + ratio * slope,
    )
    return replace(arrays, elements=elements)


def drag_factor(speed: Array, diameter: float, air: float) -> Array:
    """Return force over speed of air per length of rod (n,) [N s/m^2], across the rod."""
    reynolds = AIR_DENSITY * speed * diameter / AIR_VISCOSITY
    coefficient = 1.0 + 10.0 / np.maximum(np.cbrt(reynolds * reynolds), TINY)
    factor: Array = 0.5 * air * AIR_DENSITY * diameter * coefficient * speed
    return np.where(speed > 0.0, factor, 0.0)


class StepTerms(NamedTuple):
    """A quadratic about targets: w/2 (y - z)^2 and (p - r) . A (p - r) / 2.

    Attributes:
        weight: w (N + 1, 9) [N/m, N m].
        target: z (N + 1, 9).
        drag: A (N + 1, 3, 3) [N/m].
        rest: r (N + 1, 3) [m].
    """

    weight: Array
    target: Array
    drag: Array
    rest: Array

    def add(self, x: Iterate, gradient: Array, tangent: Array) -> None:
        """Add gradient and Hessian at x, by rotations in the material frame and displacements."""
        add_step_terms(x, self, gradient, tangent)


@compiled
def add_step_terms(x: Iterate, terms: StepTerms, gradient: Array, tangent: Array) -> None:
    """Add a step's inertia and drag to gradient (n, 6) and Hessian (n, 6, 6) of every node."""
    for n in range(len(x.p)):
        drag, weight, target = matrix_at(terms.drag, n), terms.weight[n], terms.target[n]
        away = subtract(vector_at(x.p, n), vector_at(terms.rest, n))
        add_vector(gradient[n], 3, matvec(drag, away))
        add_matrix(tangent[n], 3, 3, drag)
        for i in range(3):
            gradient[n, 3 + i] += weight[i] * (x.p[n, i] - target[i])
            tangent[n, 3 + i, 3 + i] += weight[i]
        for axis in range(1, 3):
            first = 3 * axis
            kept = to_material(quaternion_at(x.q, n), vector_from(target, first))
            seen = scale(weight[first], kept)
            ahead, behind = (axis + 1) % 3, (axis + 2) % 3
            # e x b, the unit vector e along the axis
            gradient[n, ahead] += seen[behind]
            gradient[n, behind] -= seen[ahead]
            for i in range(3):
                tangent[n, i, i] += seen[axis]
                tangent[n, axis, i] -= 0.5 * seen[i]
                tangent[n, i, axis] -= 0.5 * seen[i]


@compiled
def remembered_strains(x: Iterate, damped: Elements, elastic: Elements) -> Array:
    """Return the strains that each element's material remembers (N, 6) [1/m, 1/m^2].

    ``damped`` are the elements with their damping, ``elastic`` the same without.
    """
    out = np.empty((len(damped.steps), 6))
    for e, h in enumerate(damped.steps):
        q0, q1, n = quaternion_at(x.q, e), quaternion_at(x.q, e + 1), vector_at(x.n, e)
        section, half_load = section_at(damped, e), vector_at(damped.half_load, e)
        small, load = h * h / 12.0, scale(2.0 / h, half_load)
        _, _, strain = element_frame(q0, q1, h)
        start = end_of(q0, add(n, half_load), load, strain, small, section)
        end = end_of(q1, subtract(n, half_load), load, strain, -small, section)
        inner = moment(strain, start, end, section)
        bend = matvec(section.flexibility, mixed_imbalance(strain, inner, start, end, section))
        # what the elastic element would remember: I + [c] x has a closed inverse
        own = section_at(elastic, e)
        known = matvec(own.stiffness, cross(bend, strain))
        known = scale(small, add(known, matvec_t(own.stiffness_slope, bend)))
        c = scale(small, bend)
        solved = add(subtract(known, cross(c, known)), scale(dot(c, known), c))
        solved = scale(1.0 / (1.0 + dot(c, c)), solved)
        less = matvec(own.flexibility, solved)
        turning = add(cross(strain, solved), matvec(own.stiffness_slope, less))
        put_vector(out[e], 0, subtract(strain, less))
        put_vector(out[e], 3, subtract(bend, matvec(own.flexibility, turning)))
    return out


def potential_energy(arrays: Arrays, x: Iterate) -> float:
    """Return elastic energy and potential of the loads, without inertia and damping [J]."""
    energy = assemble(x, arrays.elements, no_elements(arrays.count))
    return energy + arrays.rest_energy - float(np.sum(arrays.nodal[:, 3:] * x.p))
