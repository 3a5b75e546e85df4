# SPDX-License-Identifier: Apache-2.0
"""The computation of the grip on one object, with contact and friction. No ROS."""

from __future__ import annotations

import math
from contextlib import suppress
from itertools import pairwise

import numpy as np

from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.closing import settling_after_ramp
from spiral_core.grip.grip import Grip
from spiral_core.grip.holding import Pull, holding_forces
from spiral_core.grip.setup import GripSetup, lay_into_coil
from spiral_core.grip.window import GripPoint, grip_window
from spiral_core.rod.contact.obstacles import Obstacle
from spiral_core.rod.contact.shapes import Cylinder
from spiral_core.rod.types import Array, Vector
from spiral_core.wrap.curve import WrapCurve
from spiral_gripper_ros.planning.grip_figures import GripFigures, GripQuestion

# Holding forces are looked for at these multiples of the pressure at which the wrap begins, at this
# part of the last pressure that holds, and at the last. Around the beginning the forces bend
# upwards: a straight line over more than this is up to twice as high as they are.
FORCE_MULTIPLES = (0.95, 1.0, 1.05, 1.15)
NEAR_TOP = 0.93


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
        onset_curling=math.inf if window.onset_curling is None else window.onset_curling,
        loss=math.inf if window.loss is None else window.loss,
        highest_good=Grip(window, (), {}).recommended_range[1],
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
    """Return how long the tube swings on at each point [s]; NaN where that is not known."""
    gripper, rate = question.gripper, question.rate
    times = np.full(len(points), np.nan)
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
