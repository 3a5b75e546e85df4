# SPDX-License-Identifier: Apache-2.0
"""The bent section again, by brute force: energy minimized over local fields with scipy.

Unknown are the axial shift and the angle of every material point around the section, and the screw
motion that sweeps the section along the tube. Nothing is shared with the package: strains come from
positions in space and their spectral derivatives, volume from the flux through a cone of triangles,
gradients from the complex step. Lengths are in units of the wound fibers' radius.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

POINTS = 21  # odd: the derivative then sees every mode
Field = NDArray[Any]
Energy = Callable[[Field, Field], Field]  # u(I1, I2)


@dataclass(frozen=True)
class Found:
    """Shape per unstretched length, in units of the wound fibers' radius."""

    stretch: float
    curvature: float
    torsion: float
    energy: float
    volume: float


@dataclass(frozen=True)
class BruteSection:
    """Fibers by their angles [rad], with single fibers at whole steps around the section."""

    families: tuple[float, ...]
    single_angle: float = 0.0
    singles: tuple[int, ...] = (0,)

    def state(self, x: Field) -> tuple[Field, Field, Field, Field]:
        """Return metric components (axial, mixed, hoop) and the volume per length over pi."""
        shift, angle = x[:POINTS], x[POINTS : 2 * POINTS]
        stretch, bend, torsion, radius = x[2 * POINTS :]
        turn = np.array([torsion, 0.0 * bend, bend])
        start = np.stack((0.0 * angle, radius * np.cos(angle), radius * np.sin(angle)), axis=1)
        points = screwed(start, shift, turn, stretch)
        along = derivative(points)
        flow = np.array([stretch, 0.0, 0.0]) + np.cross(turn, points)
        axial = flow - math.tan(self.single_angle) * along
        volume = np.sum((0.5 * np.array([stretch, 0.0, 0.0]) + np.cross(turn, points) / 3.0)
                        * np.cross(points, along)) * 2.0 / POINTS  # fmt: skip
        dot = lambda a, b: np.sum(a * b, axis=1)  # noqa: E731
        return dot(axial, axial), dot(axial, along), dot(along, along), volume

    def constraints(self, x: Field) -> Field:
        """Return what must vanish: fibers' stretch, and two choices of origin."""
        axial, mixed, hoop, _ = self.state(x)
        parts = []
        for angle in self.families:
            c, s = math.cos(angle), math.sin(angle)
            parts.append(c * c * axial + 2.0 * s * c * mixed + s * s * hoop - 1.0)
        c, s = math.cos(self.single_angle), math.sin(self.single_angle)
        k = list(self.singles)
        parts.append(c * c * axial[k] + 2.0 * s * c * mixed[k] + s * s * hoop[k] - 1.0)
        parts.append([np.sum(x[:POINTS])])
        if not self.singles:  # else the direction of bending fixes the angles
            parts.append([np.sum(x[POINTS : 2 * POINTS] - GRID)])
        return np.concatenate(parts)

    def mean_energy(self, x: Field, energy: Energy) -> Field:
        axial, mixed, hoop, _ = self.state(x)
        area = axial * hoop - mixed * mixed
        trace = axial + hoop
        result: Field = np.mean(energy(trace + 1.0 / area, area + trace / area))
        return result

    def solve(self, energy: Energy, pressure: float, wall: float, guess: Found) -> Found:
        """Return the minimum of wall x energy - pressure x volume, from a guessed shape."""
        start = np.concatenate(
            (np.zeros(POINTS), GRID, [guess.stretch, guess.curvature, guess.torsion, 1.0])
        )
        scale = wall * 1.0e5

        def total(x: Field) -> Field:
            return (wall * self.mean_energy(x, energy) - pressure * self.state(x)[3]) / scale

        found = minimize(
            lambda x: float(total(x)),
            start,
            jac=lambda x: gradient(total, x),
            constraints={
                "type": "eq",
                "fun": self.constraints,
                "jac": lambda x: gradient(self.constraints, x),
            },
            method="SLSQP",
            options={"maxiter": 400, "ftol": 1e-15},
        )
        assert np.abs(self.constraints(found.x)).max() < 1e-9, found.message
        stretch, bend, torsion, _ = found.x[2 * POINTS :]
        return Found(stretch, bend, torsion, float(self.mean_energy(found.x, energy)),
                     float(self.state(found.x)[3]))  # fmt: skip


GRID = 2.0 * np.pi * np.arange(POINTS) / POINTS
_ORDERS = np.fft.fftfreq(POINTS, 1.0 / POINTS)
_DERIVATIVE = np.real(
    np.fft.ifft(1j * _ORDERS[:, None] * np.fft.fft(np.eye(POINTS), axis=0), axis=0)
)


def derivative(points: Field) -> Field:
    """Return the derivative around the section of a closed curve."""
    return _DERIVATIVE @ points


def screwed(points: Field, shift: Field, turn: Field, stretch: Field) -> Field:
    """Return points moved along the tube: exp of the screw (turn, stretch along x)."""
    square = np.sum(turn * turn) + 1e-24
    angle = np.sqrt(square) * shift
    sine = (np.sin(angle) / np.sqrt(square))[:, None]
    cosine = ((1.0 - np.cos(angle)) / square)[:, None]
    rise = ((angle - np.sin(angle)) / (square * np.sqrt(square)))[:, None]
    once = np.cross(turn, points)
    velocity = np.array([stretch, 0.0, 0.0])
    drift, bent = np.cross(turn, velocity), np.cross(turn, np.cross(turn, velocity))
    return (points + sine * once + cosine * np.cross(turn, once)
            + shift[:, None] * velocity + cosine * drift + rise * bent)  # fmt: skip


def gradient(function: Callable[[Field], Field], x: Sequence[float] | Field) -> Field:
    """Return the derivative of a vector function by the complex step, (..., n)."""
    columns = []
    for k in range(len(x)):
        moved = np.asarray(x, dtype=np.complex128)
        moved[k] += 1e-30j
        columns.append(np.imag(function(moved)) / 1e-30)
    return np.stack(columns, axis=-1)
