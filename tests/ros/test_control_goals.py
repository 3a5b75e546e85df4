# SPDX-License-Identifier: Apache-2.0
"""A grasp goal: which are accepted, and what reaching it means."""

import math
from dataclasses import replace

import pytest
from ros.control_bench import FAILED, LIMITS, RUNNING, SUCCEEDED, TICK, Bench
from ros.fakes import regime_at

from spiral_core import SolverError, WrapRegime
from spiral_core.rod.state import RodStatus
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import TimeoutPolicy
from spiral_gripper_ros.control.release import Release, ReleaseGoal
from spiral_gripper_ros.control.snapshot import MeasuredPressure
from spiral_gripper_ros.control.states import Reason, Refusal, State


def test_a_grasp_is_reached_once_the_measured_pressure_has_settled_and_the_wrap_is_perfect(bench):
    grasp = bench.grasp()
    assert (bench.state, bench.reason) == (State.GRASPING, Reason.NONE)
    bench.run(0.52)
    assert bench.seen.pressure_command == 5.0e4
    assert grasp.report.outcome is RUNNING
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)
    report = grasp.report
    assert report.plan.pressure == 5.0e4
    assert report.plan.pressure == 5.0e4
    assert report.progress == 1.0
    assert 0.7 <= report.elapsed <= 1.2
    assert set(bench.run(5.0)) == {5.0e4}
    assert (bench.state, bench.reason) == (State.GRASPING, Reason.NONE)
    assert bench.seen.wrapped
    assert grasp.report == report


def test_without_a_measured_pressure_it_is_reached_when_the_command_has_stood_for_a_while():
    bench = Bench(measured=False)
    grasp = bench.grasp()
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)
    assert grasp.report.elapsed == pytest.approx(0.5 + 0.3, abs=2.0 * TICK)
    assert bench.seen.measured is None
    assert bench.seen.wrapped


def test_progress_is_told_on_the_way(bench):
    grasp = bench.grasp()
    bench.run(0.2)
    assert grasp.report.progress == pytest.approx(0.4)
    assert grasp.report.elapsed == pytest.approx(0.2)


def test_overpressure_is_added_and_the_tip_may_curl_off(bench):
    assert bench.end(bench.grasp(overpressure=5.0e3)) == (SUCCEEDED, Reason.NONE)
    assert bench.seen.pressure_command == 5.5e4
    assert regime_at(5.5e4, 5.0e4) is WrapRegime.CURLING
    assert bench.seen.wrapped


def test_without_overpressure_a_tip_that_curls_off_is_no_wrap(holding):
    holding.sees = lambda pressure, perfect: WrapRegime.CURLING
    holding.tick()
    assert not holding.seen.wrapped


def test_the_radius_that_is_followed_can_be_grasped(bench):
    bench.run(1.0, radius=0.025)
    grasp = bench.grasp(None)
    assert bench.seen.radius == 0.025
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)
    assert bench.seen.pressure_command == 4.0e4


def test_a_pressure_is_ramped_to_whatever_it_wraps(bench):
    bench.run(1.0, radius=0.025)
    grasp = bench.grasp(None, pressure=1.0e4)
    assert bench.seen.radius is None
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)
    assert bench.seen.pressure_command == 1.0e4
    bench.run(1.0, radius=0.02)
    assert (bench.state, bench.seen.pressure_command) == (State.GRASPING, 1.0e4)
    assert not bench.seen.wrapped


def test_a_pressure_above_a_lowered_cap_is_cut_and_never_reached(bench):
    grasp = bench.grasp(None, pressure=6.0e4, timeout=1.0)
    bench.run(0.2)
    bench.control.reconfigure(replace(LIMITS, pressure_cap=1.0e4))
    assert bench.tick() == 1.0e4
    assert bench.seen.refusal.reason is Reason.PRESSURE_CAP
    assert bench.end(grasp) == (FAILED, Reason.GRASP_TIMEOUT)
    assert bench.seen.pressure_command == 0.0


