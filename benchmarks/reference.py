# SPDX-License-Identifier: Apache-2.0
"""An independent answer for uniform rods: shooting from the tip with scipy's DOP853.

The rod's equations, seen from its material frame,

    p' = R e_x,   R' = R [u],   m' = -u x m - e_x x (R^T n),   u = u* + K^-1 m,   n = F + w (L - s)

are integrated from the tip, where the moment vanishes, to the base; the unknown is the tip's
rotation. Nothing of the solver under test is used but, as a first guess, its tip's orientation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from benchmarks.cases import Array, Case
from spiral_core import RodState

# Rotation of the base that may be left [rad]; the tip is then right to 1e-10 of the length.
LARGEST_MISS = 1e-9


@dataclass(frozen=True, slots=True)
class Reference:
    """The exact shape: positions (n, 3) at even arc lengths, and the base's strain (3,)."""

    positions: Array
    base_strain: Array

    @property
    def tip(self) -> Array:
        """Position of the tip (3,) [m]."""
        tip: Array = self.positions[-1]
        return tip


def shoot(case: Case, near: RodState, elements: int) -> Reference:
    """Return the equilibrium next to ``near``, at ``elements`` + 1 arc lengths.

    Raises:
        ArithmeticError: shooting did not reach the base's orientation.
    """
    guess = Rotation.from_quat(near.orientations[-1])
    sites = np.linspace(0.0, case.length, elements + 1)[::-1]

    def miss(turn: Array) -> Array:
        end = _integrate(case, guess * Rotation.from_rotvec(turn), sites[[0, -1]])[:, -1]
        rotation: Array = Rotation.from_matrix(end[3:12].reshape(3, 3)).as_rotvec()
        return rotation

    found = root(miss, np.zeros(3), tol=1e-13)
    if not np.abs(miss(found.x)).max() < LARGEST_MISS:
        raise ArithmeticError(f"shooting ended {np.abs(miss(found.x)).max():.1e} rad off the base")
    states = _integrate(case, guess * Rotation.from_rotvec(found.x), sites)[:, ::-1].T
    strain = np.array(case.rest_strain) + states[0, 12:] / case.stiffness
    return Reference(states[:, :3] - states[0, :3], strain)


def _integrate(case: Case, tip: Rotation, sites: Array) -> Array:
    """Return the states (15, n) of position, rotation matrix and moment from tip to base."""
    length = case.length
    weight, force = np.array(case.distributed), np.array(case.tip_force)
    rest, stiffness = np.array(case.rest_strain), case.stiffness

    def slope(s: float, y: Array) -> Array:
        frame, moment = y[3:12].reshape(3, 3), y[12:]
        u = rest + moment / stiffness
        pull = frame.T @ (force + weight * (length - s))
        turn = np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])
        push = np.array([0.0, pull[2], -pull[1]])  # -e_x x pull
        return np.concatenate((frame[:, 0], (frame @ turn).ravel(), push - turn @ moment))

    start = np.concatenate((np.zeros(3), tip.as_matrix().ravel(), np.zeros(3)))
    solution = solve_ivp(
        slope, (length, 0.0), start, method="DOP853", t_eval=sites, rtol=1e-12, atol=1e-14
    )
    states: Array = solution.y
    return states
