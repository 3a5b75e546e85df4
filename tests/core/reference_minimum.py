# SPDX-License-Identifier: Apache-2.0
"""An independent method for a rod against cylinders: constrained minimization over its strains.

Nothing of ``spiral_core`` is used, and nothing is discretized as there. The unknowns are the strain
vectors of N elements; orientations and positions follow by multiplying rotations, so the rod is
inextensible and unshearable by construction. scipy's SLSQP minimizes energy under the inequalities
gap >= 0 at the nodes; its multipliers play no role in what is compared. Errors are of second order.
"""

import numpy as np
from core.documented_energy import BACK, TANGENT, dot, gradient, product, seen
from numpy.linalg import lstsq
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation


def least_energy(problem, elements):
    """Return the constrained minimum next to the straight rod, clamped at the origin along x.

    Its positions (N + 1, 3), and the outward forces of the cylinder on the nodes that touch it.
    """
    rod, load, (cylinder,) = problem.rod, problem.load, problem.obstacles
    across = Rotation.from_quat(cylinder.orientation).as_matrix()[:, :2]
    h = rod.length / elements
    # In these unknowns the elastic energy is half the square of their norm.
    scale = 1.0 / np.sqrt(h * np.array(rod.section.stiffness))
    pull = np.full((elements + 1, 3), h) * load.distributed
    pull[[0, -1]] *= 0.5
    pull[-1] += load.tip_force

    def shape(z):
        return centerline(rod.rest_strain + z.reshape(*z.shape[:-1], -1, 3) * scale, h)

    def energy(z):
        return 0.5 * np.sum(z * z, axis=-1) - np.sum(pull * shape(z), axis=(-1, -2))

    def gaps(z):
        away = (shape(z)[..., 1:, :] - cylinder.position) @ across
        return np.sqrt(dot(away, away))[..., 0] - cylinder.shape.radius - rod.radius

    found = minimize(
        energy, np.tile(-np.array(rod.rest_strain) / scale, elements), method="SLSQP",
        jac=lambda z: gradient(energy, z),
        constraints={"type": "ineq", "fun": gaps, "jac": lambda z: gradient(gaps, z).T},
        options={"maxiter": 1000, "ftol": 1e-13 * rod.section.bending / rod.length},
    )  # fmt: skip
    assert found.success, found.message
    touching = gradient(gaps, found.x)[:, gaps(found.x) < 1e-6]
    # The forces that leave no imbalance, in the least squares.
    return shape(found.x), lstsq(touching, gradient(energy, found.x))[0]


def centerline(strains, h):
    """Return positions (..., N + 1, 3) of elements of even strain, of chords at their middles."""
    turns = 0.25 * h * strains
    angles = np.sqrt(dot(turns, turns) + 1e-30)
    halves = np.concatenate((np.sin(angles) / angles * turns, np.cos(angles)), axis=-1)
    q, middles = np.array((0.0, 0.0, 0.0, 1.0)), []
    for half in np.moveaxis(halves, -2, 0):
        middles.append(product(q, half))
        q = product(middles[-1], half)
    chords = h * seen(np.stack(middles, axis=-2) * BACK, TANGENT[None])
    return np.cumsum(np.pad(chords, [(0, 0)] * (chords.ndim - 2) + [(1, 0), (0, 0)]), axis=-2)
