# SPDX-License-Identifier: Apache-2.0
import itertools
import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ros.fakes import FakePlanner

from spiral_core import InvalidInputError, SolverError
from spiral_core.rod.state import RodStatus
from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import Limits, TimeoutPolicy
from spiral_gripper_ros.control.pressure_ramp import LONGEST_STEP
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.control.timing import LONGEST_LEAP, MonotonicClock

LIMITS = Limits(
    pressure_cap=9.0e4,
    pressure_rate_up=1.0e5,
    pressure_rate_down=2.0e5,
    radius_timeout=0.5,
    radius_rate_limit=0.05,
    radius_jump_limit=0.002,
    radius_hysteresis=0.0005,
)
TICK = 0.02


class Bench:
    """A state machine, its planner and a clock that the test winds."""

    def __init__(self, limits=LIMITS):
        self.machine = GripControl(limits)
        self.planner = FakePlanner()
        self.now = 100.0
        self.machine.activate()

    def radius(self, radius):
        return self.machine.offer_radius(self.now, radius, self.planner)

    def run(self, duration, radius=None):
        """Tick for a while, with a radius before every tick if given; return the commands."""
        commands = []
        for _ in range(round(duration / TICK)):
            self.now += TICK
            if radius is not None:
                self.radius(radius)
            commands.append(self.machine.command(self.now))
        return commands

    @property
    def state(self):
        return self.machine.snapshot().state

    @property
    def reason(self):
        return self.machine.snapshot().refusal.reason


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture
def gripping(bench):
    """A bench that holds a 20 mm object at its wrap pressure of 50 kPa."""
    commands = bench.run(1.0, radius=0.02)
    assert commands[-1] == 5.0e4
    return bench


def test_inactive_until_activated():
    machine = GripControl(LIMITS)
    planner = FakePlanner()
    assert not machine.offer_radius(0.0, 0.02, planner)
    assert machine.command(1.0) == 0.0
    assert machine.snapshot().state is State.INACTIVE
    assert machine.snapshot().refusal.reason is Reason.NOT_ACTIVE
    assert planner.asked == []


def test_active_without_a_radius_it_waits_vented(bench):
    assert set(bench.run(2.0)) == {0.0}
    assert (bench.state, bench.reason) == (State.WAITING, Reason.NO_RADIUS)


def test_a_good_radius_is_followed_at_the_rate_limit_and_reached_exactly(bench):
    bench.radius(0.02)
    commands = [0.0, *bench.run(0.48), *bench.run(0.1, radius=0.02)]
    steps = [b - a for a, b in itertools.pairwise(commands)]
    assert max(steps) <= LIMITS.pressure_rate_up * TICK * (1 + 1e-9)
    assert commands[-1] == 5.0e4
    assert (bench.state, bench.reason) == (State.TRACKING, Reason.NONE)


def test_a_larger_object_lowers_the_pressure_at_the_rate_down(gripping):
    gripping.radius(0.0215)
    first = gripping.run(TICK)[0]
    assert first == pytest.approx(max(1e3 / 0.0215, 5.0e4 - LIMITS.pressure_rate_down * TICK))


@pytest.mark.parametrize(
    ("radius", "reason"),
    [
        (math.nan, Reason.RADIUS_NOT_FINITE),
        (math.inf, Reason.RADIUS_NOT_FINITE),
        (-math.inf, Reason.RADIUS_NOT_FINITE),
        (0.0, Reason.RADIUS_NOT_POSITIVE),
        (-0.02, Reason.RADIUS_NOT_POSITIVE),
        (0.002, Reason.RADIUS_TOO_SMALL),
        (0.2, Reason.RADIUS_TOO_LARGE),
        (0.03, Reason.RADIUS_JUMP),
    ],
)
def test_a_bad_radius_is_refused_and_the_command_does_not_follow(gripping, radius, reason):
    assert gripping.radius(radius)
    assert (gripping.state, gripping.reason) == (State.HOLDING, reason)
    assert set(gripping.run(0.3)) == {5.0e4}
    snapshot = gripping.machine.snapshot()
    assert snapshot.refused[reason] == 1
    assert snapshot.radius == 0.02


