# SPDX-License-Identifier: Apache-2.0
"""What pulls answer: never a false zero, bounds that say so, and each direction computed once."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from spiral_core import (
    Actuator,
    FiberAngles,
    Gripper,
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
from spiral_core.grip.window import GripPoint, GripWindow
from spiral_core.rod.state import RodEvent, RodPath
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long


def silicone(length: float, beta: float, pressure_max: float) -> Gripper:
    """Return a gripper of soft silicone tube, 9.5 mm x 0.8 mm."""
    tube = Tube(inner_radius=4.75e-3, wall_thickness=0.8e-3, length=length)
    fibers = FiberAngles(np.radians(88.0), np.radians(beta))
    actuator = Actuator(tube, fibers, NeoHookean(190e3))
    return gripper_from_actuator("silicone", actuator, density=1150.0, pressure_max=pressure_max)


@cache
def rough() -> GripWindow:
    """Return a window with much friction, in which a state is hard to solve again."""
    return grip_window(lay_into_coil(silicone(0.4, 60.0, 165.5e3), 0.015, friction=0.5))


def test_a_window_has_no_false_zero() -> None:
    """At 111.94 kPa nothing changes from the closed state, and Newton's method finds no end."""
    pressures = (105.25e3, 111.94e3, 118.63e3, 132e3)
    points = [rough().at(pressure) for pressure in pressures]
    for pull, least in ((Pull.AWAY, 0.15), (Pull.TOWARDS, 0.025)):
        held = [holding_force(point, pull) for point in points]
        forces = [each.force for each in held]
        assert all(len(each.forces) > 5 for each in held)
        steps = [np.diff(each.displacements[:-1]) for each in held]
        assert np.concatenate(steps) == pytest.approx(1.5e-3, rel=1e-9)  # a tenth of the radius
        assert forces == sorted(forces)
        assert forces[0] > least


