# SPDX-License-Identifier: Apache-2.0
"""Plans, shapes and regimes of a gripper, at the gravity that is present."""

import math
from concurrent.futures import Future
from contextlib import nullcontext
from dataclasses import replace

import pytest

from spiral_core import (
    InvalidInputError,
    NoCoilError,
    NotGrippableError,
    SolverError,
    WrapCurve,
    WrapRegime,
    lay_into_coil,
)
from spiral_core.errors import ActuationLimit, ActuationLimitError
from spiral_core.rod.state import RodStatus
from spiral_core.wrap.wrap import line_force
from spiral_gripper import load_description
from spiral_gripper_ros.control.states import refusal_from_error
from spiral_gripper_ros.planning.grip_follower import GripFollower
from spiral_gripper_ros.planning.loaded_gripper import MEASURED_STEP, LoadedGripper
from spiral_gripper_ros.planning.planner import (
    GripperPlanner,
    NoPlanner,
    PlannerFailedError,
    StillLoadingError,
)

SIDEWAYS = (0.0, 0.0, -9.80665)


HANGING = (9.80665, 0.0, 0.0)


def loading(description, gravity, pool):
    grips = GripFollower(description.gripper, gravity, None, None, None)
    return LoadedGripper(description, gravity, pool, grips)


class LaterPool:
    """Runs work only when the test says so."""

    def __init__(self):
        self.waiting = []

    def submit(self, work, *arguments):
        self.waiting.append((Future(), work, arguments))
        return self.waiting[-1][0]

    def run(self):
        future, work, arguments = self.waiting.pop()
        future.set_result(work(*arguments))


@pytest.fixture
def pool():
    return LaterPool()


@pytest.fixture
def mount(planner, gripper, pool):
    grips = GripFollower(gripper, planner.gravity, None, None, None)
    mount = LoadedGripper(load_description("paper_design_70"), planner.gravity, pool, grips)
    mount.planner = planner
    return mount


@pytest.fixture
def loaded(pool):
    loaded = loading(load_description("paper_design_70"), HANGING, pool)
    loaded.load()
    return loaded


def test_a_plan_is_the_cores_wrap_with_margin_and_force(planner, curve, gripper):
    wrap, plan = curve.wrap_for_radius(0.02), planner.plan(0.02)
    assert plan.pressure == wrap.pressure
    assert plan.turns_margin == pytest.approx(wrap.turns - gripper.turns_required)
    shape, angle, outer = wrap.unloaded_shape, wrap.helix_angle, gripper.tube.outer_radius
    # The wrap's own radius is 0.02 m to 1e-10, times the stiffness of that.
    force = line_force(gripper.stiffness, shape, 0.02, angle, outer)
    assert plan.line_force(plan.pressure) == pytest.approx(force, rel=1e-6)


def test_an_object_of_known_direction_lies_where_its_grip_has_it(gripper):
    planner = GripperPlanner(replace(gripper, object_axis=(0.96, 0.0, -0.28)))
    plan, setup = planner.plan(0.02), lay_into_coil(planner.gripper, 0.02)
    assert plan.placement.center == setup.obstacle.position
    assert plan.laid.pressure == setup.tip_pressure != plan.wrap.pressure


@pytest.mark.parametrize("row", ["1 PERFECT_WRAP", "0.5 OVERHANG", "1.5 CURLING"])
def test_the_regime_is_that_of_the_commanded_pressure(planner, row):
    part, regime = row.split()
    shape = planner.shape(float(part) * planner.plan(0.02).pressure, 0.02)
    assert shape.regime is WrapRegime[regime]
    assert planner.shape(0.0, None).regime is None


def test_the_mount_follows_the_newest_gravity_in_the_background(mount, planner, gripper, pool):
    x, y, z = planner.gravity
    mount.want((x, y + 0.09, z), hysteresis=0.1)
    assert not pool.waiting
    for gravity in (SIDEWAYS, (0.0, 9.8, 0.0), (6.9, 6.9, 0.0)):
        mount.want(gravity, hysteresis=0.1)
    assert mount.poll() is None
    assert (mount.planner, mount.gravity) == (planner, (6.9, 6.9, 0.0))
    for gravity in (SIDEWAYS, (6.9, 6.9, 0.0)):
        assert len(pool.waiting) == 1
        pool.run()
        found = mount.poll()
        assert found is mount.planner
        assert found.gravity == gravity
        expected = WrapCurve(gripper.with_mount(gravity, None)).pressure_from_radius(0.02)
        assert found.plan(0.02).pressure == pytest.approx(expected, rel=1e-9)
    assert mount.poll() is None
    assert not pool.waiting


