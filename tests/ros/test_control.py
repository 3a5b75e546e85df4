# SPDX-License-Identifier: Apache-2.0
"""The measured pressure, loading another gripper, and the clock."""

import math
from dataclasses import replace

import pytest
from ros.control_bench import FAILED, FAULTS, LIMITS, SUCCEEDED, Bench
from ros.fakes import RegulatorFault

from spiral_core import InvalidInputError
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import AbortPolicy, FaultPolicy
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.control.states import Reason, State


def test_a_fault_is_reported_and_what_is_tracked_goes_on(bench):
    bench.run(1.0, radius=0.02)
    bench.regulator.fault = RegulatorFault.LEAK
    assert set(bench.run(2.0, radius=0.02)) == {5.0e4}
    assert (bench.state, bench.reason) == (State.TRACKING, Reason.NONE)
    assert bench.seen.pressure_fault.reason is Reason.PRESSURE_LOW
    assert bench.seen.measured.pressure == pytest.approx(3.5e4, rel=1e-3)
    assert not bench.seen.wrapped
    bench.regulator.fault = RegulatorFault.NONE
    bench.run(2.0, radius=0.02)
    assert bench.seen.pressure_fault.reason is Reason.NONE
    assert bench.seen.wrapped


@pytest.mark.parametrize(("fault", "stuck_at", "reason"), FAULTS)
@pytest.mark.parametrize("grasped", [False, True])
def test_policy_vent_vents_at_a_fault_until_it_is_mended_and_rearmed(
    grasped, fault, stuck_at, reason
):
    bench = Bench(replace(LIMITS, pressure_fault_policy=FaultPolicy.VENT))
    bench.run(1.0, radius=0.02)
    if grasped:
        bench.end(bench.grasp())
    bench.regulator.fault = fault
    bench.regulator.pressure = max(stuck_at, 0.5 * bench.regulator.pressure)
    bench.run(3.0, radius=0.02)
    assert bench.seen.pressure_command == 0.0
    assert bench.state is State.FAULT
    # A valve that is stuck below the wrap pressure is above 0 Pa.
    assert bench.reason is reason
    if bench.seen.pressure_fault.reason is not Reason.NONE:
        assert bench.control.rearm().reason is bench.seen.pressure_fault.reason
        assert "still there" in bench.control.rearm().text
    bench.regulator.fault = RegulatorFault.NONE
    assert set(bench.run(2.0, radius=0.02)) == {0.0}
    assert bench.control.rearm() is None
    assert bench.run(2.0, radius=0.02)[-1] == 5.0e4


def test_policy_vent_ends_a_grasp_in_a_fault_whatever_its_own_policy(bench):
    bench.control.reconfigure(replace(LIMITS, pressure_fault_policy=FaultPolicy.VENT))
    grasp = bench.grasp(abort_policy=AbortPolicy.HOLD)
    bench.run(0.2)
    bench.regulator.fault = RegulatorFault.LEAK
    assert bench.end(grasp) == (FAILED, Reason.PRESSURE_LOW)
    assert (bench.state, bench.reason) == (State.FAULT, Reason.PRESSURE_LOW)
    assert set(bench.run(1.0)) == {0.0}


def test_a_sensor_that_stays_lost_is_overcome_by_policy_report_or_a_new_activation():
    limits = replace(LIMITS, pressure_fault_policy=FaultPolicy.VENT)
    bench = Bench(limits)
    bench.run(1.0, radius=0.02)
    bench.is_measured = False
    bench.run(1.0, radius=0.02)
    assert bench.reason is Reason.PRESSURE_LOST
    assert bench.control.rearm().reason is Reason.PRESSURE_LOST
    bench.control.reconfigure(LIMITS)
    assert bench.control.rearm() is None
    assert bench.run(1.0, radius=0.02)[-1] == 5.0e4
    bench.control.reconfigure(limits)
    assert bench.tick(radius=0.02) == 0.0
    bench.control.deactivate()
    bench.control.activate()
    assert bench.run(1.0, radius=0.02)[-1] == 5.0e4


def test_while_inactive_a_fault_changes_nothing(bench):
    bench.control.reconfigure(replace(LIMITS, pressure_fault_policy=FaultPolicy.VENT))
    bench.control.deactivate()
    bench.run(1.0)
    bench.regulator.fault = RegulatorFault.ABSOLUTE
    bench.run(1.0)
    assert bench.seen.pressure_fault.reason is Reason.PRESSURE_HIGH
    assert (bench.state, bench.reason) == (State.INACTIVE, Reason.NOT_ACTIVE)


def test_a_goal_is_refused_while_a_fault_would_let_it_fail(holding):
    holding.regulator.fault = RegulatorFault.LEAK
    holding.run(1.0)
    before = holding.seen
    assert holding.grasp(0.03).reason is Reason.PRESSURE_LOW
    assert holding.seen == before
    holding.regulator.fault = RegulatorFault.NONE
    holding.run(1.0)
    assert holding.end(holding.grasp(0.03)) == (SUCCEEDED, Reason.NONE)


def test_a_reached_grasp_holds_through_a_fault_that_is_only_reported(holding):
    assert holding.seen.wrapped
    holding.regulator.fault = RegulatorFault.LOST
    assert set(holding.run(2.0)) == {5.0e4}
    assert (holding.state, holding.reason) == (State.GRASPING, Reason.NONE)
    assert holding.seen.pressure_fault.reason is Reason.PRESSURE_LOST
    assert holding.seen.measured is None
    assert not holding.seen.wrapped  # its watchdog may have vented: nobody knows


@pytest.mark.parametrize("pressure", [math.nan, -math.inf, 1.0e9])
def test_an_impossible_measured_pressure_is_dropped_and_counted(holding, pressure):
    before = holding.seen
    refusal = holding.control.offer_measured(holding.now, pressure)
    assert refusal.reason is Reason.PRESSURE_INVALID
    assert holding.seen.measured == before.measured
    assert holding.seen.refused[Reason.PRESSURE_INVALID] == 1
    assert (holding.state, holding.reason) == (State.GRASPING, Reason.NONE)


def test_an_activation_forgets_what_was_measured(holding):
    holding.control.deactivate()
    holding.control.activate()
    assert holding.seen.measured is None
    holding.is_measured = False
    holding.run(3.0)
    assert holding.seen.pressure_fault.reason is Reason.NONE


def test_what_is_tracked_is_wrapped_once_the_pressure_is_there(bench):
    bench.run(0.1, radius=0.02)
    assert not bench.seen.wrapped
    bench.run(1.0, radius=0.02)
    assert bench.seen.wrapped
    bench.control.release()
    assert not bench.seen.wrapped


@pytest.mark.parametrize("now", [math.nan, math.inf])
def test_a_time_that_is_none_is_an_error(holding, now):
    bench = holding
    for call in (
        lambda: bench.control.command(now),
        lambda: bench.control.offer_radius(now, 0.02, bench.planner),
        lambda: bench.control.offer_measured(now, 0.0),
        lambda: bench.control.observe(now, None),
        lambda: bench.control.cancel(now, bench.grasped),
        lambda: bench.control.start_release(now, ReleaseGoal()),
        lambda: bench.control.start_grasp(now, GraspGoal(0.02), bench.planner),
    ):
        with pytest.raises(InvalidInputError, match="now"):
            call()
