# SPDX-License-Identifier: Apache-2.0
"""Many rods at once: chunks in one compiled call each, chunks in parallel on an executor."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.rod._continuation import SolvedRod, solve_uniform
from spiral_core.rod._mesh import least_counts, path_count
from spiral_core.rod._profiles import UniformRod
from spiral_core.rod.state import STATUSES, RodStatus
from spiral_core.rod.types import ZERO, Array, as_floats

IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
# Rods in one task of the executor: enough to hide the task's cost, few enough to share evenly.
CHUNK = 32


@dataclass(frozen=True, slots=True, eq=False)
class RodBatch:
    """States of m rods on n nodes; fields as in :class:`~spiral_core.rod.state.RodState`.

    Args:
        statuses: how each solve ended (m,).
        positions: (m, n, 3) [m].
        orientations: (m, n, 4).
        energies: (m,) [J].
        residuals: (m,), as fractions of EI/L.
        smallest_pivots: (m,), as fractions of EI/L.
        iterations: (m,).
        folds: (m,).
    """

    __repr__ = brief_repr

    statuses: tuple[RodStatus, ...]
    positions: Array
    orientations: Array
    energies: Array
    residuals: Array
    smallest_pivots: Array
    iterations: IntArray
    folds: IntArray

    @property
    def stable(self) -> BoolArray:
        """Which of them are equilibria with a certificate of stability (m,)."""
        return np.array([s is RodStatus.CONVERGED for s in self.statuses]) & (
            self.smallest_pivots > 0.0
        )


def solve_rods(
    lengths: ArrayLike,
    bending: ArrayLike,
    torsional: ArrayLike,
    rest_strains: ArrayLike,
    distributed: ArrayLike,
    tip_forces: ArrayLike = (0.0, 0.0, 0.0),
    *,
    elements: int,
    executor: Executor | None = None,
) -> RodBatch:
    """Return the static shapes of many uniform rods, each along its own loading path.

    The same states as :func:`~spiral_core.rod.solve.solve_rod` without a start, to the last bit.
    The kernel runs outside Python's lock, so that a thread pool is enough to use every core.

    Args:
        lengths: L (m,) or one for all [m]; the other arguments broadcast alike.
        bending: EI [N m^2].
        torsional: GJ [N m^2].
        rest_strains: u* (m, 3) [1/m].
        distributed: force per length (m, 3) [N/m].
        tip_forces: (m, 3) [N].
        elements: number of elements of every rod.
        executor: runs the chunks; None solves them one after another.

    Raises:
        InvalidInputError: shapes do not fit together, a value is not finite, or a length or
            stiffness is not positive; or ``elements`` is not in [2, 20000], or so small that an
            element would turn too far at rest.

    Example:
        >>> batch = solve_rods(0.3, 3e-4, 2e-4, [(-5.0, 0.0, 10.0), (5.0, 0.0, 10.0)],
        ...                    (0.24, 0.0, 0.0), elements=40)
        >>> batch.positions.shape, batch.stable.tolist()
        ((2, 41, 3), [True, True])
    """
    data = _rows(lengths, bending, torsional, rest_strains, distributed, tip_forces)
    turns = data[:, 0] * np.linalg.norm(data[:, 3:6], axis=1)
    elements, _ = least_counts(elements, [float(turns.max())])
    chunks = [data[i : i + CHUNK].tolist() for i in range(0, len(data), CHUNK)]
    run = map if executor is None else executor.map
    solved = run(partial(_solve_chunk, elements), chunks)
    return _batch([state for chunk in solved for state in chunk])


def _solve_chunk(elements: int, rows: list[list[float]]) -> list[tuple[Array, SolvedRod]]:
    """Return orientations and state of each rod of a chunk."""
    states = []
    for length, bending, torsional, *vectors in rows:
        rest, weight, tip = zip(vectors[::3], vectors[1::3], vectors[2::3], strict=True)
        turn = length * math.hypot(*rest)
        few = path_count(elements, turn, torsional / bending)
        rod = UniformRod(length, torsional, bending, bending, 0.0, rest, weight, tip, ZERO)
        q = np.empty((elements + 1, 4))
        states.append((q, solve_uniform(q, rod, few)))
    return states


def _rows(*columns: ArrayLike) -> Array:
    """Return the data of m rods as rows (m, 12), checked."""
    fields = ("lengths", "bending", "torsional", "rest_strains", "distributed", "tip_forces")
    arrays = []
    for field, column, width in zip(fields, columns, (1, 1, 1, 3, 3, 3), strict=True):
        array = as_floats(column)
        array = array[..., None] if width == 1 else array
        fits = array.size and array.ndim in (1, 2) and array.shape[-1] == width
        if not (fits and np.all(np.isfinite(array))):
            shapes = "(m,), or one" if width == 1 else f"(m, {width}) or ({width},)"
            requirement = f"finite values of shape {shapes}"
            raise InvalidInputError(field, column, requirement)
        if width == 1 and not np.all(array > 0.0):
            raise InvalidInputError(field, column, "positive finite values")
        arrays.append(np.atleast_2d(array))
    count = max(map(len, arrays))
    for field, array in zip(fields, arrays, strict=True):
        if len(array) not in (1, count):
            raise InvalidInputError(
                field, len(array), f"one value, or one for each of {count} rods"
            )
    return np.hstack([np.broadcast_to(array, (count, array.shape[1])) for array in arrays])


def _batch(states: list[tuple[Array, SolvedRod]]) -> RodBatch:
    """Join the states of all rods."""
    orientations, solved = zip(*states, strict=True)
    figures = map(np.array, zip(*(one.solution for one in solved), strict=True))
    outcomes, iterations, energies, residuals, pivots, *_ = figures
    return RodBatch(
        statuses=tuple(STATUSES[outcome] for outcome in outcomes.tolist()),
        positions=np.array([one.positions for one in solved]),
        orientations=np.array(orientations),
        energies=energies,
        residuals=residuals,
        smallest_pivots=pivots,
        iterations=iterations,
        folds=np.array([one.folds for one in solved]),
    )
