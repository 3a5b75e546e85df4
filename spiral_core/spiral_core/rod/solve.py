# SPDX-License-Identifier: Apache-2.0
"""Static shape of a pre-curved Cosserat rod; by itself, of a clamped one under dead loads.

The method is derived in ``docs/derivations/rod.md``: the rod's potential energy is minimized, and
the factorization of its Hessian at the end is the certificate that the shape is stable.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from spiral_core.errors import InvalidInputError, SolverError
from spiral_core.rod._algebra import composed, resample
from spiral_core.rod._continuation import (
    SolvedRod,
    evaluated,
    solve_system,
    solve_uniform,
)
from spiral_core.rod._mesh import (
    Counts,
    discretize,
    element_counts,
    path_count,
    path_counts,
    principal_stiffnesses,
    shared_counts,
)
from spiral_core.rod._profiles import (
    UniformRod,
    is_plain,
    require_continuous,
    require_plain,
    stiffness_samples,
    uniform_rod,
    varies,
)
from spiral_core.rod._system import Solution, System
from spiral_core.rod.contact.obstacles import Obstacle
from spiral_core.rod.contact.problem import Clamped, End, Free, PointLoad, RodProblem
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.state import STATUSES, RodElement, RodState, RodStatus
from spiral_core.rod.types import MAX_ELEMENTS, Array, Rod, RodLoad
from spiral_core.validation import require_kind

# A scheme of fourth order: halving the elements multiplies the error by 16.
RICHARDSON = 15.0
# With few elements, or properties with kinks, nothing is known but that the error is of second
# order at least: it is this many times the distance to a solution on twice the elements.
SECOND_ORDER = 4.0 / 3.0
CLAMPED, FREE, NO_LOAD = Clamped(), Free(), RodLoad()
STRAIGHT = [0.0, 0.0, 0.0, 1.0]
# A start's quaternions whose squared norms are farther from 1 are rounded, and normalized.
UNIT_TOLERANCE, ONES = 1e-12, np.ones(4)


def solve_rod(
    rod: Rod | RodProblem,
    load: RodLoad = NO_LOAD,
    *,
    base: End = CLAMPED,
    tip: End = FREE,
    obstacles: tuple[Obstacle, ...] = (),
    point_loads: tuple[PointLoad, ...] = (),
    element: RodElement | None = None,
    elements: int | None = None,
    start: RodState | Array | None = None,
    estimate_error: bool | None = None,
    throw: bool = True,
) -> RodState:
    r"""Return a stable static shape of a rod: of a hanging one, held at its ends, or in contact.

    .. math:: \min_R \int_0^L \tfrac12 (u-u^*)^T K (u-u^*) - n(s) \cdot R(s) e_x \, ds,
        \quad n(s) = F + \int_s^L w \, ds', \quad R' = R \hat u

    That is the inextensible element, some thirty times as fast: of a rod clamped at the origin with
    its tip free, among no obstacles, whose section neither stretches nor shears and that has no
    radius, so that it cannot touch itself. Every other rod is
    solved with the mixed element (:func:`~spiral_core.rod.contact.solve.solve_contact` says how);
    the state's ``element`` says which it was. Where both apply they agree to 1e-6 of the length.

    Without ``start`` the loading path is followed from the rod without rest strain; a fold on the
    way is counted in ``folds`` by the inextensible element. With ``start`` the nearest minimum is
    found from there, as in a control loop; where the start does not fit (another number of
    elements) it is resampled.

    Args:
        rod: the rod; or a problem, which holds its load, ends and obstacles.
        load: distributed load and loads at the tip.
        base: how the end at arc length 0 is held.
        tip: how the other end is held.
        obstacles: several at once; each with its friction.
        point_loads: along the rod.
        element: to solve it with; None chooses. What goes on from a state with obstacles, modes of
            vibration for one, needs that of the mixed one.
        elements: how many, shared out to the pieces between breaks; None takes enough for an error
            of 3e-6 of the length in the median and 3e-5 at worst, as measured.
        start: a state to start from, or a centerline (n, 3) [m] to be released from.
        estimate_error: whether to solve once more on other elements and estimate the
            discretization's error: on half of them, or, where they are few or the rod varies, on
            more. None estimates it with the inextensible element alone: there it is cheap.
        throw: whether a solve that does not converge raises; otherwise its status says so.

    Returns:
        The state, with its certificate of stability.

    Raises:
        InvalidInputError: a profile does not give finite (positive) values of the right shape, a
            property jumps where the rod has no break (the inextensible element looks for that),
            ``elements`` is not in [2, 20000], or the start is neither a state nor a centerline.
        SolverError: no stable equilibrium was found, and ``throw`` is set; carries status, residual
            and iterations.

    Example:
        >>> from spiral_core import Section
        >>> rod = Rod(0.36, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=(-13.5, 0.0, 21.0))
        >>> state = solve_rod(rod, RodLoad(distributed=(0.24, 0.0, 0.0)))
        >>> state.stable, state.positions.shape[1]
        (True, 3)
    """
    if not (element is None or isinstance(element, RodElement)):
        raise InvalidInputError("element", element, "a RodElement, or None")
    released = not (start is None or isinstance(start, RodState))  # from a centerline
    clear = base is CLAMPED and tip is FREE and not obstacles and not point_loads
    if clear and element is None and isinstance(rod, Rod) and not rod.radius and is_plain(rod):
        hanging = not released  # known without a problem's checks
    else:
        if not isinstance(rod, RodProblem):
            rod = RodProblem(rod, load, base, tip, obstacles, point_loads)
        elif not (clear and load is NO_LOAD):
            requirement = "a Rod, where loads, ends or obstacles are given beside it"
            raise InvalidInputError("rod", rod, requirement)
        hanging = is_hanging(rod) and not released
        if element is RodElement.INEXTENSIBLE and not hanging:
            requirement = (
                "MIXED for other than a plain rod without radius, clamped and free, from a state"
            )
            raise InvalidInputError("element", element.name, requirement)
        hanging = hanging and element is not RodElement.MIXED
    if not hanging:
        problem = RodProblem(rod, load) if isinstance(rod, Rod) else rod
        return solve_contact(
            problem, start=start, elements=elements, estimate_error=bool(estimate_error),
            throw=throw,
        )  # fmt: skip
    if isinstance(rod, RodProblem):
        load, rod = rod.load, rod.rod
    counts = checked_counts(rod, load, elements)
    state = solve_with_counts(rod, load, counts, start)
    if state.status is not RodStatus.CONVERGED:
        if throw:
            raise SolverError(state.status, state.residual, state.iterations)
        return state
    if estimate_error is not False:
        return with_error_estimate(rod, load, counts, state)
    return state


def is_hanging(problem: RodProblem) -> bool:
    """Return whether the inextensible element can solve a problem."""
    held = (problem.base, problem.tip) == (CLAMPED, FREE)
    clear = held and not problem.obstacles and not problem.point_loads
    return clear and problem.rod.radius == 0.0 and is_plain(problem.rod)


def checked_counts(rod: Rod, load: RodLoad, elements: object) -> Counts:
    """Return the elements of each piece of a rod: so many in all, or, for None, enough.

    Raises:
        InvalidInputError: not a rod and a load, a property jumps where the rod has no break, or
            ``elements`` is not a whole number in range.
    """
    require_kind("rod", rod, Rod)
    require_kind("load", load, RodLoad)
    require_plain(rod)
    require_continuous(rod, load)
    if elements is None:
        return element_counts(rod, load)
    return shared_counts(rod, load, elements)


def solve_with_counts(rod: Rod, load: RodLoad, counts: Counts, start: object) -> RodState:
    """Return the state reached from ``start`` or, without one, along the loading path."""
    if varies(rod, load):
        system = discretize(rod, load, counts)
        arcs = arc_lengths_of(system.steps)
        coarse = system if start is not None else discretize(rod, load, path_counts(rod, counts))
        q = _first_orientations(start, arcs)
        solved = solve_system(q, coarse, system, start is not None)
        return state_from_solved(arcs, q, solved, system)
    uniform, few_elements = uniform_rod(rod, load), 0
    arcs = even_arc_lengths(rod.length, counts[0])
    q = _first_orientations(start, arcs)
    if start is None:
        turn = uniform.length * math.hypot(*uniform.rest_strain)
        stiffer = uniform.torsional / uniform.bending
        if uniform.coupling != 0.0 or uniform.sideways != uniform.bending:
            softest, farthest = principal_stiffnesses(*stiffness_samples(rod, np.zeros(1)).T)
            stiffer = float((farthest / softest)[0])
        few_elements = path_count(counts[0], turn, stiffer)
    return state_from_solved(arcs, q, solve_uniform(q, uniform, few_elements), uniform)


def _first_orientations(start: object, arcs: Array) -> Array:
    """Return a start's orientations at the arc lengths (n,), or without one room for (n, 4)."""
    if start is None:
        return np.empty((len(arcs), 4))
    q, before = checked_start(start)
    alike = len(before) == len(arcs) and bool((before == arcs).all())
    return q if alike else resample(q, np.diff(before), np.diff(arcs))


