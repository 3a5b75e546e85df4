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
from dataclasses import dataclass, replace

import numpy as np

from spiral_core.actuator.actuator import Actuator, CurvatureForm
from spiral_core.actuator.curvature import even_curvature
from spiral_core.actuator.curve import ActuationCurve, PressurePanels
from spiral_core.actuator.fibers import OneFamily, fiber_state, locking_stretch
from spiral_core.actuator.materials import HyperelasticLaw
from spiral_core.actuator.one_family import one_family_path
from spiral_core.actuator.volume import require_extending
from spiral_core.errors import ActuationLimit, InvalidInputError
from spiral_core.numerics.panels import Array, Panels, graded_edges, panel_nodes
from spiral_core.numerics.roots import first_sign_change
from spiral_core.section.path import (
    END_MARGIN,
    PANEL_WIDTH,
    Motion,
    SectionPath,
    ShapePath,
    motion_at,
    section_path,
    sideways_motion,
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
