# SPDX-License-Identifier: Apache-2.0
"""A grasp that runs: how else it may end, and what may change under it."""

from dataclasses import replace

import pytest
from ros.control_bench import CANCELED, FAILED, FAULTS, LIMITS, RUNNING, SUCCEEDED, TICK, Bench
from ros.fakes import FakePlanner, regime_at

from spiral_core import SolverError, WrapRegime
from spiral_core.rod.state import RodStatus
from spiral_gripper_ros.control.limits import AbortPolicy
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.control.target import LONGEST_STEP


@pytest.mark.parametrize("parameter", list(AbortPolicy))
@pytest.mark.parametrize("given", [None, *AbortPolicy])
def test_a_canceled_grasp_does_what_its_policy_or_else_the_parameter_says(given, parameter):
    bench = Bench(replace(LIMITS, grasp_abort_policy=parameter))
    grasp = bench.grasp(abort_policy=given)
    bench.run(0.2)
    bench.control.cancel(bench.now, grasp)
    report = grasp.report
    assert (report.outcome, report.refusal.reason) == (CANCELED, Reason.GRASP_CANCELED)
    vents = (given or parameter) is AbortPolicy.VENT
    commands = bench.run(3.0, radius=0.02)
    assert commands == [0.0 if vents else pytest.approx(2.0e4)] * len(commands)
    assert bench.state is (State.RELEASED if vents else State.GRASPING)
    assert bench.reason is Reason.GRASP_CANCELED


def test_a_grasp_that_has_ended_cannot_be_canceled(holding):
    before = holding.seen
    holding.control.cancel(holding.now, holding.grasped)
    assert holding.seen == before
    assert holding.grasped.report.outcome is SUCCEEDED


def test_a_newer_goal_replaces_the_one_that_runs(bench):
    first = bench.grasp(0.02)
    bench.run(0.3)
    second = bench.grasp(0.04)
    report = first.report
    assert (report.outcome, report.refusal.reason) == (FAILED, Reason.GRASP_REPLACED)
    assert report.plan.pressure == 5.0e4
    assert bench.seen.pressure_command == pytest.approx(3.0e4)
    bench.control.cancel(bench.now, first)
    assert bench.end(second) == (SUCCEEDED, Reason.NONE)
    assert bench.seen.pressure_command == 2.5e4


def test_a_grasp_that_is_not_reached_in_time_fails(bench):
    grasp = bench.grasp(timeout=0.3)
    assert bench.end(grasp) == (FAILED, Reason.GRASP_TIMEOUT)
    report = grasp.report
    assert report.elapsed <= 0.3 + TICK * (1 + 1e-9)
    assert "within 0.3 s" in report.refusal.text
    assert (bench.state, bench.reason) == (State.RELEASED, Reason.GRASP_TIMEOUT)
    assert bench.control.rearm() is None
    assert bench.state is State.WAITING


def test_the_parameter_is_the_timeout_of_a_goal_without_one(bench):
    bench.sees = lambda pressure, perfect: WrapRegime.OVERHANG
    grasp = bench.grasp()
    bench.end(grasp)
    assert grasp.report.elapsed == pytest.approx(LIMITS.grasp_timeout, abs=2.0 * TICK)


@pytest.mark.parametrize("measured", [True, False])
@pytest.mark.parametrize("seen", [WrapRegime.OVERHANG, None])
def test_a_pressure_that_settles_without_a_perfect_wrap_is_a_failed_wrap(measured, seen):
    bench = Bench(measured=measured)
    bench.sees = lambda pressure, perfect: seen
    grasp = bench.grasp(abort_policy=AbortPolicy.HOLD)
    assert bench.end(grasp) == (FAILED, Reason.WRAP_FAILED)
    assert (seen.value if seen else "unknown") in grasp.report.refusal.text
    assert not bench.seen.wrapped
    assert set(bench.run(1.0)) == {5.0e4}
    assert (bench.state, bench.reason) == (State.GRASPING, Reason.WRAP_FAILED)


