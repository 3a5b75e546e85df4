# SPDX-License-Identifier: Apache-2.0
"""An independent method for a rod against cylinders: constrained minimization over its strains.

Nothing of ``spiral_core`` is used, and nothing is discretized as there. The unknowns are the strain
vectors of N elements; orientations and positions follow by multiplying rotations, so the rod is
inextensible and unshearable by construction. scipy's SLSQP minimizes energy under the inequalities
gap >= 0 at the nodes; its multipliers play no role in what is compared. Errors are of second order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
TANGENT = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class Case:
    """A rod clamped at the origin along x, its loads, and a cylinder."""

    length: float
    stiffness: Array  # (3,) GJ, EI, EI
    rest_strain: Array  # (3,)
    weight: Array  # (3,) per length
    tip_force: Array  # (3,)
    point: Array  # (3,) on the cylinder's axis
    axis: Array  # (3,) unit
    reach: float  # of the centerline: the radii of cylinder and rod


class Minimum(NamedTuple):
    """What was found."""

    positions: Array  # (N + 1, 3)
    forces: Array  # (N + 1,) of the cylinder on the nodes, outward


def least_energy(case: Case, elements: int) -> Minimum:
    """Return the constrained minimum next to the straight rod."""
    h = case.length / elements
    # In these unknowns the elastic energy is half the square of their norm.
    scale = 1.0 / np.sqrt(h * case.stiffness)
    share = np.full(elements + 1, h)
    share[[0, -1]] *= 0.5
    load = share[:, None] * case.weight
    load[-1] += case.tip_force

    def shape(z: Array) -> tuple[Array, Array]:
        return _centerline(case.rest_strain + z.reshape(-1, 3) * scale, h)

    def energy(z: Array) -> tuple[float, Array]:
        positions, slopes = shape(z)
        work = np.einsum("ja,jaib->ib", load, slopes) * scale
        return 0.5 * float(z @ z) - float(np.sum(load * positions)), z - work.ravel()

    def gap(z: Array) -> Array:
        return _across(case, shape(z)[0])[0][1:] / case.length

    def gap_slopes(z: Array) -> Array:
        positions, slopes = shape(z)
        rows = np.einsum("ja,jaib->jib", _across(case, positions)[1], slopes)[1:] * scale
        return rows.reshape(elements, -1) / case.length

    straight = np.tile(-case.rest_strain / scale, elements)
    found = minimize(
        energy, straight, jac=True, method="SLSQP",
        constraints={"type": "ineq", "fun": gap, "jac": gap_slopes},
        options={"maxiter": 1000, "ftol": 1e-13 * case.stiffness[1] / case.length},
    )  # fmt: skip
    if not found.success:
        raise ArithmeticError(found.message)
    # The forces that leave no imbalance, in the least squares.
    rows = gap_slopes(found.x)
    touching = gap(found.x) < 1e-6
    forces = np.zeros(elements + 1)
    forces[1:][touching] = np.linalg.lstsq(rows[touching].T, energy(found.x)[1])[0] / case.length
    return Minimum(shape(found.x)[0], forces)


def _across(case: Case, positions: Array) -> tuple[Array, Array]:
    """Return the gaps (n,) and the outward normals (n, 3)."""
    away = positions - case.point
    away = away - (away @ case.axis)[:, None] * case.axis
    distance = np.linalg.norm(away, axis=1)
    return distance - case.reach, away / distance[:, None]


def _centerline(strains: Array, h: float) -> tuple[Array, Array]:
    """Return positions (N + 1, 3) and their slopes in the strains (N + 1, 3, N, 3)."""
    count = len(strains)
    whole = Rotation.from_rotvec(h * strains).as_matrix()
    half = Rotation.from_rotvec(0.5 * h * strains).as_matrix()
    frames = np.empty((count + 1, 3, 3))
    frames[0] = np.eye(3)
    for i in range(count):
        frames[i + 1] = frames[i] @ whole[i]
    middle = frames[:-1] @ half
    chords = h * middle[:, :, 0]
    positions = np.vstack((np.zeros(3), np.cumsum(chords, axis=0)))
    # A change of an element's strain turns all that follows, and its own chord half as much.
    turns = frames[1:] @ _right_jacobian(h * strains) * h
    own = (
        -h * middle @ _cross_matrix(TANGENT[None]) @ _right_jacobian(0.5 * h * strains) * (0.5 * h)
    )
    lever = positions[:, None] - positions[None, 1:]  # (N + 1, N, 3)
    slopes = -np.einsum("jiab,ibc->jaic", _cross_matrix(lever), turns) + own.transpose(1, 0, 2)
    slopes *= np.tri(count + 1, count, -1)[:, None, :, None]
    return positions, slopes


def _cross_matrix(v: Array) -> Array:
    """Return the matrices (..., 3, 3) of a -> v x a."""
    return np.cross(v[..., None, :], np.eye(3)).swapaxes(-1, -2)


def _right_jacobian(turns: Array) -> Array:
    """Return J (n, 3, 3): exp(a + da) is exp(a) exp(J da), to first order in da."""
    angles = np.maximum(np.linalg.norm(turns, axis=1), 1e-4)[:, None, None]
    first = (1.0 - np.cos(angles)) / angles**2
    second = (angles - np.sin(angles)) / angles**3
    skew = _cross_matrix(turns)
    return np.eye(3) - first * skew + second * skew @ skew
