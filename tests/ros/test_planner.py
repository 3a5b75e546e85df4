# SPDX-License-Identifier: Apache-2.0
import math
from concurrent.futures import Future
from dataclasses import replace

import pytest
from ros.grip_stand_ins import unknown_grips

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
from spiral_gripper_ros.control.states import Reason, refusal_from_error
from spiral_gripper_ros.planning.loaded_gripper import MEASURED_STEP, LoadedGripper
from spiral_gripper_ros.planning.mount_follower import MountFollower
from spiral_gripper_ros.planning.planner import (
    GripperPlanner,
    NoPlanner,
    PlannerFailedError,
    StillLoadingError,
    planner_for,
)

SIDEWAYS = (0.0, 0.0, -9.80665)


class LaterPool:
    """Runs work only when the test says so."""

    def __init__(self):
        self.waiting, self.jobs = [], []

    def submit(self, work, *arguments):
        future = Future()
        self.jobs.append(future)
        self.waiting.append(lambda: future.set_result(work(*arguments)))
        return future

    def run(self):
        self.waiting.pop(0)()


@pytest.fixture(scope="module")
def planner(gripper):
    return GripperPlanner(gripper)


def test_a_plan_is_the_cores_wrap_with_margin_and_force(planner, curve, gripper):
    wrap = curve.wrap_for_radius(0.02)
    plan = planner.plan(0.02)
    assert plan.pressure == wrap.pressure
    assert plan.turns_margin == pytest.approx(wrap.turns - gripper.turns_required)
    assert plan.line_force == pytest.approx(
        line_force(
            gripper.stiffness,
            wrap.unloaded_shape,
            0.02,
            wrap.helix_angle,
            gripper.tube.outer_radius,
        ),
        # of the wrap's own radius, which is 0.02 m to 1e-10, times the stiffness of that
        rel=1e-6,
    )
    assert 0.0 < plan.solve_time < 10.0


def test_an_object_of_known_direction_lies_where_its_grip_has_it(gripper):
    planner = GripperPlanner(replace(gripper, object_axis=(0.96, 0.0, -0.28)))
    plan, setup = planner.plan(0.02), lay_into_coil(planner.gripper, 0.02)
    assert plan.placement.center == setup.obstacle.position
    assert plan.laid.pressure == setup.tip_pressure != plan.wrap.pressure


def test_the_regime_is_that_of_the_commanded_pressure(planner):
    pressure = planner.plan(0.02).pressure
    assert planner.shape(pressure, 0.02).regime is WrapRegime.PERFECT_WRAP
    assert planner.shape(0.5 * pressure, 0.02).regime is WrapRegime.OVERHANG
    assert planner.shape(1.5 * pressure, 0.02).regime is WrapRegime.CURLING


def test_without_an_object_there_is_a_shape_but_no_regime(planner):
    shape = planner.shape(0.0, None)
    assert shape.regime is None
    assert shape.state.tip_position == pytest.approx((planner.gripper.tube.length, 0.0, 0.0))
    assert planner.shape(5.0e4, 1.0).regime is None


def test_a_gripper_that_cannot_coil_gives_a_planner_that_says_why(gripper):
    # Ten turns are more than its length can make.
    planner = planner_for(replace(gripper, turns_required=10.0), SIDEWAYS)
    assert isinstance(planner, NoPlanner)
    assert planner.gravity == SIDEWAYS
    low, high = planner.radius_range
    assert low < 0.02 < high
    for ask in (lambda: planner.plan(0.02), lambda: planner.shape(0.0, None)):
        with pytest.raises(NoCoilError):
            ask()


def test_the_mount_follows_gravity_in_the_background(planner, gripper):
    pool = LaterPool()
    mount = MountFollower(planner, gripper, pool)
    mount.want(SIDEWAYS, hysteresis=0.1)
    assert mount.poll() is None
    assert mount.planner is planner
    assert mount.gravity == SIDEWAYS
    pool.run()
    found = mount.poll()
    assert found is mount.planner
    assert found.gravity == SIDEWAYS
    expected = WrapCurve(gripper.with_mount(SIDEWAYS, None)).pressure_from_radius(0.02)
    assert found.plan(0.02).pressure == pytest.approx(expected, rel=1e-9)
    assert mount.poll() is None


