# SPDX-License-Identifier: Apache-2.0
"""Anything may happen to the control logic, in any order: what must hold whatever happens.

``pytest tests/ros/test_control_machine.py --hypothesis-profile=fuzz`` runs it for long.
"""

import math
from dataclasses import fields, replace

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import initialize, invariant, rule, run_state_machine_as_test
from ros.checked_control import SANE, CheckedControl, ImmutablePlanner
from ros.fakes import FakeRegulator, RegulatorFault

from spiral_core import InvalidInputError, SolverError, WrapRegime
from spiral_core.rod.state import RodStatus
from spiral_gripper_ros.control.grasp import GraspGoal, GraspOutcome
from spiral_gripper_ros.control.limits import AbortPolicy, FaultPolicy, Limits, TimeoutPolicy
from spiral_gripper_ros.control.states import Reason, Refusal, State

VENTED = {State.INACTIVE, State.WAITING, State.VENTED, State.RELEASED, State.FAULT}
WHERE_LOST = {
    TimeoutPolicy.HOLD: State.HOLDING,
    TimeoutPolicy.RAMP_DOWN: State.RAMPING_DOWN,
    TimeoutPolicy.VENT: State.VENTED,
}
ENDS = ["release", "activate", "deactivate", "fail", "cancel"]
# --- the usual, the odd and the impossible --------------------------------------------------
TICKS = st.sampled_from([0, 1, 15, 60])
FLOATS = st.floats()
GOOD_RADII = st.one_of(st.sampled_from([0.02, 0.021, 0.03]), st.floats(0.012, 0.04))
RADII = st.one_of(st.none(), GOOD_RADII, GOOD_RADII, st.floats(0.0, 0.06), FLOATS)
EYES = st.sampled_from(["honest", "honest", None, *WrapRegime])
ERRORS = (
    *[None] * 6,
    SolverError(RodStatus.UNSTABLE, 1.0, 7),
    InvalidInputError("radius", 0.0, "another one"),
    ZeroDivisionError("a planner with a bug"),
)
LEAPS = st.one_of(st.sampled_from([1.0e-9, 0.5, 60.0, 1.0e6, -1.0e-9, -5.0, -1.0e6]), FLOATS)


def limits(**odd):
    usual = {
        "pressure_cap": st.sampled_from([9.0e4, 4.0e4]),
        "radius_timeout": st.sampled_from([0.1, 1.0]),
        "radius_timeout_policy": st.sampled_from(TimeoutPolicy),
        "grasp_timeout": st.sampled_from([10.0, 0.6]),
        "grasp_abort_policy": st.sampled_from(AbortPolicy),
        "pressure_fault_policy": st.sampled_from(FaultPolicy),
        "grip_ratio": st.sampled_from([None, 1.0, 1.2]),
    }
    return st.builds(Limits, **usual | odd)


def goals(radius, overpressure, timeout):
    return st.builds(
        GraspGoal,
        radius=st.one_of(st.none(), radius),
        overpressure=st.one_of(st.none(), overpressure),
        timeout=st.one_of(st.none(), timeout),
        abort_policy=st.sampled_from([None, *AbortPolicy]),
    )


ANY_LIMITS = limits(
    pressure_cap=st.floats(1.0e3, 2.0e5),
    pressure_rate_up=st.floats(1.0e2, 1.0e7),
    pressure_rate_down=st.floats(1.0e2, 1.0e7),
    radius_timeout=st.floats(0.01, 5.0),
    radius_rate_limit=st.floats(1.0e-4, 10.0),
    radius_jump_limit=st.floats(1.0e-5, 1.0),
    radius_hysteresis=st.floats(0.0, 0.1),
    grasp_timeout=st.floats(0.1, 10.0),
    measured_pressure_timeout=st.floats(0.01, 5.0),
    pressure_settle_time=st.one_of(st.floats(0.0, 1.0), st.floats(0.0, 60.0)),
    pressure_tolerance=st.one_of(st.just(1.0e3), st.floats(10.0, 1.0e6)),
)
ANY_GOALS = st.one_of(
    goals(GOOD_RADII, st.sampled_from([0.0, 2.0e3]), st.nothing()),
    goals(RADII, st.one_of(st.floats(0.0, 2.0e4), FLOATS), st.one_of(st.floats(0.05, 5.0), FLOATS)),
)


