# SPDX-License-Identifier: Apache-2.0
"""The bent section again, by brute force: energy minimized over local fields with scipy.

Unknown are the axial shift and the angle of every material point around the section, and the screw
motion that sweeps the section along the tube. Nothing is shared with the package: strains come from
positions in space and their spectral derivatives, volume from the flux through a cone of triangles,
gradients from the complex step. Lengths are in units of the wound fibers' radius.
"""

from dataclasses import dataclass
from math import cos, sin, tan

import numpy as np
from scipy.optimize import minimize

POINTS = 21  # odd: the derivative then sees every mode


@dataclass(frozen=True)
class BruteSection:
    """Fibers by their angles [rad], with single fibers at whole steps around the section."""

    families: tuple
    single_angle: float
    singles: list

    def state(self, x):
        """Return metric components (axial, mixed, hoop) and the volume per length over pi."""
        shift, angle = x[:POINTS], x[POINTS : 2 * POINTS]
        stretch, bend, torsion, radius = x[2 * POINTS :]
        turn = np.array([torsion, 0.0 * bend, bend])
        rise = np.array([stretch, 0.0, 0.0])
        start = np.stack((0.0 * angle, radius * np.cos(angle), radius * np.sin(angle)), axis=1)
        points = screwed(start, shift, turn, rise)
        along = DERIVATIVE @ points
        spin = np.cross(turn, points)
        axial = rise + spin - tan(self.single_angle) * along
        cone = (0.5 * rise + spin / 3.0) * np.cross(points, along)
        pairs = (axial, axial), (axial, along), (along, along)
        return *(np.sum(a * b, axis=1) for a, b in pairs), np.sum(cone) * 2.0 / POINTS

    def constraints(self, x):
        """Return what must vanish: fibers' stretch, and two choices of origin."""
        metric = np.stack(self.state(x)[:3])

        def stretched(metric, phi):
            c, s = cos(phi), sin(phi)
            return np.array([c * c, 2.0 * s * c, s * s]) @ metric - 1.0

        parts = [stretched(metric, angle) for angle in self.families]
        parts.append(stretched(metric[:, self.singles], self.single_angle))
        parts.append([np.sum(x[:POINTS])])
        if not self.singles:  # else the direction of bending fixes the angles
            parts.append([np.sum(x[POINTS : 2 * POINTS] - GRID)])
        return np.concatenate(parts)

    def solve(self, energy, pressure, wall):
        """Return stretch, curvature and torsion of least wall x energy(I1, I2) - pressure x volume.

        Per unstretched length, in units of the wound fibers' radius.
        """
        guess = [1.0, 0.01 * bool(self.singles), tan(self.single_angle), 1.0]

        def total(x):
            axial, mixed, hoop, volume = self.state(x)
            area, trace = axial * hoop - mixed * mixed, axial + hoop
            density = np.mean(energy(trace + 1.0 / area, area + trace / area))
            return (density - pressure * volume / wall) / 1.0e5

        found = minimize(
            lambda x: float(total(x)), np.concatenate((np.zeros(POINTS), GRID, guess)),
            jac=lambda x: gradient(total, x), method="SLSQP",
            constraints={
                "type": "eq", "fun": self.constraints,
                "jac": lambda x: gradient(self.constraints, x),
            },
            options={"maxiter": 400, "ftol": 1e-15},
        )  # fmt: skip
        assert np.abs(self.constraints(found.x)).max() < 1e-9, found.message
        return found.x[2 * POINTS : -1]


GRID = 2.0 * np.pi * np.arange(POINTS) / POINTS
ORDERS = np.fft.fftfreq(POINTS, 1.0 / POINTS)
# Of a closed curve, around the section.
DERIVATIVE = np.real(np.fft.ifft(1j * ORDERS[:, None] * np.fft.fft(np.eye(POINTS), axis=0), axis=0))


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
    columns = [np.imag(function(x + 1e-30j * one)) / 1e-30 for one in np.eye(len(x))]
    return np.stack(columns, axis=-1)
