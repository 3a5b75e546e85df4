# SPDX-License-Identifier: Apache-2.0
"""The grip on one object, computed with contact and friction, as plain values. No ROS."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from spiral_core.closing.settling import settling_after_ramp
from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.holding import Pull, holding_forces
from spiral_core.grip.point import GripPoint
from spiral_core.grip.setup import GripSetup, lay_into_coil
from spiral_core.grip.window import grip_window
from spiral_core.rod.contact.obstacles import Obstacle
from spiral_core.rod.contact.shapes import Cylinder
from spiral_core.rod.types import Array, Vector
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import WrapRegime

# Holding forces are looked for at these multiples of the pressure at which the wrap begins, at this
# part of the last pressure that holds, and at the last. Around the beginning the forces bend
# upwards: a straight line over more than this is up to twice as high as they are.
FORCE_MULTIPLES = (0.95, 1.0, 1.05, 1.15)
NEAR_TOP = 0.93


@dataclass(frozen=True, slots=True)
class GripQuestion:
    """The inputs of a grip on a cylinder.

    Args:
        gripper: as it is mounted, with its gravity.
        radius: of the object [m], > 0.
        friction: Coulomb's coefficient between tube and object; None: the gripper's own, or the
            cautious default of :func:`spiral_core.grip.setup.friction_of`.
        pose: a point of the object's axis [m] and its direction; None: laid into the free coil.
        rate: of the ramp that closes the gripper [Pa/s]; 0: how long it then swings is not asked.
    """

    gripper: Gripper
    radius: float
    friction: float | None = None
    pose: tuple[Vector, Vector] | None = None
    rate: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class TubeShape:
    """A tube that lies on an object, to be drawn.

    Args:
        positions: of its nodes (n, 3) [m].
        orientations: of its material frames (n, 4), scalar last.
    """

    positions: Array
    orientations: Array


@dataclass(frozen=True, slots=True, eq=False)
class GripFigures:
    """The grip on an object while the pressure rises slowly, the object in place.

    Args:
        tip_pressure: of the perfect wrap by the criterion at the free coil's tip [Pa].
        onset_wrap: lowest pressure of the perfect wrap [Pa].
        onset_curling: pressure at which the tip lifts off again [Pa]; None: it does not.
        loss: pressure at which the wrapped coil loses stability [Pa]; None: it does not.
        top: largest pressure at which the grip was found to hold [Pa].
        friction: coefficient used.
        pressures: of the path (n,) [Pa].
        contact_lengths, normal_forces: at those (n,) [m], [N].
        force_pressures: at which holding forces were computed (m,) [Pa].
        away, towards: the largest force that holds the object against moving along its axis, away
            from the base and towards it (m,) [N].
        down: the same along gravity (m,) [N]; zeros without gravity.
        settling: how long the tube swings on after a ramp that ends there (m,) [s]; zeros where its
            weight, or a shape, is not known.
        positions, orientations: the tube's nodes at the pressures of the path (n, nodes, 3) [m],
            (n, nodes, 4), scalar last.
        center, axis: of the object [m], in the base frame.
    """

    tip_pressure: float
    onset_wrap: float
    onset_curling: float | None
    loss: float | None
    top: float
    friction: float
    pressures: Array
    contact_lengths: Array
    normal_forces: Array
    force_pressures: Array
    away: Array
    towards: Array
    down: Array
    settling: Array
    positions: Array
    orientations: Array
    center: Vector
    axis: Vector

    def regime(self, pressure: float) -> WrapRegime:
        """Return how the object is held at a pressure [Pa] that has risen from nothing."""
        if pressure < self.onset_wrap or (self.loss is not None and pressure >= self.loss):
            return WrapRegime.OVERHANG
        curls = self.onset_curling is not None and pressure >= self.onset_curling
        return WrapRegime.CURLING if curls else WrapRegime.PERFECT_WRAP

    def shape(self, pressure: float) -> TubeShape | None:
        """Return the tube on the object, blended between the pressures of the path [Pa]."""
        if not 0.0 <= pressure <= self.top:
            return None
        above = max(int(np.searchsorted(self.pressures, pressure)), 1)
        low, high = self.pressures[above - 1 : above + 1]
        part = (pressure - low) / (high - low)
        positions, turns = (
            (1.0 - part) * each[above - 1] + part * each[above]
            for each in (self.positions, self.orientations)
        )
        return TubeShape(positions, turns / np.linalg.norm(turns, axis=1, keepdims=True))


def solve_figures(question: GripQuestion) -> GripFigures:
    """Return the grip that a question asks for; takes some seconds.

    Raises:
        NotGrippableError: no pressure wraps the object.
        SpiralError: a value is out of its range, or a state could not be certified.
    """
    window = grip_window(_setup(question))
    if window.onset_wrap is None:
        reason = f"closing on it, the tip never touches: {window.end.value}"
        raise NotGrippableError(question.radius, reason, 0.0, None)
    pressures = force_pressures(window.onset_wrap, window.top)
    points = [window.at(float(pressure)) for pressure in pressures]
    away, towards, down = _forces(points)
    setup = window.setup
    return GripFigures(
        tip_pressure=setup.tip_pressure or 0.0,
        onset_wrap=window.onset_wrap,
        onset_curling=window.onset_curling,
        loss=window.loss,
        top=window.top,
        friction=setup.obstacle.friction,
        pressures=window.pressures,
        contact_lengths=window.contact_lengths,
        normal_forces=window.normal_forces,
        force_pressures=pressures,
        away=away,
        towards=towards,
        down=down,
        settling=_settling(question, points),
        positions=np.array([point.state.positions for point in window.points]),
        orientations=_aligned([point.state.orientations for point in window.points]),
        center=_vector(setup.obstacle.position),
        axis=_vector(setup.axis),
    )


def force_pressures(onset: float, top: float) -> Array:
    """Return the pressures at which holding forces are computed (m,) [Pa], increasing.

    Args:
        onset: at which the wrap begins [Pa].
        top: the last that holds [Pa].

    Example:
        >>> force_pressures(50e3, 80e3)
        array([47500., 50000., 52500., 57500., 74400., 80000.])
    """
    wanted = [*(multiple * onset for multiple in FORCE_MULTIPLES), NEAR_TOP * top, top]
    return np.unique(np.minimum(wanted, top))


def _setup(question: GripQuestion) -> GripSetup:
    gripper, radius = question.gripper, question.radius
    laid = lay_into_coil(gripper, radius, friction=question.friction)
    if question.pose is None:
        return laid
    center, axis = question.pose
    obstacle = Obstacle.along(Cylinder(radius), center, axis, laid.obstacle.friction)
    tip_pressure = WrapCurve(gripper).pressure_from_radius(radius)
    return GripSetup(gripper, obstacle, laid.closing, tip_pressure=tip_pressure)


def _forces(points: list[GripPoint]) -> Array:
    """Return what holds away from the base, towards it and along gravity (3, m) [N], or zero."""
    pulls = [Pull.AWAY, Pull.TOWARDS]
    if any(points[0].setup.gripper.gravity):
        pulls.append(Pull.DOWN)
    forces = np.zeros((3, len(points)))
    for place, point in enumerate(points):
        held = holding_forces(point, pulls)
        forces[: len(pulls), place] = [held[pull].force for pull in pulls]
    return np.nan_to_num(forces)


def _settling(question: GripQuestion, points: list[GripPoint]) -> Array:
    gripper, rate = question.gripper, question.rate
    times = np.zeros(len(points))
    if rate == 0.0:
        return times
    for place, point in enumerate(points):
        with suppress(SpiralError):
            times[place] = settling_after_ramp(gripper, point.pressure, rate, grip=point)
    return times


def _aligned(orientations: list[Array]) -> Array:
    """Return quaternions (n, nodes, 4) whose signs do not change along the path."""
    turns = np.array(orientations)
    for before, after in pairwise(turns):
        after[np.einsum("ij,ij->i", before, after) < 0.0] *= -1.0
    return turns


def _vector(components: Array | Vector) -> Vector:
    x, y, z = (float(component) for component in components)
    return (x, y, z)
