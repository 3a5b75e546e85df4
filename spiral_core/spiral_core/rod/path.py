"""Follow a rod through a sequence of shapes and loads, finding the folds where it snaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spiral_core.errors import InvalidInputError, SolverError
from spiral_core.rod._arrays import between, discretize, element_count
from spiral_core.rod._continuation import advance, snap
from spiral_core.rod._newton import LEFT_BRANCH
from spiral_core.rod.solve import solve_with_elements, state_at, state_from_solution
from spiral_core.rod.types import DEFAULT_TOLERANCE, Array, Rod, RodLoad, RodState, RodStatus


@dataclass(frozen=True, slots=True, eq=False)
class Fold:
    """A place on a path where a branch of stable states ends and the rod snaps to another.

    Args:
        position: where, as a station's index plus the fraction of the way to the next one; located
            to 1/4096 of that way.
        before: the last state of the branch that ends.
        after: the state after the snap.
    """

    position: float
    before: RodState
    after: RodState

    @property
    def energy_released(self) -> float:
        """Potential energy that the snap sets free [J]."""
        return self.before.energy - self.after.energy

    @property
    def tip_jump(self) -> float:
        """Distance that the tip jumps [m]."""
        return float(np.linalg.norm(self.after.tip_position - self.before.tip_position))


@dataclass(frozen=True, slots=True, eq=False)
class RodPath:
    """States along a path.

    Args:
        states: one for each station.
        folds: in the order met; none means that the path is one branch of stable states.
    """

    states: tuple[RodState, ...]
    folds: tuple[Fold, ...]


def follow_path(
    rods: Sequence[Rod],
    loads: RodLoad | Sequence[RodLoad],
    *,
    elements: int | None = None,
    start: RodState | None = None,
) -> RodPath:
    """Return the states of a rod that changes slowly from station to station.

    Between two stations length, stiffness, its product with rest strain, and loads are blended, and
    the branch of stable states is followed in steps that adapt to it. Where no step is small
    enough the branch has ended in a fold: the rod snaps, the place is recorded, and the path goes
    on from where the descent of the energy ends.

    Args:
        rods: the rod at each station; e.g. one for each pressure of a sweep.
        loads: one for all stations, or one for each.
        elements: for all stations; None takes enough for the most demanding one.
        start: state at the first station; None follows the loading path there.

    Returns:
        States at the stations, and the folds between them (and before the first: position < 0 is
        not reported; its count is in the first state's ``folds``).

    Raises:
        InvalidInputError: no stations, or unequal numbers of rods and loads.
        SolverError: no stable state was found after a fold.

    Example:
        >>> rods = [Rod(0.3, 3e-4, 2e-4, (-0.5 * k, 0.0, k)) for k in (5.0, 10.0, 15.0)]
        >>> path = follow_path(rods, RodLoad(distributed=(0.24, 0.0, 0.0)))
        >>> [state.stable for state in path.states], path.folds
        ([True, True, True], ())
    """
    stations = _stations(rods, loads)
    count = elements or max(element_count(*station) for station in stations)
    state = solve_with_elements(*stations[0], count, start)
    if state.status is not RodStatus.CONVERGED:
        raise SolverError(state.status, state.residual, state.iterations)
    states, folds = [state], []
    arrays = discretize(*stations[0], count)
    q: Array = state.orientations.copy()
    for index, station in enumerate(stations[1:]):
        begin, arrays = arrays, discretize(*station, count)
        tolerance = DEFAULT_TOLERANCE * min(begin.moment_scale, arrays.moment_scale)
        at, spent = 0.0, 0
        while True:
            at, solution = advance(q, begin.system, arrays.system, at, tolerance)
            spent += solution[1]
            if solution[0] != LEFT_BRANCH:
                break
            here = between(begin, arrays, at)
            before = state_at(here, q)
            position = index + at
            at, solution = snap(q, begin.system, arrays.system, at, tolerance)
            here = between(begin, arrays, at)
            after = state_from_solution(here, q.copy(), 1, solution)
            if after.status is not RodStatus.CONVERGED:
                raise SolverError(after.status, after.residual, after.iterations)
            folds.append(Fold(position, before, after))
            if at == 1.0:
                break
        met = sum(1 for fold in folds if fold.position >= index)
        solution = (solution[0], spent, *solution[2:])
        states.append(state_from_solution(arrays, q.copy(), met, solution))
    return RodPath(tuple(states), tuple(folds))


def _stations(rods: Sequence[Rod], loads: RodLoad | Sequence[RodLoad]) -> list[tuple[Rod, RodLoad]]:
    """Return rod and load of each station, checked."""
    if not rods:
        raise InvalidInputError("rods", rods, "at least one station")
    each = [loads] * len(rods) if isinstance(loads, RodLoad) else list(loads)
    if len(each) != len(rods):
        raise InvalidInputError("loads", len(each), f"one, or one for each of {len(rods)} rods")
    return list(zip(rods, each, strict=True))
