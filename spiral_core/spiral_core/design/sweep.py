# SPDX-License-Identifier: Apache-2.0
"""Many candidates at once: a feasibility map over angle and tube radius, and the Pareto set.

Every candidate is independent of the others, so that any ``concurrent.futures.Executor`` will do:
threads, processes, or a cluster's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.design.closing import close_on_objects, judged
from spiral_core.design.evaluation import Evaluation, estimate_candidate, evaluate_candidate
from spiral_core.design.margin import Constraint, Margin
from spiral_core.design.requirement import Candidate, DesignRequirement, TubeSize
from spiral_core.errors import InvalidInputError
from spiral_core.rod.types import Array
from spiral_core.validation import require_positive

SweepProgress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class SweepPoint:
    """One candidate of a sweep.

    Args:
        candidate: tube, material, angle.
        feasible: whether it meets everything as a rod under gravity.
        binding: the constraint that leaves least room, or that forbids.
        margins: room on every constraint.
        pressure: at the smallest object [Pa]; None if it cannot wrap both objects.
        strain: there; None likewise.
        length: corrected length [m]; None likewise.
    """

    __repr__ = brief_repr

    candidate: Candidate
    feasible: bool
    binding: Margin
    margins: tuple[Margin, ...]
    pressure: float | None
    strain: float | None
    length: float | None


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


def solve_point(
    requirement: DesignRequirement, candidate: Candidate, *, close: bool = False
) -> SweepPoint:
    """Return one candidate of a sweep; plain values in and out, so that it runs anywhere.

    Args:
        requirement: objects and limits.
        candidate: what to solve.
        close: whether its gripper is also closed on the objects, where its free coil lies.
    """
    evaluation = evaluate_candidate(requirement, estimate_candidate(requirement, candidate))
    if close:
        closed = close_on_objects(requirement, evaluation, lambda _: None)
        evaluation = judged(evaluation, closed)
    return _point(evaluation)


def solve_points(
    requirement: DesignRequirement,
    candidates: Sequence[Candidate],
    executor: Executor | None = None,
    progress: SweepProgress | None = None,
) -> tuple[SweepPoint, ...]:
    """Return every candidate solved as a rod, in the order given.

    Args:
        requirement: objects and limits; what it offers itself is not looked at.
        candidates: what to solve.
        executor: where; None solves one after the other, here.
        progress: called with the number done and the number there are, after each.

    Raises:
        InvalidInputError: pressure would not extend an actuator with these angles.
        SolverError: a shape could not be certified.
    """
    return _solved(partial(solve_point, requirement), candidates, executor, progress)


def feasibility_map(
    requirement: DesignRequirement,
    fiber_angles_beta: Sequence[float],
    inner_radii: Sequence[float],
    wall_thickness: float,
    executor: Executor | None = None,
    progress: SweepProgress | None = None,
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
    elastomer, gamma = requirement.elastomers[0], requirement.fiber_angles_gamma[0]
    candidates = [
        Candidate(TubeSize(f"r = {1e3 * r:.4g} mm", r, wall_thickness), elastomer, beta, gamma)
        for beta in replace(
            requirement, fiber_angles_beta=tuple(fiber_angles_beta)
        ).fiber_angles_beta
        for r in inner_radii
    ]
    points = solve_points(requirement, candidates, executor, progress)
    columns = len(inner_radii)
    rows = [points[i : i + columns] for i in range(0, len(points), columns)]
    return FeasibilityMap(
        fiber_angles_beta=np.array(fiber_angles_beta, dtype=np.float64),
        inner_radii=np.array(inner_radii, dtype=np.float64),
        room=np.array([[point.binding.relative for point in row] for row in rows]),
        binding=tuple(tuple(point.binding.constraint for point in row) for row in rows),
    )


def pareto_set(points: Sequence[SweepPoint]) -> tuple[SweepPoint, ...]:
    """Return the feasible points that no other beats in pressure, strain and length at once.

    Args:
        points: of a sweep.

    Returns:
        Those for which no feasible point is at most equal in all three and less in one, by rising
        pressure.
    """
    feasible = [point for point in points if point.feasible]
    costs = {id(point): _costs(point) for point in feasible}

    def is_beaten(point: SweepPoint) -> bool:
        own = costs[id(point)]
        return any(
            cost != own and all(a <= b for a, b in zip(cost, own, strict=True))
            for cost in costs.values()
        )

    return tuple(
        sorted((p for p in feasible if not is_beaten(p)), key=lambda point: _costs(point)[0])
    )


def closed_pareto_set(
    requirement: DesignRequirement,
    points: Sequence[SweepPoint],
    executor: Executor | None = None,
    progress: SweepProgress | None = None,
) -> tuple[SweepPoint, ...]:
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
        rest = [point.candidate for point in best if point.candidate not in closed]
        if not rest:
            return best
        found = _solved(partial(solve_point, requirement, close=True), rest, executor, progress)
        closed.update(rest)
        judged_points = {point.candidate: point for point in found}
        left = [judged_points.get(point.candidate, point) for point in left]


def _solved(
    solve: Callable[[Candidate], SweepPoint],
    candidates: Sequence[Candidate],
    executor: Executor | None,
    progress: SweepProgress | None,
) -> tuple[SweepPoint, ...]:
    """Return every candidate solved, in the order given."""
    done = progress if progress is not None else _silent
    if executor is None:
        points = []
        for number, candidate in enumerate(candidates, start=1):
            points.append(solve(candidate))
            done(number, len(candidates))
        return tuple(points)
    jobs = [executor.submit(solve, candidate) for candidate in candidates]
    try:
        for number, job in enumerate(as_completed(jobs), start=1):
            job.result()
            done(number, len(candidates))
    except BaseException:
        for job in jobs:
            job.cancel()
        raise
    return tuple(job.result() for job in jobs)


def _costs(point: SweepPoint) -> tuple[float, float, float]:
    return (point.pressure or 0.0, point.strain or 0.0, point.length or 0.0)


def _point(evaluation: Evaluation) -> SweepPoint:
    exact = evaluation.exact
    smallest = exact.smallest if exact is not None else None
    return SweepPoint(
        candidate=evaluation.candidate,
        feasible=evaluation.is_feasible,
        binding=evaluation.binding,
        margins=evaluation.margins,
        pressure=smallest.pressure if smallest is not None else None,
        strain=smallest.strain if smallest is not None else None,
        length=exact.length if exact is not None else None,
    )


def _silent(done: int, total: int) -> None:
    """Ignore the progress."""
    del done, total
