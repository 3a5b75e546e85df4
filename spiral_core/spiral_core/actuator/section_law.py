# SPDX-License-Identifier: Apache-2.0
r"""Pressure by the section law: virtual work on the wall's energy all around a bent section.

The straight fiber keeps one side while the other stretches twice as far, so the wall's energy is an
average over the section, along the one path that the fibers leave it:

.. math:: P = \frac{A}{\pi a^2} \, \frac{d\langle u \rangle / dy}{d(\bar\lambda h^2) / dy}

with the wall's area A, the radius a of the wound fibers and the strain y of the far side. The
states come from :mod:`spiral_core.actuator.section`; ``docs/derivations/section.md`` derives them.

One wound family with a single fiber: one constraint at each point leaves the wall one free motion,
z of :mod:`spiral_core.actuator.section`. At a pressure the section takes the state in which the
energy less the work of the pressure is stationary, subject to the wall's closure along the axis:

.. math:: \frac{\partial}{\partial (y, g, z_i)} \left( \frac{A}{\pi a^2} \langle u \rangle
    - P \bar\lambda h^2 + \mu \, \langle \sigma / \eta \rangle \right) = 0

For a strain y of the far side these are as many equations as unknowns: g, z at each angle, the
multiplier and the pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from spiral_core.actuator.actuator import Actuator, CurvatureForm
from spiral_core.actuator.curvature import even_curvature
from spiral_core.actuator.curve import ActuationCurve, PressurePanels
from spiral_core.actuator.fibers import (
    OneFamily,
    family_angles,
    fiber_state,
    locking_stretch,
    require_extending,
)
from spiral_core.actuator.materials import HyperelasticLaw
from spiral_core.actuator.section import (
    END_MARGIN,
    FREE_ANGLES,
    PANEL_WIDTH,
    STEP,
    Motion,
    SectionPath,
    ShapePath,
    invariant_excess,
    motion_at,
    ring_at,
    section_path,
    sideways_motion,
)
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.numerics.panels import Array, Panels, graded_edges, panel_nodes, relative_tails
from spiral_core.numerics.roots import first_sign_change

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


# Towards the elastomer's limit the energy has a pole: panels halve this many times, if I1 - 3 comes
# to this fraction of its limit.
POLE_PANELS, NEAR_POLE = 14, 0.75
# Less change of the torsion with the far side's strain than this is rounding.
NO_TWIST = 1e-9
# At rest the stiffness is that at this strain of the far side: sideways it is 0 by 0.
LEAST_STRAIN = 1e-6


@dataclass(frozen=True, slots=True)
class SectionStiffness:
    """Stiffness of a section at fixed pressure, per unstretched length, by the section law.

    Fibers that do not stretch leave bending in its own plane and twist one motion together.

    Attributes:
        bending: moment over curvature, the twist left free [N m^2].
        torsional: torque over twist, the curvature left free [N m^2]; infinite without twist.
        twist_per_curvature: how far it twists as it bends.
        sideways: out of that plane [N m^2]; infinite with two single fibers.
    """

    bending: float
    torsional: float
    twist_per_curvature: float
    sideways: float


def section_curve(actuator: Actuator) -> ActuationCurve:
    """Return the curve of an actuator by the section law.

    Raises:
        InvalidInputError: pressure would not move the section in a way its fibers can hold.
    """
    if isinstance(actuator.fibers, OneFamily):
        states = one_family_path(actuator)
        _require_pull(actuator, states)
        return ActuationCurve(actuator, states, states.pressure, states.strain_limit, states.limit)
    path = section_path(actuator.fiber_set)
    _require_pull(actuator, path)
    pressure, end, limit = section_pressure(actuator)
    if actuator.curvature_form is CurvatureForm.FIRST_ORDER:
        end, limit = _first_order_end(actuator, path, end, limit)
        path = _first_order_path(actuator, path, end)
    return ActuationCurve(actuator, path, pressure, end, limit)


def section_pressure(actuator: Actuator) -> tuple[PressurePanels, float, ActuationLimit]:
    """Return the pressure over the far side's strain, where path or material end it, and why.

    Args:
        actuator: two wound families.
    """
    path = section_path(actuator.fiber_set)
    end, limit = _material_end(path, actuator.material)
    scale = actuator.tube.wall_area / (math.pi * actuator.wound_radius**2)
    work = _work(path, actuator.material, end, scale)
    return PressurePanels(work, path.volume_slope), end, limit


def section_stiffness(actuator: Actuator, pressure: float) -> SectionStiffness:
    r"""Return the stiffness at a pressure [Pa] from 0 to the actuator's limit.

    At fixed pressure the energy less the pressure's work rises by half
    :math:`\pi a^2 L \, P'(y) v'(y)` times the square of a change of y, so that the bending
    stiffness is :math:`\pi a^4 P' v' / \kappa_n'^2` with :math:`\kappa_n = a \hat\kappa`. Bent
    sideways, the fiber leaves the plane of the coil by an angle, whose cosine c the energy
    less the work, per :math:`\pi a^2 L`, depends on:
    :math:`-\pi a^4 (d\Phi/dc) / \kappa_n^2`.

    Raises:
        InvalidInputError: it has one wound family, or no single fiber.
    """
    actuator.fiber_pair  # noqa: B018 - refuses one family
    if not actuator.single_fibers:
        raise InvalidInputError("single_fibers", (), "one that makes the section bend")
    curve, path = section_curve(actuator), section_path(actuator.fiber_set)
    size = max(curve.size_from_pressure(pressure), LEAST_STRAIN)
    volume = path.volume_slope(size)
    curvature, curvature_slope = path.curvature.with_slope(size)
    torsion, torsion_slope = path.torsion.with_slope(size)
    bend, twist = curvature + size * curvature_slope, torsion + size * torsion_slope
    held, slope = curve.pressure.with_slope(size)
    rise = math.pi * actuator.wound_radius**4 * slope * volume
    torsional = rise / twist**2 if abs(twist) > NO_TWIST else math.inf
    single = len(actuator.single_fibers) == 1
    sideways = _sideways(actuator, path, size, held) if single else math.inf
    return SectionStiffness(rise / bend**2, torsional, twist / bend, sideways)


def _sideways(actuator: Actuator, path: SectionPath, size: float, pressure: float) -> float:
    """Return the stiffness of bending out of the coil's plane [N m^2]."""
    motion = sideways_motion(path.fibers, np.array([path.direction * size]))
    radius = actuator.wound_radius
    wall = actuator.tube.wall_area / (math.pi * radius**2)
    energy = wall * float(_mean_energy_slope(motion, actuator.material)[0])
    work = pressure * float(motion.volume_slope[0])
    curvature = size * path.curvature(size)
    return math.pi * radius**4 * (work - energy) / curvature**2