def test_while_it_grasps_radii_are_neither_followed_nor_counted_nor_missed(bench):
    grasp = bench.grasp()
    bench.run(0.5, radius=0.03)
    bench.run(0.5, radius=math.nan)
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)
    assert set(bench.run(2.0, radius=0.03)) == {5.0e4}
    assert set(bench.run(2.0)) == {5.0e4}
    assert (bench.seen.radius, bench.seen.accepted) == (0.02, 0)
    assert not bench.seen.refused


@pytest.mark.parametrize("policy", list(TimeoutPolicy))
def test_no_radius_timeout_lets_go_of_what_is_grasped(policy):
    bench = Bench(replace(LIMITS, radius_timeout_policy=policy))
    bench.run(1.0, radius=0.02)
    assert bench.end(bench.grasp(None)) == (SUCCEEDED, Reason.NONE)
    assert set(bench.run(3.0)) == {5.0e4}
    assert bench.seen.radius_age is None


BAD_GOALS = [
    (GraspGoal(math.nan), Reason.RADIUS_NOT_FINITE),
    (GraspGoal(math.inf), Reason.RADIUS_NOT_FINITE),
    (GraspGoal(0.0), Reason.RADIUS_NOT_POSITIVE),
    (GraspGoal(-0.02), Reason.RADIUS_NOT_POSITIVE),
    (GraspGoal(0.002), Reason.RADIUS_TOO_SMALL),
    (GraspGoal(0.2), Reason.RADIUS_TOO_LARGE),
    (GraspGoal(0.02, overpressure=math.nan), Reason.INVALID_REQUEST),
    (GraspGoal(0.02, overpressure=-1.0), Reason.INVALID_REQUEST),
    (GraspGoal(0.02, timeout=math.nan), Reason.INVALID_REQUEST),
    (GraspGoal(0.02, timeout=0.0), Reason.INVALID_REQUEST),
    (GraspGoal(0.02, overpressure=math.inf), Reason.INVALID_REQUEST),
    (GraspGoal(0.02, timeout=math.inf), Reason.INVALID_REQUEST),
    (GraspGoal(0.0105), Reason.PRESSURE_CAP),
    (GraspGoal(0.02, overpressure=4.1e4), Reason.PRESSURE_CAP),
    (GraspGoal(0.02, overpressure=1.0e308), Reason.PRESSURE_CAP),
    (GraspGoal(None, pressure=1.0e308), Reason.PRESSURE_CAP),
    (GraspGoal(None, pressure=-1.0), Reason.INVALID_REQUEST),
    (GraspGoal(None, pressure=math.nan), Reason.INVALID_REQUEST),
    (GraspGoal(None, pressure=1.0, overpressure=1.0), Reason.INVALID_REQUEST),
]


@pytest.mark.parametrize(("goal", "reason"), BAD_GOALS)
@pytest.mark.parametrize("occupied", ["waiting", "tracking", "grasping", "grasped"])
def test_a_bad_goal_is_refused_and_changes_nothing(bench, occupied, goal, reason):
    grasp = None
    if occupied == "tracking":
        bench.run(1.0, radius=0.02)
    elif occupied != "waiting":
        grasp = bench.grasp()
        bench.run(0.2 if occupied == "grasping" else 2.0)
    before = bench.seen
    refusal = bench.control.start_grasp(bench.now, goal, bench.planner)
    assert refusal.reason is reason
    assert bench.seen == before
    if grasp:
        assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)


def test_a_goal_for_which_no_shape_is_certified_is_refused(bench):
    bench.planner.error = SolverError(RodStatus.UNSTABLE, 1.0, 7)
    assert bench.grasp().reason is Reason.NOT_CERTIFIED
    assert bench.state is State.WAITING


