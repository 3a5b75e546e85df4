# SPDX-License-Identifier: Apache-2.0
"""Cost of a state's derivatives, in warm solves of it: ``python -m benchmarks.derivatives``.

12 components of parameters on 60 elements, for both elements, free, in contact and with friction;
a few seconds. ``tests/core/test_derivatives.py`` compares them with differences.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from benchmarks.timing import median_time
from spiral_core import (
    Cylinder,
    Obstacle,
    Rod,
    RodElement,
    RodLoad,
    RodProblem,
    Section,
    differentiate,
    solve_rod,
)

REPEATS = 200
LENGTH = 0.36
COIL = Rod(LENGTH, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=(-13.5, 0.0, 21.0))
HANGING = RodProblem(COIL, RodLoad((0.24, 0.02, 0.0)))
BAR = replace(COIL, radius=3e-3, rest_strain=(0.5, 0.0, 1.0))
STEM = Obstacle.along(Cylinder(0.02), (0.15, 0.0, -0.033), (0.0, 1.0, 0.0))
ROUGH = replace(STEM, friction=0.4)
LYING = RodProblem(BAR, RodLoad((0.0, 0.0, -0.3)), obstacles=(STEM,))
PARAMETERS = ("distributed", "tip_force", "rest_strain")


def ratio(problem: RodProblem, element: RodElement | None) -> tuple[float, float, float]:
    """Return the times of a warm solve and of the derivatives [s], and their ratio."""
    state = solve_rod(problem, elements=60, element=element)
    rest = problem.rod.rest_strain
    if callable(rest):
        raise TypeError("the rest strain of these rods is a vector")
    rod = replace(problem.rod, rest_strain=(rest[0], rest[1], rest[2] + 1e-3))
    near = replace(problem, rod=rod)
    names = (*PARAMETERS, "obstacle_position" if problem.obstacles else "base_rotation")
    solve = partial(solve_rod, near, start=state, elements=60, element=element)
    warm = median_time(partial(solve, estimate_error=False), REPEATS)
    found = median_time(partial(differentiate, state, names), REPEATS)
    return warm, found, found / warm


def main() -> None:
    """Print the times of both, and their ratios."""
    cases = (
        ("inextensible", HANGING, None),
        ("mixed", HANGING, RodElement.MIXED),
        ("in contact", LYING, None),
        ("with friction", replace(LYING, obstacles=(ROUGH,)), None),
    )
    for name, problem, element in cases:
        warm, found, part = ratio(problem, element)
        print(f"{name}: warm {1e6 * warm:.0f} us, derivatives {1e6 * found:.0f} us, {part:.2f}")


if __name__ == "__main__":
    main()
