# SPDX-License-Identifier: Apache-2.0
"""A stream of radii: what is followed, and how the command moves."""

import itertools
import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ros.control_bench import LIMITS, TICK, Bench
from ros.fakes import FakePlanner

from spiral_core import SolverError
from spiral_core.rod.state import RodStatus
from spiral_gripper_ros.control.limits import TimeoutPolicy
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.control.target import LONGEST_STEP
from spiral_gripper_ros.control.timing import LONGEST_LEAP, MonotonicClock

WRAP = 5.0e4  # of the bench's planner at 20 mm [Pa]


@pytest.fixture
def gripping(bench):
    """A bench that holds a 20 mm object at its wrap pressure of 50 kPa."""
    assert bench.run(1.0, radius=0.02)[-1] == WRAP
    return bench


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
    snapshot = gripping.seen
    assert snapshot.refused[reason] == 1
    assert snapshot.radius == 0.02


@pytest.mark.parametrize(
    ("radius", "product", "reason"),
    [
        (math.nan, 1.0e3, Reason.RADIUS_NOT_FINITE),
        (0.0105, 1.0e3, Reason.PRESSURE_CAP),
        (0.02, math.nan, Reason.INVALID_REQUEST),  # a plan without a finite pressure is none
    ],
)
def test_a_bad_first_radius_leaves_it_waiting(bench, radius, product, reason):
    bench.planner.product = product
    bench.radius(radius)
    assert set(bench.run(1.0)) == {0.0}
    assert (bench.state, bench.reason) == (State.WAITING, reason)


@pytest.mark.parametrize("radius", [None, math.nan])
@pytest.mark.parametrize(
    ("policy", "state"),
    [
        (TimeoutPolicy.HOLD, State.HOLDING),
        (TimeoutPolicy.VENT, State.VENTED),
        (TimeoutPolicy.RAMP_DOWN, State.VENTED),
    ],
)
def test_a_stream_that_stops_or_turns_bad_does_what_its_policy_says(policy, state, radius):
    bench = Bench(replace(LIMITS, radius_timeout_policy=policy))
    bench.run(1.0, radius=0.02)
    commands, reasons = [], []
    for _ in range(round(3.0 / TICK)):
        commands.append(bench.tick(radius))
        reasons.append(bench.reason)
    stops = round(LIMITS.radius_timeout / TICK)
    assert set(commands[:stops]) == {WRAP}
    if policy is TimeoutPolicy.RAMP_DOWN:
        downs = [a - b for a, b in itertools.pairwise(commands[stops - 1 : stops + 10])]
        assert downs == [pytest.approx(LIMITS.pressure_rate_down * TICK)] * len(downs)
        assert commands[-1] == 0.0
    else:
        assert set(commands[stops:]) == {WRAP if policy is TimeoutPolicy.HOLD else 0.0}
    before = Reason.NONE if radius is None else Reason.RADIUS_NOT_FINITE
    assert set(reasons[:stops]) == {before}
    refusal, refused = bench.seen.refusal, bench.seen.refused
    assert bench.state is state
    # Bad radii after the time-out change the reason no more.
    assert set(reasons[stops:]) == {Reason.RADIUS_STALE}
    assert refusal.text.count("last refused: object_radius must be") == (radius is not None)
    assert refused[Reason.RADIUS_STALE] == 1
    assert refused[Reason.RADIUS_NOT_FINITE] == (0 if radius is None else len(commands))
    assert bench.run(2.0, radius=0.025)[-1] == 4.0e4
    assert bench.state is State.TRACKING


def test_noise_within_the_hysteresis_does_not_move_the_command(gripping):
    asked = len(gripping.planner.asked)
    for i in range(100):
        gripping.radius(0.02 + LIMITS.radius_hysteresis * math.sin(i))
        assert gripping.tick() == WRAP
    assert len(gripping.planner.asked) == asked
    assert gripping.run(1.0, radius=0.0206)[-1] == pytest.approx(1e3 / 0.0206)


def test_lowering_the_cap_cuts_the_command_at_once_and_says_so(gripping):
    gripping.control.reconfigure(replace(LIMITS, pressure_cap=3.0e4))
    assert gripping.run(TICK) == [3.0e4]
    assert (gripping.state, gripping.reason) == (State.HOLDING, Reason.PRESSURE_CAP)
    gripping.radius(0.02)
    assert gripping.reason is Reason.PRESSURE_CAP


def test_without_a_certificate_the_safe_command_stands(gripping):
    gripping.planner.error = SolverError(RodStatus.UNSTABLE, 1.0, 7)
    gripping.radius(0.0215)
    assert (gripping.state, gripping.reason) == (State.HOLDING, Reason.NOT_CERTIFIED)
    assert RodStatus.UNSTABLE.value in gripping.seen.refusal.text
    assert set(gripping.run(0.3)) == {5.0e4}


def test_deactivation_vents_at_once_and_activation_remembers_nothing(gripping):
    gripping.control.deactivate()
    assert gripping.run(TICK) == [0.0]
    gripping.control.activate()
    snapshot = gripping.seen
    assert (snapshot.state, snapshot.radius, snapshot.accepted) == (State.WAITING, None, 0)
    assert not snapshot.refused
    gripping.radius(0.035)
    assert gripping.state is State.TRACKING


def test_another_gravity_moves_the_target_of_the_radius_in_use(gripping):
    gripping.control.replan(FakePlanner(product=1.2e3))
    assert gripping.run(1.0, radius=0.02)[-1] == pytest.approx(6.0e4)


def test_a_gravity_at_which_nothing_can_be_gripped_holds_until_it_can(gripping):
    gripping.planner.error = SolverError(RodStatus.LEFT_BRANCH, 1.0, 7)
    gripping.control.replan(gripping.planner)
    assert (gripping.state, gripping.reason) == (State.HOLDING, Reason.NOT_CERTIFIED)
    gripping.radius(0.02)
    assert gripping.reason is Reason.NOT_CERTIFIED
    gripping.planner.error = None
    gripping.radius(0.02)
    assert (gripping.state, gripping.reason) == (State.TRACKING, Reason.NONE)


def test_a_clock_that_leaps_forward_does_not_make_the_pressure_leap(bench):
    bench.radius(0.02)
    bench.run(TICK)
    before = bench.seen.pressure_command
    bench.now += 0.4
    after = bench.control.command(bench.now)
    assert after - before <= LIMITS.pressure_rate_up * LONGEST_STEP * (1 + 1e-12)


def test_a_clock_that_leaps_back_stops_neither_the_ramp_nor_the_timeout(bench):
    bench.radius(0.02)
    bench.run(0.1)
    bench.now -= 1000.0
    assert bench.run(0.3, radius=0.02)[-1] > 1.0e4
    bench.run(1.0)
    assert bench.reason is Reason.RADIUS_STALE


@given(readings=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=2))
def test_inner_time_never_runs_backwards_and_never_ends(readings):
    clock = MonotonicClock()
    times = [clock.advance(reading) for reading in readings]
    for before, after in itertools.pairwise(times):
        assert 0.0 <= after - before <= LONGEST_LEAP * (1.0 + 1e-9)
    clock.advance(0.0)
    before = clock.now
    assert clock.advance(0.02) - before == pytest.approx(0.02, abs=1e-6)
