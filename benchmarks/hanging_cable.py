# SPDX-License-Identifier: Apache-2.0
"""An independent reference for a cable between two supports: bending, stretch and weight.

Nothing of ``spiral_core`` is used: half of the planar elastica is solved by scipy's solve_bvp. With
tension H along and V up at the support, stretch e = 1 + T / EA and the slope theta,

    x' = e cos(theta),  z' = e sin(theta),  theta' = M / EI,  M' = -e Q.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

Array = NDArray[np.float64]


def hanging_cable(
    axial: float, bending: float, weight: float, length: float, span: float, count: int
) -> Array:
    """Return the positions (count + 1, 3) of evenly spaced material points, pinned at z = 0.

    Args:
        axial: EA [N].
        bending: EI [N m^2].
        weight: per unstretched length [N/m].
        length: unstretched [m].
        span: between the supports, along x [m].
        count: how many even parts.
    """
    support = 0.5 * weight * length

    def along(tension: float, s: Array) -> Array:
        hang = np.arcsinh((weight * s - support) / tension) + np.arcsinh(support / tension)
        place: Array = tension * s / axial + tension / weight * hang
        return place

    def gap(tension: float) -> float:
        return float(along(tension, np.array(length))) - span

    # The flexible cable in closed form to start from.
    flexible = brentq(gap, 1e-6 * support, 1e6 * support, xtol=1e-15)
    s = np.linspace(0.0, 0.5 * length, 2001)
    up = (0.5 * weight * s**2 - support * s) / axial + (
        np.hypot(flexible, weight * s - support) - np.hypot(flexible, support)
    ) / weight
    slope = np.arctan2(weight * s - support, flexible)

    def rates(s: Array, y: Array, parameters: Array) -> Array:
        (tension,) = parameters
        cos, sin = np.cos(y[2]), np.sin(y[2])
        force = weight * s - support
        stretch = 1.0 + (tension * cos + force * sin) / axial
        return np.vstack(
            (stretch * cos, stretch * sin, y[3] / bending, -stretch * (force * cos - tension * sin))
        )

    def ends(a: Array, b: Array, _: Array) -> Array:
        return np.array([a[0], a[1], a[3], b[0] - 0.5 * span, b[2]])

    guess = np.vstack((along(flexible, s), up, slope, bending * np.gradient(slope, s)))
    found = solve_bvp(rates, ends, s, guess, p=[flexible], tol=1e-7, max_nodes=100_000)
    if not found.success:
        raise ArithmeticError(found.message)
    sites = np.linspace(0.0, length, count + 1)
    x, z = found.sol(np.minimum(sites, length - sites))[:2]
    x = np.where(sites <= 0.5 * length, x, span - x)
    return np.column_stack((x, np.zeros(count + 1), z))
