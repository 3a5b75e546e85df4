# SPDX-License-Identifier: Apache-2.0
r"""Pressure by virtual work on the wall's energy all around a section, by either pressure law.

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
from dataclasses import replace
from functools import lru_cache

import numpy as np

from spiral_core.actuator.actuator import Actuator, CurvatureForm, PressureLaw
from spiral_core.actuator.curvature import even_curvature
from spiral_core.actuator.curve import Branch, PressurePanels
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
    HALVINGS,
    PANEL_WIDTH,
    SCAN,
    STEP,
    Motion,
    SectionPath,
    ShapePath,
    invariant_excess,
    motion_at,
    ring_at,
    section_path,
)
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.numerics.panels import (
    Array,
    Panels,
    graded_edges,
    panel_nodes,
    refined_panels,
    relative_tails,
)
from spiral_core.numerics.roots import first_sign_change

# Differences of gradients that are exact to rounding; Newton's method only needs a good Jacobian.
DIFFERENCE = 1e-6
NEWTON_STEPS, CONVERGED, ROUNDING = 20, 1e-13, 1e-13
RUNAWAY = 1e6
# Panels of the far side's strain: the first, how they grow, the least, and the farthest strain
# looked at, where the far side is 3.6 times as long as at rest.
FIRST_PANEL, GROWTH, LEAST_PANEL, FARTHEST = 0.2, 1.6, 1e-3, 12.0
TAIL_TOLERANCE = 1e-11


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

        (NODES, 4), or None where no state was found.
        """
        (strains,) = panel_nodes((low, high))
        rows = np.empty((len(strains), 4))
        for k in np.argsort(strains).tolist():
            found = self._solved(float(strains[k]))
            if found is None:
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
        real = first[:, 0].real, second[:, 0].real
        if not np.isfinite(real).all():
            raise ActuationLimitError(ActuationLimit.MODEL_END, "first_invariant", np.inf, np.inf)
        values = _energies(self.material, *real) / self.scale
        density, by_first, by_second = values[:, :, None, :]
        local = (by_first * first.imag + by_second * second.imag) * share.real
        energy = self.wall * (local + density * share.imag).sum(axis=2) / STEP
        volume = ((1.0 + ring.stretch_change) * ring.hoop**2).imag.reshape(count, size) / STEP
        closure = ring.warp.reshape(count, size)
        return energy, volume, closure.imag / STEP, closure[:, 0].real


def _energies(material: HyperelasticLaw, first: Array, second: Array) -> Array:
    """Return (3, n, points): energy density and its derivatives in I1 and I2 [Pa].

    Args:
        material: the elastomer's law.
        first: I1 - 3 (n, points).
        second: I2 - 3.
    """
    pairs = zip((3.0 + first).ravel().tolist(), (3.0 + second).ravel().tolist(), strict=True)
    # One flat list of numbers: thousands of small tuples would keep the garbage collector busy.
    values = [
        value
        for pair in pairs
        for value in (material.energy_density(*pair), *material.invariant_derivatives(*pair))
    ]
    return np.array(values).reshape(-1, 3).T.reshape(3, *first.shape)


