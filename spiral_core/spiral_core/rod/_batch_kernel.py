"""Solve a chunk of uniform rods (compiled); the columns of its data are those of `rod_batch`."""

import math

import numpy as np
from numpy.typing import NDArray

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._arrays import uniform_arrays
from spiral_core.rod._continuation import path_elements, walk, walk_and_refine
from spiral_core.rod._newton import Array
from spiral_core.rod._shape import shape_from_orientations
from spiral_core.rod.types import DEFAULT_TOLERANCE


@compiled
def solve_chunk(rods: Array, elements: int) -> tuple[NDArray[np.int64], Array, Array, Array]:
    """Return counts (m, 3), figures (m, 3), positions (m, n, 3) and orientations (m, n, 4).

    A row of ``rods`` (m, 12) is length, EI, GJ, rest strain, distributed load, tip force; counts
    are outcome, iterations and folds; figures are energy [J], and residual and smallest pivot as
    fractions of EI/L.
    """
    m = rods.shape[0]
    counts = np.zeros((m, 3), dtype=np.int64)
    figures = np.zeros((m, 3))
    positions = np.zeros((m, elements + 1, 3))
    orientations = np.zeros((m, elements + 1, 4))
    no_moment = np.zeros(3)
    for i in range(m):
        length, bending, torsional = rods[i, 0], rods[i, 1], rods[i, 2]
        rest = (rods[i, 3], rods[i, 4], rods[i, 5])
        weight = (rods[i, 6], rods[i, 7], rods[i, 8])
        tip = (rods[i, 9], rods[i, 10], rods[i, 11])
        h = length / elements
        force, nodal, distributed, rows, rest_energy = uniform_arrays(
            h, elements, torsional, bending, rest, weight, tip
        )
        fine = (force, nodal, no_moment, rows, h)
        unit = bending / length
        bent = math.sqrt(rest[0] * rest[0] + rest[1] * rest[1] + rest[2] * rest[2])
        few = path_elements(elements, length * bent)
        if few == elements:
            q, folds, solution = walk(fine, DEFAULT_TOLERANCE * unit)
        else:
            coarse_arrays = uniform_arrays(length / few, few, torsional, bending, rest, weight, tip)
            coarse = (coarse_arrays[0], coarse_arrays[1], no_moment, coarse_arrays[3], length / few)
            q, folds, solution = walk_and_refine(coarse, fine, DEFAULT_TOLERANCE * unit)
        shape, _ = shape_from_orientations(q, force, distributed, rows, h)
        counts[i, 0], counts[i, 1], counts[i, 2] = solution[0], solution[1], folds
        figures[i, 0] = solution[2] + rest_energy
        figures[i, 1] = solution[3] / unit
        figures[i, 2] = solution[4] / unit
        positions[i] = shape
        orientations[i] = q
    return counts, figures, positions, orientations
