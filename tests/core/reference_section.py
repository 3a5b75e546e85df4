# SPDX-License-Identifier: Apache-2.0
"""The bent section again, by brute force: energy minimized over local fields with scipy.

Unknown are the axial shift and the angle of every material point around the section, and the screw
motion that sweeps the section along the tube. Nothing is shared with the package: strains come from
positions in space and their spectral derivatives, volume from the flux through a cone of triangles,
gradients from the complex step. Lengths are in units of the wound fibers' radius.
"""

from math import cos, sin, tan

import numpy as np
from scipy.fftpack import diff
from scipy.optimize import minimize

POINTS = 21  # odd: the derivative then sees every mode
GRID = 2.0 * np.pi * np.arange(POINTS) / POINTS
# Of a closed curve, around the section.
DERIVATIVE = np.transpose([diff(one) for one in np.eye(POINTS)])


def least_section(families, gamma, singles, energy, load):
    """Return stretch, curvature and torsion of least energy(I1, I2) - load x volume.

    Per unstretched length, in units of the wound fibers' radius. Fibers are given by their angles
    [rad], the single ones by their whole steps around the section too; the volume is over that at
    rest.
    """
    start = np.concatenate((np.zeros(POINTS), GRID, (1.0, 0.01 * bool(singles), tan(gamma), 1.0)))

    def state(x):
        """Return metric components (axial, mixed, hoop) and the volume per length over pi."""
        shift, angle, (stretch, bend, torsion, radius) = np.split(x, (POINTS, 2 * POINTS))
        turn, rise = np.array([(torsion, 0.0, bend), (stretch, 0.0, 0.0)])
        ring = radius * np.stack((0.0 * angle, np.cos(angle), np.sin(angle)), axis=1)
        points = screwed(ring, shift, turn, rise)
        along, spin = DERIVATIVE @ points, np.cross(turn, points)
        axial = rise + spin - tan(gamma) * along
        cone = (0.5 * rise + spin / 3.0) * np.cross(points, along)
        pairs = (axial, axial), (axial, along), (along, along)
        return *(np.sum(a * b, axis=1) for a, b in pairs), np.sum(cone) * 2.0 / POINTS

    def constraints(x):
        """Return what must vanish: fibers' stretch, and two choices of origin."""
        metric = np.stack(state(x)[:3])

        def stretched(metric, phi):
            c, s = cos(phi), sin(phi)
            return np.array([c * c, 2.0 * s * c, s * s]) @ metric - 1.0

        parts = [stretched(metric, angle) for angle in families]
        parts += [stretched(metric[:, singles], gamma), [np.sum(x[:POINTS])]]
        if not singles:  # else the direction of bending fixes the angles
            parts.append([np.sum((x - start)[POINTS : 2 * POINTS])])
        return np.concatenate(parts)

    def total(x):
        axial, mixed, hoop, volume = state(x)
        area, trace = axial * hoop - mixed * mixed, axial + hoop
        density = np.mean(energy(trace + 1.0 / area, area + trace / area))
        return (density - load * volume) / 1.0e5

    found = minimize(
        total, start, jac=lambda x: gradient(total, x), method="SLSQP",
        constraints={
            "type": "eq", "fun": constraints, "jac": lambda x: gradient(constraints, x),
        },
        options={"maxiter": 400, "ftol": 1e-15},
    )  # fmt: skip
    assert np.abs(constraints(found.x)).max() < 1e-9, found.message
    return found.x[2 * POINTS : -1]


def screwed(points, shift, turn, velocity):
    """Return points moved along the tube: exp of the screw (turn, velocity)."""
    rate = np.sqrt(np.sum(turn * turn) + 1e-24)
    angle = rate * shift
    speed = velocity + np.cross(turn, points)
    across = np.cross(turn, speed)
    parts = shift, (1.0 - np.cos(angle)) / rate**2, (angle - np.sin(angle)) / rate**3
    return points + np.einsum("pn,pni->ni", parts, (speed, across, np.cross(turn, across)))


def gradient(function, x):
    """Return the derivative of a vector function by the complex step, (..., n)."""
    columns = [np.imag(function(x + step)) for step in 1e-30j * np.eye(len(x))]
    return np.transpose(columns) / 1e-30