def test_after_a_bad_radius_a_good_one_is_followed_again(gripping):
    gripping.radius(math.nan)
    gripping.radius(0.0201)
    assert (gripping.state, gripping.reason) == (State.TRACKING, Reason.NONE)


def test_a_bad_first_radius_leaves_it_waiting(bench):
    bench.radius(math.nan)
    assert set(bench.run(1.0)) == {0.0}
    assert (bench.state, bench.reason) == (State.WAITING, Reason.RADIUS_NOT_FINITE)


def test_hold_policy_keeps_the_pressure_when_the_stream_stops(gripping):
    assert set(gripping.run(3.0)) == {5.0e4}
    assert (gripping.state, gripping.reason) == (State.HOLDING, Reason.RADIUS_STALE)
    assert gripping.machine.snapshot().refused[Reason.RADIUS_STALE] == 1


def test_vent_policy_vents_at_once():
    bench = Bench(replace(LIMITS, radius_timeout_policy=TimeoutPolicy.VENT))
    bench.run(1.0, radius=0.02)
    commands = bench.run(1.0)
    assert set(commands) == {5.0e4, 0.0}
    assert commands.index(0.0) == round(LIMITS.radius_timeout / TICK)
    assert (bench.state, bench.reason) == (State.VENTED, Reason.RADIUS_STALE)


def test_ramp_down_policy_goes_down_at_the_rate():
    bench = Bench(replace(LIMITS, radius_timeout_policy=TimeoutPolicy.RAMP_DOWN))
    bench.run(1.0, radius=0.02)
    bench.run(LIMITS.radius_timeout)
    commands = bench.run(0.1)
    assert bench.state is State.RAMPING_DOWN
    steps = {round(a - b, 6) for a, b in itertools.pairwise(commands)}
    assert steps == {LIMITS.pressure_rate_down * TICK}
    assert bench.run(1.0)[-1] == 0.0
    assert (bench.state, bench.reason) == (State.VENTED, Reason.RADIUS_STALE)


@pytest.mark.parametrize("policy", list(TimeoutPolicy))
def test_a_stream_of_bad_radii_is_as_good_as_none(policy):
    bench = Bench(replace(LIMITS, radius_timeout_policy=policy))
    bench.run(1.0, radius=0.02)
    commands = bench.run(3.0, radius=math.nan)
    assert commands[-1] == (5.0e4 if policy is TimeoutPolicy.HOLD else 0.0)


@pytest.mark.parametrize("policy", list(TimeoutPolicy))
def test_when_the_stream_comes_back_it_is_followed(policy):
    bench = Bench(replace(LIMITS, radius_timeout_policy=policy))
    bench.run(1.0, radius=0.02)
    bench.run(3.0)
    assert bench.run(2.0, radius=0.025)[-1] == 4.0e4
    assert bench.state is State.TRACKING


def test_noise_within_the_hysteresis_does_not_move_the_command(gripping):
    asked = len(gripping.planner.asked)
    for i in range(100):
        gripping.radius(0.02 + LIMITS.radius_hysteresis * math.sin(i))
        assert gripping.run(TICK) == [5.0e4]
    assert len(gripping.planner.asked) == asked


def test_a_change_beyond_the_hysteresis_moves_it(gripping):
    gripping.radius(0.0206)
    assert gripping.run(1.0)[-1] == pytest.approx(1e3 / 0.0206)


def test_a_wrap_above_the_cap_is_refused(bench):
    bench.radius(0.0105)
    assert bench.reason is Reason.PRESSURE_CAP
    assert set(bench.run(1.0)) == {0.0}


def test_lowering_the_cap_cuts_the_command_at_once_and_says_so(gripping):
    gripping.machine.reconfigure(replace(LIMITS, pressure_cap=3.0e4))
    assert gripping.run(TICK) == [3.0e4]
    assert (gripping.state, gripping.reason) == (State.HOLDING, Reason.PRESSURE_CAP)
    gripping.radius(0.02)
    assert gripping.reason is Reason.PRESSURE_CAP


