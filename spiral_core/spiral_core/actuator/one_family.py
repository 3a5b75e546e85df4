# SPDX-License-Identifier: Apache-2.0
r"""One wound family with a single fiber: the elastomer determines the motion that remains free.

One constraint at each point leaves the wall one free motion, z of
:mod:`spiral_core.section.fiber_set`. At a pressure the section takes the state in which the energy
less the work of the pressure is stationary, subject to the wall's closure along the axis:

.. math:: \frac{\partial}{\partial (y, g, z_i)} \left( \frac{A}{\pi a^2} \langle u \rangle
    - P \bar\lambda h^2 + \mu \, \langle \sigma / \eta \rangle \right) = 0

For a strain y of the far side these are as many equations as unknowns: g, z at each angle, the
multiplier and the pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from spiral_core.actuator.actuator import Actuator
from spiral_core.actuator.curve import PressurePanels
from spiral_core.actuator.materials import HyperelasticLaw
from spiral_core.actuator.single_fiber import family_angles
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.numerics.panels import Array, Panels, panel_nodes, relative_tails
from spiral_core.section.closure import STEP
from spiral_core.section.path import ShapePath
from spiral_core.section.ring import FREE_ANGLES, invariant_excess, ring_at

# Differences of gradients that are exact to rounding; Newton's method only needs a good Jacobian.
DIFFERENCE = 1e-6
NEWTON_STEPS, CONVERGED, ROUNDING = 20, 1e-13, 1e-13
RUNAWAY = 1e6
# Panels of the far side's strain: the first, how they grow, the least, and the farthest strain
# looked at, where the far side is 3.6 times as long as at rest.
FIRST_PANEL, GROWTH, LEAST_PANEL, FARTHEST = 0.2, 1.6, 1e-3, 12.0
TAIL_TOLERANCE = 1e-11


@dataclass(frozen=True, slots=True, kw_only=True)
class OneFamilyPath(ShapePath):
    """States of one actuator over the far side's strain, and the pressure that holds them.

    Attributes:
        pressure: the pressure over the strain.
    """

    pressure: PressurePanels


class _States:
    """Stationary states of one actuator, each found from the one before.

    Args:
        actuator: one wound family, with or without a single fiber.
    """

    def __init__(self, actuator: Actuator) -> None:
        self.fibers = actuator.fiber_set
        self.material = actuator.material
        self.scale = actuator.material.small_strain_modulus
        self.wall = actuator.tube.wall_area / (math.pi * actuator.wound_radius**2)
        # g - T, z at each angle, the multiplier, the pressure over the modulus
        self.unknowns: Array = np.zeros(FREE_ANGLES + 3)
        self.strain = 0.0

    def panel(self, low: float, high: float) -> Array | None:
        """Return pressure, stretch, curvature and torsion over the strain at a panel's nodes.

        (NODES, 4), or None where no state was found; then the last state is where it was.
        """
        (strains,) = panel_nodes((low, high))
        before = self.unknowns, self.strain
        rows = np.empty((len(strains), 4))
        for k in np.argsort(strains).tolist():
            found = self._solved(float(strains[k]))
            if found is None:
                self.unknowns, self.strain = before
                return None
            self.unknowns, self.strain = found, float(strains[k])
            rows[k] = self._shape() / strains[k]
        return rows

    def _shape(self) -> Array:
        """Return pressure, elongation, curvature and change of the torsion at the last state."""
        free = self.unknowns[None, 1:-2]
        ring = ring_at(self.fibers, np.array([self.strain]), self.unknowns[:1], 0.0, free)
        turn = ring.twist / ring.hoop - self.fibers.single_slope
        parts = (ring.stretch_change, ring.bend / ring.hoop, turn)
        return np.array([self.unknowns[-1] * self.scale, *(float(part[0]) for part in parts)])

    def _solved(self, strain: float) -> Array | None:
        """Return the unknowns at a strain, or None."""
        growth = strain / self.strain if self.strain > 0.0 else 0.0
        unknowns: Array = self.unknowns * growth
        for _ in range(NEWTON_STEPS):
            try:
                residuals, jacobian = self._linearized(strain, unknowns)
                step = np.linalg.solve(jacobian, residuals)
            except (ActuationLimitError, np.linalg.LinAlgError):
                return None
            unknowns = unknowns - step
            if not np.abs(unknowns).max() < RUNAWAY:
                return None
            floor = ROUNDING * abs(self.fibers.single_slope)
            if np.abs(step).max() <= CONVERGED * strain + floor:
                return unknowns
        return None

    def _linearized(self, strain: float, unknowns: Array) -> tuple[Array, Array]:
        """Return the residuals and their Jacobian: differences of exact gradients."""
        moves = DIFFERENCE * np.eye(FREE_ANGLES + 1)
        states = unknowns[:-2] + np.concatenate((np.zeros((1, FREE_ANGLES + 1)), moves, -moves))
        energy, volume, closure, warp = self._gradients(strain, states)
        residuals = energy - unknowns[-1] * volume + unknowns[-2] * closure
        residuals = np.concatenate((residuals, warp[:, None]), axis=1)
        up, down = residuals[1 : FREE_ANGLES + 2], residuals[FREE_ANGLES + 2 :]
        multiplier, pressure = np.append(closure[0], 0.0), np.append(-volume[0], 0.0)
        columns = [*((up - down) / (2.0 * DIFFERENCE)), multiplier, pressure]
        return residuals[0], np.stack(columns, axis=1)

    def _gradients(self, strain: float, states: Array) -> tuple[Array, Array, Array, Array]:
        """Return the gradients of energy, volume and closure in (y, g, z), and the closure."""
        count, size = len(states), FREE_ANGLES + 2
        all_of = np.concatenate((np.full((count, 1), strain), states), axis=1)
        moved = (all_of[:, None, :] + 1j * STEP * np.eye(size)).reshape(count * size, size)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            ring = ring_at(self.fibers, moved[:, 0], moved[:, 1], 0.0, moved[:, 2:])
            first, second, shares = invariant_excess(self.fibers, ring)
        shape = (count, size, FREE_ANGLES)
        first, second = first.reshape(shape), second.reshape(shape)
        share = (ring.weight * shares).reshape(shape)
        values = _energies(self.material, first[:, 0].real, second[:, 0].real) / self.scale
        density, by_first, by_second = values[:, :, None, :]
        local = (by_first * first.imag + by_second * second.imag) * share.real
        energy = self.wall * (local + density * share.imag).sum(axis=2) / STEP
        volume = ((1.0 + ring.stretch_change) * ring.hoop**2).imag.reshape(count, size) / STEP
        closure = ring.warp.reshape(count, size)
        return energy, volume, closure.imag / STEP, closure[:, 0].real


def _energies(material: HyperelasticLaw, first: Array, second: Array) -> Array:
    """Return (3, n, points): energy density and its derivatives in I1 and I2 [Pa]."""
    if not (np.isfinite(first).all() and np.isfinite(second).all()):
        raise ActuationLimitError(ActuationLimit.MODEL_END, "first_invariant", np.inf, np.inf)
    pairs = zip((3.0 + first).ravel().tolist(), (3.0 + second).ravel().tolist(), strict=True)
    rows = [
        (material.energy_density(*pair), *material.invariant_derivatives(*pair)) for pair in pairs
    ]
    return np.array(rows).T.reshape(3, *first.shape)


@lru_cache(maxsize=16)
def one_family_path(actuator: Actuator) -> OneFamilyPath:
    """Return the path of an actuator with one wound family, up to where its pressure stops rising.

    Raises:
        InvalidInputError: pressure would shorten it, or leave it as it is.
    """
    states = _States(actuator)
    edges, rows, width = [0.0], [], FIRST_PANEL
    while edges[-1] < FARTHEST and width > LEAST_PANEL:
        before = states.unknowns, states.strain
        panel = states.panel(edges[-1], edges[-1] + width)
        if panel is None or relative_tails(panel[:, 0]) > TAIL_TOLERANCE:
            states.unknowns, states.strain = before
            width *= 0.5
            continue
        rows.append(panel)
        edges.append(edges[-1] + width)
        (strains,) = panel_nodes(edges[-2:])
        if not panel[0, 0] * strains[0] > panel[-1, 0] * strains[-1]:  # the nodes fall
            break
        width *= GROWTH
    if not (rows and rows[0][-1, 0] > 0.0):
        angle = math.degrees(family_angles(actuator.fibers)[0])
        raise InvalidInputError(
            "fibers", f"{angle:.6g} degrees alone", "a family with which pressure extends the tube"
        )
    table = np.stack(rows)
    work, stretch, curvature, torsion = (Panels(edges, table[:, :, k]) for k in range(4))
    return OneFamilyPath(
        fibers=states.fibers,
        direction=1.0,
        strain_limit=edges[-1],
        limit=ActuationLimit.MODEL_END,
        stretch=stretch,
        curvature=curvature,
        torsion=torsion,
        pressure=PressurePanels(work, volume=Panels(edges, np.ones(table.shape[:2]))),
    )
