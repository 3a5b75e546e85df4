# SPDX-License-Identifier: Apache-2.0
"""The default grip, the take-over of a pressure, and what happens when nobody is heard."""

from dataclasses import replace
from itertools import pairwise

import pytest
from ros.control_bench import LIMITS, SUCCEEDED, TICK, Bench

from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import FaultPolicy, TimeoutPolicy
from spiral_gripper_ros.control.states import Event, Reason, Refusal, State

WRAP = 5.0e4  # of the bench's planner at 20 mm [Pa]


def bench_with(**limits):
    measured = limits.pop("measured", True)
    return Bench(replace(LIMITS, **limits), measured=measured)


# --- the default grip ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("ratio", "recommended", "cap", "part"),
    [
        (1.1, None, 9.0e4, 1.1),
        (1.1, None, 1.02 * WRAP, 1.02),  # the cap bounds the overpressure, not the range
        (None, None, 9.0e4, 1.1),
        (None, 1.05, 9.0e4, 1.05),
        (None, 0.97, 9.0e4, 1.0),
        (None, 1.3, 9.0e4, 1.2),
    ],
)
@pytest.mark.parametrize("is_goal", [False, True])
def test_the_default_grip_is_the_ratio_or_what_is_recommended(
    is_goal, ratio, recommended, cap, part
):
    bench = bench_with(grip_ratio=ratio, pressure_cap=cap)
    bench.planner.recommended, bench.planner.highest_good = recommended, 1.2
    if is_goal:
        grasp = bench.grasp()
        assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)
        assert grasp.report.overpressure == bench.seen.overpressure
    command = bench.run(1.5, radius=0.02)[-1]
    assert command == pytest.approx(part * WRAP)
    assert bench.seen.overpressure == pytest.approx((part - 1.0) * WRAP)
    assert bench.seen.wrapped
    assert bench.seen.shown(WrapRegime.CURLING) is WrapRegime.PERFECT_WRAP


def test_a_grip_that_becomes_known_is_not_loosened():
    bench = bench_with(grip_ratio=None)
    bench.run(1.5, radius=0.02)
    bench.planner.recommended = 1.04
    bench.control.replan(bench.planner)
    assert bench.tick(radius=0.02) == pytest.approx(1.1 * WRAP)
    bench.planner.highest_good = 1.07
    bench.control.replan(bench.planner)
    assert bench.run(1.0, radius=0.02)[-1] == pytest.approx(1.07 * WRAP)
    assert bench.run(1.0, radius=0.021)[-1] == pytest.approx(1.04 * WRAP / 1.05)


def test_where_gravity_changes_the_wrap_an_object_is_held_at_the_same_multiple_of_it():
    bench = bench_with(grip_ratio=None)
    bench.run(1.5, radius=0.02)
    bench.planner.recommended = 1.04
    bench.control.replan(bench.planner)
    bench.planner.product *= 0.8
    bench.control.replan(bench.planner)
    assert bench.run(1.0, radius=0.02)[-1] == pytest.approx(1.1 * 0.8 * WRAP)


def test_what_is_recommended_at_another_mount_is_not_kept_at_the_next():
    bench = bench_with(grip_ratio=None)
    for recommended in (1.05, 1.2, 1.05):
        bench.planner.recommended = recommended
        bench.control.replan(bench.planner)
        assert bench.run(1.5, radius=0.02)[-1] == pytest.approx(recommended * WRAP)


def test_a_ratio_that_is_given_up_is_not_kept():
    bench = bench_with(grip_ratio=1.2)
    bench.planner.recommended = 1.05
    bench.run(1.5, radius=0.02)
    bench.control.reconfigure(replace(LIMITS, grip_ratio=None))
    assert bench.run(1.0, radius=0.02)[-1] == pytest.approx(1.05 * WRAP)


def test_a_lowered_cap_takes_the_overpressure_first():
    bench = bench_with(grip_ratio=1.1)
    bench.run(1.5, radius=0.02)
    bench.control.reconfigure(replace(LIMITS, grip_ratio=1.1, pressure_cap=WRAP))
    assert bench.tick(radius=0.02) == WRAP
    assert bench.state is State.TRACKING
    assert bench.seen.overpressure == 0.0