@lru_cache(maxsize=16)
def one_family_branch(actuator: Actuator) -> Branch:
    """Return the branch of an actuator with one family, up to where its pressure stops rising.

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
    path = ShapePath(
        fibers=states.fibers,
        direction=1.0,
        strain_limit=edges[-1],
        limit=ActuationLimit.MODEL_END,
        stretch=stretch,
        curvature=curvature,
        torsion=torsion,
    )
    pressure = PressurePanels(work, volume=Panels(edges, np.ones(table.shape[:2])))
    return Branch(path, pressure, path.strain_limit, path.limit)


# Towards the elastomer's limit the energy has a pole: panels halve this many times, if I1 - 3 comes
# to this fraction of its limit.
POLE_PANELS, NEAR_POLE = 14, 0.75


def useful_branch(actuator: Actuator) -> Branch:
    """Return shapes and pressures of an actuator by its own pressure law, in its curvature form.

    Raises:
        InvalidInputError: pressure would not move the actuator in a way its fibers can hold.

    Source: ``docs/derivations/actuator.md``, "Where the useful range ends".

    Example:
        >>> from spiral_core import FiberAngles, NeoHookean, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(88.0), beta=math.radians(60.0)),
        ...     material=NeoHookean(c1=145.0e3),
        ...     pressure_law=PressureLaw.UNIFORM,
        ... )
        >>> branch = useful_branch(actuator)
        >>> round(branch.path.stretch_at(branch.end), 4), branch.limit.name
        (1.9999, 'FIBER_LOCKING')
    """
    if actuator.pressure_law is PressureLaw.UNIFORM:
        straight = actuator.without_single_fibers()
        path = section_path(straight.fiber_set)
        require_extending(actuator.fiber_pair)
        branch = section_branch(straight)
        # Short of what ends it by a part of the elongation, not of the strain.
        rise = path.stretch_at(branch.end / (1.0 - END_MARGIN)) - 1.0
        end = path.strain_from_stretch(1.0 + (1.0 - END_MARGIN) * rise)
        return _even_shapes(actuator, path, branch._replace(end=end))
    branch = section_branch(actuator)
    if branch.path.direction < 0.0 and actuator.single_fibers:
        require_extending(actuator.fiber_pair)
        raise InvalidInputError(
            "single_fibers",
            math.degrees(actuator.single_fibers[0].angle),
            "at an angle at which pressure pulls them: they cannot push",
        )
    if actuator.curvature_form is CurvatureForm.EXACT:
        return branch
    return _even_shapes(actuator, section_path(actuator.fiber_set), branch)


def section_branch(actuator: Actuator) -> Branch:
    """Return shapes and pressures over the far side's strain, up to where path or material end."""
    if isinstance(actuator.fibers, OneFamily):
        return one_family_branch(actuator)
    path, material = section_path(actuator.fiber_set), actuator.material
    edges, motion, sizes = path.edges, path.motion, panel_nodes(path.edges)
    end, limit, room = path.strain_limit, path.limit, material.first_invariant_limit - 3.0
    nodes = [*(edge for edge in edges if edge < end), end]
    reached = [
        first_sign_change(Panels(edges, (room - excess).reshape(sizes.shape)), nodes)
        for excess in motion.first[:, np.nanmax(motion.first, axis=0) >= room].T
    ]
    full = min((size for size in reached if size is not None), default=None)
    if full is not None:
        end, limit = full * (1.0 - END_MARGIN), ActuationLimit.MATERIAL_LIMIT
    if np.nanmax(motion.first) >= NEAR_POLE * room:
        kept = [edge for edge in edges if edge < 0.5 * end]
        graded = [end - (end - kept[-1]) * 0.5**k for k in range(1, POLE_PANELS)]
        edges = (*kept, *graded, end)
        sizes = panel_nodes(edges)
        motion = motion_at(path.fibers, path.direction * sizes.ravel())
    scale = actuator.tube.wall_area / (math.pi * actuator.wound_radius**2)
    # The derivative of the mean energy density over |y|, scaled [Pa].
    slopes = path.direction * scale * mean_energy_slope(motion, material)
    work = Panels(edges, slopes.reshape(sizes.shape) / sizes)
    return Branch(path, PressurePanels(work, path.volume_slope), end, limit)


def _even_shapes(actuator: Actuator, path: SectionPath, branch: Branch) -> Branch:
    """Return a branch with the shapes of an evenly stretched wall at its stretches.

    They end no farther than the twist of an even tube is known, and than it leaves the straight
    fiber its length.
    """
    pair, end, limit = actuator.fiber_pair, branch.end, branch.limit
    lock = locking_stretch(pair)
    last = 1.0 + (1.0 - END_MARGIN) * (lock - 1.0)
    if path.direction > 0.0 and path.stretch_at(end) >= last:
        end, limit = path.strain_from_stretch(last), ActuationLimit.FIBER_LOCKING
    value, slope = path.stretch.with_slope(end)
    rate = value + end * slope
    right = end + (lock - path.stretch_at(end)) / rate if rate > 0.0 else math.inf
    taut = None
    if actuator.curvature_form is CurvatureForm.EXACT:
        ratio = actuator.fiber_radius / actuator.tube.inner_radius
        nodes = (end * np.sqrt(np.linspace(0.0, 1.0, SCAN))).tolist()
        taut = first_sign_change(
            lambda size: 1.0 - ratio * abs(fiber_state(pair, path.stretch_at(size)).twist), nodes
        )
    if taut is not None:
        stretch = path.stretch_at(taut)
        end = path.strain_from_stretch(stretch - END_MARGIN * (stretch - 1.0))
        right, limit = taut, ActuationLimit.STRAIGHT_FIBER_LOCKING
    edges = graded_edges(end, path.edges[1] / PANEL_WIDTH, right, PANEL_WIDTH)

    def sample(sizes: Array) -> Array:
        rows = []
        for size in sizes.ravel().tolist():
            rise = path.stretch(size)
            stretch = 1.0 + size * rise
            # Over the elongation of the rounded stretch, the quotients have no rounding of it.
            per_size = rise / (stretch - 1.0)
            twist = fiber_state(pair, stretch).twist
            curvature = even_curvature(actuator, stretch, twist) * actuator.wound_radius
            rows.append((curvature * per_size, twist * per_size))
        return np.array(rows).T.reshape(2, *sizes.shape)

    edges, samples = refined_panels(edges, sample, TAIL_TOLERANCE, HALVINGS)
    bend, turn = (Panels(edges, one) for one in samples)
    return branch._replace(path=replace(path, curvature=bend, torsion=turn), end=end, limit=limit)


def mean_energy_slope(motion: Motion, material: HyperelasticLaw) -> Array:
    """Return d<u>/dy [Pa] of each state."""
    densities, first, second = _energies(material, motion.first, motion.second)
    local = (first * motion.first_slope + second * motion.second_slope) * motion.share
    slopes: Array = (local + densities * motion.share_slope).sum(axis=1)
    return slopes
