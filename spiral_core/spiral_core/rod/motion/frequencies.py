# SPDX-License-Identifier: Apache-2.0
"""Vibrations of a rod about a static state: its slowest modes, and their decay."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.rod._algebra import matrices
from spiral_core.rod.contact._contact import TINY, Iterate, Nodal
from spiral_core.rod.contact._mesh import Arrays, node_lengths
from spiral_core.rod.contact._newton import assemble, bearing_of, eliminate, no_elements, no_step
from spiral_core.rod.motion._terms import masses, stiffened, strains
from spiral_core.rod.motion.inertia import Inertia
from spiral_core.rod.motion.swing import Swing, air_coefficients
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Array

# Part of the material's stiffness that is added and taken away, to tell it from the weight's. The
# larger it is, the less rounding errors count; what resists is nearly linear in it.
STIFFER = 3e-2
# A node that touches stays where it is: so many times the largest stiffness of its neighbors.
HELD = 1e6
# Vectors that the iteration keeps beside the modes asked for.
SPARE = 12


@dataclass(frozen=True, slots=True, eq=False)
class Modes:
    """The slowest small vibrations about a static state.

    Args:
        frequencies: (k,) increasing, undamped [Hz].
        shapes: (k, n, 3) displacements of the nodes, the largest of each mode of length one.
        swings: (k,) how the amplitude of each decays.
    """

    __repr__ = brief_repr

    frequencies: Array
    shapes: Array
    swings: tuple[Swing, ...]


def vibration_modes(state: RodState, inertia: Inertia, count: int = 6) -> Modes:
    r"""Return the slowest vibrations of a rod about a stable static state.

    .. math:: H \xi = (2 \pi f)^2 M \xi

    with the Hessian H of the static energy and the lumped inertia M. Nodes that touch an obstacle
    stay where they are. The material's part of a squared angular frequency is
    :math:`-\omega^4\, d(\xi^T M C_r M \xi)/dr` for the compliance C_r of H + r K and
    :math:`\xi \cdot M \xi = 1`.

    Args:
        state: a converged state at rest.
        inertia: of the rod.
        count: how many modes.

    Raises:
        InvalidInputError: the state is not stable or not at rest, a moment loads it, the whole rod
            may turn freely, or there are not as many modes.
    """
    if not state.stable or state._point is None:
        requirement = (
            "a stable state at rest, of the mixed element: solve_rod(..., element=RodElement.MIXED)"
        )
        raise InvalidInputError("state", state.status, requirement)
    if state.neutral_modes:
        raise _free()
    arrays, x = state._point.arrays, state._point.x
    if arrays.nodal[:, :3].any():
        requirement = "one that no moment loads: a dead moment has no energy"
        raise InvalidInputError("state", "one with a moment", requirement)
    still: NDArray[np.bool_] = np.asarray(state.touching.any(axis=0))
    size = 6 * (arrays.count + 1)
    if type(count) is not int or not 1 <= count < size // 2:
        raise InvalidInputError("count", count, f"from 1 to {size // 2 - 1}")
    lumped = masses(arrays, inertia)
    turning = lumped[:, 3:4] * np.array((2.0, 1.0, 1.0))  # about x, y and z
    inertias = np.hstack((turning, lumped[:, :3]))
    values, vectors = _largest(_Compliance(x, arrays, still), np.sqrt(inertias).ravel(), count)
    if not values[-1] > 0.0:
        raise InvalidInputError("count", count, "no more than the motions left free")
    turned = vectors.reshape(count, -1, 6)
    # Forces on a rod whose material alone is softer and stiffer.
    strain, every = strains(x, arrays, arrays), np.full((arrays.count, 1), STIFFER)
    softer, stiffer = (
        _Compliance(x, stiffened(arrays, sign * every, strain), still) for sign in (-1.0, 1.0)
    )
    along, lengths = matrices(x.q)[:, :, 0], node_lengths(arrays.arc_lengths)
    shapes, swings = [], []
    for mode, value in zip(turned, values, strict=True):
        # the modal mass is 1 before the fastest node gets length one
        largest = max(float(np.linalg.norm(mode[:, 3:], axis=1).max()), TINY)
        shape, omega, force = mode[:, 3:] / largest, 1.0 / math.sqrt(value), mode * inertias
        across = shape - np.sum(shape * along, axis=1)[:, None] * along
        speeds = np.linalg.norm(across, axis=1)
        air = air_coefficients(speeds, lengths, 1.0 / largest**2, omega, 2.0 * arrays.radius)
        # how the deflection under the mode's inertia resists more as the material gets stiffer
        more, less = (1.0 / np.sum(force * rod.times(force)) for rod in (stiffer, softer))
        material = float(more - less) / (2.0 * STIFFER)
        shapes.append(shape)
        swings.append(Swing(omega / (2.0 * math.pi), material, *air))
    frequencies = 1.0 / (2.0 * math.pi * np.sqrt(values))
    return Modes(frequencies, np.array(shapes), tuple(swings))


def _free() -> InvalidInputError:
    return InvalidInputError("state", "one that is free to turn", "one that resists every motion")


def _largest(compliance: _Compliance, root: Array, count: int) -> tuple[Array, Array]:
    """Return the largest eigenvalues of R C R, falling, and C's vectors (count, size) for them."""
    size = len(root)

    def symmetric(vector: Array) -> Array:
        product: Array = root * compliance.times((root * vector.ravel()).reshape(-1, 6)).ravel()
        return product

    if 2 * count + SPARE < size // 4:
        from scipy.sparse.linalg import LinearOperator, eigsh

        operator = LinearOperator((size, size), matvec=symmetric, dtype=np.float64)
        kept = 2 * count + SPARE
        values, vectors = eigsh(operator, k=count, ncv=kept, v0=np.sqrt(np.arange(1.0, size + 1.0)))
    else:
        matrix = np.column_stack([symmetric(column) for column in np.eye(size)])
        values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    chosen = np.argsort(values)[::-1][:count]
    return values[chosen], (vectors[:, chosen] / root[:, None]).T


class _Compliance:
    """The inverse of the Hessian over rotations and displacements; touching nodes stay."""

    def __init__(self, x: Iterate, arrays: Arrays, still: NDArray[np.bool_]) -> None:
        count = arrays.count
        self.bearing, self.assembled = bearing_of(arrays), no_elements(count)
        assemble(x, arrays.elements, self.assembled)
        for imbalance in (self.assembled.gradient, self.assembled.chord):
            imbalance[:] = 0.0  # what stands still stays where it is
        self.tangent = np.zeros((count + 1, 6, 6))
        stiffness = (arrays.bending / np.diff(arrays.arc_lengths) ** 3).max()
        for axis in range(3, 6):
            self.tangent[still, axis, axis] = HELD * stiffness

    def times(self, force: Array) -> Array:
        """Return the small motion (n, 6) under forces on rotations and displacements (n, 6)."""
        nodal, step = Nodal(-force, -force, self.tangent), no_step(len(self.bearing.compliance))
        if not eliminate(self.assembled, nodal, self.bearing, False, step) > 0.0:
            raise _free()
        return step.nodes
