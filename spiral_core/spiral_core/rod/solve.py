"""Static shape of a pre-curved Cosserat rod, clamped at its base, under its weight and tip loads.

The method is derived in ``docs/derivations/rod.md``: the rod's potential energy is minimized, and
the factorization of its Hessian at the end is the certificate that the shape is stable.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from spiral_core.errors import InvalidInputError, SolverError
from spiral_core.rod._arrays import RodArrays, discretize, element_count, floats
from spiral_core.rod._continuation import path_elements, resample, settle, walk, walk_and_refine
from spiral_core.rod._newton import Solution, minimize
from spiral_core.rod._shape import shape_from_orientations
from spiral_core.rod._uniform import Settled, settle_uniform
from spiral_core.rod.types import (
    DEFAULT_TOLERANCE,
    MAX_ELEMENTS,
    Array,
    Rod,
    RodLoad,
    RodState,
    RodStatus,
)

# In the order of the kernels' outcomes.
STATUSES = (
    RodStatus.CONVERGED,
    RodStatus.ITERATION_LIMIT,
    RodStatus.LINE_SEARCH_FAILED,
    RodStatus.NOT_FINITE,
    RodStatus.UNSTABLE,
    RodStatus.LEFT_BRANCH,
)
# At the very end of a branch the equilibrium is ill-conditioned: there it is found less sharply.
PATH_TOLERANCE = 1e-4
SETTLING_ITERATIONS = 10
# A scheme of fourth order: halving the elements multiplies the error by 16.
RICHARDSON = 15.0


def solve_rod(
    rod: Rod,
    load: RodLoad,
    *,
    elements: int | None = None,
    start: RodState | None = None,
    estimate_error: bool = True,
    throw: bool = True,
) -> RodState:
    r"""Return the stable static shape of a clamped rod.

    .. math:: \min_R \int_0^L \tfrac12 (u-u^*)^T K (u-u^*) - n(s) \cdot R(s) e_x \, ds,
        \quad n(s) = F + \int_s^L w \, ds', \quad R' = R \hat u

    Without ``start`` the loading path is followed from the rod without rest strain; a fold on the
    way is counted in ``folds``. With ``start`` the nearest minimum is found from there, as in a
    control loop; where the start does not fit (another number of elements) it is resampled.

    Args:
        rod: length, stiffness and rest strain.
        load: distributed load and loads at the tip.
        elements: how many; None takes enough for an error of 3e-6 of the length in the median and
            3e-5 at worst, as measured.
        start: a state to start from.
        estimate_error: whether to solve once more with half the elements and estimate the
        discretization's error.
        throw: whether a solve that does not converge raises; otherwise its status says so.

    Returns:
        The state, with its certificate of stability.

    Raises:
        InvalidInputError: a profile does not give finite (positive) values of the right shape, or
            ``elements`` is not in [2, 20000].
        SolverError: no stable equilibrium was found, and ``throw`` is set; carries status, residual
            and iterations.

    Example:
        >>> rod = Rod(
        ...     length=0.36,
        ...     bending_stiffness=2.5e-4,
        ...     torsional_stiffness=1.7e-4,
        ...     rest_strain=(-13.5, 0.0, 21.0),
        ... )
        >>> state = solve_rod(rod, RodLoad(distributed=(0.24, 0.0, 0.0)))
        >>> state.stable, state.positions.shape[1]
        (True, 3)
    """
    count = element_count(rod, load) if elements is None else elements
    if type(count) is not int or not 2 <= count <= MAX_ELEMENTS:
        raise InvalidInputError("elements", elements, f"a whole number from 2 to {MAX_ELEMENTS}")
    state = solve_with_elements(rod, load, count, start)
    if state.status is not RodStatus.CONVERGED:
        if throw:
            raise SolverError(state.status, state.residual, state.iterations)
        return state
    if estimate_error:
        return with_error_estimate(rod, load, state)
    return state


def solve_with_elements(rod: Rod, load: RodLoad, count: int, start: RodState | None) -> RodState:
    """Return the state reached from ``start`` or, without one, along the loading path."""
    if start is not None:
        q = start.orientations
        q = q.copy() if len(q) == count + 1 else resample(np.ascontiguousarray(q), count)
        return _settled(rod, load, q)
    arrays = discretize(rod, load, count)
    tolerance = DEFAULT_TOLERANCE * arrays.moment_scale
    turned = float(np.linalg.norm(arrays.rest_strain, axis=1).max()) * rod.length
    coarse_count = path_elements(count, turned)
    if coarse_count == count:
        q, folds, solution = walk(arrays.system, tolerance)
    else:
        coarse = discretize(rod, load, coarse_count)
        q, folds, solution = walk_and_refine(coarse.system, arrays.system, tolerance)
    return state_from_solution(arrays, q, folds, solution)


def _settled(rod: Rod, load: RodLoad, q: Array) -> RodState:
    """Return the state that q (N + 1, 4) settles into; q is used up."""
    bending, torsional = rod.bending_stiffness, rod.torsional_stiffness
    rest, weight = rod.rest_strain, load.distributed
    count = len(q) - 1
    if callable(bending) or callable(torsional) or callable(rest) or callable(weight):
        arrays = discretize(rod, load, count)
        folds, solution = settle(q, arrays.system, DEFAULT_TOLERANCE * arrays.moment_scale)
        return state_from_solution(arrays, q, folds, solution)
    settled = settle_uniform(
        q,
        float(rod.length),
        float(torsional),
        float(bending),
        floats(rest),
        floats(weight),
        floats(load.tip_force),
        floats(load.tip_moment),
    )
    return state_from_settled(rod.length, q, settled)


def state_from_settled(length: float, q: Array, settled: Settled) -> RodState:
    """Return the state of a uniform rod with orientations q (N + 1, 4), as its kernel found it."""
    folds, solution, forces, positions, moments, strains = settled
    outcome, iterations, energy, residual, pivot = solution
    count = len(q) - 1
    return RodState(
        status=STATUSES[outcome],
        arc_lengths=_arc_lengths(length / count, count),
        positions=positions,
        orientations=q,
        forces=forces,
        moments=moments,
        strains=strains,
        energy=energy,
        residual=residual,
        smallest_pivot=pivot,
        iterations=iterations,
        folds=folds,
    )


def state_from_solution(arrays: RodArrays, q: Array, folds: int, solution: Solution) -> RodState:
    """Return the state with orientations q (N + 1, 4) and the evidence a kernel gave for it."""
    outcome, iterations, energy, residual, pivot = solution
    scale = arrays.moment_scale
    positions, moments = shape_from_orientations(
        q, arrays.force, arrays.distributed, arrays.elements, arrays.step
    )
    return RodState(
        status=STATUSES[outcome],
        arc_lengths=_arc_lengths(arrays.step, arrays.count),
        positions=positions,
        orientations=q,
        forces=arrays.force,
        moments=moments,
        strains=moments / arrays.stiffness + arrays.rest_strain,
        energy=energy + arrays.rest_energy,
        residual=residual / scale,
        smallest_pivot=pivot / scale,
        iterations=iterations,
        folds=folds,
    )


@lru_cache(maxsize=64)
def _arc_lengths(step: float, count: int) -> Array:
    """Return the nodes' arc lengths; control loops ask for the same ones over and over."""
    arc_lengths = np.linspace(0.0, step * count, count + 1)
    arc_lengths.flags.writeable = False
    return arc_lengths