@pytest.mark.parametrize("force", [0.0, -1.0])
def test_a_wrap_without_force_is_not_held(bench, force):
    bench.run(1.5, radius=0.02)
    assert bench.seen.wrapped
    bench.control.observe(bench.now, WrapRegime.PERFECT_WRAP, force)
    assert not bench.seen.wrapped
    bench.control.observe(bench.now, WrapRegime.PERFECT_WRAP, 1e-9)
    assert bench.seen.wrapped


def test_a_regime_that_is_not_wrapped_is_shown_as_it_is(bench):
    assert bench.seen.shown(WrapRegime.CURLING) is WrapRegime.CURLING


# --- take-over -----------------------------------------------------------------------------------


@pytest.fixture
def restarted():
    bench = Bench()
    bench.regulator.pressure = 4.0e4
    bench.control.activate(take_over=True)
    return bench


def agree(bench, *pressures):
    """Measure and command for longer than it takes to agree; return whether all is silent."""
    silent = []
    for step in range(14):
        bench.now += TICK
        bench.control.offer_measured(bench.now, pressures[step % len(pressures)])
        bench.control.command(bench.now)
        silent.append(bench.control.is_silent)
    return all(silent)


def test_a_measured_pressure_that_agrees_is_taken_over_and_stands(restarted):
    control = restarted.control
    assert control.is_silent
    agree(restarted, 4.0e4)
    assert not control.is_silent
    assert {control.command(restarted.now + TICK * step) for step in range(100)} == {4.0e4}
    assert restarted.state is State.TAKEN_OVER
    assert restarted.reason is Reason.TAKEN_OVER
    assert not restarted.seen.wrapped


def test_nothing_is_started_before_the_pressure_is_known(restarted):
    control = restarted.control
    assert not control.offer_radius(restarted.now, 0.02, restarted.planner)
    refusal = control.start_grasp(restarted.now, GraspGoal(0.02), restarted.planner)
    assert isinstance(refusal, Refusal)
    assert refusal.reason is Reason.TAKEN_OVER
    control.command(restarted.now)
    assert control.is_silent
    assert restarted.state is State.WAITING


def test_without_a_measured_pressure_it_starts_from_zero_after_the_time_out(restarted):
    restarted.is_measured = False
    silent = []
    for _ in range(round(6.0 / TICK)):
        restarted.tick()
        silent.append(restarted.control.is_silent)
    until = silent.index(False) * TICK
    assert until == pytest.approx(5.0, abs=2.0 * TICK)  # longer than measured_pressure.timeout
    assert restarted.seen.pressure_command == 0.0
    assert restarted.state is State.WAITING


def test_three_stalls_do_not_end_the_wait_for_a_pressure(restarted):
    restarted.is_measured = False
    for _ in range(3):
        restarted.now += 10.0
        restarted.tick()
        assert restarted.control.is_silent
    agree(restarted, 4.0e4)
    assert restarted.state is State.TAKEN_OVER


def test_a_vented_gripper_is_not_taken_over(restarted):
    agree(restarted, 10.0)
    assert not restarted.control.is_silent
    assert restarted.state is State.WAITING


def test_stale_gravity_vents_though_a_pressure_is_waited_for(restarted):
    control = restarted.control
    control.reconfigure(
        replace(LIMITS, gravity_timeout=0.2, gravity_timeout_policy=FaultPolicy.VENT)
    )
    control.hear_gravity(restarted.now)
    for step in range(11):  # faster than commands: it has agreed, and then it does not any more
        control.offer_measured(restarted.now + TICK * step, 4.0e4)
    assert restarted.state is State.TAKEN_OVER
    control.offer_measured(restarted.now + TICK * 11, 7.0e4)
    assert control.is_silent
    assert [control.command(restarted.now + 0.3 * step) for step in (1, 2)][-1] == 0.0
    assert restarted.state is State.FAULT
    assert not control.is_silent


