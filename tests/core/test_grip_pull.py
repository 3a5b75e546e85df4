# SPDX-License-Identifier: Apache-2.0
"""What pulls answer: never a false zero, bounds that say so, and each direction computed once."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import count

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.testing import assert_allclose

from spiral_core import (
    Actuator,
    FiberAngles,
    InvalidInputError,
    NeoHookean,
    Pull,
    Tube,
    grip_window,
    gripper_from_actuator,
    holding_force,
    lay_into_coil,
)
from spiral_core.grip import holding
from spiral_core.grip.holding import HoldingForce, PullEnd, holding_forces
from spiral_core.rod.state import RodEvent, RodPath
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long

GRIPPER = load_gripper("paper_design_70")


@pytest.mark.parametrize(
    ("setup", "pressures", "ends", "least", "most"),
    [
        # Close below its loss a coil presses towards the base, and gives way at the first step.
        ((0.02, 0.3), (57.0, 75.0, 85.57), {Pull.TOWARDS: PullEnd.LOST}, 0.0, 0.0),
        ((0.02, 0.0), (57.0, 59.0), dict.fromkeys((Pull.AWAY, Pull.TOWARDS), PullEnd.SLIPPED),
         0.0, 0.0),
        # The force doubles at each step, until a step is not found.
        ((0.015, 1.5), (40.0, 60.0, 70.71), {Pull.AWAY: PullEnd.NOT_FOLLOWED}, 0.5, math.inf),
        # Pulled with tens of newtons, elements are too long: no state answers there.
        ((0.015, 0.8, 60), (40.0, 60.0, 73.38), {Pull.AWAY: PullEnd.NOT_FOLLOWED}, 1.0, math.inf),
    ],
)  # fmt: skip
def test_force_is_what_holds_or_a_bound(
    setup,
    pressures,
    ends,
    least,
    most,
):
    radius, friction, *elements = setup
    laid = lay_into_coil(GRIPPER, radius, friction=friction, elements=(*elements, None)[0])
    point = grip_window(laid, [1e3 * pressure for pressure in pressures]).points[-1]
    for pull, held in holding_forces(point, list(ends)).items():
        assert held.end is ends[pull]
        assert least <= held.force <= most
        assert held.is_lower_bound == (held.end is PullEnd.NOT_FOLLOWED)
        assert held.forces.max() < 1e-12 or most > 0.0


def giving_up(monkeypatch, gives_up):
    """Let steps fail where a function of their number and place says so."""
    follow, numbers = holding.follow_contact, count(1)

    def given_up(problems, *, start, **given):
        if gives_up(next(numbers), problems[0].obstacles[0].position):
            return RodPath((), (RodEvent(0.0, start, start),))
        return follow(problems, start=start, **given)

    monkeypatch.setattr(holding, "follow_contact", given_up)


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_a_pull_that_cannot_be_followed_says_so(steps, monkeypatch):
    """Unknown if not even the first step is found; else the force is a lower bound."""
    point, _ = sliding()
    giving_up(monkeypatch, lambda number, _: number > steps)
    held = holding_force(point, Pull.AWAY)
    assert held.end is PullEnd.NOT_FOLLOWED
    assert held.is_lower_bound == (steps > 1)
    if steps < 2:
        assert math.isnan(held.force)
        assert math.isnan(held.within(1.0))
        assert "unknown" in repr(held)
    else:
        assert held.force == held.forces.max() > 0.0
        assert "at least" in repr(held)


@cache
def sliding():
    """Return a coil whose object slides along its axis, and its forces."""
    laid = lay_into_coil(GRIPPER, 0.01615, friction=0.3)
    point = grip_window(laid, [38.4e3, 57.5e3, 62.7e3, 70.33e3]).points[-1]
    return point, holding_forces(point, (Pull.DOWN, Pull.AWAY))


def test_a_weight_that_slides_has_a_curve_of_its_own():
    """Along gravity, 12 degrees off its axis, the tube would be taut after two diameters: 60 N.

    Of its weight a share acts along the axis: the same work along either way.
    """
    point, found = sliding()
    away, down = found[Pull.AWAY], found[Pull.DOWN]
    along, gravity = (holding.pull_direction(point, pull) for pull in (Pull.AWAY, Pull.DOWN))
    share = float(along @ gravity)
    assert 0.97 < share < 0.99
    assert_allclose(down.forces * share, away.forces, rtol=1e-12)
    assert_allclose(down.displacements, away.displacements * share, rtol=1e-12)
    for held in (away, down):
        assert held.end is PullEnd.SLIPPED
        assert 0.69 < held.force < 0.77
        peak = np.argmax(held.forces)
        assert held.force == held.forces[peak]
        assert held.displacement == held.displacements[peak] <= 2.0 * 0.01615
        slope = np.diff(held.forces)[0] / np.diff(held.displacements)[0]
        assert held.stiffness == pytest.approx(slope, rel=1e-9)


@pytest.mark.parametrize("unknown", [Pull.DOWN, Pull.AWAY])
def test_along_gravity_nothing_is_known_where_one_of_both_ways_is_not(unknown, monkeypatch):
    """Sliding along its axis or moved straight down: the force not known may be the smaller one."""
    point, _ = sliding()
    setup, axis = point.setup, holding.pull_direction(point, Pull.AWAY)
    across = np.cross(axis, (0.0, 0.0, 1.0))
    x, y, z = (7.0 * (axis + across / norm(across))).tolist()
    leaning = replace(setup, gripper=replace(setup.gripper, gravity=(x, y, z)))
    tilted = replace(point, setup=leaning)

    def gives_up(_, place):
        way = np.subtract(place, setup.obstacle.position)
        along = bool(norm(np.cross(way, axis)) < 1e-9)
        return along is (unknown is Pull.AWAY)

    giving_up(monkeypatch, gives_up)
    assert math.isnan(holding_force(tilted, unknown).force)
    assert math.isnan(holding_force(tilted, Pull.DOWN).force)


def test_within_a_diameter_less_is_held_than_at_a_late_peak():
    forces, ways = np.array((0.0, 0.3, 0.2, 0.5)), np.array((0.0, 0.01, 0.02, 0.03))
    held = HoldingForce(Pull.TOWARDS, 0.5, 0.03, 30.0, ways, forces, PullEnd.SLIPPED)
    assert [held.within(way) for way in (0.005, 0.025, 0.03)] == [0.0, 0.3, 0.5]
    assert replace(held, forces=forces - 1.0).within(0.01) == 0.0
    for displacement in (math.nan, -0.1):
        with pytest.raises(InvalidInputError, match="displacement"):
            held.within(displacement)


def test_a_window_has_no_false_zero():
    """At 111.94 kPa nothing changes from the closed state, and Newton's method finds no end."""
    tube = Tube(inner_radius=4.75e-3, wall_thickness=0.8e-3, length=0.4)
    actuator = Actuator(tube, FiberAngles(np.radians(88.0), np.radians(60.0)), NeoHookean(190e3))
    soft = gripper_from_actuator("silicone", actuator, density=1150.0, pressure_max=165.5e3)
    window = grip_window(lay_into_coil(soft, 0.015, friction=0.5))
    points = [window.at(pressure) for pressure in (105.25e3, 111.94e3, 118.63e3, 132e3)]
    for pull, least in ((Pull.AWAY, 0.15), (Pull.TOWARDS, 0.025)):
        held = [holding_force(point, pull) for point in points]
        forces = [each.force for each in held]
        assert all(len(each.forces) > 5 for each in held)
        steps = [np.diff(each.displacements[:-1]) for each in held]
        assert np.concatenate(steps) == pytest.approx(1.5e-3, rel=1e-9)  # a tenth of the radius
        assert forces == sorted(forces)
        assert forces[0] > least