def test_a_change_within_the_hysteresis_is_none(planner, gripper):
    pool = LaterPool()
    x, y, z = planner.gravity
    MountFollower(planner, gripper, pool).want((x, y + 0.09, z), hysteresis=0.1)
    assert pool.waiting == []


def test_only_the_newest_gravity_is_solved_after_the_running_one(planner, gripper):
    pool = LaterPool()
    mount = MountFollower(planner, gripper, pool)
    for angle in (0.5, 1.0, 1.5):
        mount.want((9.8 * math.cos(angle), 9.8 * math.sin(angle), 0.0), hysteresis=0.1)
    assert len(pool.waiting) == 1
    pool.run()
    first = mount.poll()
    assert len(pool.waiting) == 1
    pool.run()
    last = mount.poll()
    assert first.gravity == pytest.approx((9.8 * math.cos(0.5), 9.8 * math.sin(0.5), 0.0))
    assert last.gravity == pytest.approx((9.8 * math.cos(1.5), 9.8 * math.sin(1.5), 0.0))
    assert pool.waiting == []


def test_a_planner_that_cannot_be_made_is_raised_and_nothing_is_planned_any_more(planner, gripper):
    pool = LaterPool()
    mount = MountFollower(planner, gripper, pool)
    mount.want(SIDEWAYS, hysteresis=0.1)
    (job,) = pool.jobs
    job.set_exception(ZeroDivisionError("broken on purpose"))
    with pytest.raises(ZeroDivisionError):
        mount.poll()
    with pytest.raises(PlannerFailedError, match="broken on purpose"):
        mount.planner.plan(0.02)
    assert mount.poll() is None


def test_a_loaded_gripper_solves_a_shape_only_when_something_changed():
    loaded = LoadedGripper.ready("paper_design_70", (), LaterPool(), unknown_grips)
    assert loaded.planner.gravity == loaded.gripper.gravity
    assert loaded.update_shape(5.0e4, 0.02)
    first = loaded.shape
    assert not loaded.update_shape(5.0e4, 0.02)
    assert loaded.shape is first
    assert loaded.update_shape(5.1e4, 0.02)
    assert loaded.shape is not first
    loaded.mount.planner = NoPlanner(SIDEWAYS, SolverError(RodStatus.UNSTABLE, 1.0, 1))
    assert not loaded.update_shape(5.1e4, 0.02)
    assert loaded.shape is None


def test_the_measured_shape_is_solved_anew_when_the_pressure_has_changed_noticeably():
    loaded = LoadedGripper.ready("paper_design_70", (), LaterPool(), unknown_grips)
    assert loaded.update_measured_shape(5.0e4, 0.02, 1.0e3)
    first = loaded.measured_shape
    assert not loaded.update_measured_shape(5.0e4 + MEASURED_STEP, 0.02, 1.0e3)
    assert loaded.measured_shape is first
    assert loaded.update_measured_shape(5.0e4 + 1.01 * MEASURED_STEP, 0.02, 1.0e3)
    assert loaded.measured_shape is not first
    # Steps that are each too small add up.
    assert not loaded.update_measured_shape(5.0e4 + 2.0 * MEASURED_STEP, 0.02, 1.0e3)
    assert loaded.update_measured_shape(5.0e4 + 2.1 * MEASURED_STEP, 0.02, 1.0e3)
    assert loaded.update_measured_shape(5.0e4 + 2.1 * MEASURED_STEP, 0.03, 1.0e3)
    assert not loaded.update_measured_shape(None, 0.03, 1.0e3)
    assert loaded.measured_shape is None


