# SPDX-License-Identifier: Apache-2.0
"""The same rod by ``scipy.integrate.solve_bvp``, given what makes it fast.

Orientation and moment are a boundary value problem of 7 unknowns, because the force is known
beforehand; the right-hand side is vectorized, its Jacobian analytic, and the position, which the
problem does not need, is the integral of the tangent over the collocation cubics.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy.integrate import solve_bvp
from scipy.spatial.transform import Rotation

from benchmarks.cases import Array, Case

BASE = np.array([0.0, 0.0, 0.0, 1.0])
Slope: TypeAlias = Callable[[Array, Array], Array]


@dataclass(frozen=True, slots=True)
class Collocation:
    """A solution, to be used as the next guess: mesh (n,), states (7, n), tip (3,)."""

    success: bool
    mesh: Array
    states: Array
    tip: Array


def cross(a: Array, b: Array) -> Array:
    """Return a x b for (3, n) arrays."""
    return np.stack(
        (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    )


def skew(a: Array) -> Array:
    """Return the matrices (3, 3, n) of v -> a x v."""
    matrix = np.zeros((3, *a.shape))
    matrix[0, 1], matrix[0, 2], matrix[1, 2] = -a[2], a[1], -a[0]
    matrix[1, 0], matrix[2, 0], matrix[2, 1] = a[2], -a[1], a[0]
    return matrix


def balance(case: Case, y: Array, n: Array) -> Array:
    """Return the derivatives (7, n) of quaternion and moment (7, n) under the force n (3, n)."""
    rest, stiffness = np.array(case.rest_strain)[:, None], case.stiffness[:, None]
    v, w, m = y[:3], y[3], y[4:]
    u = rest + m / stiffness
    pull = (w * w - np.sum(v * v, 0)) * n + 2.0 * (np.sum(v * n, 0) * v - w * cross(v, n))
    out = np.empty_like(y)
    out[:3] = 0.5 * (w * u + cross(v, u))
    out[3] = -0.5 * np.sum(v * u, 0)
    out[4:] = cross(m, u)
    out[5] += pull[2]
    out[6] -= pull[1]
    return out


def equations(case: Case) -> tuple[Slope, Slope]:
    """Return the right-hand side (7, n) and its Jacobian (7, 7, n).

    State: quaternion (x, y, z, w) and moment in the material frame.
    """
    length = case.length
    weight = np.array(case.distributed)[:, None]
    force = np.array(case.tip_force)[:, None]
    rest = np.array(case.rest_strain)[:, None]
    stiffness = case.stiffness[:, None]

    def slope(s: Array, y: Array) -> Array:
        return balance(case, y, force + weight * (length - s))

    def jacobian(s: Array, y: Array) -> Array:
        v, w, m = y[:3], y[3], y[4:]
        u = rest + m / stiffness
        n = force + weight * (length - s)
        eye = np.eye(3)[:, :, None]
        out = np.zeros((7, 7, len(s)))
        out[:3, :3] = -0.5 * skew(u)
        out[:3, 3] = 0.5 * u
        out[3, :3] = -0.5 * u
        by_strain = 0.5 * (w * eye + skew(v))
        out[:3, 4:] = by_strain / stiffness.T[:, :, None]
        out[3, 4:] = -0.5 * v / stiffness
        out[4:, 4:] = skew(m) / stiffness.T[:, :, None] - skew(u)
        by_vector = 2.0 * (v[:, None] * n - n[:, None] * v + np.sum(v * n, 0) * eye + w * skew(n))
        by_scalar = 2.0 * (w * n - cross(v, n))
        out[5, :3], out[5, 3] = by_vector[2], by_scalar[2]
        out[6, :3], out[6, 3] = -by_vector[1], -by_scalar[1]
        return out

    return slope, jacobian


def at_ends(base: Array, tip: Array) -> Array:
    """Return what the ends miss: the base's frame, and the tip's moment (zero)."""
    return np.concatenate((base[:4] - BASE, tip[4:]))


def at_ends_jacobian(_base: Array, _tip: Array) -> tuple[Array, Array]:
    """Return the Jacobians (7, 7) of :func:`at_ends`."""
    by_base, by_tip = np.zeros((7, 7)), np.zeros((7, 7))
    by_base[:4, :4] = np.eye(4)
    by_tip[4:, 4:] = np.eye(3)
    return by_base, by_tip


def solve(case: Case, guess: Collocation, tolerance: float, max_nodes: int = 2000) -> Collocation:
    """Return the solution from a guess."""
    slope, jacobian = equations(case)
    found = solve_bvp(
        slope,
        at_ends,
        guess.mesh,
        guess.states,
        fun_jac=jacobian,
        bc_jac=at_ends_jacobian,
        tol=tolerance,
        max_nodes=max_nodes,
    )
    return Collocation(found.status == 0, found.x, found.y, _tip(found.x, found.y, found.yp))


def solve_plainly(case: Case, guess: Collocation, tolerance: float) -> Collocation:
    """Return the solution of the equations as textbooks have them, without Jacobians.

    Quaternion, moment, position and force are unknown: 13 rows. A guess of 7 rows gets position
    and force from its tangents and the load.
    """
    length, weight = case.length, np.array(case.distributed)[:, None]
    states = guess.states
    if len(states) == 7:
        forward = _tangents(states[:4]) * length / (len(guess.mesh) - 1)
        force = np.array(case.tip_force)[:, None] + weight * (length - guess.mesh)
        states = np.vstack((states, np.cumsum(forward, axis=1) - forward, force))

    def slope(_s: Array, y: Array) -> Array:
        pulled = balance(case, y[:7], y[10:])
        return np.vstack((pulled, _tangents(y[:4]), np.tile(-weight, y.shape[1])))

    def ends(base: Array, tip: Array) -> Array:
        return np.concatenate((at_ends(base, tip[:7]), base[7:10], tip[10:] - case.tip_force))

    found = solve_bvp(slope, ends, guess.mesh, states, tol=tolerance, max_nodes=2000)
    return Collocation(found.status == 0, found.x, found.y, found.y[7:10, -1])


def _tip(mesh: Array, states: Array, slopes: Array) -> Array:
    """Return the tip (3,): Simpson's rule for the tangent over the cubics, as accurate as they."""
    h = np.diff(mesh)
    middle = 0.5 * (states[:4, :-1] + states[:4, 1:])
    middle -= 0.125 * h * np.diff(slopes[:4], axis=1)
    ends, middles = _tangents(states[:4]), _tangents(middle)
    tip: Array = np.sum(h / 6.0 * (ends[:, :-1] + 4.0 * middles + ends[:, 1:]), axis=1)
    return tip


