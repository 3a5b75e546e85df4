# SPDX-License-Identifier: Apache-2.0
"""Many candidates at once: a feasibility map over angle and tube radius, and the Pareto set.

Every candidate is independent of the others, so that any ``concurrent.futures.Executor`` will do:
threads, processes, or a cluster's.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from operator import le

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.design.closing import close_on_objects, judged
from spiral_core.design.evaluation import Evaluation, solve_candidate
from spiral_core.design.margin import Constraint
from spiral_core.design.requirement import Candidate, DesignRequirement, TubeSize
from spiral_core.errors import InvalidInputError
from spiral_core.numerics.tasks import Progress, in_turn
from spiral_core.rod.types import Array
from spiral_core.validation import require_positive


@dataclass(frozen=True, slots=True, eq=False)
class FeasibilityMap:
    """Room on the nearest limit over angle and tube radius.

    Args:
        fiber_angles_beta: (n,) [rad].
        inner_radii: (m,) [m].
        room: (n, m) smallest relative margin; negative where infeasible.
        binding: n rows of m constraints, those which leave that room.
    """

    __repr__ = brief_repr

    fiber_angles_beta: Array
    inner_radii: Array
    room: Array
    binding: tuple[tuple[Constraint, ...], ...]


def solve_points(
    requirement: DesignRequirement,
    candidates: Sequence[Candidate],
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> tuple[Evaluation, ...]:
    """Return every candidate solved as a rod, in the order given.

    Args:
        requirement: objects and limits; what it offers itself is not looked at.
        candidates: what to solve.
        executor: where; None solves one after the other, here.
        progress: called with the number done, in the order given, and the number there are.

    Raises:
        InvalidInputError: pressure would not extend an actuator with these angles.
        SolverError: a shape could not be certified.
    """
    solve = partial(solve_candidate, requirement)
    return tuple(in_turn(solve, candidates, executor, progress))


def feasibility_map(
    requirement: DesignRequirement,
    fiber_angles_beta: Sequence[float],
    inner_radii: Sequence[float],
    wall_thickness: float,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> FeasibilityMap:
    """Return where designs exist, over the second family's angle and the tube's radius.

    Args:
        requirement: objects and limits; its first elastomer is used.
        fiber_angles_beta: angles to look at [rad], rising.
        inner_radii: tube radii to look at [m], rising.
        wall_thickness: of all tubes [m].
        executor: see :func:`solve_points`.
        progress: see :func:`solve_points`.

    Raises:
        InvalidInputError: a value is out of its range.
        SolverError: a shape could not be certified.
    """
    require_positive("wall_thickness", wall_thickness)
    for field, grid in (("fiber_angles_beta", fiber_angles_beta), ("inner_radii", inner_radii)):
        if len(grid) < 2 or not all(low < high for low, high in pairwise(grid)):
            raise InvalidInputError(field, list(grid), "at least two values, rising")
    offer = replace(
        requirement,
        tubes=tuple(TubeSize(f"r = {1e3 * r:.4g} mm", r, wall_thickness) for r in inner_radii),
        elastomers=requirement.elastomers[:1],
        fiber_angles_beta=tuple(fiber_angles_beta),
        fiber_angles_gamma=requirement.fiber_angles_gamma[:1],
    )
    points = solve_points(requirement, offer.candidates(), executor, progress)
    bindings = [point.binding for point in points]  # tube by tube
    rows = [bindings[row :: len(fiber_angles_beta)] for row in range(len(fiber_angles_beta))]
    return FeasibilityMap(
        fiber_angles_beta=np.array(fiber_angles_beta, dtype=np.float64),
        inner_radii=np.array(inner_radii, dtype=np.float64),
        room=np.array([[margin.relative for margin in row] for row in rows]),
        binding=tuple(tuple(margin.constraint for margin in row) for row in rows),
    )


def pareto_set(points: Sequence[Evaluation]) -> tuple[Evaluation, ...]:
    """Return the feasible points that no other beats in pressure, strain and length at once.

    Args:
        points: of a sweep.

    Returns:
        Those for which no feasible point is at most equal in all three and less in one, by rising
        pressure.
    """
    feasible = [
        ((point.pressure or 0.0, point.strain or 0.0, point.length or 0.0), point)
        for point in points
        if point.feasible
    ]
    best = [
        (cost, point)
        for cost, point in feasible
        if not any(other != cost and all(map(le, other, cost)) for other, _ in feasible)
    ]
    return tuple(point for _, point in sorted(best, key=lambda one: one[0][0]))


def closed_pareto_set(
    requirement: DesignRequirement,
    points: Sequence[Evaluation],
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> tuple[Evaluation, ...]:
    """Return :func:`pareto_set` of the points whose grippers wrap their objects, with contact.

    Only what would be in the set is closed on the objects, each where the free coil fits best.

    Args:
        requirement: that the points were solved for.
        points: of a sweep.
        executor: see :func:`solve_points`.
        progress: called with the number closed and the number to close, at each round anew.

    Raises:
        SolverError: a shape could not be certified.
    """
    left, closed = list(points), set[Candidate]()
    while True:
        best = pareto_set(left)
        rest = [point for point in best if point.candidate not in closed]
        if not rest:
            return best
        found = in_turn(partial(_closed, requirement), rest, executor, progress)
        judged_points = {point.candidate: point for point in found}
        closed.update(judged_points)
        left = [judged_points.get(point.candidate, point) for point in left]


def _closed(requirement: DesignRequirement, point: Evaluation) -> Evaluation:
    """Return a candidate whose gripper was also closed on the objects."""
    return judged(requirement, point, close_on_objects(requirement, point, lambda _: None))
