# SPDX-License-Identifier: Apache-2.0
"""Follow a rod through a sequence of shapes and loads, finding the folds where it snaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from spiral_core.errors import InvalidInputError, SolverError
from spiral_core.rod._continuation import (
    MAX_FOLDS,
    SMALLEST_STEP,
    follow_branch,
    minimize_to_stable,
)
from spiral_core.rod._mesh import discretize
from spiral_core.rod._newton import LEFT_BRANCH, minimize
from spiral_core.rod._system import Ending, Solution, System, blended
from spiral_core.rod.contact._continuation import SMALLEST_INCREMENT
from spiral_core.rod.contact.problem import RodProblem
from spiral_core.rod.contact.solve import follow_contact
from spiral_core.rod.solve import (
    checked_counts,
    is_hanging,
    solve_with_counts,
    state_at,
)
from spiral_core.rod.state import RodElement, RodEvent, RodPath, RodState, RodStatus
from spiral_core.rod.types import DEFAULT_TOLERANCE, Array, Rod, RodLoad
from spiral_core.validation import require_all

# At the very end of a branch the equilibrium is ill-conditioned: there it is found less sharply.
PATH_TOLERANCE = 1e-4
SETTLING_ITERATIONS = 10
# A rod that moves by no more than this part of its length has not snapped.
NEXT_TO = 1e-2


def follow_rod(
    problems: Sequence[RodProblem],
    *,
    start: RodState | None = None,
    elements: int | None = None,
    largest_increment: float = 1.0,
    smallest_increment: float = SMALLEST_INCREMENT,
    stop_at_event: bool = False,
) -> RodPath:
    """Return the states of a rod that changes slowly from station to station.

    Between two stations everything is blended and the branch of stable states is followed in steps
    that adapt to it, as :func:`follow_path` does with the inextensible element, where it applies to
    every station, and :func:`~spiral_core.rod.contact.solve.follow_contact` with the mixed one.
    Increments other than the usual ones, ``stop_at_event`` or a start of the mixed element choose
    the mixed one.

    Args:
        problems: the stations, one at least.
        start: the state at the first station (with the mixed element: one of it, at which the
            first way begins); None solves the first station from scratch.
        elements: for all stations; None takes enough for the most demanding one, with the mixed
            element the start's.
        largest_increment: of the way between two stations, in (0, 1]. With friction the states
            depend on the way: give stations, or increments, as close as the slip needs.
        smallest_increment: of the way between two stations: the end of a branch is located so
            closely.
        stop_at_event: whether to end at the first event, without following the motion after it.

    Returns:
        A state for each station that was reached, and the events on the way.

    Raises:
        InvalidInputError: no stations, or stations that differ in more than their values.
        SolverError: the first station has no stable state, or nothing rests after a fold of the
            inextensible element.

    Example:
        >>> from spiral_core import Section
        >>> section = Section.inextensible(3e-4, 2e-4)
        >>> bends = [(-0.5 * k, 0.0, k) for k in (5.0, 10.0, 15.0)]
        >>> load = RodLoad(distributed=(0.24, 0.0, 0.0))
        >>> path = follow_rod([RodProblem(Rod(0.3, section, rest_strain=u), load) for u in bends])
        >>> [state.stable for state in path.states], path.events
        ([True, True, True], ())
    """
    require_all("problems", problems, (RodProblem,), "RodProblem values")
    given = (largest_increment, smallest_increment, stop_at_event)
    mixed = given != (1.0, SMALLEST_INCREMENT, False)
    mixed = mixed or (isinstance(start, RodState) and start.element is RodElement.MIXED)
    if problems and not mixed and all(is_hanging(problem) for problem in problems):
        stations = [(each.rod, each.load) for each in problems]
        path = follow_path(stations, elements=elements, start=start)
        return replace(path, events=tuple(filter(_has_snapped, path.events)))
    return follow_contact(
        problems, start=start, elements=elements, largest_increment=largest_increment,
        smallest_increment=smallest_increment, stop_at_event=stop_at_event,
    )  # fmt: skip


def _has_snapped(fold: RodEvent) -> bool:
    """Return whether a rod moved at a fold: next to a bifurcation it may go on all but there."""
    if fold.after is None:
        return True
    moved = np.abs(fold.after.positions - fold.before.positions).max()
    return bool(moved > NEXT_TO * fold.before.arc_lengths[-1])


def follow_path(
    stations: Sequence[tuple[Rod, RodLoad]],
    *,
    elements: int | None = None,
    start: RodState | None = None,
) -> RodPath:
    """Return the states of a rod that changes slowly from station to station.

    Between two stations length, breaks, stiffness, its product with rest strain, and loads are
    blended, and the branch of stable states is followed in steps that adapt to it. Where no step is
    small enough the branch has ended in a fold: the rod snaps, the place is recorded, and the path
    goes on from where the descent of the energy ends.

    Args:
        stations: the rod and its load at each; e.g. one for each pressure of a sweep.
        elements: for all stations; None takes enough for the most demanding one. A piece between
            breaks has as many as where it is given the most: with breaks that move, more in all.
        start: state at the first station; None follows the loading path there.

    Returns:
        States at the stations, and the folds between them (and before the first: position < 0 is
        not reported; its count is in the first state's ``folds``).

    Raises:
        InvalidInputError: no stations, unequal numbers of breaks, or what
            :func:`~spiral_core.rod.solve.solve_rod` refuses.
        SolverError: no stable state was found after a fold.

    Example:
        >>> from spiral_core import Section
        >>> section = Section.inextensible(3e-4, 2e-4)
        >>> bends = [(-0.5 * k, 0.0, k) for k in (5.0, 10.0, 15.0)]
        >>> load = RodLoad(distributed=(0.24, 0.0, 0.0))
        >>> path = follow_path([(Rod(0.3, section, rest_strain=bend), load) for bend in bends])
        >>> [state.stable for state in path.states], path.events
        ([True, True, True], ())
    """
    if not stations:
        raise InvalidInputError("stations", stations, "at least one")
    every = [checked_counts(rod, load, elements) for rod, load in stations]
    if len({len(counts) for counts in every}) > 1:
        raise InvalidInputError(
            "stations", [rod.breaks for rod, _ in stations], "rods with as many breaks at each"
        )
    counts = tuple(max(column) for column in zip(*every, strict=True))
    state = solve_with_counts(*stations[0], counts, start)
    if state.status is not RodStatus.CONVERGED:
        raise SolverError(state.status, state.residual, state.iterations)
    states, events = [state], []
    system = discretize(*stations[0], counts)
    q = np.array(state.orientations)
    for index, station in enumerate(stations[1:]):
        begin, system = system, discretize(*station, counts)
        met, found = _follow(q, begin, system, index)
        events += met
        states.append(state_at(q, system, len(met), found))
    return RodPath(tuple(states), tuple(events))


def _follow(q: Array, begin: System, end: System, index: int) -> tuple[list[RodEvent], Solution]:
    """Follow the path from station ``index`` to the next; q in place. Return its folds."""
    folds: list[RodEvent] = []
    at, spent = 0.0, 0
    while True:
        at, found = follow_branch(q, begin, end, at, DEFAULT_TOLERANCE, spent)
        if found.outcome != LEFT_BRANCH:
            return folds, found
        here, resting = blended(begin, end, at), q.copy()
        last = minimize(resting, here, Ending(PATH_TOLERANCE, SETTLING_ITERATIONS, True), 0)
        before, position = state_at(resting, here, 0, last), index + at
        at = min(1.0, at + SMALLEST_STEP)
        here = blended(begin, end, at)
        rest = minimize_to_stable(q, here, DEFAULT_TOLERANCE, 0)
        spent = found.iterations + rest.iterations
        after = state_at(q, here, 1, rest)
        if after.status is not RodStatus.CONVERGED:
            raise SolverError(after.status, after.residual, after.iterations)
        folds.append(RodEvent(position, before, after))
        if len(folds) > MAX_FOLDS:
            raise SolverError(RodStatus.FOLD_LIMIT, after.residual, spent)
        if at == 1.0:
            return folds, rest._replace(iterations=spent)