def test_without_a_certificate_the_safe_command_stands(gripping):
    gripping.planner.error = SolverError(RodStatus.UNSTABLE, 1.0, 7)
    gripping.radius(0.0215)
    assert (gripping.state, gripping.reason) == (State.HOLDING, Reason.NOT_CERTIFIED)
    assert RodStatus.UNSTABLE.value in gripping.machine.snapshot().refusal.text
    assert set(gripping.run(0.3)) == {5.0e4}


def test_a_plan_without_a_finite_pressure_is_no_plan(bench):
    bench.planner.product = math.nan
    bench.radius(0.02)
    assert bench.reason is not Reason.NONE
    assert set(bench.run(1.0)) == {0.0}


def test_release_vents_at_once_and_stays_vented_until_rearmed(gripping):
    gripping.machine.release()
    assert set(gripping.run(1.0, radius=0.02)) == {0.0}
    assert (gripping.state, gripping.reason) == (State.RELEASED, Reason.RELEASED)
    assert gripping.machine.rearm() is None
    assert gripping.state is State.WAITING
    assert gripping.run(1.0, radius=0.02)[-1] == 5.0e4


def test_a_fault_vents_and_stays_until_rearmed(gripping):
    gripping.machine.fail("boom")
    assert set(gripping.run(1.0, radius=0.02)) == {0.0}
    assert (gripping.state, gripping.reason) == (State.FAULT, Reason.INTERNAL_ERROR)
    gripping.machine.release()
    assert gripping.reason is Reason.INTERNAL_ERROR
    assert gripping.machine.rearm() is None
    assert gripping.run(1.0, radius=0.02)[-1] == 5.0e4


def test_rearm_changes_nothing_while_it_follows_and_is_refused_while_inactive(gripping):
    assert gripping.machine.rearm() is None
    assert gripping.state is State.TRACKING
    gripping.machine.deactivate()
    assert gripping.machine.rearm().reason is Reason.NOT_ACTIVE


@pytest.mark.parametrize("event", ["release", "fail"])
def test_nothing_leaves_the_inactive_state_but_activation(event):
    machine = GripControl(LIMITS)
    machine.fail("boom") if event == "fail" else machine.release()
    assert machine.snapshot().state is State.INACTIVE
    machine.activate()
    assert machine.snapshot().state is State.WAITING


def test_deactivation_vents_at_once_and_activation_remembers_nothing(gripping):
    gripping.machine.deactivate()
    assert gripping.run(TICK) == [0.0]
    gripping.machine.activate()
    snapshot = gripping.machine.snapshot()
    assert (snapshot.state, snapshot.radius, snapshot.accepted) == (State.WAITING, None, 0)
    assert not snapshot.refused
    gripping.radius(0.035)
    assert gripping.state is State.TRACKING


def test_another_gravity_moves_the_target_of_the_radius_in_use(gripping):
    gripping.machine.replan(FakePlanner(product=1.2e3))
    assert gripping.run(1.0, radius=0.02)[-1] == pytest.approx(6.0e4)


def test_a_gravity_at_which_nothing_can_be_gripped_holds_until_it_can(gripping):
    gripping.planner.error = SolverError(RodStatus.LEFT_BRANCH, 1.0, 7)
    gripping.machine.replan(gripping.planner)
    assert (gripping.state, gripping.reason) == (State.HOLDING, Reason.NOT_CERTIFIED)
    gripping.radius(0.02)
    assert gripping.reason is Reason.NOT_CERTIFIED
    gripping.planner.error = None
    gripping.radius(0.02)
    assert (gripping.state, gripping.reason) == (State.TRACKING, Reason.NONE)


def test_a_refused_input_of_another_kind_holds_too(gripping):
    gripping.machine.refuse(Refusal(Reason.GRAVITY_INVALID, "gravity must be finite"))
    assert (gripping.state, gripping.reason) == (State.HOLDING, Reason.GRAVITY_INVALID)


def test_a_clock_that_leaps_forward_does_not_make_the_pressure_leap(bench):
    bench.radius(0.02)
    bench.run(TICK)
    before = bench.machine.snapshot().pressure_command
    bench.now += 0.4
    after = bench.machine.command(bench.now)
    assert after - before <= LIMITS.pressure_rate_up * LONGEST_STEP * (1 + 1e-12)