def _tangents(q: Array) -> Array:
    """Return the tangents (3, n) of quaternions (4, n)."""
    x, y, z, w = q / np.linalg.norm(q, axis=0)
    return np.stack((1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)))


def helix_guess(case: Case, nodes: int) -> Collocation:
    """Return the unloaded rod on ``nodes`` mesh points."""
    mesh = np.linspace(0.0, case.length, nodes)
    twist, _, curvature = case.rest_strain
    turns = Rotation.from_rotvec(np.outer(mesh, (twist, 0.0, curvature)))
    states = np.vstack((turns.as_quat().T, np.zeros((3, nodes))))
    return Collocation(True, mesh, states, np.zeros(3))


def straight_guess(case: Case, nodes: int) -> Collocation:
    """Return the rod along its base's tangent on ``nodes`` mesh points."""
    mesh = np.linspace(0.0, case.length, nodes)
    states = np.zeros((7, nodes))
    states[3] = 1.0
    return Collocation(True, mesh, states, np.zeros(3))


def ramp(case: Case, steps: int, nodes: int, tolerance: float) -> Collocation:
    """Return the solution reached from the straight rod by ``steps`` of rest strain."""
    guess = straight_guess(case, nodes)
    for fraction in np.linspace(0.0, 1.0, steps + 1)[1:].tolist():
        guess = solve(case.scaled(fraction), guess, tolerance)
    return guess
