# SPDX-License-Identifier: Apache-2.0
r"""Pressure by the section law: virtual work on the wall's energy all around a bent section.

The straight fiber keeps one side while the other stretches twice as far, so the wall's energy is an
average over the section, along the one path that the fibers leave it:

.. math:: P = \frac{A}{\pi a^2} \, \frac{d\langle u \rangle / dy}{d(\bar\lambda h^2) / dy}

with the wall's area A, the radius a of the wound fibers and the strain y of the far side. The
states come from :mod:`spiral_core.section.path`; ``docs/derivations/section.md`` derives them.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass

import numpy as np

from spiral_core.actuator.actuator import Actuator, CurvatureForm
from spiral_core.actuator.curvature import unloaded_shape_from_section, unloaded_shape_from_stretch
from spiral_core.actuator.fibers import OneFamily, locking_stretch
from spiral_core.actuator.interface import UnloadedShape
from spiral_core.actuator.materials import HyperelasticLaw
from spiral_core.actuator.one_family import OneFamilyPath, one_family_path
from spiral_core.actuator.volume import require_extending
from spiral_core.errors import ActuationLimit, InvalidInputError
from spiral_core.numerics.panels import Array, Panels, panel_nodes
from spiral_core.numerics.roots import first_sign_change, rising_root
from spiral_core.section.path import (
    END_MARGIN,
    Motion,
    SectionPath,
    ShapePath,
    motion_at,
    section_path,
    sideways_motion,
)

# States at which the pressure is tabulated: brackets for the inverse, and where it stops rising.
TABLE_NODES = 129
# Towards the elastomer's limit the energy has a pole: panels halve this many times.
POLE_PANELS = 14
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


class SectionEnergy:
    """Pressure of one actuator over the far side's strain, without its limits.

    Args:
        actuator: two wound families.
        path: what :func:`spiral_core.section.path.section_path` says of its fibers.
    """

    __slots__ = ("_energy_slope", "_scale", "_volume_slope", "limit", "strain_limit")

    def __init__(self, actuator: Actuator, path: SectionPath) -> None:
        self._scale = actuator.tube.wall_area / (math.pi * actuator.wound_radius**2)
        self.strain_limit, self.limit = _material_end(path, actuator.material)
        self._energy_slope = _energy_slope(path, actuator.material, self.strain_limit)
        self._volume_slope = path.volume_slope

    def pressure_with_slope(self, size: float) -> tuple[float, float]:
        """Return the pressure [Pa] at a far-side strain's size, and its derivative in it."""
        energy, energy_slope = self._energy_slope.with_slope(size)
        volume, volume_slope = self._volume_slope.with_slope(size)
        scale = self._scale / volume
        pressure = scale * energy * size
        return pressure, scale * (energy + energy_slope * size) - pressure * volume_slope / volume