def checked_start(start: object) -> tuple[Array, Array]:
    """Return a copy of a start's orientations, and its arc lengths.

    Raises:
        InvalidInputError: the start is not a state of at least three nodes with finite values.
    """
    if not isinstance(start, RodState):
        raise InvalidInputError("start", start, "a RodState")
    q, arcs = np.array(start.orientations, dtype=np.float64), start.arc_lengths
    if q.ndim != 2 or q.shape[1] != 4 or len(q) < 3 or arcs.shape != (len(q),):
        requirement = "a state with arc lengths (n,) and orientations (n, 4) of 3 nodes or more"
        raise InvalidInputError("start", f"arrays {arcs.shape} and {q.shape}", requirement)
    squares = (q * q) @ ONES
    off = squares - 1.0
    if q[0].tolist() != STRAIGHT or not off @ off <= UNIT_TOLERANCE**2:
        if not 0.0 < squares.min() <= squares.max() < math.inf:
            requirement = "a state of finite values"
            raise InvalidInputError("start", "orientations that are not finite", requirement)
        q /= np.sqrt(squares)[:, None]
        back = q[:1] * (-1.0, -1.0, -1.0, 1.0)  # seen from the base: a rod clamped in the frame
        q = composed(np.repeat(back, len(q), axis=0), q)
    return q, arcs