def state_at(arrays: RodArrays, q: Array) -> RodState:
    """Return the equilibrium at or next to orientations q; for a state just before a fold."""
    at = q.copy()
    tolerance = PATH_TOLERANCE * arrays.moment_scale
    solution = minimize(at, arrays.system, tolerance, SETTLING_ITERATIONS, True)
    return state_from_solution(arrays, at, 0, solution)


def with_error_estimate(rod: Rod, load: RodLoad, state: RodState) -> RodState:
    """Return ``state`` with its error estimated from a solve on half as many elements."""
    count = max(2, (len(state.arc_lengths) - 1) // 2)
    coarse = solve_with_elements(rod, load, count, state)
    if coarse.status is not RodStatus.CONVERGED:
        return replace(state, discretization_error=rod.length)
    at = coarse.arc_lengths
    fine = np.column_stack([np.interp(at, state.arc_lengths, x) for x in state.positions.T])
    if (len(state.arc_lengths) - 1) % 2:  # nodes do not coincide: compare where both have one
        fine, coarse_positions = state.positions[[-1]], coarse.positions[[-1]]
    else:
        coarse_positions = coarse.positions
    distance = np.linalg.norm(fine - coarse_positions, axis=1).max()
    return replace(state, discretization_error=float(distance) / RICHARDSON)
