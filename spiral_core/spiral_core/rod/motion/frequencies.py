# SPDX-License-Identifier: Apache-2.0
"""How a rod vibrates about a static state: frequencies and shapes of its slowest modes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.rod.contact._elimination import newton_pass
from spiral_core.rod.contact._mesh import Arrays
from spiral_core.rod.contact._newton import CHORD_COMPLIANCE
from spiral_core.rod.contact.state import ContactState
from spiral_core.rod.motion._terms import masses
from spiral_core.rod.motion.inertia import Damping, Inertia
from spiral_core.rod.types import Array


@dataclass(frozen=True, slots=True, eq=False)
class Modes:
    """The slowest small vibrations about a static state.

    Args:
        frequencies: (k,) increasing, undamped [Hz].
        shapes: (k, n, 3) displacements of the nodes, the largest of each mode of length one.
    """

    frequencies: Array
    shapes: Array

    def settling_times(self, damping: Damping, fraction: float = 0.05) -> Array:
        r"""Return the times in which the modes decay to a fraction of their amplitude (k,) [s].

        .. math:: t = -\ln(x) / \left((2 \pi f)^2 T / 2 + \nu / 2\right)

        Damping of the material and linear drag; the air's drag is left out, which makes the time
        longer than it is. Infinite without damping.
        """
        if not 0.0 < fraction < 1.0:
            raise InvalidInputError("fraction", fraction, "between 0 and 1")
        omega = 2.0 * math.pi * self.frequencies
        decay = 0.5 * (omega * omega * damping.retardation_time + damping.drag_rate)
        times: Array = -math.log(fraction) / decay if np.all(decay > 0.0) else omega * math.inf
        return times


def vibration_modes(state: ContactState, inertia: Inertia, count: int = 6) -> Modes:
    r"""Return the slowest vibrations of a rod about a stable static state.

    .. math:: H \xi = (2 \pi f)^2 M \xi

    with the Hessian H of the static energy and the lumped inertia M. The rod touches nothing.

    Args:
        state: a converged state without contact.
        inertia: of the rod.
        count: how many modes.

    Raises:
        InvalidInputError: the state is not stable, or it touches an obstacle, or there are not as
            many modes.
    """
    if not state.stable or state._point is None or bool(state.touching.any()):
        raise InvalidInputError("state", state.status, "a stable state that touches no obstacle")
    arrays = state._point.arrays
    size = 6 * (arrays.count + 1)
    if not 1 <= count < size // 2:
        raise InvalidInputError("count", count, f"from 1 to {size // 2 - 1}")
    compliance = _compliance(state, arrays)
    lumped = masses(arrays, inertia)
    turning = lumped[:, 3:4] * np.array((2.0, 1.0, 1.0))  # about x, y and z
    root = np.sqrt(np.hstack((turning, lumped[:, :3]))).ravel()
    symmetric = root[:, None] * compliance * root
    values, vectors = np.linalg.eigh(0.5 * (symmetric + symmetric.T))
    chosen = np.argsort(values)[::-1][:count]
    if not values[chosen[-1]] > 0.0:
        raise InvalidInputError("count", count, "no more than the motions left free")
    shapes = (vectors[:, chosen] / root[:, None]).T.reshape(count, -1, 6)[:, :, 3:]
    sizes = np.sqrt(np.max(np.sum(shapes * shapes, axis=2), axis=1))
    shapes /= np.maximum(sizes, 1e-300)[:, None, None]
    return Modes(1.0 / (2.0 * math.pi * np.sqrt(values[chosen])), shapes)


def _compliance(state: ContactState, arrays: Arrays) -> Array:
    """Return the inverse of the Hessian over rotations and displacements, column by column."""
    assert state._point is not None  # noqa: S101 - for the type checker; the caller has looked
    x, count = state._point.x, arrays.count
    size = 6 * (count + 1)
    tangent = np.zeros((count + 1, 6, 6))
    turn = np.zeros((count + 1, 6))
    turn[:, 3:] = -arrays.nodal[:, 3:]
    soft = CHORD_COMPLIANCE * np.diff(arrays.arc_lengths) ** 3 / (12.0 * arrays.bending)
    step, force = np.zeros((count + 1, 6)), np.zeros((count, 3))
    gradient, chord, moments = np.zeros_like(step), np.zeros_like(force), np.zeros((count + 1, 3))
    columns = np.empty((size + 1, size))
    for column in range(size + 1):
        load = turn.copy()
        if column < size:
            load.ravel()[column] -= 1.0
        newton_pass(
            x.q, x.p, x.n, arrays.half, arrays.own, soft, load, tangent, arrays.end_free,
            arrays.step, False, step, force, gradient, chord, moments,
        )  # fmt: skip
        columns[column] = step.ravel()
    compliance: Array = (columns[:-1] - columns[-1]).T
    return compliance