def test_a_planner_that_cannot_be_made_is_raised_and_nothing_is_planned_any_more(mount, pool):
    mount.want(SIDEWAYS, hysteresis=0.1)
    pool.waiting[0][0].set_exception(ZeroDivisionError("broken on purpose"))
    with pytest.raises(ZeroDivisionError):
        mount.poll()
    with pytest.raises(PlannerFailedError, match="broken on purpose"):
        mount.planner.plan(0.02)


def test_a_loaded_gripper_solves_a_shape_only_when_something_changed(loaded):
    assert loaded.planner.gravity == loaded.gripper.gravity
    assert loaded.update_shape(5.0e4, 0.02)
    assert not loaded.update_shape(5.0e4, 0.02)
    assert loaded.update_shape(5.1e4, 0.02)
    loaded.planner = NoPlanner(SIDEWAYS, SolverError(RodStatus.UNSTABLE, 1.0, 1))
    assert not loaded.update_shape(5.1e4, 0.02)
    assert loaded.commanded.shape is None


def test_the_measured_shape_is_solved_anew_when_the_pressure_has_changed_noticeably(loaded):
    for steps, radius, is_new in (
        (0.0, 0.02, True),
        (1.0, 0.02, False),
        (1.01, 0.02, True),
        (2.0, 0.02, False),  # steps that are each too small add up
        (2.1, 0.02, True),
        (2.1, 0.03, True),
    ):
        before = loaded.measured.shape
        found = loaded.update_measured_shape(5.0e4 + steps * MEASURED_STEP, radius, 1.0e3)
        assert found is is_new is (loaded.measured.shape is not before)


@pytest.mark.parametrize("beyond", [900.0, 1100.0, math.nan, math.inf])
def test_a_pressure_just_outside_the_description_counts_as_its_bound(loaded, beyond):
    highest, counts = loaded.gripper.pressure_max, beyond == 900.0
    for bound, pressure in ((0.0, -beyond), (highest, highest + beyond)):
        assert loaded.update_measured_shape(pressure, None, 1.0e3) is counts
        if counts:
            expected = loaded.planner.shape(bound, None).state.tip_position
            found = loaded.measured.shape.state.tip_position
            assert found == pytest.approx(expected, abs=1e-12)
        else:
            assert loaded.measured.shape is None


def test_the_regime_is_as_measured_and_unknown_where_the_measured_shape_is(loaded):
    pressure = loaded.planner.plan(0.02).pressure
    loaded.update_shape(pressure, 0.02)
    for measured, regime in (
        (None, WrapRegime.PERFECT_WRAP),
        (0.8 * pressure, WrapRegime.OVERHANG),
        (1.0e6, None),
    ):
        loaded.update_measured_shape(measured, 0.02, 1.0e3)
        assert loaded.regime(pressure) is regime


@pytest.mark.parametrize("can_coil", [True, False])
def test_a_gripper_that_is_being_loaded_says_so_until_its_planner_is_ready(pool, can_coil):
    description = load_description("prototype_p1")
    turns = description.gripper.turns_required if can_coil else 50.0
    gripper = replace(description.gripper, turns_required=turns)
    loaded = loading(replace(description, gripper=gripper), SIDEWAYS, pool)
    loaded.refresh()
    assert loaded.is_loading
    with pytest.raises(StillLoadingError, match="prototype_p1 is being loaded"):
        loaded.planner.plan(0.02)
    assert not loaded.update_shape(0.0, None)
    pool.run()
    assert loaded.poll() is loaded.planner
    assert (loaded.planner.gravity, loaded.is_loading) == (SIDEWAYS, False)
    assert loaded.update_shape(0.0, None) is can_coil
    with nullcontext() if can_coil else pytest.raises(NoCoilError):
        loaded.planner.plan(0.02)


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (NotGrippableError(0.002, "too thin", -1.0, 0.005), "RADIUS_TOO_SMALL"),
        (NotGrippableError(0.2, "too thick", -1.0, 0.04), "RADIUS_TOO_LARGE"),
        (NotGrippableError(0.2, "hopeless", -1.0, None), "NOT_CERTIFIED"),
        (NoCoilError(0.5, 1.05, 1.0e5), "NOT_CERTIFIED"),
        (InvalidInputError("friction", -1.0, "positive"), "INVALID_REQUEST"),
        (ActuationLimitError(ActuationLimit.LIMIT_POINT, "pressure", 2.0, 1.0), "PRESSURE_CAP"),
    ],
)
def test_every_error_of_the_core_has_its_reason(error, reason):
    refusal = refusal_from_error(error)
    assert (refusal.reason.name, refusal.text) == (reason, str(error))
