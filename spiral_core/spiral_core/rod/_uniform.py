"""A uniform rod's warm solve in one compiled call: what a control loop asks for over and over."""

from typing import TypeAlias

import numpy as np

from spiral_core.numerics.kernel import compiled
from spiral_core.rod._arrays import uniform_arrays
from spiral_core.rod._continuation import settle
from spiral_core.rod._newton import Array, Solution
from spiral_core.rod._shape import shape_from_orientations
from spiral_core.rod.types import DEFAULT_TOLERANCE, Vector

# Folds, solution (the energy complete, residual and pivot as fractions of EI/L), forces, positions,
# moments and strains as `RodState` holds them.
Settled: TypeAlias = tuple[int, Solution, Array, Array, Array, Array]


@compiled
def settle_uniform(
    q: Array,
    length: float,
    torsional: float,
    bending: float,
    rest: Vector,
    weight: Vector,
    tip_force: Vector,
    tip_moment: Vector,
) -> Settled:
    """Settle q, in place, and evaluate the state: the general way, without its arrays between."""
    count = q.shape[0] - 1
    h = length / count
    unit = bending / length
    force, nodal, distributed, elements, rest_energy = uniform_arrays(
        h, count, torsional, bending, rest, weight, tip_force
    )
    system = (force, nodal, np.array(tip_moment), elements, h)
    folds, found = settle(q, system, DEFAULT_TOLERANCE * unit)
    positions, moments = shape_from_orientations(q, force, distributed, elements, h)
    strains = np.empty((count + 1, 3))
    for i in range(count + 1):
        strains[i, 0] = moments[i, 0] / torsional + rest[0]
        strains[i, 1] = moments[i, 1] / bending + rest[1]
        strains[i, 2] = moments[i, 2] / bending + rest[2]
    solution = (found[0], found[1], found[2] + rest_energy, found[3] / unit, found[4] / unit)
    return folds, solution, force, positions, moments, strains
