# SPDX-License-Identifier: Apache-2.0
"""An independent reference for the rod: shooting from the tip with an adaptive integrator.

Nothing of ``spiral_core`` is used. The equations of a rod, seen from its material frame,

    p' = R v,   q' = q (u, 0) / 2,   n' = -w,   m' = -u x m - v x (R^T n),   u = u* + K^-1 m,

with v = e_x, or (u - u*, v - e_x) = K^-1 (m, R^T n) where K is (6, 6), are integrated from the tip,
where n and m are known, to the base by scipy's DOP853. The unknown is the tip's rotation; it is
found by Newton's method so that the base comes out as the identity. Many rods are integrated as one
system, each with the three perturbed copies that its Jacobian needs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

Array: TypeAlias = NDArray[np.float64]
Profile: TypeAlias = Array | Callable[[float], Array]

# Perturbation of the tip's rotation for the Jacobian [rad]. Small, because the base's rotation can
# be a million times more sensitive than the tip's where the load presses the rod together.
PERTURBATION = 1e-8
# Longest Newton step [rad]: a guess is near, and more would leave the equilibrium that was meant.
LONGEST_STEP = 0.3
TANGENT = np.array([1.0, 0.0, 0.0])
EPSILON = 1e-13


@dataclass(frozen=True)
class Rods:
    """B rods at once; a profile is (B, 3) or a function of s / L giving (B, 3)."""

    lengths: Array  # (B,)
    stiffness: Profile  # K (B, 3, 3), of twist and bending about y and z, or K (B, 6, 6)
    rest_strain: Profile
    distributed: Profile  # base frame
    tip_force: Array  # (B, 3) base frame
    tip_moment: Array  # (B, 3) base frame
    breaks: tuple[float, ...] = ()  # s / L at which a profile jumps


@dataclass(frozen=True)
class Shapes:
    """What shooting found; S sites from base to tip."""

    positions: Array  # (B, S, 3), base frame, base at the origin
    orientations: Array  # (B, S, 4), scalar last
    moments: Array  # (B, S, 3), material frame
    miss: Array  # (B,) rotation of the base that is left [rad]


def shoot(rods: Rods, tip_orientations: Array, sites: Array, iterations: int = 30) -> Shapes:
    """Return the equilibria whose tips are nearest to the guesses (B, 4); sites are s / L."""
    count = len(rods.lengths)
    perturbed = np.vstack((np.zeros((1, 3)), PERTURBATION * np.eye(3)))
    best = np.full(count, np.inf)
    kept = trial = Rotation.from_quat(tip_orientations)
    steps = np.zeros((count, 3))
    for _ in range(iterations):
        copies = Rotation.from_quat(np.repeat(trial.as_quat(), 4, axis=0)) * Rotation.from_rotvec(
            np.tile(perturbed, (count, 1))
        )
        states = _integrate(rods, copies, 4, np.array([0.0]))[:, 0]
        bases = Rotation.from_quat(states[:, 3:7]).as_rotvec().reshape(count, 4, 3)
        miss = np.linalg.norm(bases[:, 0], axis=1)
        # Newton's step from where the miss fell; half the last one from where it did not.
        fell = miss < best
        best = np.where(fell, miss, best)
        kept = Rotation.from_quat(np.where(fell[:, None], trial.as_quat(), kept.as_quat()))
        jacobian = np.transpose(bases[:, 1:] - bases[:, :1], (0, 2, 1)) / PERTURBATION
        newton = np.linalg.solve(jacobian, -bases[:, 0, :, None])[:, :, 0]
        newton *= np.minimum(1.0, LONGEST_STEP / np.linalg.norm(newton, axis=1))[:, None]
        steps = np.where(fell[:, None], newton, 0.5 * steps)
        if best.max() < 1e-9:
            break
        trial = kept * Rotation.from_rotvec(steps)
    tips = kept
    states = _integrate(rods, tips, 1, sites)
    turned = Rotation.from_quat(states[:, 0, 3:7])
    return Shapes(
        positions=states[:, :, :3] - states[:, :1, :3],
        orientations=states[:, :, 3:7] / np.linalg.norm(states[:, :, 3:7], axis=2)[:, :, None],
        moments=states[:, :, 7:10],
        miss=np.atleast_1d(turned.magnitude()),
    )


def continue_from_rest(rods: Rods, steps: int, sites: Array) -> Shapes:
    """Return the equilibria reached from the unloaded helices as the load grows from nothing.

    Needs no solution by anybody else; the rods must be uniform and the loads moderate.
    """
    if callable(rods.rest_strain) or callable(rods.distributed):
        raise TypeError("only uniform rods start from a helix")
    tips = Rotation.from_rotvec(rods.rest_strain * rods.lengths[:, None]).as_quat()
    shapes = None
    for fraction in np.linspace(0.0, 1.0, steps + 1)[1:]:
        loaded = replace(
            rods,
            distributed=fraction * rods.distributed,
            tip_force=fraction * rods.tip_force,
            tip_moment=fraction * rods.tip_moment,
        )
        shapes = shoot(loaded, tips, sites)
        tips = shapes.orientations[:, -1]
    if shapes is None:
        raise ValueError("at least one step")
    return shapes


def _integrate(rods: Rods, tips: Rotation, copies: int, sites: Array) -> Array:
    """Return the states (B copies, S, 10) of position, quaternion and moment at the sites s / L."""
    lengths = np.repeat(rods.lengths, copies)[:, None]
    count = len(lengths)

    def at(profile: Profile, x: float) -> Array:
        return np.repeat(profile(x) if callable(profile) else profile, copies, axis=0)

    def slope(x: float, flat: Array) -> Array:
        y = flat.reshape(count, 13)
        q, m, n = y[:, 3:7], y[:, 7:10], y[:, 10:13]
        k = at(rods.stiffness, x)
        local = _rotate(q * np.array([-1.0, -1.0, -1.0, 1.0]), n)
        inner = np.column_stack((m, local))[:, : k.shape[1]]
        strains = np.linalg.solve(k, inner[:, :, None])[:, :, 0]
        u = at(rods.rest_strain, x) + strains[:, :3]
        v = np.tile(TANGENT, (count, 1))
        v[:, : strains.shape[1] - 3] += strains[:, 3:]
        out = np.empty_like(y)
        out[:, :3] = _rotate(q, v)
        out[:, 3:6] = 0.5 * (q[:, 3:] * u + _cross(q[:, :3], u))
        out[:, 6] = -0.5 * np.einsum("ij,ij->i", q[:, :3], u)
        out[:, 7:10] = -_cross(u, m) - _cross(v, local)
        out[:, 10:13] = -at(rods.distributed, x)
        return (lengths * out).ravel()

    start = np.zeros((count, 13))
    start[:, 3:7] = tips.as_quat()
    start[:, 7:10] = tips.inv().apply(np.repeat(rods.tip_moment, copies, axis=0))
    start[:, 10:13] = np.repeat(rods.tip_force, copies, axis=0)
    ends = (1.0, *sorted(rods.breaks, reverse=True), 0.0)
    found = []
    for high, low in pairwise(ends):
        # A profile that jumps at an end is asked just inside of it.
        solution = solve_ivp(
            lambda x, y, low=low, high=high: slope(min(max(x, low + EPSILON), high - EPSILON), y),
            (high, low), start.ravel(), method="DOP853", rtol=1e-11, atol=1e-13,
            t_eval=np.unique((*(x for x in sites if low <= x <= high), low, high))[::-1],
        )  # fmt: skip
        if not solution.success:
            raise ArithmeticError(solution.message)
        start = solution.y[:, -1]
        found += zip(solution.t, solution.y.T, strict=True)
    at_sites = dict(found)
    states = np.array([at_sites[x] for x in np.sort(sites)])
    return np.transpose(states.reshape(len(sites), count, 13)[:, :, :10], (1, 0, 2))


def _cross(a: Array, b: Array) -> Array:
    """Return row-wise a x b (np.cross spends most of its time elsewhere)."""
    return np.column_stack(
        (
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        )
    )


def _rotate(q: Array, v: Array) -> Array:
    """Return row-wise R(q) v for (nearly) unit quaternions."""
    t = 2.0 * _cross(q[:, :3], v)
    return v + q[:, 3:] * t + _cross(q[:, :3], t)
