# SPDX-License-Identifier: Apache-2.0
"""What one step in time adds to the energy: inertia, damping of the material, drag.

Positions and the two directors across the rod are the coordinates y (N + 1, 9) of the nodes, and
their inertia is diagonal. Derived in ``docs/derivations/motion.md``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from spiral_core.rod.contact._algebra import matrices, node_lengths
from spiral_core.rod.contact._contact import Iterate
from spiral_core.rod.contact._elimination import newton_pass
from spiral_core.rod.contact._laws import TINY
from spiral_core.rod.contact._mesh import Arrays
from spiral_core.rod.motion._kernels import add_step_terms, remembered_strains
from spiral_core.rod.motion.inertia import AIR_DENSITY, AIR_VISCOSITY, Damping, Inertia
from spiral_core.rod.types import Array


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
    steps = np.diff(arrays.arc_lengths)
    return remembered_strains(x.q, x.n, arrays.half, steps, arrays.own, elastic.own)


def stiffened(arrays: Arrays, ratio: Array, strain: Array) -> Arrays:
    """Return the rod with ratio K (u - strain) added to its moments, ratio (N, 1) = T / duration.

    A Kelvin-Voigt material over a step is a stiffer elastic one with another rest strain.

    Args:
        arrays: the elastic rod.
        ratio: for each element.
        strain: mean strains and slopes (N, 6).
    """
    own = arrays.own.copy()
    every = ratio[:, :, None]
    own[:, 4, :2] += every * np.einsum("nkij,nj->nki", own[:, :2], strain[:, :3])
    own[:, 4, 1] -= ratio * np.einsum("nij,nj->ni", own[:, 0], strain[:, 3:])
    own[:, :2] *= 1.0 + every[:, None]
    own[:, 2] /= 1.0 + every
    return replace(arrays, own=own)


def drag_factor(speed: Array, diameter: float, air: float) -> Array:
    """Return force over speed of air per length of rod (n,) [N s/m^2], across the rod."""
    reynolds = AIR_DENSITY * speed * diameter / AIR_VISCOSITY
    coefficient = 1.0 + 10.0 / np.maximum(np.cbrt(reynolds * reynolds), TINY)
    factor: Array = 0.5 * air * AIR_DENSITY * diameter * coefficient * speed
    return np.where(speed > 0.0, factor, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class StepTerms:
    """A quadratic about targets: w/2 (y - z)^2 and (p - r) . A (p - r) / 2.

    Args:
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
        add_step_terms(x.q, x.p, self.weight, self.target, self.drag, self.rest, gradient, tangent)


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
    count = arrays.count
    bare = np.zeros((count + 1, 6))
    energy, _ = newton_pass(
        x.q, x.p, x.n, arrays.half, arrays.own, np.full(count, 1e-9), bare,
        np.zeros((count + 1, 6, 6)), arrays.end_free, arrays.step, True, bare.copy(),
        np.zeros((count, 3)), bare.copy(), np.zeros((count, 3)), np.zeros((count + 1, 3)),
    )  # fmt: skip
    return energy + arrays.rest_energy - float(np.sum(arrays.nodal[:, 3:] * x.p))