def state_from_solved(
    arcs: Array, q: Array, solved: SolvedRod, data: UniformRod | System
) -> RodState:
    """Return the state with orientations q (N + 1, 4) and the evidence a kernel gave for it."""
    solution, folds, forces, positions, moments, strains = solved
    outcome, iterations, energy, residual, pivot, step, neutral = solution
    contact_forces, none, sticking = _untouched(len(q))
    return RodState(
        status=STATUSES[outcome],
        arc_lengths=arcs.copy(),  # they may be those of other states too
        positions=positions,
        orientations=q,
        forces=forces,
        moments=moments,
        strains=strains,
        contact_forces=contact_forces,
        normal_forces=none,
        gaps=none,
        sticking=sticking,
        base_reaction=-np.concatenate((forces[0], moments[0])),
        tip_reaction=np.zeros(6),
        energy=energy,
        residual=residual,
        smallest_pivot=pivot,
        iterations=iterations,
        folds=folds,
        last_step=step,
        neutral_modes=neutral,
        _data=data,
    )


def state_at(q: Array, system: System, folds: int, found: Solution) -> RodState:
    """Return the state at which a minimization ended, with a copy of the orientations q."""
    solved = evaluated(q, system, folds, found)
    return state_from_solved(arc_lengths_of(system.steps), q.copy(), solved, system)


@lru_cache(maxsize=64)
def _untouched(nodes: int) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return the contact arrays of a rod without obstacles: forces, their size, what sticks."""
    return np.empty((0, nodes, 3)), np.empty((0, nodes)), np.empty((0, nodes), dtype=bool)


@lru_cache(maxsize=64)
def even_arc_lengths(length: float, count: int) -> Array:
    """Return evenly spaced nodes' arc lengths; control loops ask for the same ones repeatedly."""
    return np.linspace(0.0, length, count + 1)


def arc_lengths_of(steps: Array) -> Array:
    """Return the nodes' arc lengths (N + 1,) from the elements' lengths (N,)."""
    return np.concatenate(([0.0], np.cumsum(steps)))


def with_error_estimate(rod: Rod, load: RodLoad, counts: Counts, state: RodState) -> RodState:
    """Return ``state`` with its error estimated from a solve on other elements.

    Half as many where the order of four holds: a uniform rod on enough elements. Otherwise on as
    many as are enough, and at least twice as many.
    """
    enough = element_counts(rod, load)
    pairs = list(zip(counts, enough, strict=True))
    finer = max(math.ceil(max(2 * count, most) / count) for count, most in pairs)
    finer = finer if finer * sum(counts) <= MAX_ELEMENTS else 2
    given = (rod.section, rod.rest_strain, load.distributed)
    halved = all(count % 2 == 0 and count >= most for count, most in pairs)
    if halved and not any(map(callable, given)):
        other = tuple(count // 2 for count in counts)
        stride, other_stride, factor = 2, 1, 1.0 / RICHARDSON
    else:
        other = tuple(finer * count for count in counts)
        stride, other_stride, factor = 1, finer, SECOND_ORDER
    second = solve_with_counts(rod, load, other, state)
    if second.status is not RodStatus.CONVERGED:
        return replace(state, discretization_error=rod.length)
    apart = state.positions[::stride] - second.positions[::other_stride]
    error = factor * float(np.linalg.norm(apart, axis=1).max()) + state.last_step * rod.length
    return replace(state, discretization_error=min(error, 2.0 * rod.length))
