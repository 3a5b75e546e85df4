# SPDX-License-Identifier: Apache-2.0
"""Anything may happen to the control logic, in any order: what must hold whatever happens.

``pytest tests/ros/test_control_machine.py --hypothesis-profile=fuzz`` runs it for long.
"""

import math
from dataclasses import fields, replace

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    rule,
    run_state_machine_as_test,
)
from ros.control_bench import TICK, VALUES, Bench, rows
from ros.fakes import FakePlanner, FakeRegulator, RegulatorFault

from spiral_core import InvalidInputError, WrapRegime
from spiral_gripper_ros.control.grasp import GraspOutcome
from spiral_gripper_ros.control.limits import AbortPolicy, FaultPolicy, Limits
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.control.target import LONGEST_STEP

# Half a second to the pressure of a wrap, so that a run of some ticks ends there.
SANE = Limits(pressure_cap=9.0e4, pressure_rate_up=1.0e5)
GRIPPING = {State.TRACKING, State.HOLDING, State.RAMPING_DOWN, State.GRASPING}
VENTED = {State.INACTIVE, State.WAITING, State.VENTED, State.RELEASED, State.FAULT}
# What is left of a second's digits after a hundred leaps of the inner clock [s].
CLOCK_RESOLUTION = 1.0e-8
# --- the usual, the odd and the impossible --------------------------------------------------
USUAL_COURSES = """
grasp; run 2.4
grasp; run 0.3; cancel
limit grasp_timeout=0.1; grasp; run 0.2
limit radius_timeout=0.1; run 0.4 0.02; run 0.14
limit radius_timeout=0.1 radius_timeout_policy=TimeoutPolicy.VENT; run 0.4 0.02; run 0.14
limit radius_timeout=0.1 radius_timeout_policy=TimeoutPolicy.RAMP_DOWN; run 0.4 0.02; run 0.14
"""
TICKS = st.sampled_from([0, 1, 15, 60])
FLOATS = st.floats()
RADII = st.none() | st.sampled_from([0.02, 0.021, 0.03]) | st.floats(0.0, 0.06) | FLOATS
ERRORS = [VALUES["uncertified"], InvalidInputError("radius", 0.0, "another one")]
USUAL = {
    "radius_timeout": st.sampled_from([0.1, 1.0]),
    "radius_timeout_policy": ...,
    "grasp_timeout": st.sampled_from([10.0, 0.6]),
    "grasp_abort_policy": ...,
    "pressure_fault_policy": ...,
    "grip_ratio": st.sampled_from([None, 1.0, 1.2]),
}
ODD = """
pressure_cap 1e3 2e5
pressure_rate_up 1e2 1e7
pressure_rate_down 1e2 1e7
radius_rate_limit 1e-4 10
radius_jump_limit 1e-5 1
radius_hysteresis 0 0.1
measured_pressure_timeout 0.01 5
pressure_settle_time 0 60
pressure_tolerance 10 1e6
"""
ODD = {
    name: st.just(getattr(SANE, name)) | st.floats(float(low), float(high))
    for name, low, high in map(str.split, rows(ODD))
}
LIMITS = st.builds(Limits, **USUAL | ODD)
GOALS = st.fixed_dictionaries(
    {
        "radius": RADII,
        "overpressure": st.sampled_from([None, 0.0, 2.0e3]) | FLOATS,
        "timeout": st.none() | st.floats(0.05, 5.0) | FLOATS,
        "abort_policy": st.sampled_from([None, *AbortPolicy]),
    }
)
TALLY = set()  # of states and ends


