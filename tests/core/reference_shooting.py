# SPDX-License-Identifier: Apache-2.0
"""An independent reference for the rod: shooting from the tip with an adaptive integrator.

Nothing of ``spiral_core``'s solvers is used. The equations of a rod, seen from its material frame,

    p' = R v,   R' = R [u],   m' = -u x m - v x (R^T n),   n' = -w,   u = u* + K^-1 m,

with v = e_x, or (u - u*, v - e_x) = K^-1 (m, R^T n) where K is (6, 6), are integrated from the tip,
where n and m are known, to the base by scipy's DOP853. The unknown is the tip's rotation; it is
found by Newton's method so that the base comes out as the identity.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from core.rod_cases import stiffness_at, vectors_at
from numpy.linalg import norm
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

# Perturbation of the tip's rotation for the Jacobian [rad]. Small, because the base's rotation can
# be a million times more sensitive than the tip's where the load presses the rod together.
PERTURBATION = 1e-8
# Longest Newton step [rad]: a guess is near, and more would leave the equilibrium that was meant.
LONGEST_STEP = 0.3
TANGENT = np.array([1.0, 0.0, 0.0])
EPSILON = 1e-13
CROSS = np.cross(np.eye(3)[:, None], np.eye(3))  # a @ (b @ CROSS) is a x b


def integrated(case, tip, sites=()):
    """Return the shape whose tip is turned so, at its ends and at sites between them.

    Positions (S, 3), base frame, base at the origin; frames (S, 3, 3); moments (S, 3), material
    frame; forces (S, 3), base frame.
    """
    rod, load = case.rod, case.load

    def slope(s, y, low, high):
        at = np.clip([s], low, high)
        frame, m, n = y[3:12].reshape(3, 3), y[12:15], y[15:]
        k, local = stiffness_at(rod.section, at)[0], n @ frame
        strains = np.linalg.solve(k, np.concatenate((m, local))[: len(k)])
        v = TANGENT + (strains[3:] if len(k) == 6 else 0.0)
        turn = (vectors_at(rod.rest_strain, at)[0] + strains[:3]) @ CROSS
        weight = vectors_at(load.distributed, at)[0]
        bent = m @ turn + local @ (v @ CROSS)
        return np.concatenate((frame @ v, (frame @ turn).ravel(), bent, -weight))

    frame = tip.as_matrix()
    y = np.concatenate((np.zeros(3), frame.ravel(), frame.T @ load.tip_moment, load.tip_force))
    found = {rod.length: y}
    for high, low in pairwise((rod.length, *rod.breaks[::-1], 0.0)):
        # A profile that jumps at an end is asked just inside of it.
        ends = low + EPSILON, high - EPSILON
        places = [*(s for s in sites[::-1] if ends[0] < s < ends[1]), low]
        solution = solve_ivp(
            slope, (high, low), y, "DOP853", places, args=ends, rtol=1e-11, atol=1e-13
        )
        y = solution.y[:, -1]
        found |= zip(solution.t, solution.y.T, strict=True)
    p, frames, moments, forces = np.split(
        np.array([found[s] for s in sorted(found)]), (3, 12, 15), 1
    )
    return p - p[0], frames.reshape(-1, 3, 3), moments, forces


def shoot(case, tip):
    """Return the rotation of the tip, next to a guess, that leaves the base as it is clamped."""

    def base(turn):
        frames = integrated(case, tip * Rotation.from_rotvec(turn))[1]
        return Rotation.from_matrix(frames[0]).as_rotvec()

    for _ in range(30):
        miss = base(np.zeros(3))
        if norm(miss) < 1e-8:
            return tip
        slopes = [base(row) - miss for row in PERTURBATION * np.eye(3)]
        step = np.linalg.solve(np.transpose(slopes), -PERTURBATION * miss)
        tip *= Rotation.from_rotvec(step * min(1.0, LONGEST_STEP / norm(step)))
    raise ArithmeticError(f"off by {miss}")
