# SPDX-License-Identifier: Apache-2.0
"""The computation of the grip on one object over the pressure, and of a table over the radii."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.closing import settling_after_ramp
from spiral_core.grip.curve import GripCurve, GripQuestion, GripShapes
from spiral_core.grip.grip import Grip
from spiral_core.grip.holding import Pull, holding_forces
from spiral_core.grip.places import THINNEST, why_not_held
from spiral_core.grip.setup import GripSetup, lay_into_coil, vector_of
from spiral_core.grip.table import GripTable
from spiral_core.grip.window import GripPoint, WindowEnd, grip_window
from spiral_core.numerics.tasks import Progress, in_turn
from spiral_core.rod.contact.obstacles import Obstacle
from spiral_core.rod.contact.shapes import Cylinder
from spiral_core.rod.types import Array
from spiral_core.validation import require_in_range, require_positive
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper

# Holding forces are looked for at these multiples of the pressure at which the wrap begins, at this
# part of the last pressure that holds, and at the last. Around the beginning the forces bend
# upwards: a straight line over more than this is up to twice as high as they are.
FORCE_MULTIPLES = (0.95, 1.0, 1.05, 1.15)
NEAR_TOP = 0.93
# A table's radii keep this fraction away from the ends of the range, where nothing is held.
MARGIN = 0.005
# It grows to this many times the radii that it begins with.
MOST_REFINED = 10
# Radii are rounded to these decimals of a meter, so that a file holds those that were solved.
DECIMALS = 7


def solve_curve(question: GripQuestion) -> GripCurve:
    """Return the grip that a question asks for; takes some seconds.

    Raises:
        NotGrippableError: no pressure wraps the object.
        SpiralError: a value is out of its range, or a state could not be certified.
    """
    window = grip_window(_setup(question))
    if window.onset_wrap is None:
        reason, gap = why_not_held(window)
        raise NotGrippableError(question.radius, reason, -gap, None)
    pressures = force_pressures(window.onset_wrap, window.top)
    points = [window.at(float(pressure)) for pressure in pressures]
    away, towards, down = _forces(points)
    setup = window.setup
    return GripCurve(
        tip_pressure=setup.tip_pressure or 0.0,
        onset_wrap=window.onset_wrap,
        onset_curling=math.inf if window.onset_curling is None else window.onset_curling,
        loss=window.loss or (math.inf if window.end is WindowEnd.LIMIT else window.top),
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
        shapes=GripShapes(
            positions=np.array([point.state.positions for point in window.points]),
            orientations=_aligned([point.state.orientations for point in window.points]),
            center=vector_of(setup.obstacle.position),
            axis=vector_of(setup.axis),
        ),
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


def solve_table(
    gripper: Gripper,
    count: int,
    rate: float,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> GripTable:
    """Return the table of grips over the radii that a gripper wraps; takes some minutes.

    It begins with radii evenly spaced in their logarithm. Each further round solves the middle of
    every two between which the table is poor (:meth:`GripTable.poor`), until none is left or there
    are ``MOST_REFINED`` times as many. The answer is the same with any number of processes.

    Args:
        gripper: as it is mounted, with its own friction or the default.
        count: of the radii to begin with, at least 2.
        rate: of the ramp that closes the gripper [Pa/s].
        executor: where; None solves one after the other, here.
        progress: called with the number of radii done, and of those known to be due.

    Raises:
        InvalidInputError: count or rate is out of its range.
        NoCoilError: the gripper makes no coil.
        SolverError: a free shape could not be certified.
    """
    require_in_range("count", count, 2, math.inf)
    require_positive("rate", rate)
    curve, most = WrapCurve(replace(gripper, object_axis=None)), MOST_REFINED * count
    least = max(curve.radius_min, THINNEST * gripper.tube.outer_radius)
    ends = (1.0 + MARGIN) * least, (1.0 - MARGIN) * curve.radius_max

    entries = partial(in_turn, partial(_entry, gripper, rate))
    radii = np.round(np.geomspace(*ends, count), DECIMALS).tolist()
    errors = (math.inf,) * (count - 1)
    table = GripTable(
        tuple(radii), tuple(entries(radii, executor, progress)), errors, gripper.gravity, rate
    )
    while pairs := table.poor(most - len(table.radii)):
        middles = [math.sqrt(table.radii[pair] * table.radii[pair + 1]) for pair in pairs]
        radii = np.round(middles, DECIMALS).tolist()
        solved = entries(radii, executor, progress, len(table.radii))
        # From the last pair on: the places of those before it do not change.
        for pair, radius, grip in sorted(zip(pairs, radii, solved, strict=True), reverse=True):
            table = table.halved(pair, radius, grip)
    return table


def _entry(gripper: Gripper, rate: float, radius: float) -> GripCurve | None:
    """Return the grip on a radius [m], without shapes; None: it is not held."""
    try:
        return replace(solve_curve(GripQuestion(gripper, radius, rate=rate)), shapes=None)
    except SpiralError:
        return None


def _setup(question: GripQuestion) -> GripSetup:
    gripper, radius = question.gripper, question.radius
    laid = lay_into_coil(gripper, radius, friction=question.friction)
    if question.pose is None:
        return laid
    center, axis = question.pose
    obstacle = Obstacle.along(Cylinder(radius), center, axis, laid.obstacle.friction)
    return GripSetup(gripper, obstacle, laid.closing, tip_pressure=laid.tip_pressure)


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