class GripMachine(CheckedControl):
    """What may happen, and what must hold after each of it."""

    @initialize(limits=limits())
    def starts(self, limits):
        self.parameters_are_set(limits=limits)
        self.control.activate()

    @rule(limits=st.one_of(limits(), limits(), ANY_LIMITS))
    def parameters_are_set(self, limits):
        self.limits, self.ceiling = limits, min(self.ceiling, limits.pressure_cap)
        self.guarded(self.control.reconfigure, limits)

    @rule(
        ticks=st.integers(1, 60),
        period=st.sampled_from([0.0, 0.002, 0.02, 0.02, 0.1, 1.0]),
        radius=RADII,
        goes_well=st.booleans(),
    )
    def time_passes(self, ticks, period, radius, goes_well):
        if goes_well:
            self.regulator.fault, self.eyes, period = RegulatorFault.NONE, "honest", 0.02
        for _ in range(ticks):
            self.tick(period, radius)

    @rule(radius=GOOD_RADII, policy=st.sampled_from(TimeoutPolicy))
    def object_is_lost(self, radius, policy):
        """Radii come for a while, and then no more."""
        lost = replace(SANE, radius_timeout=0.1, radius_timeout_policy=policy)
        self.parameters_are_set(limits=lost)
        self.gravity_changes(product=1.0e3, error=None, contact=(None, math.inf))
        self.time_passes(ticks=30, period=0.02, radius=radius, goes_well=True)
        before = self.control.snapshot()
        self.time_passes(ticks=10, period=0.02, radius=None, goes_well=True)
        if before.state is State.TRACKING:
            assert self.control.snapshot().state is WHERE_LOST[policy]

    @rule(radius=FLOATS, pressure=st.one_of(st.floats(-2.0e5, 2.0e5), FLOATS), count=TICKS)
    def messages_arrive(self, radius, pressure, count):
        for _ in range(count):
            self.guarded(self.control.offer_radius, self.time(), radius, self.planner)
            self.control.offer_measured(self.time(), pressure)

    @rule(fault=st.sampled_from(RegulatorFault), eyes=EYES, pushed=st.floats(0.0, 2.0e5))
    def something_breaks(self, fault, eyes, pushed):
        self.regulator.fault, self.eyes = fault, eyes
        if eyes is None:
            self.regulator.pressure = pushed

    @rule(goal=ANY_GOALS, ticks=TICKS, end=st.sampled_from([None, None, *ENDS]))
    def goal_arrives(self, goal, ticks, end):
        before = self.control.snapshot()
        answer = self.guarded(self.control.start_grasp, self.time(), goal, self.planner)
        seen = self.control.snapshot()
        if isinstance(answer, Refusal):
            assert answer.reason is not Reason.NONE
            assert answer.text
            assert same(before, seen)
        elif answer is not None:
            assert answer not in self.timeouts
            given = goal.timeout
            self.timeouts[answer] = self.limits.grasp_timeout if given is None else given
            self.overpressure, self.regime = goal.overpressure, None
            self.ceiling = self.limits.pressure_cap
            assert (seen.state, seen.refusal.reason) == (State.GRASPING, Reason.NONE)
            assert seen.radius == (before.radius if goal.radius is None else goal.radius)
            assert 0.0 < seen.pressure_target <= self.limits.pressure_cap
            assert not seen.wrapped
            assert before.state not in (State.INACTIVE, State.FAULT)
            assert before.pressure_fault.reason is Reason.NONE
        for _ in range(ticks):
            self.tick()
        if end == "cancel":
            self.goal_is_canceled(back=0)
        elif end is not None:
            self.something_vents(event=end)

    @rule(back=st.sampled_from([0, 1, 9]))
    def goal_is_canceled(self, back):
        before, running = self.control.snapshot(), self.running()
        for grasp in [*self.timeouts][-1 - back :][:1]:
            self.control.cancel(self.time(), grasp)
            if grasp in running:
                assert grasp.report.outcome is GraspOutcome.CANCELED
            else:
                assert same(before, self.control.snapshot())

    def something_vents(self, event):
        before = self.control.snapshot()
        getattr(self.control, event)(*["an internal error"] * (event == "fail"))
        seen = self.control.snapshot()
        assert seen.state in VENTED
        assert not self.running()
        if event == "activate":
            assert (seen.state, seen.measured) == (State.WAITING, None)
            assert seen.pressure_fault.reason is Reason.NONE
        elif before.state is State.INACTIVE or (event, before.state) == ("release", State.FAULT):
            assert seen.state is before.state

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
        error=st.sampled_from(ERRORS),
        contact=st.sampled_from([(None, math.inf)] * 2 + [(1.05, 1.1), (1.15, 1.3), (1.0, 1.0)]),
    )
    def gravity_changes(self, product, error, contact):
        self.planner = ImmutablePlanner(product, error, *contact)
        self.guarded(self.control.replan, self.planner)

    @rule()
    def gravity_is_bad(self):
        self.control.refuse(Refusal(Reason.GRAVITY_INVALID, "gravity must be finite"))

    @rule(leap=LEAPS, comes_back=st.booleans())
    def clock_leaps(self, leap, comes_back):
        before = self.now
        if not math.isfinite(before + leap):
            return
        self.now += leap
        self.command()
        if comes_back or abs(self.now) > 1.0e9:
            self.now = before
            self.command()

    # --- what must hold ---------------------------------------------------------------------

    @invariant()
    def numbers_are_finite(self):
        seen = self.control.snapshot()
        values = [getattr(seen, field.name) for field in fields(seen)]
        if seen.measured is not None:
            values += [seen.measured.pressure, seen.measured.age]
            assert seen.measured.age >= 0.0
        assert all(math.isfinite(value) for value in values if isinstance(value, float))

    @invariant()
    def what_does_not_grip_is_vented(self):
        seen = self.control.snapshot()
        self.tally[seen.state] += 1
        if seen.state in VENTED:
            assert seen.pressure_command == seen.pressure_target == 0.0
            assert (seen.radius, seen.wrapped) == (None, False)

    @invariant()
    def a_reason_is_given_unless_it_is_followed(self):
        seen = self.control.snapshot()
        followed = seen.refusal.reason is Reason.NONE
        assert followed is (seen.refusal.text == "")
        if seen.state is State.GRASPING:
            newest = next(reversed(self.timeouts)).report.outcome
            was_aborted = newest in (GraspOutcome.FAILED, GraspOutcome.CANCELED)
            assert followed is (not was_aborted and self.is_possible(seen))
        else:
            assert followed is (seen.state is State.TRACKING)
            if followed:
                wrap = seen.plan.pressure
                assert wrap <= seen.pressure_target <= max(wrap, self.highest(wrap))
                assert seen.pressure_target <= self.limits.pressure_cap

    @invariant()
    def reports_are_final_once_they_are(self):
        running = self.running()
        assert len(running) <= 1
        for grasp in self.timeouts:
            report = grasp.report
            assert self.ended.get(grasp, report) == report
            assert 0.0 <= report.progress <= 1.0
            assert math.isfinite(report.elapsed)
            if grasp in running:
                assert report.refusal.reason is Reason.NONE
                assert self.control.snapshot().state is State.GRASPING
            else:
                self.ended[grasp] = report
                self.tally[report.outcome] += 1
                succeeded = report.outcome is GraspOutcome.SUCCEEDED
                assert succeeded is (report.refusal.reason is Reason.NONE)
                assert succeeded is (report.refusal.text == "")
                assert not succeeded or report.progress == 1.0

    def teardown(self):
        """It is always possible to grip again."""
        self.limits, self.planner, self.eyes = SANE, ImmutablePlanner(), "honest"
        self.regulator = FakeRegulator()
        self.guarded(self.control.reconfigure, SANE)
        self.control.replan(self.planner)
        self.control.activate()
        for _ in range(60):
            self.tick(radius=0.02)
        seen = self.control.snapshot()
        assert (seen.state, seen.refusal.reason) == (State.TRACKING, Reason.NONE)
        assert (seen.pressure_command, seen.wrapped) == (5.0e4, True)


def same(before, after):
    """Return whether two snapshots tell the same, but for the time that has passed."""
    timeless = {"measured": None, "radius_age": None}
    return replace(before, **timeless) == replace(after, **timeless)


def run(**profile):
    run_state_machine_as_test(GripMachine, settings=settings(deadline=None, **profile))


def test_whatever_happens_for_a_while_what_must_hold_holds():
    run(max_examples=12, stateful_step_count=30)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_whatever_happens_what_must_hold_holds_in_every_state_and_at_every_end():
    GripMachine.tally.clear()
    run(max_examples=max(150, settings().max_examples))
    everything = {*State, *GraspOutcome} - {State.TAKEN_OVER, GraspOutcome.RUNNING}
    assert not everything - set(GripMachine.tally)