class SectionCurve:
    """Pressure, stretch and shape of one actuator by the section law.

    Args:
        actuator: two wound families.

    Raises:
        InvalidInputError: pressure would not move the section in a way its fibers can hold.
    """

    __slots__ = (
        "_actuator", "_pressures", "_radius", "_strains", "energy", "limit", "path",
        "pressure_limit", "strain_limit", "stretch_limit",
    )  # fmt: skip

    def __init__(self, actuator: Actuator) -> None:
        self._actuator, self._radius = actuator, actuator.wound_radius
        self.path, self.energy = _path_and_energy(actuator)
        _require_pull(actuator, self.path)
        end, self.limit = self.energy.strain_limit, self.energy.limit
        if actuator.curvature_form is CurvatureForm.FIRST_ORDER:
            end, self.limit = _first_order_end(actuator, self.path, end, self.limit)
        fractions = 1.0 - np.linspace(0.0, 1.0, TABLE_NODES)
        strains: list[float] = (end * (1.0 - fractions**2)).tolist()
        if not self.energy.pressure_with_slope(0.0)[1] > 0.0:
            raise InvalidInputError(
                "material", actuator.material, "a law whose pressure rises with the stretch at rest"
            )
        peak = first_sign_change(lambda size: self.energy.pressure_with_slope(size)[1], strains)
        if peak is not None:
            end, self.limit = peak, ActuationLimit.LIMIT_POINT
            strains = [*(size for size in strains if size < peak), peak]
        self._strains = strains
        self._pressures = [self.energy.pressure_with_slope(size)[0] for size in strains]
        self.strain_limit, self.pressure_limit = end, self._pressures[-1]
        self.stretch_limit = self.path.stretch_at(end)

    def pressure_from_stretch(self, stretch: float) -> float:
        """Return the pressure [Pa] at a stretch from 1 to ``stretch_limit``."""
        size = min(self.path.strain_from_stretch(stretch), self.strain_limit)
        return self.energy.pressure_with_slope(size)[0]

    def stretch_from_pressure(self, pressure: float) -> float:
        """Return the stretch at a pressure [Pa] from 0 to ``pressure_limit``."""
        return self.path.stretch_at(self.strain_from_pressure(pressure))

    def strain_from_pressure(self, pressure: float) -> float:
        """Return the far-side strain's size at a pressure [Pa] from 0 to ``pressure_limit``."""
        cell = min(bisect_right(self._pressures, pressure), len(self._pressures) - 1)
        low, high = self._strains[cell - 1], self._strains[cell]
        return rising_root(self.energy.pressure_with_slope, pressure, low, high)

    def stiffness(self, pressure: float) -> SectionStiffness:
        r"""Return the stiffness at a pressure [Pa] from 0 to ``pressure_limit``.

        At fixed pressure the energy less the pressure's work rises by half
        :math:`\pi a^2 L \, P'(y) v'(y)` times the square of a change of y, so that the bending
        stiffness is :math:`\pi a^4 P' v' / \kappa_n'^2` with :math:`\kappa_n = a \hat\kappa`. Bent
        sideways, the fiber leaves the plane of the coil by an angle, whose cosine c the energy
        less the work, per :math:`\pi a^2 L`, depends on:
        :math:`-\pi a^4 (d\Phi/dc) / \kappa_n^2`.

        Raises:
            InvalidInputError: it has one wound family, or no single fiber.
        """
        self._actuator.fiber_pair  # noqa: B018 - refuses one family
        if not (self._actuator.single_fibers and isinstance(self.path, SectionPath)):
            raise InvalidInputError("single_fibers", (), "one that makes the section bend")
        size = max(self.strain_from_pressure(pressure), LEAST_STRAIN)
        volume = self.path.volume_slope(size)
        curvature, curvature_slope = self.path.curvature.with_slope(size)
        torsion, torsion_slope = self.path.torsion.with_slope(size)
        bend, twist = curvature + size * curvature_slope, torsion + size * torsion_slope
        rise = math.pi * self._radius**4 * self.energy.pressure_with_slope(size)[1] * volume
        torsional = rise / twist**2 if abs(twist) > NO_TWIST else math.inf
        sideways = (
            self._sideways(self.path, size) if len(self._actuator.single_fibers) == 1 else math.inf
        )
        return SectionStiffness(rise / bend**2, torsional, twist / bend, sideways)

    def _sideways(self, path: SectionPath, size: float) -> float:
        """Return the stiffness of bending out of the coil's plane [N m^2]."""
        actuator = self._actuator
        motion = sideways_motion(path.fibers, np.array([path.direction * size]))
        wall = actuator.tube.wall_area / (math.pi * self._radius**2)
        energy = wall * float(_mean_energy_slope(motion, actuator.material)[0])
        work = self.energy.pressure_with_slope(size)[0] * float(motion.volume_slope[0])
        curvature = size * path.curvature(size)
        return math.pi * self._radius**4 * (work - energy) / curvature**2

    def unloaded_shape(self, pressure: float) -> UnloadedShape:
        """Return the unloaded shape at a pressure [Pa] from 0 to ``pressure_limit``."""
        return section_shape(self._actuator, self.path, self.strain_from_pressure(pressure))

    def unloaded_shape_from_stretch(self, stretch: float) -> UnloadedShape:
        """Return the unloaded shape at a stretch from 1 to ``stretch_limit``."""
        return section_shape(self._actuator, self.path, self.path.strain_from_stretch(stretch))


def section_shape(actuator: Actuator, path: ShapePath, size: float) -> UnloadedShape:
    """Return the unloaded shape at a far-side strain's size, in the actuator's curvature form."""
    if actuator.curvature_form is CurvatureForm.FIRST_ORDER:
        return unloaded_shape_from_stretch(actuator, path.stretch_at(size))
    return unloaded_shape_from_section(actuator, path, size)


def _path_and_energy(actuator: Actuator) -> tuple[ShapePath, SectionEnergy | OneFamilyPath]:
    """Return an actuator's shapes, and the pressure that holds them."""
    if isinstance(actuator.fibers, OneFamily):
        states = one_family_path(actuator)
        return states, states
    path = section_path(actuator.fiber_set)
    return path, SectionEnergy(actuator, path)


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


def _energy_slope(path: SectionPath, material: HyperelasticLaw, end: float) -> Panels:
    """Return d<u>/d|y| over |y| [Pa], up to an end."""
    edges, motion = path.edges, path.motion
    if motion.first.max() >= material.first_invariant_limit - 3.0:
        kept = [edge for edge in edges if edge < 0.5 * end]
        graded = [end - (end - kept[-1]) * 0.5**k for k in range(1, POLE_PANELS)]
        edges = (*kept, *graded, end)
        motion = motion_at(path.fibers, path.direction * panel_nodes(edges).ravel())
    sizes = panel_nodes(edges)
    slopes = path.direction * _mean_energy_slope(motion, material)
    return Panels(edges, slopes.reshape(sizes.shape) / sizes)


def _mean_energy_slope(motion: Motion, material: HyperelasticLaw) -> Array:
    """Return d<u>/dy [Pa] of each state."""
    shape = motion.first.shape
    firsts, seconds = (3.0 + motion.first).ravel().tolist(), (3.0 + motion.second).ravel().tolist()
    pairs = list(zip(firsts, seconds, strict=True))
    derivatives = np.array([material.invariant_derivatives(*pair)[:2] for pair in pairs])
    densities = np.array([material.energy_density(*pair) for pair in pairs]).reshape(shape)
    first, second = derivatives[:, 0].reshape(shape), derivatives[:, 1].reshape(shape)
    local = (first * motion.first_slope + second * motion.second_slope) * motion.share
    slopes: Array = (local + densities * motion.share_slope).sum(axis=1)
    return slopes