def test_a_planner_that_breaks_leaves_everything_as_it_was(holding):
    before = holding.seen
    holding.planner.error = ZeroDivisionError()
    with pytest.raises(ZeroDivisionError):
        holding.grasp(0.03)
    assert holding.seen == before


def test_after_a_fault_a_goal_is_refused_until_rearmed(bench):
    bench.control.fail("boom")
    refusal = bench.grasp()
    assert refusal == Refusal(Reason.INTERNAL_ERROR, "rearm first: boom")
    assert bench.control.rearm() is None
    assert bench.end(bench.grasp()) == (SUCCEEDED, Reason.NONE)


def test_the_followed_radius_cannot_be_grasped_if_there_is_none(bench):
    assert bench.grasp(None).reason is Reason.NO_RADIUS
    bench.run(1.0, radius=0.02)
    bench.run(0.1, radius=math.nan)
    assert bench.grasp(None).reason is Reason.RADIUS_NOT_FINITE
    bench.grasp(0.02)
    refusal = bench.grasp(None)
    assert (refusal.reason, refusal.text) == (
        Reason.NO_RADIUS,
        "no object_radius is being followed: give a radius",
    )
    bench.control.release()
    assert bench.grasp(None).reason is Reason.RELEASED


LOST, HIGH = Reason.PRESSURE_LOST, Reason.PRESSURE_HIGH
LOW, NO_FAULT = Refusal(Reason.PRESSURE_LOW, "a leak"), Refusal(Reason.NONE, "")


@pytest.mark.parametrize(
    "course",
    [
        # Of time, pressure, its age, fault, outcome. From before the ramp that the release ended:
        [
            (0.0, 500.0, 0.08, NO_FAULT, RUNNING),
            (0.02, 5.3e3, 0.0, NO_FAULT, RUNNING),
            (0.1, 500.0, 0.02, NO_FAULT, SUCCEEDED),
        ],
        # A leak or a burst hose: too low for the grip before, on its way to 0 now.
        [
            (0.0, 3.0e4, 0.01, LOW, RUNNING),
            (0.02, 2.0e4, 0.0, LOW, RUNNING),
            (0.3, 200.0, 0.0, LOW, SUCCEEDED),
        ],
        # A sensor that has failed:
        [(0.0, -1.0e5, 0.01, LOW, RUNNING), (0.02, -1.0e5, 0.0, LOW, (FAILED, LOW.reason))],
        # Nothing, or the same pressure, until it is late:
        [(2.9, 0.0, 4.0, NO_FAULT, RUNNING), (3.1, 0.0, 4.2, NO_FAULT, (FAILED, LOST))],
        [(2.9, 3e4, 0.0, NO_FAULT, RUNNING), (3.1, 3e4, 0.0, NO_FAULT, (FAILED, HIGH))],
    ],
)
def test_a_release_is_done_by_what_is_measured_after_it_began(bench, course):
    release = Release(ReleaseGoal(), 10.0, LIMITS)
    vented = replace(bench.seen, state=State.RELEASED, is_measured=True)
    for time, pressure, age, fault, expected in course:
        seen = MeasuredPressure(pressure, age)
        release.update(10.0 + time, replace(vented, measured=seen, pressure_fault=fault))
        report = release.report
        found = (report.outcome, report.refusal.reason) if report.outcome is FAILED else None
        assert expected == (found or report.outcome)


@pytest.mark.parametrize(
    ("end", "reason"),
    [
        (lambda bench: bench.control.deactivate(), Reason.NOT_ACTIVE),
        (lambda bench: bench.control.fail("a defect"), Reason.INTERNAL_ERROR),
    ],
)
def test_a_release_is_answered_though_nothing_is_commanded_any_more(holding, end, reason):
    release = holding.control.start_release(0.0, ReleaseGoal())
    assert release.report.outcome is RUNNING
    end(holding)
    assert (release.report.outcome, release.report.refusal.reason) == (FAILED, reason)