def test_a_wrap_that_is_seen_late_is_reached(bench):
    bench.sees = lambda pressure, perfect: WrapRegime.OVERHANG
    grasp = bench.grasp()
    bench.run(2.0)
    bench.sees = regime_at
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)


def test_what_was_seen_of_another_object_does_not_count(holding):
    assert holding.seen.wrapped
    other = holding.grasp(0.03)
    assert not holding.seen.wrapped
    holding.end(other)
    holding.control.release()
    holding.control.rearm()
    holding.control.offer_radius(holding.now, 0.02, holding.planner)
    assert (holding.state, holding.seen.wrapped) == (State.TRACKING, False)


@pytest.mark.parametrize(("fault", "stuck_at", "reason"), FAULTS)
@pytest.mark.parametrize("policy", list(AbortPolicy))
def test_a_fault_of_the_measured_pressure_lets_a_grasp_fail(bench, fault, stuck_at, reason, policy):
    bench.run(0.5)
    grasp = bench.grasp(abort_policy=policy)
    bench.regulator.fault = fault
    bench.regulator.pressure = max(bench.regulator.pressure, stuck_at)
    assert bench.end(grasp) == (FAILED, reason)
    vents = policy is AbortPolicy.VENT
    assert bench.state is (State.RELEASED if vents else State.GRASPING)
    assert bench.reason is reason
    assert len(set(bench.run(1.0))) == 1
    assert (bench.seen.pressure_command == 0.0) is vents


def test_another_gravity_moves_the_pressure_of_a_grasp(holding):
    holding.control.replan(FakePlanner(product=1.2e3))
    assert holding.run(1.0)[-1] == pytest.approx(6.0e4)
    assert (holding.state, holding.reason) == (State.GRASPING, Reason.NONE)


def test_overpressure_stays_on_top_when_gravity_changes(bench):
    grasp = bench.grasp(overpressure=5.0e3)
    bench.control.replan(FakePlanner(product=1.2e3))
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)
    assert bench.seen.pressure_command == pytest.approx(6.5e4)


def test_at_a_gravity_at_which_it_cannot_be_gripped_the_grasp_waits_until_it_can(bench):
    grasp = bench.grasp()
    bench.planner.error = SolverError(RodStatus.UNSTABLE, 1.0, 7)
    bench.control.replan(bench.planner)
    bench.run(2.0)
    assert (bench.state, bench.reason) == (State.GRASPING, Reason.NOT_CERTIFIED)
    assert bench.seen.pressure_command == 5.0e4
    assert grasp.report.outcome is RUNNING
    bench.planner.error = None
    bench.control.replan(bench.planner)
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)


def test_a_grasp_that_runs_out_of_time_says_what_kept_it(bench):
    grasp = bench.grasp()
    bench.planner.error = SolverError(RodStatus.UNSTABLE, 1.0, 7)
    bench.control.replan(bench.planner)
    assert bench.end(grasp) == (FAILED, Reason.GRASP_TIMEOUT)
    assert RodStatus.UNSTABLE.value in grasp.report.refusal.text


def test_a_continually_tilting_arm_does_not_keep_a_grasp_from_being_reached(bench):
    grasp = bench.grasp()
    for step in range(100):
        bench.control.replan(FakePlanner(product=1.0e3 + 0.2 * step))
        bench.tick()
    assert grasp.report.outcome is SUCCEEDED


def test_lowering_the_cap_cuts_a_grasp_at_once_and_raising_it_raises_no_command(bench):
    grasp = bench.grasp()
    bench.run(0.5)
    bench.control.reconfigure(replace(LIMITS, pressure_cap=3.0e4))
    assert bench.tick() == 3.0e4
    bench.run(1.0)
    assert (bench.state, bench.reason) == (State.GRASPING, Reason.PRESSURE_CAP)
    assert grasp.report.outcome is RUNNING
    bench.control.reconfigure(LIMITS)
    assert set(bench.run(0.2)) == {3.0e4}
    bench.control.replan(bench.planner)
    assert set(bench.run(0.2)) == {3.0e4}
    assert (bench.state, bench.reason) == (State.GRASPING, Reason.PRESSURE_CAP)
    assert bench.end(bench.grasp()) == (SUCCEEDED, Reason.NONE)
    assert bench.seen.pressure_command == 5.0e4


