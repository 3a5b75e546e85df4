# SPDX-License-Identifier: Apache-2.0
"""Anything may happen to the control logic, in any order: what must hold whatever happens.

``pytest tests/ros/test_control_machine.py --hypothesis-profile=fuzz`` runs it for long.
"""

import math
from dataclasses import fields, replace
from typing import ClassVar

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)
from ros.control_bench import NOT_CERTIFIED, rows
from ros.fakes import FakePlanner, FakeRegulator, RegulatorFault, regime_at

from spiral_core import InvalidInputError, WrapRegime
from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome
from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import AbortPolicy, FaultPolicy, Limits, TimeoutPolicy
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.control.target import LONGEST_STEP

# Half a second to the pressure of a wrap, so that a run of some ticks ends there.
SANE = Limits(pressure_cap=9.0e4, pressure_rate_up=1.0e5)
GRIPPING = {State.TRACKING, State.HOLDING, State.RAMPING_DOWN, State.GRASPING}
VENTED = {State.INACTIVE, State.WAITING, State.VENTED, State.RELEASED, State.FAULT}
# What is left of a second's digits after a hundred leaps of the inner clock [s].
CLOCK_RESOLUTION = 1.0e-8
# --- the usual, the odd and the impossible --------------------------------------------------
TICKS = st.sampled_from([0, 1, 15, 60])
FLOATS = st.floats()
GOOD_RADII = st.one_of(st.sampled_from([0.02, 0.021, 0.03]), st.floats(0.012, 0.04))
RADII = st.one_of(st.none(), GOOD_RADII, GOOD_RADII, st.floats(0.0, 0.06), FLOATS)
ERRORS = [
    *[None] * 6,
    NOT_CERTIFIED,
    InvalidInputError("radius", 0.0, "another one"),
    ZeroDivisionError("a planner with a bug"),
]
USUAL = {
    "pressure_cap": st.sampled_from([9.0e4, 4.0e4]),
    "radius_timeout": st.sampled_from([0.1, 1.0]),
    "radius_timeout_policy": st.sampled_from(TimeoutPolicy),
    "grasp_timeout": st.sampled_from([10.0, 0.6]),
    "grasp_abort_policy": st.sampled_from(AbortPolicy),
    "pressure_fault_policy": st.sampled_from(FaultPolicy),
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
ODD = {name: st.floats(float(low), float(high)) for name, low, high in map(str.split, rows(ODD))}
LIMITS = st.one_of(st.builds(Limits, **USUAL), st.builds(Limits, **USUAL | ODD))
GOALS = st.builds(
    GraspGoal,
    radius=RADII,
    overpressure=st.one_of(st.none(), st.sampled_from([0.0, 2.0e3]), FLOATS),
    timeout=st.one_of(st.none(), st.none(), st.floats(0.05, 5.0), FLOATS),
    abort_policy=st.sampled_from([None, *AbortPolicy]),
)


class GripMachine(RuleBasedStateMachine):
    """The control logic and a regulator, called as the node does; every command is checked."""

    tally: ClassVar[set] = set()  # of states and ends

    def __init__(self):
        super().__init__()
        self.limits = SANE
        self.control = GripControl(SANE)
        self.planner = FakePlanner()
        self.regulator = FakeRegulator()
        self.eyes = "honest"
        self.now = 0.0
        self.read = 0.0  # what the clock said last
        self.elapsed = LONGEST_STEP  # since the last command, as the control logic may count it
        self.last = 0.0
        self.timeouts = {}  # by grasp
        self.ended = {}  # final reports by grasp
        self.regime = None  # seen last

    @property
    def seen(self):
        return self.control.snapshot()

    def time(self):
        """Return what the clock says, and count the time as the control logic may."""
        self.elapsed += max(self.now - self.read, 0.0)
        self.read = self.now
        return self.now

    def guarded(self, call, *arguments):
        """Call as the node's guards do: an exception that is not expected is a fault."""
        try:
            return call(*arguments)
        except ZeroDivisionError:
            self.control.fail("a planner broke")
            return None

    def command(self):
        """Let it command, and check the command."""
        before, running = self.seen, self.running()
        command = self.control.command(self.time())
        seen, limits = self.seen, self.limits
        step = min(self.elapsed + CLOCK_RESOLUTION, LONGEST_STEP) * (1.0 + 1e-9)
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
        self.last, self.elapsed = command, 0.0

    def is_held(self):
        """Return whether the regime seen last holds the object in use."""
        curls = self.regime is WrapRegime.CURLING and self.seen.overpressure > 0.0
        return curls or self.regime is WrapRegime.PERFECT_WRAP

    def tick(self, period=0.02, radius=None):
        """Let one period of the node's timer pass, and look at how the object is held."""
        self.now += period
        if radius is not None:
            self.guarded(self.control.offer_radius, self.time(), radius, self.planner)
        measured = self.regulator.step(self.last, period)
        if measured is not None:
            self.control.offer_measured(self.time(), measured)
        self.command()
        seen, self.regime = self.seen, self.eyes
        if self.regime == "honest":
            self.regime = seen.plan and regime_at(seen.pressure, seen.plan.pressure)
        self.control.observe(self.time(), self.regime)
        is_heard = seen.pressure_fault.reason is not Reason.PRESSURE_LOST
        assert self.seen.wrapped is (seen.radius is not None and is_heard and self.is_held())

    def running(self):
        return [one for one in self.timeouts if one.report.outcome is GraspOutcome.RUNNING]

    # --- what may happen --------------------------------------------------------------------

    @initialize(limits=LIMITS)
    def starts(self, limits):
        self.parameters_are_set(limits=limits)
        self.control.activate()

    @rule(limits=LIMITS)
    def parameters_are_set(self, limits):
        self.limits = limits
        self.guarded(self.control.reconfigure, limits)

    @rule(
        ticks=st.integers(1, 60),
        period=st.sampled_from([0.0, 0.002, 0.02, 0.02, 0.02, 0.1, 1.0]),
        radius=RADII,
        fault=st.sampled_from([RegulatorFault.NONE] * 6 + list(RegulatorFault)),
        eyes=st.sampled_from(["honest"] * 4 + [None, *WrapRegime]),
    )
    def time_passes(self, ticks, period, radius, fault, eyes):
        self.regulator.fault, self.eyes = fault, eyes
        for _ in range(ticks):
            self.tick(period, radius)

    @rule(policy=st.sampled_from(TimeoutPolicy), end=st.sampled_from(["wrap", "cancel", "silence"]))
    def something_usual_happens(self, policy, end):
        limits = replace(SANE, radius_timeout=0.1, radius_timeout_policy=policy)
        self.parameters_are_set(limits=limits if end == "silence" else SANE)
        self.planner, self.regulator, self.eyes = FakePlanner(), FakeRegulator(), "honest"
        self.guarded(self.control.replan, self.planner)
        self.control.activate()
        if end == "silence":
            for radius in [0.02] * 20 + [None] * 7:
                self.tick(radius=radius)
        else:
            ticks, ends = (120, None) if end == "wrap" else (15, "cancel")
            self.goal_arrives(goal=GraspGoal(radius=0.02), ticks=ticks, end=ends)

    @rule(radius=FLOATS, pressure=st.one_of(st.floats(-2.0e5, 2.0e5), FLOATS), count=TICKS)
    def messages_arrive(self, radius, pressure, count):
        for _ in range(count):
            self.guarded(self.control.offer_radius, self.time(), radius, self.planner)
            self.control.offer_measured(self.time(), pressure)
        self.control.refuse(Refusal(Reason.GRAVITY_INVALID, "gravity must be finite"))

    @rule(
        goal=GOALS,
        ticks=TICKS,
        end=st.sampled_from([None, None, "release", "activate", "deactivate", "fail", "cancel"]),
    )
    def goal_arrives(self, goal, ticks, end):
        before = self.seen
        answer = self.guarded(self.control.start_grasp, self.time(), goal, self.planner)
        seen = self.seen
        if isinstance(answer, Refusal):
            assert answer.reason is not Reason.NONE
            assert answer.text
            assert same(before, seen)
        elif answer is not None:
            given = goal.timeout
            self.timeouts[answer] = self.limits.grasp_timeout if given is None else given
            self.regime = None
            assert (seen.state, seen.refusal.reason) == (State.GRASPING, Reason.NONE)
            assert 0.0 < seen.pressure_target <= self.limits.pressure_cap
            assert not seen.wrapped
        for _ in range(ticks):
            self.tick()
        before, running = self.seen, self.running()
        if end == "cancel":
            for grasp in self.timeouts:
                self.control.cancel(self.time(), grasp)
            assert running or same(before, self.seen)
        elif end is not None:
            getattr(self.control, end)(*["an internal error"] * (end == "fail"))
            assert self.seen.state in VENTED
        assert end is None or not self.running()

    @rule()
    def rearm(self):
        before = self.seen
        refusal = self.control.rearm()
        if refusal is not None or before.state not in (State.RELEASED, State.FAULT):
            assert same(before, self.seen)
        else:
            assert self.seen.state is State.WAITING

    @rule(
        product=st.one_of(st.just(1.0e3), st.floats(8.0e2, 1.2e3), st.floats(-1.0e3, 4.0e3)),
        error=st.sampled_from(ERRORS),
        recommended=st.sampled_from([None, None, 1.0, 1.15]),
        highest_good=st.sampled_from([math.inf, 1.0, 1.1]),
    )
    def gravity_changes(self, product, **answers):
        self.planner = FakePlanner(product)
        vars(self.planner).update(answers)
        self.guarded(self.control.replan, self.planner)

    @rule(leap=st.sampled_from([1.0e-9, 0.5, 60.0, 1.0e6, -1.0e-9, -5.0, -1.0e6]))
    def clock_leaps(self, leap):
        self.now += leap
        self.command()

    # --- what must hold ---------------------------------------------------------------------

    @invariant()
    def what_is_seen_is_finite_vented_or_followed_and_gives_its_reason(self):
        seen = self.seen
        self.tally.add(seen.state)
        values = [getattr(seen, field.name) for field in fields(seen)]
        if seen.measured is not None:
            values += [seen.measured.pressure, seen.measured.age]
            assert seen.measured.age >= 0.0
        assert all(math.isfinite(value) for value in values if isinstance(value, float))
        if seen.state in VENTED:
            assert seen.pressure_command == seen.pressure_target == 0.0
            assert (seen.radius, seen.wrapped) == (None, False)
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
        for grasp in self.timeouts:
            report = grasp.report
            assert self.ended.get(grasp, report) == report
            assert 0.0 <= report.progress <= 1.0
            assert math.isfinite(report.elapsed)
            fails = report.outcome in (GraspOutcome.FAILED, GraspOutcome.CANCELED)
            assert fails is (report.refusal.reason is not Reason.NONE) is bool(report.refusal.text)
            if grasp in running:
                assert self.seen.state is State.GRASPING
            else:
                self.ended[grasp] = report
                self.tally.add(report.outcome)

    def teardown(self):
        """It is always possible to grip again."""
        self.limits, self.planner, self.eyes = SANE, FakePlanner(), "honest"
        self.regulator = FakeRegulator()
        self.guarded(self.control.reconfigure, SANE)
        self.control.replan(self.planner)
        self.control.activate()
        for _ in range(60):
            self.tick(radius=0.02)
        seen = self.seen
        assert (seen.state, seen.pressure_command, seen.wrapped) == (State.TRACKING, 5.0e4, True)


def same(before, after):
    """Return whether two snapshots tell the same, but for the time that has passed."""
    timeless = {"measured": None, "radius_age": None}
    return replace(before, **timeless) == replace(after, **timeless)


@pytest.mark.parametrize(
    "profile",
    [
        {"max_examples": 12, "stateful_step_count": 30},
        pytest.param({}, marks=[pytest.mark.slow, pytest.mark.timeout(3600)]),
    ],
)
def test_whatever_happens_what_must_hold_holds_in_every_state_and_at_every_end(profile):
    GripMachine.tally.clear()
    longest = {"max_examples": max(150, settings().max_examples)}
    run_state_machine_as_test(GripMachine, settings=settings(**longest | profile))
    everything = {*State, *GraspOutcome} - {State.TAKEN_OVER, GraspOutcome.RUNNING}
    missing = {one.name for one in everything - GripMachine.tally}
    assert profile or not missing
