# SPDX-License-Identifier: Apache-2.0
"""Plans, shapes and regimes of a gripper, at the gravity that is present."""

import math
from concurrent.futures import Future
from dataclasses import replace

import pytest
from ros.control_bench import snapshot

from spiral_core import (
    NotGrippableError,
    SolverError,
    SpiralError,
    WrapCurve,
    WrapRegime,
    lay_into_coil,
)
from spiral_core.rod.state import RodStatus
from spiral_gripper import load_description
from spiral_gripper.files.grips import read_grips
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.planning.grip_follower import GripFollower
from spiral_gripper_ros.planning.loaded_gripper import MEASURED_STEP, LoadedGripper
from spiral_gripper_ros.planning.planner import GripperPlanner, planner_for

SIDEWAYS, HANGING = (0.0, 0.0, -9.80665), (9.80665, 0.0, 0.0)


class LaterPool(list):
    """Runs work only when the test says so."""

    def submit(self, *work):
        self.append((Future(), *work))
        return self[-1][0]

    def run(self):
        future, work, *arguments = self.pop()
        future.set_result(work(*arguments))


@pytest.fixture
def pool():
    return LaterPool()


@pytest.fixture
def loaded(gripper, pool):
    grips = GripFollower(gripper, HANGING, None, None, None)
    loaded = LoadedGripper(load_description("paper_design_70"), HANGING, pool, grips)
    loaded.load()
    return loaded


def test_an_object_of_known_direction_lies_where_its_grip_has_it(gripper):
    planner = GripperPlanner(replace(gripper, object_axis=(0.96, 0.0, -0.28)))
    plan, setup = planner.plan(0.02), lay_into_coil(planner.gripper, 0.02)
    assert plan.placement.center == setup.obstacle.position
    assert plan.laid.pressure == setup.tip_pressure != plan.wrap.pressure


def test_the_mount_follows_the_newest_gravity_in_the_background(loaded, gripper, pool):
    planner, (x, y, z), newest = loaded.planner, HANGING, (6.9, 6.9, 0.0)
    loaded.want((x, y + 0.09, z), hysteresis=0.1)
    assert not pool
    for gravity in (SIDEWAYS, (0.0, 9.8, 0.0), newest):
        loaded.want(gravity, hysteresis=0.1)
    assert loaded.poll() is None
    assert loaded.planner is planner
    for gravity in (SIDEWAYS, newest):
        assert len(pool) == 1
        pool.run()
        expected = WrapCurve(gripper.with_mount(gravity, None)).pressure_from_radius(0.02)
        assert loaded.poll().plan(0.02).pressure == pytest.approx(expected, rel=1e-9)
    assert loaded.poll() is None
    assert not pool


def test_a_planner_that_cannot_be_made_is_raised_and_nothing_is_planned_any_more(loaded, pool):
    loaded.want(SIDEWAYS, hysteresis=0.1)
    pool[0][0].set_exception(ZeroDivisionError("broken on purpose"))
    with pytest.raises(ZeroDivisionError):
        loaded.poll()
    with pytest.raises(SpiralError, match="broken on purpose"):
        loaded.planner.plan(0.02)


def test_a_shape_is_solved_anew_only_when_something_changed_noticeably(loaded):
    assert [loaded.update_shape(p, 0.02) for p in (5.0e4, 5.0e4, 5.1e4)] == [True, False, True]
    # Steps that are each too small add up.
    for steps, is_new in ((0.0, True), (1.0, False), (1.01, True), (2.0, False), (2.1, True)):
        before = loaded.measured.shape
        found = loaded.update_measured_shape(5.0e4 + steps * MEASURED_STEP, 0.02, 1.0e3)
        assert found is is_new is (loaded.measured.shape is not before)
    assert loaded.update_measured_shape(5.0e4 + 2.1 * MEASURED_STEP, 0.03, 1.0e3)
    error = SolverError(RodStatus.UNSTABLE, 1.0, 1)
    loaded.planner = GripperPlanner(loaded.gripper, error)
    assert not loaded.update_shape(5.1e4, 0.02)
    assert loaded.commanded.shape is None


def test_a_pressure_just_outside_the_description_counts_as_its_bound(loaded):
    highest = loaded.gripper.pressure_max
    for bound, pressure in ((0.0, -900.0), (highest, highest + 900.0)):
        assert loaded.update_measured_shape(pressure, None, 1.0e3)
        found, (expected, _) = loaded.measured.shape, loaded.planner.shape(bound, None)
        assert found.tip_position == pytest.approx(expected.tip_position, abs=1e-12)
        for beyond in (-1100.0, highest + 1100.0, math.nan, math.inf):
            assert not loaded.update_measured_shape(beyond, None, 1.0e3)
            assert loaded.measured.shape is None


def test_the_regime_is_as_measured_and_unknown_where_the_measured_shape_is(loaded):
    pressure = loaded.planner.plan(0.02).pressure
    loaded.update_shape(pressure, 0.02)
    seen = snapshot(State.TRACKING)
    for measured, regime in (
        (None, WrapRegime.PERFECT_WRAP),
        (0.5 * pressure, WrapRegime.OVERHANG),
        (1.0e6, None),
        (1.15 * pressure, WrapRegime.CURLING),
    ):
        loaded.update_measured_shape(measured, 0.02, 1.0e3)
        assert loaded.shown_regime(seen) is regime
    # A wrap that is pressed by overpressure is shown as perfect.
    pressed = snapshot(State.TRACKING, wrapped=True)
    assert loaded.shown_regime(pressed) is WrapRegime.PERFECT_WRAP
    loaded.update_measured_shape(pressure, None, 1.0e3)
    assert loaded.shown_regime(seen) is None


def test_what_is_told_to_be_gripped_is_held_by_the_table_where_there_is_one():
    description = load_description("prototype_p1")
    gripper, table = description.gripper, read_grips(description)
    told = GripFollower(gripper, gripper.gravity, table, None, None)
    planner = planner_for(gripper, gripper.gravity, told)
    smallest, largest = planner.held_range
    assert smallest == planner.radius_range[0]  # its thinnest one is held
    assert largest == table.held[-1] < 0.6 * planner.radius_range[1]
    for radius in (1.001 * table.radii[-1], table.radii[-2]):  # not held, and beyond the table
        with pytest.raises(NotGrippableError, match="the table of grips"):
            planner.plan(radius)
    with pytest.raises(NotGrippableError) as thick:
        planner.plan(0.05)
    assert thick.value.nearest_radius == largest