@pytest.mark.parametrize("cap", [0.0, 1.0])
def test_a_followed_radius_that_was_capped_comes_back_with_the_next_radius_alone(bench, cap):
    bench.run(2.0, radius=0.02)
    before = bench.seen.pressure_command
    bench.control.reconfigure(replace(LIMITS, pressure_cap=cap))
    assert bench.tick() == cap
    bench.control.reconfigure(LIMITS)
    assert set(bench.run(3.0)) == {cap}  # beyond radius.timeout: held
    assert bench.run(2.0, radius=0.02)[-1] == before


def test_raising_the_cap_does_not_hide_that_gravity_forbids_the_grasp(holding):
    holding.planner.error = SolverError(RodStatus.UNSTABLE, 1.0, 7)
    holding.control.replan(holding.planner)
    holding.control.reconfigure(replace(LIMITS, pressure_cap=3.0e4))
    holding.control.reconfigure(LIMITS)
    assert holding.reason is Reason.NOT_CERTIFIED


def test_a_gravity_that_needs_more_than_the_cap_is_followed_with_the_next_goal(holding):
    holding.control.replan(FakePlanner(product=2.0e3))
    assert holding.reason is Reason.PRESSURE_CAP
    assert set(holding.run(1.0)) == {5.0e4}
    holding.control.reconfigure(replace(LIMITS, pressure_cap=1.2e5))
    assert set(holding.run(1.0)) == {5.0e4}
    assert holding.reason is Reason.PRESSURE_CAP
    holding.planner = FakePlanner(product=2.0e3)
    assert holding.end(holding.grasp()) == (SUCCEEDED, Reason.NONE)
    assert holding.seen.pressure_command == pytest.approx(1.0e5)


def test_a_pressure_that_was_left_standing_moves_for_nothing_but_the_cap(bench):
    grasp = bench.grasp(abort_policy=AbortPolicy.HOLD)
    bench.run(0.2)
    bench.control.cancel(bench.now, grasp)
    bench.control.replan(FakePlanner(product=1.2e3))
    commands = bench.run(1.0)
    assert commands == [pytest.approx(2.0e4)] * len(commands)
    bench.control.reconfigure(replace(LIMITS, pressure_cap=1.0e4))
    assert set(bench.run(1.0)) == {1.0e4}
    bench.control.reconfigure(LIMITS)
    assert set(bench.run(1.0)) == {1.0e4}
    assert (bench.state, bench.reason) == (State.GRASPING, Reason.GRASP_CANCELED)
    assert bench.end(bench.grasp()) == (SUCCEEDED, Reason.NONE)


def test_a_clock_that_leaps_back_does_not_stop_a_grasp(bench):
    grasp = bench.grasp()
    bench.run(0.2)
    bench.now -= 1000.0
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)
    assert grasp.report.elapsed < 2.0


@pytest.mark.parametrize("leap", [60.0, 1.0e15])
def test_a_clock_that_leaps_forward_ends_a_grasp_without_a_leap_of_the_pressure(bench, leap):
    grasp = bench.grasp(abort_policy=AbortPolicy.HOLD)
    bench.run(0.2)
    bench.now += leap
    command = bench.control.command(bench.now)
    assert command - 2.0e4 <= LIMITS.pressure_rate_up * LONGEST_STEP * (1 + 1e-12)
    assert grasp.report.refusal.reason is Reason.GRASP_TIMEOUT


def test_after_an_absurd_leap_of_the_clock_time_goes_on(bench):
    bench.control.command(1.0e300)
    bench.control.command(-1.0e300)
    bench.control.command(1.0e300)
    bench.control.command(bench.now)
    assert bench.end(bench.grasp()) == (SUCCEEDED, Reason.NONE)


def test_rearming_under_a_grasp_is_refused(holding):
    refusal = holding.control.rearm()
    assert (refusal.reason, refusal.text) == (
        Reason.INVALID_REQUEST,
        "a grasp is the target: release it first",
    )
    assert holding.state is State.GRASPING
