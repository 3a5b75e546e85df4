# SPDX-License-Identifier: Apache-2.0
"""Closure of the wall around the section: its unknowns by Newton's method, starting at rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spiral_core.section.fiber_set import Array, FiberSet, Numbers
from spiral_core.section.ring import Ring, ring_at

# The complex step: derivatives to rounding.
STEP = 1e-30
NEWTON_STEPS, CONVERGED, ROUNDING = 8, 1e-14, 4e-15
# Rows solved at once; a first one beyond this strain is approached from rest in so many steps.
ROWS, FAR, RAMP = 6, 0.1, 24


def ring_of(fibers: FiberSet, far_strains: Numbers, unknowns: Numbers) -> Ring:
    """Return the section at the unknowns of its closure: g - T, and the single fibers' angle."""
    near = unknowns[:, 1] if unknowns.shape[1] > 1 else 0.0
    return ring_at(fibers, far_strains, unknowns[:, 0], near)


def _residuals(fibers: FiberSet, far_strains: Numbers, unknowns: Numbers) -> Numbers:
    ring = ring_of(fibers, far_strains, unknowns)
    parts = (ring.warp, ring.spread)[: unknowns.shape[1]]
    return np.stack(parts, axis=1)


def _jacobian(fibers: FiberSet, far_strains: Numbers, unknowns: Array) -> Array:
    """Return the derivatives (n, equations, unknowns) of the closure."""
    columns = [
        _residuals(fibers, far_strains, unknowns + 1j * STEP * one).imag / STEP
        for one in np.eye(unknowns.shape[1])
    ]
    return np.stack(columns, axis=2)


def closure_slopes(fibers: FiberSet, far_strains: Array, unknowns: Array) -> Array:
    """Return d(unknowns)/dy along the path."""
    change = _residuals(fibers, far_strains + 1j * STEP, unknowns + 0j).imag / STEP
    jacobian = _jacobian(fibers, far_strains, unknowns)
    return np.asarray(-np.linalg.solve(jacobian, change[:, :, None])[:, :, 0], dtype=np.float64)


def closures(fibers: FiberSet, far_strains: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the unknowns (n, 1 or 2) that close the section, and where they were found.

    From rest outwards, a few rows at a time, each guessed from the last.
    """
    spread = fibers.half_spread or 0.0
    rest = np.array([[0.0, spread]]) if spread else np.array([[0.0]])
    ratio = closure_slopes(fibers, np.zeros(1), rest)
    order = np.argsort(np.abs(far_strains), kind="stable")
    nearest = far_strains[order[0]]
    ramp = nearest * np.arange(1, RAMP) / RAMP if abs(nearest) > FAR else np.zeros(0)
    rows = np.concatenate((ramp, far_strains[order]))
    unknowns = np.full((len(rows), rest.shape[1]), np.nan)
    closed = np.zeros(len(rows), dtype=np.bool_)
    known = 0.0
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for start in range(0, len(rows), ROWS):
            part = slice(start, start + ROWS)
            guess = rest + ratio * rows[part, None]
            unknowns[part], closed[part] = _newton(fibers, rows[part], guess)
            for k in (np.flatnonzero(~closed[part]) + start).tolist():  # too far from the last
                steps = np.linspace(known, float(rows[k]), RAMP)[1:]
                found = _in_steps(fibers, steps, rest, ratio)
                if found is None:
                    break
                unknowns[k], closed[k], known = found, True, float(rows[k])
                ratio = (found - rest) / known
            last = min(start + ROWS, len(rows)) - 1
            if not closed[last]:
                break
            if rows[last] != 0.0:
                ratio, known = (unknowns[last] - rest) / rows[last], float(rows[last])
    back = np.empty_like(order)
    back[order] = np.arange(len(order)) + len(ramp)
    return unknowns[back], closed[back]


def _in_steps(fibers: FiberSet, steps: Array, rest: Array, ratio: Array) -> Array | None:
    """Return the unknowns at the last of some strains, each guessed from the one before."""
    for step in steps[:, None]:
        unknowns, closed = _newton(fibers, step, rest + ratio * step[:, None])
        if not closed[0]:
            return None
        ratio = (unknowns - rest) / step
    return np.asarray((rest + ratio * steps[-1])[0], dtype=np.float64)


def _newton(
    fibers: FiberSet, far_strains: Array, unknowns: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the unknowns that close the section, from a guess, and where they were found."""
    closed = np.zeros(len(far_strains), dtype=np.bool_)
    for _ in range(NEWTON_STEPS):
        residuals = _residuals(fibers, far_strains, unknowns)
        jacobian = _jacobian(fibers, far_strains, unknowns)
        usable = np.isfinite(jacobian).all(axis=(1, 2)) & (np.linalg.det(jacobian) != 0.0)
        jacobian[~usable] = np.eye(unknowns.shape[1])
        step = np.linalg.solve(jacobian, residuals[:, :, None])[:, :, 0]
        unknowns = np.where(usable[:, None], unknowns - step, np.nan)
        floor = abs(fibers.single_slope) + (fibers.half_spread or 0.0)
        size = CONVERGED * (np.abs(far_strains) + np.abs(unknowns[:, 0])) + ROUNDING * floor
        closed = usable & (np.abs(step).max(axis=1) <= size)
        if closed.all():
            break
    return unknowns, closed