def test_a_pull_begins_at_the_onset_too() -> None:
    """There the coil shifts by a quarter of a millimeter in the step that moves nothing."""
    window = grip_window(lay_into_coil(load_gripper("paper_design_70"), 0.02, friction=0.6))
    held = holding_force(window.at(window.onset_wrap), Pull.AWAY)
    assert held.end is PullEnd.SLIPPED
    assert held.force > 0.4


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_a_pull_that_cannot_be_followed_says_so(
    steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Unknown if not even the first step is found; else the force is a lower bound."""
    follow, calls = holding.follow_contact, []

    def given_up(problems, *, start, stop_at_event) -> RodPath:
        calls.append(start)
        if len(calls) <= steps:
            return follow(problems, start=start, stop_at_event=stop_at_event)
        return RodPath((), (RodEvent(0.0, start, start),))

    monkeypatch.setattr(holding, "follow_contact", given_up)
    held = holding_force(rough().points[-1], Pull.AWAY)
    assert held.end is PullEnd.NOT_FOLLOWED
    if steps < 2:
        assert not held.is_lower_bound
        assert math.isnan(held.force)
        assert math.isnan(held.within(1.0))
        assert "unknown" in repr(held)
    else:
        assert held.is_lower_bound
        assert held.force == held.forces.max() > 0.0
        assert "at least" in repr(held)


def test_friction_beyond_what_can_be_followed_gives_a_lower_bound() -> None:
    """With a coefficient of 1.5 the force doubles at each step, until a step is not found."""
    setup = lay_into_coil(load_gripper("paper_design_70"), 0.015, friction=1.5)
    tip = setup.tip_pressure
    held = holding_force(grip_window(setup, [0.6 * tip, 0.9 * tip, 1.06 * tip]).points[-1])
    assert held.end is not PullEnd.LOST
    assert held.is_lower_bound
    assert held.force > 0.5


def test_a_taut_tube_whose_elements_are_too_long_ends_the_pull_in_a_lower_bound() -> None:
    """With a coefficient of 0.8 the tube is pulled with tens of newtons: no state answers there."""
    setup = lay_into_coil(load_gripper("paper_design_70"), 0.015, friction=0.8, elements=60)
    tip = setup.tip_pressure
    held = holding_force(grip_window(setup, [0.6 * tip, 0.9 * tip, 1.1 * tip]).points[-1])
    assert held.is_lower_bound
    assert held.force > 1.0


@cache
def sliding() -> tuple[GripPoint, dict[Pull, HoldingForce]]:
    """Return a point whose object slides along its axis, and its forces in several ways."""
    window = grip_window(lay_into_coil(silicone(0.300908, 50.0, 85e3), 0.025, friction=0.5))
    point = window.at(76.12e3)
    return point, holding_forces(point, (Pull.DOWN, Pull.AWAY, Pull.TOWARDS))


def test_a_weight_that_slides_has_a_curve_of_its_own() -> None:
    """Force, curve, stiffness and way of the pull along gravity belong together."""
    point, found = sliding()
    away, down = found[Pull.AWAY], found[Pull.DOWN]
    share = float(
        holding.pull_direction(point, Pull.DOWN) @ holding.pull_direction(point, Pull.AWAY)
    )
    assert 0.98 < share < 1.0
    assert down.force == pytest.approx(away.force / share, rel=1e-12)
    assert down.force == down.forces.max()
    assert down.displacement == down.displacements[np.argmax(down.forces)]
    slope = (down.forces[1] - down.forces[0]) / down.displacements[1]
    assert down.stiffness == pytest.approx(slope, rel=1e-9)
    # The same work along either way.
    work = [np.trapezoid(each.forces, each.displacements) for each in (away, down)]
    assert work[0] == pytest.approx(work[1], rel=1e-12)


@pytest.mark.parametrize("unknown", [Pull.DOWN, Pull.AWAY])
def test_along_gravity_nothing_is_known_where_one_of_both_ways_is_not(
    unknown: Pull, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sliding along its axis or moved straight down: the force not known may be the smaller one."""
    point, _ = sliding()
    axis = holding.pull_direction(point, Pull.AWAY)
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    gravity = 9.81 * (axis + across / np.linalg.norm(across)) / math.sqrt(2.0)
    gripper = replace(point.setup.gripper, gravity=tuple(gravity.tolist()))
    tilted = replace(point, setup=replace(point.setup, gripper=gripper))
    follow, place = holding.follow_contact, np.asarray(point.setup.obstacle.position)

    def given_up(problems, *, start, **given) -> RodPath:
        way = np.subtract(problems[0].obstacles[0].position, place)
        along = bool(np.linalg.norm(np.cross(way, axis)) < 1e-9)
        if along is (unknown is Pull.AWAY):
            return RodPath((), (RodEvent(0.0, start, start),))
        return follow([point.setup.problem(point.pressure)], start=point.state, **given)

    monkeypatch.setattr(holding, "follow_contact", given_up)
    assert math.isnan(holding_force(tilted, unknown).force)
    assert math.isnan(holding_force(tilted, Pull.DOWN).force)


def test_several_directions_are_computed_once_each(monkeypatch: pytest.MonkeyPatch) -> None:
    point, found = sliding()
    follow, asked = holding.follow_contact, []

    def counted(problems, **given) -> RodPath:
        asked.append(problems[0].obstacles[0].position)
        return follow(problems, **given)

    monkeypatch.setattr(holding, "follow_contact", counted)
    again = holding_forces(point, (Pull.DOWN, Pull.AWAY))
    assert len(asked) == len(set(asked)) >= len(found[Pull.AWAY].forces)
    assert again[Pull.DOWN].force == found[Pull.DOWN].force


def test_within_a_diameter_less_is_held_than_at_a_late_peak() -> None:
    _, found = sliding()
    held = found[Pull.TOWARDS]
    assert held.displacement > 0.03
    assert held.within(held.displacement) == held.force
    near = held.within(0.5 * held.displacement)
    assert 0.0 < near < held.force
    assert near in held.forces
    none = replace(held, forces=held.forces - 1.0)
    assert none.within(0.01) == 0.0


def test_a_displacement_that_is_no_number_is_refused() -> None:
    held = HoldingForce(Pull.AWAY, 1.0, 0.1, 1.0, np.array([0.1]), np.array([1.0]), PullEnd.SLIPPED)
    assert held.within(0.1) == 1.0
    assert "away from the base: 1 N at 100 mm; the object slides" in repr(held)
    for displacement in (math.nan, -0.1):
        with pytest.raises(InvalidInputError, match="displacement"):
            held.within(displacement)
