# SPDX-License-Identifier: Apache-2.0
"""An independent reference for the rod: shooting from the tip with an adaptive integrator.

Nothing of ``spiral_core``'s solvers is used. The equations of a rod, seen from its material frame,

    p' = R v,   R' = R [u],   m' = -u x m - v x (R^T n),   n' = -w,   u = u* + K^-1 m,

with v = e_x, or (u - u*, v - e_x) = K^-1 (m, R^T n) where K is (6, 6), are integrated from the tip,
where n and m are known, to the base by scipy's DOP853. The unknown is the tip's rotation; it is
found by Newton's method so that the base comes out as the identity.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
from core.rod_cases import Array, cross_matrix, profile, stiffness_at
from numpy.linalg import norm
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from spiral_core import RodLoad, RodProblem

# Perturbation of the tip's rotation for the Jacobian [rad]. Small, because the base's rotation can
# be a million times more sensitive than the tip's where the load presses the rod together.
PERTURBATION = 1e-8
# Longest Newton step [rad]: a guess is near, and more would leave the equilibrium that was meant.
LONGEST_STEP = 0.3
TANGENT = np.array([1.0, 0.0, 0.0])
EPSILON = 1e-13


@dataclass(frozen=True)
class Shape:
    """What was integrated, at S sites from base to tip."""

    positions: Array  # (S, 3), base frame, base at the origin
    frames: Array  # (S, 3, 3)
    moments: Array  # (S, 3), material frame
    forces: Array  # (S, 3), base frame


def integrated(case, tip, sites):
    """Return the shape whose tip is turned so, at the base, the tip and sites between them."""
    length, load = case.rod.length, case.load
    rest, weight = profile(case.rod.rest_strain), profile(load.distributed)
    section = case.rod.section
    uniform = stiffness_at(section, np.zeros(1))[0]
    stiffness = profile(partial(stiffness_at, section) if callable(section) else uniform)

    def slope(s, y):
        frame, m, n = y[3:12].reshape(3, 3), y[12:15], y[15:]
        k, local = stiffness(s), frame.T @ n
        strains = np.linalg.solve(k, np.concatenate((m, local))[: len(k)])
        v = TANGENT + (strains[3:] if len(k) == 6 else 0.0)
        turn = cross_matrix(rest(s) + strains[:3])
        bent = turn @ m + cross_matrix(v) @ local
        return np.concatenate((frame @ v, (frame @ turn).ravel(), -bent, -weight(s)))

    frame = tip.as_matrix()
    y = np.concatenate((np.zeros(3), frame.ravel(), frame.T @ load.tip_moment, load.tip_force))
    found = {length: y}
    for high, low in pairwise((length, *case.rod.breaks[::-1], 0.0)):
        ends = low + EPSILON, high - EPSILON
        # A profile that jumps at an end is asked just inside of it.
        solution = solve_ivp(
            lambda s, y, ends=ends: slope(min(max(s, ends[0]), ends[1]), y),
            (high, low), y, method="DOP853", rtol=1e-11, atol=1e-13,
            t_eval=[*(s for s in sites[::-1] if ends[0] < s < ends[1]), low],
        )  # fmt: skip
        y = solution.y[:, -1]
        found |= zip(solution.t, solution.y.T, strict=True)
    states = np.array([found[s] for s in sorted(found)])
    frames = states[:, 3:12].reshape(-1, 3, 3)
    return Shape(states[:, :3] - states[0, :3], frames, states[:, 12:15], states[:, 15:])


def shoot(case, tip):
    """Return the rotation of the tip, next to a guess, that leaves the base as it is clamped."""

    def base(turn):
        frames = integrated(case, tip * Rotation.from_rotvec(turn), np.zeros(0)).frames
        return Rotation.from_matrix(frames[0]).as_rotvec()

    for _ in range(30):
        miss = base(np.zeros(3))
        if norm(miss) < 1e-8:
            return tip
        slopes = [base(row) - miss for row in PERTURBATION * np.eye(3)]
        step = np.linalg.solve(np.transpose(slopes), -PERTURBATION * miss)
        tip *= Rotation.from_rotvec(step * min(1.0, LONGEST_STEP / norm(step)))
    raise ArithmeticError(f"off by {miss}")


def shoot_from_rest(case, steps):
    """Return the tip's rotation as the load grows from nothing on a uniform rod.

    Needs no solution by anybody else; the load must be moderate, and the rod uniform.
    """
    tip = Rotation.from_rotvec(np.multiply(case.rod.length, case.rod.rest_strain))
    given = case.load.distributed, case.load.tip_force, case.load.tip_moment
    for fraction in np.linspace(0.0, 1.0, steps + 1)[1:]:
        load = RodLoad(*(tuple((fraction * np.array(vector)).tolist()) for vector in given))
        tip = shoot(RodProblem(case.rod, load), tip)
    return tip
