# SPDX-License-Identifier: Apache-2.0
"""Anything may happen to the control logic, in any order: what must hold whatever happens.

``pytest tests/ros/test_control_machine.py --hypothesis-profile=fuzz`` runs it for long.
"""

import math
import sys
from dataclasses import fields, replace

import pytest
from hypothesis import event, settings
from hypothesis import strategies as st
from hypothesis.stateful import initialize, invariant, rule, run_state_machine_as_test
from ros.checked_control import SANE, CheckedControl, ImmutablePlanner
from ros.control_inputs import (
    ANY_GOALS,
    EYES,
    GOOD_GOALS,
    GOOD_RADIUS,
    LEAPS,
    LIMITS,
    PERIODS,
    PLANNER_ERRORS,
    PRESSURE,
    RADIUS,
    USUAL_LIMITS,
    VENTS,
)
from ros.fakes import FakeRegulator, RegulatorFault

from spiral_gripper_ros.control.grasp import GraspOutcome
from spiral_gripper_ros.control.limits import FaultPolicy, TimeoutPolicy
from spiral_gripper_ros.control.states import Reason, Refusal, State

VENTED = {State.INACTIVE, State.WAITING, State.VENTED, State.RELEASED, State.FAULT}
ENDS = set(GraspOutcome) - {GraspOutcome.RUNNING}
WHERE_LOST = {
    TimeoutPolicy.HOLD: State.HOLDING,
    TimeoutPolicy.RAMP_DOWN: State.RAMPING_DOWN,
    TimeoutPolicy.VENT: State.VENTED,
}
# Of the control logic, but for what test_control_grip.py tests; the first belongs to a service.
REASONS = set(Reason) - {
    Reason.OBJECT_TOO_SHORT,
    Reason.GRAVITY_STALE,
    Reason.CLIENT_LOST,
    Reason.TAKEN_OVER,
}