def test_a_clock_that_leaps_back_stops_neither_the_ramp_nor_the_timeout(bench):
    bench.radius(0.02)
    bench.run(0.1)
    bench.now -= 1000.0
    assert bench.run(0.3, radius=0.02)[-1] > 1.0e4
    bench.run(1.0)
    assert bench.reason is Reason.RADIUS_STALE


@pytest.mark.parametrize("now", [math.nan, math.inf])
def test_a_time_that_is_none_is_an_error(bench, now):
    with pytest.raises(InvalidInputError, match="now"):
        bench.machine.command(now)


@given(readings=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=2))
def test_inner_time_never_runs_backwards_and_never_ends(readings):
    clock = MonotonicClock()
    times = [clock.advance(reading) for reading in readings]
    for before, after in itertools.pairwise(times):
        assert 0.0 <= after - before <= LONGEST_LEAP * (1.0 + 1e-9)
    clock.advance(0.0)
    before = clock.now
    assert clock.advance(0.02) - before == pytest.approx(0.02, abs=1e-6)


EVENTS = st.one_of(
    st.tuples(st.just("radius"), st.floats(allow_nan=True, allow_infinity=True)),
    st.tuples(st.just("radius"), st.floats(0.005, 0.05)),
    st.tuples(st.just("wait"), st.floats(0.0, 2.0)),
    st.tuples(
        st.sampled_from(["release", "rearm", "fail", "activate", "deactivate", "replan"]),
        st.just(0.0),
    ),
    st.tuples(st.just("cap"), st.floats(1.0e3, 2.0e5)),
)


@settings(max_examples=200)
@given(events=st.lists(EVENTS, max_size=30), policy=st.sampled_from(list(TimeoutPolicy)))
def test_whatever_happens_cap_and_rate_hold_and_it_can_grip_again(events, policy):
    bench = Bench(replace(LIMITS, radius_timeout_policy=policy))
    machine, cap, last = bench.machine, LIMITS.pressure_cap, 0.0
    for name, value in events:
        if name == "radius":
            bench.radius(value)
        elif name == "cap":
            cap = value
            machine.reconfigure(replace(LIMITS, radius_timeout_policy=policy, pressure_cap=cap))
        elif name == "replan":
            machine.replan(bench.planner)
        elif name == "fail":
            machine.fail("boom")
        elif name == "release":
            machine.release()
        elif name != "wait":
            getattr(machine, name)()
        bench.now += value if name == "wait" else TICK
        command = machine.command(bench.now)
        assert 0.0 <= command <= cap
        assert command - last <= LIMITS.pressure_rate_up * LONGEST_STEP * (1 + 1e-12)
        last = command
    machine.reconfigure(LIMITS)
    machine.deactivate()
    machine.activate()
    assert bench.run(1.0, radius=0.02)[-1] == 5.0e4


def test_bad_radii_after_the_time_out_do_not_change_the_reason():
    machine = GripControl(LIMITS)
    machine.activate()
    planner, reasons = FakePlanner(), []
    machine.offer_radius(0.0, 0.02, planner)
    for step in range(1, 300):
        machine.command(0.02 * step)
        if step % 5 == 0:
            machine.offer_radius(0.02 * step, math.nan, planner)
        reasons.append(machine.snapshot().refusal.reason)
    stale = reasons.index(Reason.RADIUS_STALE)
    assert set(reasons[stale:]) == {Reason.RADIUS_STALE}
    assert "last refused: object_radius must be a finite" in machine.snapshot().refusal.text
    assert machine.snapshot().refused[Reason.RADIUS_NOT_FINITE] == 59


def test_a_stale_stream_goes_on_saying_what_was_last_refused():
    machine = GripControl(LIMITS)
    machine.activate()
    planner = FakePlanner()
    machine.offer_radius(0.0, 0.02, planner)
    for step in range(1, 60):
        machine.offer_radius(0.1 * step, 1.0, planner)
        machine.command(0.1 * step)
    machine.command(7.0)
    machine.command(8.0)
    refusal = machine.snapshot().refusal
    assert refusal.reason is Reason.RADIUS_STALE
    assert "; last refused: object_radius 1 m is above" in refusal.text
    assert refusal.text.count("last refused") == 1