def test_an_impossible_pressure_is_not_taken_over(restarted):
    restarted.control.offer_measured(restarted.now, float("nan"))
    assert restarted.control.is_silent


@pytest.mark.parametrize(
    ("pressures", "why"),
    [
        ((2.5e5,), "above pressure.cap"),
        ((101325.0,), "absolute"),
        ((-101325.0,), "below 0"),
        ((0.0, 6.275e4), "agree"),
        ((0.0,) * 5 + (6.275e4,) * 5, "agree"),
    ],
)
def test_readings_that_cannot_be_held_or_disagree_are_waited_out_and_then_taken_over(
    restarted, pressures, why
):
    for _ in range(50):  # for far longer than all time-outs
        assert agree(restarted, *pressures)
    assert restarted.reason is Reason.TAKEN_OVER
    assert why in restarted.seen.refusal.text
    agree(restarted, 4.0e4)
    assert restarted.control.command(restarted.now) == 4.0e4
    assert restarted.state is State.TAKEN_OVER


@pytest.mark.parametrize("pressure", [0.0, 4.0e4])
def test_the_first_command_is_what_was_agreed_though_radii_stream(restarted, pressure):
    control, commands = restarted.control, []
    while not commands:
        restarted.now += TICK
        control.offer_measured(restarted.now, pressure)
        control.offer_radius(restarted.now, 0.02, restarted.planner)
        command = control.command(restarted.now)
        commands += [] if control.is_silent else [command]
    assert commands == [pressure]


def test_a_pressure_that_was_measured_once_is_waited_for(restarted):
    restarted.tick()
    restarted.is_measured = False
    restarted.run(20.0)
    assert restarted.control.is_silent
    restarted.control.release()
    assert restarted.tick() == 0.0
    assert not restarted.control.is_silent


@pytest.mark.parametrize("event", [Event.RELEASE, Event.DEACTIVATE, Event.FAULT])
def test_whatever_vents_ends_the_wait_for_a_pressure(restarted, event):
    control = restarted.control
    vents = {Event.RELEASE: control.release, Event.DEACTIVATE: control.deactivate}
    vents.get(event, lambda: control.fail("broken"))()
    state = restarted.state
    assert not restarted.control.is_silent
    restarted.control.offer_measured(restarted.now, 4.0e4)
    assert restarted.control.command(restarted.now) == 0.0
    assert restarted.state is state


# --- silence -------------------------------------------------------------------------------------


def test_a_grip_is_vented_when_its_client_is_lost():
    bench = bench_with(keep_alive_timeout=0.5)
    grasp = bench.grasp()
    for _ in range(50):
        bench.control.keep_alive(bench.now)
        bench.tick()
    assert grasp.report.outcome is SUCCEEDED
    bench.run(0.48)
    assert bench.state is State.GRASPING
    assert bench.run(0.1)[-1] == 0.0
    assert (bench.state, bench.reason) == (State.RELEASED, Reason.CLIENT_LOST)


def test_a_client_has_the_whole_time_from_the_begin_of_a_grip():
    bench = bench_with(keep_alive_timeout=0.5)
    bench.run(60.0)
    bench.grasp()
    bench.run(0.48)
    assert bench.state is State.GRASPING


def test_without_a_time_out_no_client_is_expected(holding):
    holding.run(60.0)
    assert holding.seen.wrapped


def test_gravity_grows_stale_and_is_reported():
    bench = bench_with(gravity_timeout=0.5)
    bench.run(1.0, radius=0.02)
    assert bench.seen.gravity_age is None
    bench.control.hear_gravity(bench.now)
    bench.run(0.48, radius=0.02)
    assert bench.seen.gravity_fault.reason is Reason.NONE
    bench.run(0.1, radius=0.02)
    assert bench.seen.gravity_fault.reason is Reason.GRAVITY_STALE
    assert bench.seen.gravity_age == pytest.approx(0.58, abs=2.0 * TICK)
    assert bench.seen.wrapped
    bench.control.forget_gravity()
    bench.tick(radius=0.02)
    assert bench.seen.gravity_fault.reason is Reason.NONE


