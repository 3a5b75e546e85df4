# SPDX-License-Identifier: Apache-2.0
"""Solve a rod among obstacles, from scratch or from a state nearby, and follow it along a path.

The method is derived in ``docs/derivations/contact.md``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from spiral_core.errors import InvalidInputError, SolverError
from spiral_core.message import Message, Quantity
from spiral_core.rod.contact._continuation import (
    NEXT_TO,
    SMALLEST_INCREMENT,
    Point,
    advance,
    attempt,
    continued,
    halved,
    legs,
    loaded,
    moved_fraction,
    release,
    slide,
    straight,
    tried,
    unsolved,
)
from spiral_core.rod.contact._mesh import (
    Arrays,
    between,
    discretize,
    discretize_like,
    element_count,
    on_nodes,
    shared,
)
from spiral_core.rod.contact._results import PathLog, from_shape, point_of_state, state_from_point
from spiral_core.rod.contact.obstacles import Obstacle, passes_through, seen_from
from spiral_core.rod.contact.problem import RodProblem, require_alike
from spiral_core.rod.state import RodElement, RodEvent, RodPath, RodState, RodStatus
from spiral_core.rod.types import MAX_ELEMENTS, Array
from spiral_core.validation import require_all

# With friction the state that a rod reaches depends on its way there: from the straight rod the
# loads, and then the rest strain, come on in increments of at most this fraction.
FRICTION_INCREMENT = 0.1
# Lift-off moves by nodes, so no order above one is relied on: the error is at most this many times
# the distance to the state on elements half as long.
FIRST_ORDER = 2.0
# On an element shorter than this fraction of the rod forces are rounding errors.
LEAST_APART = 2e-4
# A path with more events than this is given up.
MAX_EVENTS = 64
# On the way between two stations the rod may stay where it was after a failed increment so often,
# each time on twice as much of the way.
MOST_STAYS = 3


def solve_contact(
    problem: RodProblem,
    *,
    start: RodState | Array | None = None,
    elements: int | None = None,
    estimate_error: bool = False,
    throw: bool = True,
) -> RodState:
    r"""Return a stable static shape of a rod among obstacles.

    .. math:: \min_{p, R} \int \tfrac12 (u-u^*)^T K (u-u^*) + \tfrac12 \epsilon^T S \epsilon
        - w \cdot p \; ds \quad \text{with} \quad p' = R (e_x + \epsilon), \; d(p) \ge r

    The mixed element's part of :func:`~spiral_core.rod.solve.solve_rod`.

    Without a start the rod begins straight, along its base, without rest strain, with the obstacles
    in place; loads come on while its tip is brought to where it is held, and then the rest strain.
    Snaps on the way are followed. If that leads nowhere, as where both ends push an inextensible
    rod together, and no obstacle is in between, the rod is released from two legs. With a state as
    start, one increment is made from it (friction goes on from there), or as many as the way needs.
    With a centerline, the rod is released from that shape.

    Args:
        problem: rod, ends, loads and obstacles.
        start: a state, or a centerline (n, 3) [m] along the rod; with one point more than elements,
            the nodes themselves, stretched as they are. From a state of the inextensible element
            the rod is released.
        elements: how many; None takes enough for the rod's rest strain and its obstacles.
        estimate_error: whether to solve once more on elements half as long and estimate the
            discretization's error, the state's ``discretization_error``. It takes about twice the
            time of a warm solve, or with friction, which remembers its way, of the whole solve.
        throw: whether a solve that does not converge raises; otherwise its status says so.

    Returns:
        The state, with its certificate of stability.

    Raises:
        InvalidInputError: a profile, a start or the number of elements is not valid; or point loads
            or breaks are so near to each other or to an end that none is found.
        SolverError: no stable equilibrium was found, and ``throw`` is set.

    Example:
        >>> from spiral_core.rod.contact.obstacles import Obstacle
        >>> from spiral_core.rod.types import Rod, Section
        >>> from spiral_core.rod.contact.shapes import Plane
        >>> from spiral_core.rod.types import RodLoad
        >>> rod = Rod(0.4, Section((1e-4, 1e-4, 1e-4)), radius=2e-3)
        >>> floor = Obstacle(Plane(), position=(0.0, 0.0, -0.02))
        >>> state = solve_contact(
        ...     RodProblem(rod, RodLoad(distributed=(0.0, 0.0, -0.5)), obstacles=(floor,))
        ... )
        >>> state.stable, bool(state.gaps.min() > -1e-6)
        (True, True)
    """
    if estimate_error and isinstance(start, RodState) and _rubs(problem.obstacles):
        requirement = "a start that is no state where there is friction: the slips up to it are not"
        raise InvalidInputError("estimate_error", True, requirement + " known on other elements")
    state = _solved(problem, start, elements)
    if throw and state.status is not RodStatus.CONVERGED:
        length, least = problem.rod.length, float(np.diff(state.arc_lengths).min())
        if (problem.point_loads or problem.rod.breaks) and least < LEAST_APART * length:
            far = Message(
                "at least {} apart and from the ends", Quantity(LEAST_APART * length, "m")
            )
            raise InvalidInputError("point_loads, breaks", least, far, "m")
        raise SolverError(state.status, state.residual, state.iterations)
    if estimate_error and state.status is RodStatus.CONVERGED:
        apart = _halving_changes(problem, start, state)
        return replace(state, discretization_error=FIRST_ORDER * apart)
    return state


def _solved(problem: RodProblem, start: RodState | Array | None, elements: int | None) -> RodState:
    """Return the state that is reached from a start."""
    if isinstance(start, RodState) and start.element is RodElement.MIXED:
        path = follow_contact([problem], start=start, elements=elements)
        return path.states[-1] if path.states else path.events[-1].last
    return _solved_on(problem, discretize(problem, checked_count([problem], elements)), start)


def _solved_on(problem: RodProblem, arrays: Arrays, start: RodState | Array | None) -> RodState:
    """Return the state that is reached on given elements from the straight rod or a shape."""
    if start is None:
        return _from_straight(problem, arrays)
    return _released(unsolved(arrays, from_shape(problem, arrays, start)))


def _released(here: Point) -> RodState:
    """Return the state to which a rod moves from where it is let go."""
    there, rests, trail = release(here)
    status = None if rests else RodStatus.NOT_HELD
    state = state_from_point(tried(there), there.spent, status)
    return replace(state, trail=np.array(trail))


def _halving_changes(problem: RodProblem, start: RodState | Array | None, state: RodState) -> float:
    """Return the largest distance of a node from the state on elements half as long [m].

    That follows from the state or, since friction remembers its way, from the same start.
    """
    coarse = point_of_state(state)
    nodes = coarse.arrays.arc_lengths
    nodes = np.insert(nodes, np.arange(1, len(nodes)), 0.5 * (nodes[:-1] + nodes[1:]))
    arrays = on_nodes(problem, nodes, tuple(2 * count for count in coarse.arrays.pieces))
    if _rubs(problem.obstacles):
        finer = _solved_on(problem, arrays, start)
        positions, found = finer.positions, finer.status is RodStatus.CONVERGED
    else:
        here = unsolved(arrays, halved(coarse, arrays))
        there, _ = attempt(here, arrays)
        positions, found = there.x.p, there.solved
    if not found:
        return math.inf
    return float(np.linalg.norm(positions[::2] - state.positions, axis=1).max())


def _rubs(obstacles: Sequence[Obstacle]) -> bool:
    """Return whether there is friction."""
    return any(obstacle.friction > 0.0 for obstacle in obstacles)


def follow_contact(
    problems: Sequence[RodProblem],
    *,
    start: RodState | None = None,
    elements: int | None = None,
    largest_increment: float = 1.0,
    smallest_increment: float = SMALLEST_INCREMENT,
    stop_at_event: bool = False,
) -> RodPath:
    """Return the states of a rod whose length, shape, loads, ends or obstacles change on a path.

    Between two problems everything is blended, obstacles and ends move along straight lines and
    turn evenly, and the branch of stable states is followed in increments that adapt to it;
    friction remembers. Where no increment is small enough the branch has ended, in a fold or
    because friction no longer holds: the rod moves on, overdamped, to where it rests, the place is
    recorded, and the path goes on from there. If it rests nowhere the path ends. A rod that rests
    where it was, to a tenth of what a node may move in an increment, has not snapped: no event.

    Args:
        problems: the stations; the same rod radius, kinds of ends and obstacles in all of them.
            Where the rod's length changes, nodes keep their fractions of it.
        start: these and what they raise are as of :func:`~spiral_core.rod.path.follow_rod`.
        elements: likewise.
        largest_increment: likewise.
        smallest_increment: likewise; at most the largest.
        stop_at_event: likewise; the event's ``after`` is then None, or NOT_HELD where the rod
            neither moved nor rested.

    Returns:
        A state for each station that was reached, and the events on the way.

    Raises:
        InvalidInputError: no stations, or stations that differ in more than their values.
        SolverError: the first station has no stable state.
    """
    require_all("problems", problems, (RodProblem,), "RodProblem values")
    if not problems:
        raise InvalidInputError("problems", problems, "at least one station")
    if not 0.0 < largest_increment <= 1.0:
        raise InvalidInputError("largest_increment", largest_increment, "in (0, 1]")
    if not 0.0 < smallest_increment <= largest_increment:
        requirement = f"in (0, {largest_increment:g}], the largest increment"
        raise InvalidInputError("smallest_increment", smallest_increment, requirement)
    require_alike(problems)
    states: list[RodState] = []
    log = PathLog()
    stations = list(problems)
    if start is None:
        start = solve_contact(stations.pop(0), elements=checked_count(problems, elements))
        states.append(start)
    here = point_of_state(start)
    count = here.arrays.count
    given = checked_count(problems, count if elements is None else elements)
    if given != count and shared(problems[0], given) != here.arrays.pieces:
        raise InvalidInputError("elements", elements, f"the start's number, {count}")
    before = start._before
    for index, problem in enumerate(stations):
        end = discretize_like(problem, here.arrays)
        sizes = (smallest_increment, largest_increment)
        reached, before, spent = _travel(here, before, end, sizes, stop_at_event, index, log)
        if reached is None:
            break
        states.append(replace(state_from_point(reached, spent, log.status), _before=before))
        here = reached
    return RodPath(tuple(states), tuple(log.events), log.self_contact)


def _travel(
    here: Point,
    before: Point | None,
    end: Arrays,
    sizes: tuple[float, float],
    stop: bool,
    index: int,
    log: PathLog,
) -> tuple[Point | None, Point | None, int]:
    """Go from a point to the next station, over the events on the way; None if the rod is lost.

    ``before`` is the point passed before; the same is returned. ``sizes`` are the smallest and
    the largest increment; ``stop`` ends the way at its first event.
    """
    first = here.arrays
    spent = stays = 0
    here = replace(here, at=0.0)
    before = continued(before, here, end)
    while here.at < 1.0:
        for point in advance(here, end, sizes, first, before):
            before, here = here, point
            spent += point.spent
            log.watch(index + here.at, before.x.p, here.x.p, here.arrays)
        if here.at == 1.0:
            break
        at = min(1.0, here.at + sizes[0] * 2.0**stays)
        arrays = between(first, end, at)
        last = state_from_point(here, spent, log.status)
        position = index + here.at
        there, rests, trail = slide(here, arrays, reach=NEXT_TO if stop else math.inf)
        spent += there.spent
        for passed, reached in pairwise(trail):
            log.watch(position, passed, reached, arrays)
        gone = moved_fraction(here, arrays, there.x.p) > NEXT_TO
        if rests and not gone and stays < MOST_STAYS:
            here, before = replace(there, at=at), None
            stays += 1
            continue
        lost, after = stop or not rests or len(log.events) >= MAX_EVENTS, None
        here, before = tried(there) if lost else replace(there, at=at), None
        if not (stop and gone):
            status = RodStatus.NOT_HELD if lost else log.status
            after = replace(state_from_point(here, here.spent, status), trail=np.array(trail))
        log.events.append(RodEvent(position, last, after))
        if lost:
            return None, None, spent
    return here, before, spent


def _from_straight(problem: RodProblem, arrays: Arrays) -> RodState:
    """Return the state reached from the straight rod, along its loading path."""
    x, first = straight(problem, arrays)
    here = unsolved(first, x)
    if not _is_clear(here):
        return state_from_point(tried(here), 0, RodStatus.INSIDE_OBSTACLE)
    log = PathLog()
    spent = 0
    largest = FRICTION_INCREMENT if _rubs(arrays.obstacles) else 1.0
    for end in (loaded(arrays, first, x), arrays):
        reached, _, used = _travel(here, None, end, (SMALLEST_INCREMENT, largest), False, 0, log)
        spent += used
        if reached is None:
            state, shape = log.events[-1].last, legs(arrays, x)
            if shape is not None:
                bent = unsolved(arrays, from_shape(problem, arrays, shape))
                places = ((o, seen_from(o, x.p), seen_from(o, bent.x.p)) for o in problem.obstacles)
                if _is_clear(bent) and not any(passes_through(*place) for place in places):
                    state = _released(bent)
                    spent += state.iterations
            return replace(state, iterations=spent)
        here = reached
    return state_from_point(here, spent)


def _is_clear(here: Point) -> bool:
    """Return whether a rod is clear of every obstacle, but for its base."""
    arrays = here.arrays
    clear = -1e-3 * max(arrays.radius, 1e-3 * arrays.length)
    return bool((here.solution.contacts.gap[:, 1:] > clear).all())


def checked_count(problems: Sequence[RodProblem], elements: int | None) -> int:
    """Return the number of elements, checked."""
    count = max(element_count(problem) for problem in problems) if elements is None else elements
    if type(count) is not int or not 2 <= count <= MAX_ELEMENTS:
        raise InvalidInputError("elements", elements, f"a whole number from 2 to {MAX_ELEMENTS}")
    return count
