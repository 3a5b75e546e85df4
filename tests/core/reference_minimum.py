# SPDX-License-Identifier: Apache-2.0
"""An independent method for a rod against cylinders: constrained minimization over its strains.

Nothing of ``spiral_core`` is used, and nothing is discretized as there. The unknowns are the strain
vectors of N elements; orientations and positions follow by multiplying rotations, so the rod is
inextensible and unshearable by construction. scipy's SLSQP minimizes energy under the inequalities
gap >= 0 at the nodes; its multipliers play no role in what is compared. Errors are of second order.
"""

import numpy as np
from numpy.linalg import norm
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

TANGENT = np.array([1.0, 0.0, 0.0])


def least_energy(problem, elements):
    """Return the constrained minimum next to the straight rod, clamped at the origin along x.

    Its positions (N + 1, 3), and the outward forces of the cylinder on the nodes that touch it.
    """
    rod, load, (cylinder,) = problem.rod, problem.load, problem.obstacles
    axis = Rotation.from_quat(cylinder.orientation).apply((0.0, 0.0, 1.0))
    h = rod.length / elements
    # In these unknowns the elastic energy is half the square of their norm.
    scale = 1.0 / np.sqrt(h * np.array(rod.section.stiffness))
    pull = np.full((elements + 1, 3), h) * load.distributed
    pull[[0, -1]] *= 0.5
    pull[-1] += load.tip_force

    def shape(z):
        positions, slopes = _centerline(rod.rest_strain + z.reshape(-1, 3) * scale, h)
        return positions, slopes * scale

    def energy(z):
        positions, slopes = shape(z)
        work = np.einsum("ja,jaib->ib", pull, slopes)
        return 0.5 * z @ z - np.sum(pull * positions), z - work.ravel()

    def gaps(z):
        positions, slopes = shape(z)
        away = positions - cylinder.position
        away -= np.outer(away @ axis, axis)
        distance = norm(away, axis=1)
        rows = np.einsum("ja,jaib->jib", away / distance[:, None], slopes)[1:]
        return distance[1:] - cylinder.shape.radius - rod.radius, rows.reshape(elements, -1)

    found = minimize(
        energy, np.tile(-np.array(rod.rest_strain) / scale, elements), jac=True, method="SLSQP",
        constraints={"type": "ineq", "fun": lambda z: gaps(z)[0], "jac": lambda z: gaps(z)[1]},
        options={"maxiter": 1000, "ftol": 1e-13 * rod.section.bending / rod.length},
    )  # fmt: skip
    assert found.success, found.message
    apart, rows = gaps(found.x)
    # The forces that leave no imbalance, in the least squares.
    forces = np.linalg.lstsq(rows[apart < 1e-6].T, energy(found.x)[1])[0]
    return shape(found.x)[0], forces


def _centerline(strains, h):
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


def _cross_matrix(v):
    """Return the matrices (..., 3, 3) of a -> v x a."""
    return np.cross(v[..., None, :], np.eye(3)).swapaxes(-1, -2)


def _right_jacobian(turns):
    """Return J (n, 3, 3): exp(a + da) is exp(a) exp(J da), to first order in da."""
    angles = np.maximum(norm(turns, axis=1), 1e-4)[:, None, None]
    first = (1.0 - np.cos(angles)) / angles**2
    second = (angles - np.sin(angles)) / angles**3
    skew = _cross_matrix(turns)
    return np.eye(3) - first * skew + second * skew @ skew