class GripMachine(Bench, RuleBasedStateMachine):
    """The control logic and a regulator, called as the node does; every command is checked."""

    def __init__(self):
        super().__init__(SANE)
        self.timeouts, self.ended = {}, {}  # by grasp, and its final report
        self.read, self.last, self.regime = -math.inf, 0.0, None  # when it was commanded, and what

    def command(self):
        """Let it command, and check the command."""
        before, running = self.seen, self.running()
        command = super().command()
        seen, limits = self.seen, self.limits
        elapsed = max(self.now - self.read, 0.0) + CLOCK_RESOLUTION
        step = min(elapsed, LONGEST_STEP) * (1.0 + 1e-9)
        assert 0.0 <= command <= limits.pressure_cap
        assert command - self.last <= limits.pressure_rate_up * step
        assert command == seen.pressure_command
        if seen.state in GRIPPING:
            lowest = before.pressure_command - limits.pressure_rate_down * step
            assert command >= min(lowest, limits.pressure_cap)
        is_fault = seen.pressure_fault.reason is not Reason.NONE
        for grasp in running:
            report = grasp.report
            if report.outcome is GraspOutcome.RUNNING:
                assert report.elapsed <= self.timeouts[grasp]
                assert not is_fault
            if report.outcome is GraspOutcome.SUCCEEDED:
                assert command == seen.pressure_target
                assert self.is_held()
        if is_fault and limits.pressure_fault_policy is FaultPolicy.VENT:
            assert seen.state in (State.INACTIVE, State.FAULT)
            assert before.state is seen.state or seen.refusal == seen.pressure_fault
        self.read, self.last = self.now, command
        return command

    def is_held(self):
        """Return whether the regime seen last holds the object in use."""
        curls = self.regime is WrapRegime.CURLING and self.seen.overpressure > 0.0
        return curls or self.regime is WrapRegime.PERFECT_WRAP

    def look(self):
        super().look()
        is_heard = self.seen.pressure_fault.reason is not Reason.PRESSURE_LOST
        assert self.seen.wrapped is (self.seen.radius is not None and is_heard and self.is_held())

    def running(self):
        return [one for one in self.timeouts if one.report.outcome is GraspOutcome.RUNNING]

    # --- what may happen --------------------------------------------------------------------

    @rule(limits=LIMITS)
    def parameters_are_set(self, limits):
        self.limits = limits
        self.control.reconfigure(limits)

    @rule(
        ticks=st.integers(1, 60),
        period=st.sampled_from([0.0, 0.002, TICK, 0.1, 1.0]),
        radius=RADII,
        fault=st.sampled_from([RegulatorFault.NONE] * 6 + list(RegulatorFault)),
        sees=st.sampled_from(["honest"] * 4 + [None, *WrapRegime]),
    )
    def time_passes(self, ticks, period, radius, fault, sees):
        self.regulator.fault, self.sees = fault, sees
        for _ in range(ticks):
            self.tick(radius, period)

    @rule(course=st.sampled_from(rows(USUAL_COURSES)))
    def something_usual_happens(self, course):
        self.planner, self.regulator, self.sees = FakePlanner(), FakeRegulator(), "honest"
        self.parameters_are_set(limits=SANE)
        self.control.replan(self.planner)
        self.control.activate()
        self.follow(course)

    @rule(radius=FLOATS, pressure=st.floats(-2.0e5, 2.0e5) | FLOATS, count=TICKS)
    def messages_arrive(self, radius, pressure, count):
        for _ in range(count):
            self.radius(radius)
            self.control.offer_measured(self.now, pressure)
        self.refused()

    def grasp(self, radius=0.02, **goal):
        before = self.seen
        answer = super().grasp(radius, **goal)
        seen = self.seen
        if isinstance(answer, Refusal):
            assert answer.reason is not Reason.NONE
            assert answer.text
            assert same(before, seen)
        else:
            timeout = goal.get("timeout")
            self.timeouts[answer] = self.limits.grasp_timeout if timeout is None else timeout
            assert seen.state is State.GRASPING
            assert seen.refusal.reason is Reason.NONE
            assert 0.0 < seen.pressure_target <= self.limits.pressure_cap
            assert not seen.wrapped

    @rule(
        goal=GOALS,
        ticks=TICKS,
        end=st.sampled_from([None, None, "release", "activate", "deactivate", "fail", "cancel"]),
    )
    def goal_arrives(self, goal, ticks, end):
        self.grasp(**goal)
        for _ in range(ticks):
            self.tick()
        before, running = self.seen, self.running()
        if end == "cancel":
            for grasp in self.timeouts:
                self.control.cancel(self.now, grasp)
            assert running or same(before, self.seen)
        elif end is not None:
            self.call(end, *["an internal error"] * (end == "fail"))
            assert self.seen.state in VENTED
        assert end is None or not self.running()

    @rule()
    def rearm(self):
        self.control.rearm()

    @rule(
        product=st.just(1.0e3) | st.floats(8.0e2, 1.2e3) | st.floats(-1.0e3, 4.0e3),
        error=st.sampled_from([*[None] * 6, *ERRORS]),
        recommended=st.sampled_from([None, None, 1.0, 1.15]),
        highest_good=st.sampled_from([math.inf, 1.0, 1.1]),
    )
    def gravity_changes(self, product, **answers):
        self.planner = FakePlanner(product)
        self.gravity(**answers)

    @rule(leap=st.sampled_from([1.0e-9, 0.5, 60.0, 1.0e6, -1.0e-9, -5.0, -1.0e6]))
    def clock_leaps(self, leap):
        self.now += leap
        self.command()

    # --- what must hold ---------------------------------------------------------------------

    @invariant()
    def what_is_seen_is_finite_vented_or_followed_and_gives_its_reason(self):
        seen = self.seen
        TALLY.add(seen.state)
        values = [getattr(seen, field.name) for field in fields(seen)]
        assert (seen.measured_age or 0.0) >= 0.0
        assert all(math.isfinite(value) for value in values if isinstance(value, float))
        if seen.state in VENTED:
            assert seen.pressure_command == seen.pressure_target == 0.0
            assert seen.radius is None
            assert not seen.wrapped
        followed = seen.refusal.reason is Reason.NONE
        assert followed is (seen.refusal.text == "")
        if seen.state is not State.GRASPING:
            assert followed is (seen.state is State.TRACKING)
        if followed:
            assert seen.plan.pressure <= seen.pressure_target <= self.limits.pressure_cap

    @invariant()
    def reports_are_final_once_they_are(self):
        running = self.running()
        assert len(running) <= 1
        assert not running or self.seen.state is State.GRASPING
        for grasp in self.timeouts:
            report = grasp.report
            assert self.ended.get(grasp, report) == report
            assert 0.0 <= report.progress <= 1.0
            assert math.isfinite(report.elapsed)
            fails = report.outcome in (GraspOutcome.FAILED, GraspOutcome.CANCELED)
            assert fails is (report.refusal.reason is not Reason.NONE) is bool(report.refusal.text)
            if grasp not in running:
                self.ended[grasp] = report
                TALLY.add(report.outcome)

    def teardown(self):
        """It is always possible to grip again."""
        self.something_usual_happens(course="run 1.2 0.02")
        seen = self.seen
        assert seen.state is State.TRACKING
        assert seen.pressure_command == 5.0e4
        assert seen.wrapped


def same(before, after):
    """Return whether two snapshots tell the same, but for the time that has passed."""
    timeless = {"measured_pressure": None, "measured_age": None}
    return replace(before, **timeless) == replace(after, **timeless)


def test_whatever_happens_what_must_hold_holds_in_every_state_and_at_every_end():
    TALLY.clear()
    fewer = settings(max_examples=settings().max_examples * 3 // 5)
    run_state_machine_as_test(GripMachine, settings=fewer)
    assert {*State, *GraspOutcome} - TALLY == {State.TAKEN_OVER, GraspOutcome.RUNNING}
