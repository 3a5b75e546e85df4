# SPDX-License-Identifier: Apache-2.0
"""What pulls answer: never a false zero, bounds that say so, and each direction computed once."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import count
from math import inf, isnan, nan

import numpy as np
import pytest
from core.actuator_cases import actuator
from core.recorded import recorded
from numpy.linalg import norm
from numpy.testing import assert_allclose

from spiral_core import (
    InvalidInputError,
    NeoHookean,
    PressureLaw,
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


def closed_on(radius, pressures, **choices):
    """Return the paper's gripper closed up to the last of some pressures [kPa]."""
    setup = lay_into_coil(GRIPPER, radius, **choices)
    return grip_window(setup, np.multiply(pressures, 1e3).tolist()).points[-1]


def test_force_is_what_holds_or_a_bound():
    both = Pull.AWAY, Pull.TOWARDS
    for point, pulls, end, least, most in [
        # Close below its loss a coil presses towards the base, and gives way at the first step.
        (closed_on(0.02, (57.0, 75.0, 85.57)), both[1:], PullEnd.LOST, 0.0, 0.0),
        (closed_on(0.02, (57.0, 59.0), friction=0.0), both, PullEnd.SLIPPED, 0.0, 0.0),
        # The force doubles at each step, until a step is not found.
        (
            closed_on(0.015, (40.0, 60.0, 70.71), friction=1.5),
            *(both[:1], PullEnd.NOT_FOLLOWED, 0.5, inf),
        ),
    ]:
        for held in holding_forces(point, pulls).values():
            assert held.end is end
            assert least <= held.force <= most
            assert held.is_lower_bound == (end is PullEnd.NOT_FOLLOWED)
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
    recorded(f"pull/{steps} steps", [held, held.within(1.0), repr(held)])
    assert isnan(held.force) == (steps < 2)


@cache
def sliding():
    """Return a coil whose object slides along its axis, and its forces."""
    point = closed_on(0.01615, (38.4, 57.5, 62.7, 70.33))
    return point, holding_forces(point, (Pull.DOWN, Pull.AWAY))


def test_a_weight_that_slides_has_a_curve_of_its_own():
    """Along gravity, 12 degrees off its axis, the tube would be taut after two diameters: 60 N.

    Of its weight a share acts along the axis: the same work along either way.
    """
    point, found = sliding()
    recorded("pull/sliding", found)
    away, down = found[Pull.AWAY], found[Pull.DOWN]
    along, gravity = (holding.pull_direction(point, pull) for pull in (Pull.AWAY, Pull.DOWN))
    share = float(along @ gravity)
    assert 0.97 < share < 0.99
    assert_allclose(down.forces * share, away.forces, 1e-12)
    assert_allclose(down.displacements, away.displacements * share, 1e-12)
    for held in (away, down):
        assert held.end is PullEnd.SLIPPED
        peak = np.argmax(held.forces)
        assert held.force == held.forces[peak]
        assert held.displacement == held.displacements[peak] <= 2.0 * 0.01615
        slope = np.diff(held.forces)[0] / np.diff(held.displacements)[0]
        assert_allclose(held.stiffness, slope, 1e-9)


@pytest.mark.parametrize("unknown", [Pull.DOWN, Pull.AWAY])
def test_along_gravity_nothing_is_known_where_one_of_both_ways_is_not(unknown, monkeypatch):
    """Sliding along its axis or moved straight down: the force not known may be the smaller one."""
    point, _ = sliding()
    setup, axis = point.setup, holding.pull_direction(point, Pull.AWAY)
    leaning = setup.gripper.with_mount(tuple(7.0 * (axis + np.roll(axis, 1))), None)
    tilted = replace(point, setup=replace(setup, gripper=leaning))

    def gives_up(_, place):
        way = np.subtract(place, setup.obstacle.position)
        return (norm(np.cross(way, axis)) < 1e-9) == (unknown is Pull.AWAY)

    giving_up(monkeypatch, gives_up)
    assert isnan(holding_force(tilted, unknown).force)
    assert isnan(holding_force(tilted, Pull.DOWN).force)


def test_a_pull_ends_where_it_holds_enough():
    """Its curve is the first part of the whole one; moved both ways, each holds enough."""
    point, found = sliding()
    leaning = point.setup.gripper.with_mount((5.0, 5.0, 0.0), None)
    both = replace(point, setup=replace(point.setup, gripper=leaning))
    for at, pull, whole in [
        (point, Pull.AWAY, found[Pull.AWAY]),
        (point, Pull.DOWN, found[Pull.DOWN]),
        (both, Pull.DOWN, holding_force(both, Pull.DOWN)),
    ]:
        for part in (1e-9, 0.2, 0.7, 1.01):
            held = holding_force(at, pull, part * whole.force)
            assert (held.end is PullEnd.ENOUGH) == held.is_lower_bound == (part < 1.0)
            assert min(part, 1.0) * whole.force <= held.force <= whole.force
            if at is point:
                assert_allclose(held.forces, whole.forces[: len(held.forces)], 1e-12)
                assert (len(held.forces) < len(whole.forces)) == (part < 1.0)
    for enough in (nan, -0.1):
        with pytest.raises(InvalidInputError, match="enough"):
            holding_force(point, Pull.AWAY, enough)


def test_within_a_diameter_less_is_held_than_at_a_late_peak():
    forces, ways = np.array((0.0, 0.3, 0.2, 0.5)), np.array((0.0, 0.01, 0.02, 0.03))
    held = HoldingForce(Pull.TOWARDS, 0.5, 0.03, 30.0, ways, forces, PullEnd.SLIPPED)
    assert [held.within(way) for way in (0.005, 0.025, 0.03)] == [0.0, 0.3, 0.5]
    assert replace(held, forces=forces - 1.0).within(0.01) == 0.0
    for displacement in (nan, -0.1):
        with pytest.raises(InvalidInputError, match="displacement"):
            held.within(displacement)


def test_a_window_has_no_false_zero():
    """At 111.94 kPa nothing changes from the closed state, and Newton's method finds no end."""
    own = actuator(88.0, 60.0, NeoHookean(190e3), tube=Tube(4.75e-3, 0.8e-3, 0.4))
    own = replace(own, pressure_law=PressureLaw.SECTION)
    soft = gripper_from_actuator("silicone", own, density=1150.0, pressure_max=165.5e3)
    window = grip_window(lay_into_coil(soft, 0.015, friction=0.5))
    points = [window.at(pressure) for pressure in (105.25e3, 111.94e3, 118.63e3, 132e3)]
    for pull, least in ((Pull.AWAY, 0.15), (Pull.TOWARDS, 0.025)):
        held = [holding_force(point, pull) for point in points]
        forces = [each.force for each in held]
        assert least < forces[0] <= min(forces)
        assert forces == sorted(forces)
        for each in held:
            steps = np.diff(each.displacements[:-1])
            assert len(steps) > 3
            assert_allclose(steps, 1.5e-3, 1e-9)  # a tenth of the radius