class GripMachine(CheckedControl):
    """What may happen, and what must hold after each of it."""

    @rule(
        ticks=st.integers(1, 60), period=PERIODS, radius=st.one_of(st.none(), GOOD_RADIUS, RADIUS)
    )
    def time_passes(self, ticks, period, radius):
        for _ in range(ticks):
            self.tick(period, radius)

    @rule(eyes=EYES, goal=GOOD_GOALS)
    def goal_arrives_but_the_shape_is_another(self, eyes, goal):
        self.eyes = eyes
        self.goal_arrives(goal=goal, ticks=60)
        self.eyes = "honest"

    @rule(ticks=st.integers(10, 100), radius=st.one_of(st.none(), GOOD_RADIUS))
    def all_goes_well(self, ticks, radius):
        self.regulator.fault, self.eyes = RegulatorFault.NONE, "honest"
        for _ in range(ticks):
            self.tick(0.02, radius)

    @rule(radius=GOOD_RADIUS, policy=st.sampled_from(TimeoutPolicy))
    def object_is_lost(self, radius, policy):
        """Radii come for a while, and then no more."""
        self.parameters_are_set(
            limits=replace(SANE, radius_timeout=0.1, radius_timeout_policy=policy)
        )
        self.gravity_changes(product=1.0e3, error=None, contact=(None, math.inf))
        self.all_goes_well(ticks=30, radius=radius)
        before = self.control.snapshot()
        for _ in range(10):
            self.tick(0.02, None)
        if before.state is State.TRACKING:
            assert self.control.snapshot().state is WHERE_LOST[policy]

    @rule(radius=RADIUS)
    def radius_arrives(self, radius):
        self.guarded(self.control.offer_radius, self.time(), radius, self.planner)

    @rule(pressure=PRESSURE, count=st.integers(1, 30))
    def pressures_arrive(self, pressure, count):
        for _ in range(count):
            self.control.offer_measured(self.time(), pressure)

    @rule(fault=st.sampled_from(RegulatorFault), ticks=st.integers(1, 60), mended=st.booleans())
    def regulator_breaks(self, fault, ticks, mended):
        self.regulator.fault = fault
        for _ in range(ticks):
            self.tick(0.02, None)
        if mended:
            self.regulator.fault = RegulatorFault.NONE

    @rule(pressure=st.floats(0.0, 2.0e5))
    def pressure_is_pushed(self, pressure):
        self.regulator.pressure = pressure

    @rule(eyes=EYES, ticks=st.sampled_from([1, 15, 60]), mended=st.booleans())
    def shape_is_seen_otherwise(self, eyes, ticks, mended):
        self.eyes = eyes
        for _ in range(ticks):
            self.tick(0.02, None)
        if mended:
            self.eyes = "honest"

    @rule(goal=st.one_of(GOOD_GOALS, ANY_GOALS), ticks=st.sampled_from([0, 1, 15, 60]))
    def goal_arrives(self, goal, ticks):
        before = self.control.snapshot()
        answer = self.guarded(self.control.start_grasp, self.time(), goal, self.planner)
        if isinstance(answer, Refusal):
            assert answer.reason is not Reason.NONE
            assert answer.text
            assert same(before, self.control.snapshot())
            self.tally[f"reason {answer.reason.name}"] += 1
        elif answer is not None:
            assert answer not in self.timeouts
            given = goal.timeout
            self.timeouts[answer] = self.limits.grasp_timeout if given is None else given
            self.overpressure, self.regime = goal.overpressure, None
            self.ceiling = self.limits.pressure_cap
            seen = self.control.snapshot()
            assert (seen.state, seen.refusal.reason) == (State.GRASPING, Reason.NONE)
            assert seen.radius == (before.radius if goal.radius is None else goal.radius)
            assert 0.0 < seen.pressure_target <= self.limits.pressure_cap
            assert not seen.wrapped
            assert before.state not in (State.INACTIVE, State.FAULT)
            assert before.pressure_fault.reason is Reason.NONE
        for _ in range(ticks):
            self.tick(0.02, None)

    @rule(back=st.sampled_from([0, 0, 1, 9]))
    def goal_is_canceled(self, back):
        known = [*self.timeouts]
        grasp = known[-1 - back] if back < len(known) else None
        was_running = grasp in self.running() and self.is_running(grasp)
        before = self.control.snapshot()
        if grasp is not None:
            self.control.cancel(self.time(), grasp)
        if was_running:
            assert self.outcome(grasp) is GraspOutcome.CANCELED
        else:
            assert same(before, self.control.snapshot())

    @rule(event=st.sampled_from(VENTS), rare=st.sampled_from([False, False, True]))
    def vents(self, event, rare):
        if not rare:
            return
        before = self.control.snapshot()
        if event == "fail":
            self.control.fail("an internal error")
        else:
            getattr(self.control, event)()
        seen = self.control.snapshot()
        assert seen.state in VENTED
        assert seen.pressure_command == 0.0
        assert not [grasp for grasp in self.running() if self.is_running(grasp)]
        stays = before.state is State.INACTIVE or (
            before.state is State.FAULT and event == "release"
        )
        if event == "activate":
            assert seen.state is State.WAITING
            assert seen.measured is None
            assert seen.pressure_fault.reason is Reason.NONE
        elif stays:
            assert seen.state is before.state

    @rule(goal=GOOD_GOALS, ticks=st.integers(0, 15), event=st.sampled_from(VENTS))
    def goal_arrives_and_something_vents(self, goal, ticks, event):
        self.goal_arrives(goal=goal, ticks=ticks)
        self.vents(event=event, rare=True)

    @rule(goal=GOOD_GOALS, ticks=st.integers(0, 30))
    def goal_arrives_and_is_canceled(self, goal, ticks):
        self.goal_arrives(goal=goal, ticks=ticks)
        self.goal_is_canceled(back=0)

    @rule()
    def rearm(self):
        before = self.control.snapshot()
        refusal = self.control.rearm()
        if refusal is not None or before.state not in (State.RELEASED, State.FAULT):
            assert same(before, self.control.snapshot())
        else:
            assert self.control.snapshot().state is State.WAITING
        vents = self.limits.pressure_fault_policy is FaultPolicy.VENT
        is_fault = before.pressure_fault.reason is not Reason.NONE
        stays = before.state is State.FAULT and vents and is_fault
        not_now = before.state in (State.INACTIVE, State.GRASPING)
        assert (refusal is not None) is (stays or not_now)

    @rule(
        product=st.one_of(st.just(1.0e3), st.floats(8.0e2, 1.2e3), st.floats(-1.0e3, 4.0e3)),
        error=st.sampled_from(PLANNER_ERRORS),
        contact=st.sampled_from([(None, math.inf)] * 2 + [(1.05, 1.1), (1.15, 1.3), (1.0, 1.0)]),
    )
    def gravity_changes(self, product, error, contact):
        self.planner = ImmutablePlanner(product, error, *contact)
        self.guarded(self.control.replan, self.planner)

    @rule()
    def gravity_is_bad(self):
        self.control.refuse(Refusal(Reason.GRAVITY_INVALID, "gravity must be finite"))

    @initialize(limits=USUAL_LIMITS)
    def starts(self, limits):
        self.limits = limits
        self.control.reconfigure(limits)
        self.control.activate()

    @rule(limits=st.one_of(USUAL_LIMITS, USUAL_LIMITS, LIMITS))
    def parameters_are_set(self, limits):
        self.limits, self.ceiling = limits, min(self.ceiling, limits.pressure_cap)
        self.guarded(self.control.reconfigure, limits)

    @rule(leap=LEAPS, comes_back=st.booleans())
    def clock_leaps(self, leap, comes_back):
        before = self.now
        leapt = before + leap
        if not math.isfinite(leapt):
            return
        self.now = leapt
        self.command()
        if comes_back or abs(self.now) > 1.0e9:
            self.now = before
            self.command()

    # --- what must hold ---------------------------------------------------------------------

    @invariant()
    def numbers_are_finite(self):
        seen = self.control.snapshot()
        for field in fields(seen):
            value = getattr(seen, field.name)
            if isinstance(value, float):
                assert math.isfinite(value), field.name
        if seen.measured is not None:
            assert math.isfinite(seen.measured.pressure)
            assert math.isfinite(seen.measured.age)
            assert seen.measured.age >= 0.0

    @invariant()
    def what_does_not_grip_is_vented(self):
        seen = self.control.snapshot()
        self.visited.add(seen.state)
        self.tally["steps"] += 1
        self.tally[f"state {seen.state.name}"] += 1
        self.tally[f"reason {seen.refusal.reason.name}"] += 1
        self.tally[f"fault {seen.pressure_fault.reason.name}"] += 1
        for reason in seen.refused:
            self.tally[f"reason {reason.name}"] += 1
        if seen.state in VENTED:
            assert seen.pressure_command == seen.pressure_target == 0.0
            assert seen.radius is None
            assert not seen.wrapped

    @invariant()
    def a_reason_is_given_unless_it_is_followed(self):
        seen = self.control.snapshot()
        followed = seen.refusal.reason is Reason.NONE
        assert followed is (seen.refusal.text == "")
        if seen.state is State.GRASPING:
            assert followed is (not self.was_aborted() and self.is_possible(seen))
        else:
            assert followed is (seen.state is State.TRACKING)
            if followed:
                wrap = seen.plan.pressure
                assert wrap <= seen.pressure_target <= max(wrap, self.highest(wrap))
                assert seen.pressure_target <= self.limits.pressure_cap

    @invariant()
    def reports_are_final_once_they_are(self):
        running = 0
        for grasp in self.timeouts:
            report = grasp.report
            if grasp in self.ended:
                assert report == self.ended[grasp]
                continue
            assert 0.0 <= report.progress <= 1.0
            assert math.isfinite(report.elapsed)
            if report.outcome is GraspOutcome.RUNNING:
                running += 1
                assert report.refusal.reason is Reason.NONE
                assert self.control.snapshot().state is State.GRASPING
                continue
            self.note_end(report)
            self.ended[grasp] = report
        assert running <= 1

    def teardown(self):
        """It is always possible to grip again."""
        for state in self.visited:
            event(f"state {state.name}")
        self.limits, self.planner, self.eyes = SANE, ImmutablePlanner(), "honest"
        self.regulator = FakeRegulator()
        self.guarded(self.control.reconfigure, SANE)
        self.control.replan(self.planner)
        self.control.activate()
        for _ in range(60):
            self.tick(0.02, 0.02)
        seen = self.control.snapshot()
        assert (seen.state, seen.refusal.reason) == (State.TRACKING, Reason.NONE)
        assert seen.pressure_command == 5.0e4
        assert seen.wrapped