def test_stale_gravity_vents_if_that_is_the_policy():
    bench = bench_with(gravity_timeout=0.5, gravity_timeout_policy=FaultPolicy.VENT)
    bench.control.hear_gravity(bench.now)
    assert bench.run(1.0, radius=0.02)[-1] == 0.0
    assert (bench.state, bench.reason) == (State.FAULT, Reason.GRAVITY_STALE)


# --- interruptions -----------------------------------------------------------------------------


def interrupt(bench, duration=1.0):
    """Let the node hang, and the regulator's watchdog vent meanwhile."""
    bench.now += duration
    bench.regulator.pressure, bench.regulator.latched = 0.0, True


def test_after_a_watchdogs_vent_a_followed_radius_is_ramped_to_from_nothing(bench):
    limits = replace(LIMITS, radius_timeout=5.0)
    bench.control.reconfigure(limits)
    assert bench.run(2.0, radius=0.02)[-1] == WRAP
    interrupt(bench)
    commands = bench.run(3.0, radius=0.02)
    start = commands.index(0.0)
    assert set(commands[:start]) == {WRAP}
    assert start * TICK < 0.5
    # Long enough that the watchdog hears it, whatever single message is lost.
    assert not any(commands[start : start + round(0.5 / TICK)])
    rises = [after - before for before, after in pairwise(commands[start:])]
    assert max(rises) <= LIMITS.pressure_rate_up * TICK * (1.0 + 1e-9)
    assert commands[-1] == WRAP


def test_after_a_watchdogs_vent_a_goal_has_ended_and_says_why(bench):
    grasp = bench.grasp()
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)
    interrupt(bench)
    assert bench.run(1.0)[-1] == 0.0
    assert (bench.state, bench.reason) == (State.RELEASED, Reason.PRESSURE_LOW)
    assert "vented by itself" in bench.seen.refusal.text
    assert not bench.seen.wrapped


@pytest.mark.parametrize("kind", ["radius", "client", "gravity"])
def test_a_stall_is_no_silence_of_what_has_come_meanwhile(kind):
    limits = {
        "radius": {"radius_timeout_policy": TimeoutPolicy.VENT, "radius_timeout": 0.5},
        "client": {"keep_alive_timeout": 0.5},
        "gravity": {"gravity_timeout": 0.5, "gravity_timeout_policy": FaultPolicy.VENT},
    }[kind]
    bench = bench_with(measured=False, **{"radius_timeout": 600.0} | limits)

    def speak():
        bench.control.offer_radius(bench.now, 0.02, bench.planner)
        bench.control.keep_alive(bench.now)
        bench.control.hear_gravity(bench.now)

    for _ in range(100):
        speak()
        bench.tick()
    for _ in range(3):  # the timer comes first, then what has waited
        bench.now += 1.2
        assert bench.tick() == WRAP
        speak()
    assert bench.run(0.4)[-1] == WRAP
    assert bench.run(0.4)[-1] == 0.0


def test_a_keep_alive_that_is_switched_on_grants_its_first_period(bench):
    bench.end(bench.grasp())
    bench.run(5.0)
    bench.control.reconfigure(replace(LIMITS, keep_alive_timeout=0.5))
    assert set(bench.run(0.4)) == {WRAP}
    assert bench.run(0.4)[-1] == 0.0


def test_gravity_heard_before_an_activation_stays_as_old_as_it_is(bench):
    bench.control.reconfigure(replace(LIMITS, gravity_timeout=2.0))
    bench.control.hear_gravity(bench.now, age=0.5)
    bench.control.deactivate()
    bench.now += 1.0
    bench.control.activate()
    bench.tick()
    assert bench.seen.gravity_age == pytest.approx(1.5, abs=2 * TICK)
    assert bench.seen.gravity_fault.reason is Reason.NONE
    bench.run(1.0)
    assert bench.seen.gravity_fault.reason is Reason.GRAVITY_STALE
