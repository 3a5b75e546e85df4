# SPDX-License-Identifier: Apache-2.0
"""What one step in time adds to the energy: inertia, damping of the material, drag.

Positions and the two directors across the rod are the coordinates y (N + 1, 9) of the nodes, and
their inertia is diagonal. Derived in ``docs/derivations/motion.md``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._algebra import (
    TANGENT,
    Array,
    add,
    cross,
    dot,
    matrices,
    matrix_at,
    matvec,
    matvec_t,
    quaternion_at,
    scale,
    subtract,
    to_material,
    vector_at,
)
from spiral_core.rod._element import element_frame
from spiral_core.rod.contact._contact import TINY, Iterate
from spiral_core.rod.contact._element import Elements
from spiral_core.rod.contact._mesh import Arrays, node_lengths
from spiral_core.rod.contact._newton import assemble, no_elements
from spiral_core.rod.motion.inertia import AIR_DENSITY, AIR_VISCOSITY, Damping, Inertia


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
    for n in range(x.p.shape[0]):
        for i in range(3):
            gradient[n, 3 + i] += terms.weight[n, i] * (x.p[n, i] - terms.target[n, i])
            tangent[n, 3 + i, 3 + i] += terms.weight[n, i]
            for k in range(3):
                gradient[n, 3 + i] += terms.drag[n, i, k] * (x.p[n, k] - terms.rest[n, k])
                tangent[n, 3 + i, 3 + k] += terms.drag[n, i, k]
        turn = quaternion_at(x.q, n)
        for axis in range(1, 3):
            first = 3 * axis
            kept = (terms.target[n, first], terms.target[n, first + 1], terms.target[n, first + 2])
            seen = scale(terms.weight[n, first], to_material(turn, kept))
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
    out = np.empty((damped.steps.shape[0], 6))
    for e in range(damped.steps.shape[0]):
        a, b = quaternion_at(x.q, e), quaternion_at(x.q, e + 1)
        _, _, strain = element_frame(a, b, damped.steps[e])
        stiffness, slope = matrix_at(damped.stiffness, e), matrix_at(damped.stiffness_slope, e)
        moment = subtract(matvec(stiffness, strain), vector_at(damped.rest, e))
        change = subtract(matvec(slope, strain), vector_at(damped.rest_slope, e))
        change = add(change, cross(strain, moment))
        for end in range(2):
            sign = 1.0 - 2.0 * end
            load = add(vector_at(x.n, e), scale(sign, vector_at(damped.half_load, e)))
            inner = to_material(quaternion_at(x.q, e + end), load)
            stretch = add(TANGENT, matvec(matrix_at(damped.compliance, e), inner))
            change = add(change, scale(0.5, cross(stretch, inner)))
        bend = matvec(matrix_at(damped.flexibility, e), change)
        # what the elastic element would remember: I + [c] x has a closed inverse
        stiffness, slope = matrix_at(elastic.stiffness, e), matrix_at(elastic.stiffness_slope, e)
        flexible = matrix_at(elastic.flexibility, e)
        small = damped.steps[e] * damped.steps[e] / 12.0
        known = add(matvec(stiffness, cross(bend, strain)), matvec_t(slope, bend))
        known, c = scale(small, known), scale(small, bend)
        solved = add(known, add(scale(-1.0, cross(c, known)), scale(dot(c, known), c)))
        solved = scale(1.0 / (1.0 + dot(c, c)), solved)
        less = matvec(flexible, solved)
        turning = matvec(flexible, add(cross(strain, solved), matvec(slope, less)))
        for i in range(3):
            out[e, i] = strain[i] - less[i]
            out[e, 3 + i] = bend[i] - turning[i]
    return out


def step_terms(
    inertia: Array,
    scale: NDArray[np.float64],
    target: Array,
    damping: Damping,
    duration: Array,
    rest: Array,
    drag: Array,
) -> StepTerms:
    """Return the terms of a step.

    Args:
        inertia: of the coordinates (N + 1, 9).
        scale: time squared that turns accelerations into displacements (N + 1, 1) [s^2].
        target: where the nodes would be without forces (N + 1, 9).
        damping: its drag rate counts here.
        duration: by which a displacement from ``rest`` becomes a velocity (N + 1, 1) [s].
        rest: coordinates from which velocities are measured (N + 1, 9).
        drag: force over velocity of the air (N + 1, 3, 3) [N s/m].
    """
    moved, resisted = inertia / scale, inertia * (damping.drag_rate / duration)
    weight = moved + resisted
    middle = (moved * target + resisted * rest) / weight
    return StepTerms(weight, middle, drag / duration[:, :, None], rest[:, :3])


def potential_energy(arrays: Arrays, x: Iterate) -> float:
    """Return elastic energy and potential of the loads, without inertia and damping [J]."""
    energy = assemble(x, arrays.elements, no_elements(arrays.count))
    return energy + arrays.rest_energy - float(np.sum(arrays.nodal[:, 3:] * x.p))