@pytest.mark.parametrize(
    ("pressure", "at"),
    [(-900.0, 0.0), ("limit + 900", "limit"), (-1100.0, None), ("limit + 1100", None)],
)
def test_a_pressure_just_outside_the_description_counts_as_its_bound(gripper, pressure, at):
    loaded = LoadedGripper.ready("paper_design_70", (), LaterPool(), unknown_grips)
    limit = gripper.pressure_max
    values = {"limit": limit, "limit + 900": limit + 900.0, "limit + 1100": limit + 1100.0}
    loaded.update_measured_shape(values.get(pressure, pressure), None, 1.0e3)
    if at is None:
        assert loaded.measured_shape is None
    else:
        expected = loaded.planner.shape(values.get(at, at), None).state.tip_position
        assert loaded.measured_shape.state.tip_position == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("pressure", [math.nan, math.inf, -math.inf])
def test_a_pressure_that_is_no_number_has_no_shape(pressure):
    loaded = LoadedGripper.ready("paper_design_70", (), LaterPool(), unknown_grips)
    assert not loaded.update_measured_shape(pressure, 0.02, 1.0e3)
    assert loaded.measured_shape is None


def test_the_regime_is_as_measured_and_unknown_where_the_measured_shape_is(planner):
    loaded = LoadedGripper.ready("paper_design_70", (), LaterPool(), unknown_grips)
    pressure = planner.plan(0.02).pressure
    loaded.update_shape(pressure, 0.02)
    loaded.update_measured_shape(None, 0.02, 1.0e3)
    assert loaded.regime() is WrapRegime.PERFECT_WRAP
    loaded.update_measured_shape(0.8 * pressure, 0.02, 1.0e3)
    assert loaded.regime() is WrapRegime.OVERHANG
    loaded.update_measured_shape(1.0e6, 0.02, 1.0e3)
    assert loaded.regime() is None


def test_a_given_gravity_replaces_the_descriptions():
    assert (
        LoadedGripper.ready("paper_design_70", SIDEWAYS, LaterPool(), unknown_grips).planner.gravity
        == SIDEWAYS
    )


def test_a_gripper_that_is_being_loaded_says_so_until_its_planner_is_ready():
    pool = LaterPool()
    loaded = LoadedGripper.loading(load_description("prototype_p1"), SIDEWAYS, pool, unknown_grips)
    assert loaded.is_loading
    assert loaded.gripper.name == "prototype_p1"
    with pytest.raises(StillLoadingError, match="prototype_p1 is being loaded"):
        loaded.planner.plan(0.02)
    assert not loaded.update_shape(0.0, None)
    pool.run()
    planner = loaded.mount.poll()
    assert planner is loaded.planner
    assert planner.gravity == SIDEWAYS
    assert not loaded.is_loading
    assert loaded.update_shape(0.0, None)


def test_a_gripper_that_cannot_be_planned_for_is_no_longer_loading():
    pool = LaterPool()
    description = load_description("prototype_p1")
    description = replace(description, gripper=replace(description.gripper, turns_required=50.0))
    loaded = LoadedGripper.loading(description, (), pool, unknown_grips)
    pool.run()
    assert isinstance(loaded.mount.poll(), NoPlanner)
    assert not loaded.is_loading


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (NotGrippableError(0.002, "too thin", -1.0, 0.005), Reason.RADIUS_TOO_SMALL),
        (NotGrippableError(0.2, "too thick", -1.0, 0.04), Reason.RADIUS_TOO_LARGE),
        (NotGrippableError(0.2, "hopeless", -1.0, None), Reason.NOT_CERTIFIED),
        (SolverError(RodStatus.UNSTABLE, 1.0, 1), Reason.NOT_CERTIFIED),
        (NoCoilError(0.5, 1.05, 1.0e5), Reason.NOT_CERTIFIED),
        (InvalidInputError("friction", -1.0, "positive"), Reason.INVALID_REQUEST),
        (
            ActuationLimitError(ActuationLimit.LIMIT_POINT, "pressure", 2.0, 1.0),
            Reason.PRESSURE_CAP,
        ),
    ],
)
def test_every_error_of_the_core_has_its_reason(error, reason):
    refusal = refusal_from_error(error)
    assert refusal.reason is reason
    assert refusal.text == str(error)