def _require_pull(actuator: Actuator, path: ShapePath) -> None:
    """Refuse fibers under which pressure shortens a tube that single fibers would have to push."""
    if path.direction > 0.0 or not actuator.single_fibers:
        return
    require_extending(actuator.fiber_pair)
    raise InvalidInputError(
        "single_fibers",
        math.degrees(actuator.single_fibers[0].angle),
        "at an angle at which pressure pulls them: they cannot push",
    )


def _first_order_end(
    actuator: Actuator, path: ShapePath, end: float, limit: ActuationLimit
) -> tuple[float, ActuationLimit]:
    """Return the end of the range, no farther than the twist of an even tube is known."""
    locking = 1.0 + (1.0 - END_MARGIN) * (locking_stretch(actuator.fiber_pair) - 1.0)
    if path.direction < 0.0 or path.stretch_at(end) < locking:
        return end, limit
    return path.strain_from_stretch(locking), ActuationLimit.FIBER_LOCKING


def _first_order_path(actuator: Actuator, path: SectionPath, end: float) -> SectionPath:
    """Return the shapes of an evenly stretched wall at the stretches of a path, up to an end."""
    value, slope = path.stretch.with_slope(end)
    room = locking_stretch(actuator.fiber_pair) - path.stretch_at(end)
    rate = value + end * slope
    right = end + room / rate if rate > 0.0 else math.inf
    edges = graded_edges(end, path.edges[1] / PANEL_WIDTH, right, PANEL_WIDTH)
    sizes = panel_nodes(edges)
    rows = []
    for size in sizes.ravel().tolist():
        rise = path.stretch(size)
        stretch = 1.0 + size * rise
        per_size = rise / (stretch - 1.0)
        twist = fiber_state(actuator.fiber_pair, stretch).twist
        curvature = even_curvature(actuator, stretch, twist) * actuator.wound_radius
        rows.append((curvature * per_size, twist * per_size))
    bend, turn = (Panels(edges, one) for one in np.array(rows).T.reshape(2, *sizes.shape))
    return replace(path, curvature=bend, torsion=turn)


def _material_end(path: SectionPath, material: HyperelasticLaw) -> tuple[float, ActuationLimit]:
    """Return |y| at which the path ends, or the elastomer's limit is reached before."""
    room = material.first_invariant_limit - 3.0
    if not path.motion.first.max() >= room:
        return path.strain_limit, path.limit

    def left(size: float) -> float:
        return room - float(motion_at(path.fibers, np.array([path.direction * size])).first.max())

    nodes = [edge for edge in path.edges if edge < path.strain_limit]
    end = first_sign_change(left, [*nodes, path.strain_limit])
    if end is None:
        return path.strain_limit, path.limit
    return end * (1.0 - END_MARGIN), ActuationLimit.MATERIAL_LIMIT


def _work(path: SectionPath, material: HyperelasticLaw, end: float, scale: float) -> Panels:
    """Return the derivative of the mean energy density over |y|, scaled, up to an end [Pa]."""
    edges, motion = path.edges, path.motion
    if motion.first.max() >= NEAR_POLE * (material.first_invariant_limit - 3.0):
        kept = [edge for edge in edges if edge < 0.5 * end]
        graded = [end - (end - kept[-1]) * 0.5**k for k in range(1, POLE_PANELS)]
        edges = (*kept, *graded, end)
        motion = motion_at(path.fibers, path.direction * panel_nodes(edges).ravel())
    sizes = panel_nodes(edges)
    slopes = path.direction * scale * _mean_energy_slope(motion, material)
    return Panels(edges, slopes.reshape(sizes.shape) / sizes)


def _mean_energy_slope(motion: Motion, material: HyperelasticLaw) -> Array:
    """Return d<u>/dy [Pa] of each state."""
    shape = motion.first.shape
    invariants = (3.0 + motion.first).ravel().tolist(), (3.0 + motion.second).ravel().tolist()
    pairs = list(zip(*invariants, strict=True))
    # One flat list of numbers: thousands of small tuples would keep the garbage collector busy.
    derivatives = [part for pair in pairs for part in material.invariant_derivatives(*pair)]
    first, second = np.array(derivatives).reshape(*shape, 2).transpose(2, 0, 1)
    densities = np.array([material.energy_density(*pair) for pair in pairs]).reshape(shape)
    local = (first * motion.first_slope + second * motion.second_slope) * motion.share
    slopes: Array = (local + densities * motion.share_slope).sum(axis=1)
    return slopes