def same(before, after):
    """Return whether two snapshots tell the same, but for the time that has passed."""
    return replace(before, measured=None, radius_age=None) == replace(
        after, measured=None, radius_age=None
    )


def run(**profile):
    """Run the machine and return what has happened how often since the tally was cleared."""
    run_state_machine_as_test(GripMachine, settings=settings(deadline=None, **profile))
    return GripMachine.tally


def test_whatever_happens_for_a_while_what_must_hold_holds():
    run(max_examples=12, stateful_step_count=30)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_whatever_happens_what_must_hold_holds_and_it_can_grip_again(capsys):
    GripMachine.tally.clear()
    tally = run()
    if settings.get_current_profile_name() == "fuzz":
        assert tally["steps"] >= 100_000
        assert not [reason for reason in REASONS if not tally[f"reason {reason.name}"]]
        lines = [f"{count:9} {what}" for what, count in sorted(tally.items())]
        with capsys.disabled():
            sys.stdout.write("\n" + "\n".join(lines) + "\n")


@pytest.mark.slow
def test_the_machine_reaches_every_state_and_every_end_of_a_grasp():
    wanted = {f"state {state.name}" for state in set(State) - {State.TAKEN_OVER}} | {
        f"outcome {end.name}" for end in ENDS
    }
    GripMachine.tally.clear()
    tally = run(database=None, max_examples=150, stateful_step_count=50)
    assert not sorted(what for what in wanted if not tally[what])
