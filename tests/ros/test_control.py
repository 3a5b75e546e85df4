# SPDX-License-Identifier: Apache-2.0
"""Courses of the control logic: where each leads, what is commanded then, and what is held."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given as drawn
from hypothesis import strategies as st
from ros.control_bench import (
    CANCELED,
    FAILED,
    FAULTS,
    LIMITS,
    RUNNING,
    SUCCEEDED,
    TICK,
    WRAP,
    rows,
)

from spiral_core import InvalidInputError, WrapRegime
from spiral_gripper_ros.control.release import Release, ReleaseGoal
from spiral_gripper_ros.control.snapshot import MeasuredPressure
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.control.timing import LONGEST_LEAP, MonotonicClock

# State, reason, end of the goal, command, whether the object is held: the steps.
COURSES = """
TRACKING NONE - 5e4 held: track
TRACKING NONE - 5e4 held: track; wait 1 0.0200999
TRACKING NONE - 49750.996 held: track; wait 1 0.0201001
TRACKING NONE - 5e4 held: track; cut; raised; track
TRACKING NONE - 6e4 held: track; heavy; wait 0.4 0.02
TRACKING NONE - 5e4 held: wait 0.1 0.02; leap -1e3; track
TRACKING NONE - 28571.43 held: track; call deactivate; call activate; wait 1 0.035
TRACKING NONE - 5e4 no: track; leaks; wait 2 0.02
TRACKING NONE - 5e4 held: vents; track; unmeasured; track; call activate; track
TRACKING NONE - 5e4 no: vents; track; unmeasured; track; limit pressure_fault_policy=report;
  call rearm; track
TRACKING NONE - 5.5e4 held: limit grip_ratio=1.1; track
TRACKING NONE - 5.1e4 held: limit grip_ratio=1.1 pressure_cap=5.1e4; track
TRACKING NONE - 5.5e4 held: unknown; track
TRACKING NONE - 5e4 held: unknown; gravity recommended=0.97; track
TRACKING NONE - 6e4 held: unknown; gravity recommended=1.3 highest_good=1.2; track
TRACKING NONE - 5e4 held: limit grip_ratio=1.1; track; limit pressure_cap=5e4; wait 0.02 0.02
TRACKING NONE - 5.5e4 held: unknown; track; gravity recommended=1.04; wait 0.2 0.02
TRACKING NONE - 5.35e4 held: unknown; track; gravity recommended=1.04; gravity highest_good=1.07;
  track
TRACKING NONE - 49523.81 held: unknown; track; gravity recommended=1.04; wait 1 0.021
TRACKING NONE - 4.4e4 held: unknown; track; gravity recommended=1.04; gravity product=8e2;
  wait 0.4 0.02
TRACKING NONE - 5.25e4 held: unknown; gravity recommended=1.05; track; gravity recommended=1.2;
  track; gravity recommended=1.05; track
TRACKING NONE - 5.25e4 held: limit grip_ratio=1.2; track; gravity recommended=1.05; track;
  unknown; track
WAITING RADIUS_NOT_FINITE - 0 no: wait 0.2 nan
WAITING PRESSURE_CAP - 0 no: wait 0.2 0.0105
WAITING INVALID_REQUEST - 0 no: gravity product=nan; track
HOLDING RADIUS_NOT_FINITE - 5e4 held: track; wait 0.02 inf
HOLDING PRESSURE_CAP - 3e4 no: track; cut; wait 0.02 0.02
HOLDING NOT_CERTIFIED - 5e4 held: track; uncertified; wait 0.2 0.02
HOLDING NOT_CERTIFIED - 5e4 held: track; fails; wait 0.02 0.021
HOLDING RADIUS_STALE - 5e4 held: track; leap -1e3; wait 1
HOLDING RADIUS_STALE - 3e4 no: track; cut; raised; wait 3
INACTIVE NOT_ACTIVE - 0 no: vents; call deactivate; wait 1; breaks absolute; track
GRASPING NONE SUCCEEDED 5e4 held: hold; wait 60
GRASPING NONE SUCCEEDED 5.5e4 held: goal overpressure=5e3; wait 2
GRASPING NONE SUCCEEDED 6.49e4 held: gravity loss=1.3; goal overpressure=1.49e4; wait 2
GRASPING NONE SUCCEEDED 1e4 no: wait 1 0.025; goal radius=none pressure=1e4; wait 2 0.02
GRASPING NONE SUCCEEDED 5e4 held: goal; wait 0.5 0.03; wait 0.5 nan; wait 2 0.03
GRASPING NONE SUCCEEDED 5e4 held: limit radius_timeout_policy=stale_hold; track; goal none; wait 3
GRASPING NONE SUCCEEDED 5e4 held: limit radius_timeout_policy=stale_vent; track; goal none; wait 3
GRASPING NONE SUCCEEDED 5e4 held: limit radius_timeout_policy=stale_ramp; track; goal none; wait 3
GRASPING NONE SUCCEEDED 5e4 no: hold; breaks lost; wait 2
GRASPING NONE SUCCEEDED 5e4 no: hold; given sees=curling; wait 0.02
GRASPING NONE SUCCEEDED 6e4 held: hold; heavy; wait 1
GRASPING NONE SUCCEEDED 6.5e4 held: goal overpressure=5e3; heavy; wait 2
GRASPING NONE SUCCEEDED 5e4 held: goal; uncertified; wait 2; certified; wait 0.02
GRASPING NONE SUCCEEDED 5e4 held: goal; cut; raised; wait 1; hold
GRASPING NONE SUCCEEDED 1e5 held: hold; gravity product=2e3; limit pressure_cap=1.2e5; hold
GRASPING NONE SUCCEEDED 5e4 held: keeps; wait 0.2; cancel; hold
GRASPING NONE SUCCEEDED 2.5e4 held: goal; wait 0.3; goal 0.04; wait 1.5
GRASPING NONE SUCCEEDED 5e4 held: hold; limit keep_alive_timeout=0.5; wait 0.24
GRASPING NONE RUNNING 5e4 no: limit keep_alive_timeout=1; wait 60; goal; given sees=none; wait 0.76
GRASPING PRESSURE_CAP RUNNING 3e4 no: goal; wait 0.5; cut; wait 1; raised; certified
GRASPING PRESSURE_CAP RUNNING 1e4 no: goal none pressure=6e4; wait 0.2; limit pressure_cap=1e4
GRASPING PRESSURE_CAP SUCCEEDED 5e4 held: hold; gravity product=2e3; limit pressure_cap=1.2e5
GRASPING NOT_CERTIFIED RUNNING 5e4 held: goal; uncertified; wait 2
GRASPING NOT_CERTIFIED SUCCEEDED 3e4 no: hold; uncertified; cut; wait 0.02; raised
GRASPING WRAP_FAILED FAILED 5e4 no: given sees=overhang; keeps; wait 3.1
GRASPING WRAP_FAILED FAILED 5e4 no: unmeasured; given sees=none; keeps; wait 3.1
GRASPING GRASP_TIMEOUT FAILED 2e4 no: keeps; wait 0.2; leap 60
RELEASED GRASP_TIMEOUT FAILED 0 no: goal timeout=0.3; wait 0.32
RELEASED GRASP_TIMEOUT FAILED 0 no: goal; uncertified; wait 3.02
RELEASED GRASP_TIMEOUT FAILED 0 no: goal none pressure=6e4; wait 0.2; limit pressure_cap=1e4; wait 3
GRASPING GRASP_CANCELED CANCELED 2e4 no: keeps; wait 0.2; cancel; heavy; wait 1 0.02
GRASPING GRASP_CANCELED CANCELED 1e4 no: keeps; wait 0.2; cancel; limit pressure_cap=1e4;
  wait 0.1; raised
GRASPING GRASP_CANCELED CANCELED 2e4 no: limit grasp_abort_policy=hold; goal; wait 0.2; cancel
RELEASED GRASP_CANCELED CANCELED 0 no: limit grasp_abort_policy=hold; goal abort_policy=vent;
  wait 0.2; cancel
RELEASED CLIENT_LOST SUCCEEDED 0 no: hold; wait 5; limit keep_alive_timeout=0.5; wait 0.6
FAULT PRESSURE_LOW FAILED 0 no: vents; keeps; wait 0.2; leaks; wait 2
RELEASED PRESSURE_LOW SUCCEEDED 0 no: hold; hang; wait 1
RELEASED PRESSURE_LOW SUCCEEDED 0 no: hold; unmeasured; wait 1; given is_measured=yes;
  breaks stuck 0; wait 1
"""


@pytest.mark.parametrize("row", rows(COURSES))
def test_a_course_ends_as_it_should_and_stays_so(bench, row):
    expected, steps = row.split(": ")
    state, reason, outcome, pressure, held = expected.split()
    bench.follow(steps)
    assert bench.run(0.2) == [pytest.approx(float(pressure))] * 10
    seen, grasp = bench.seen, bench.grasped
    assert (seen.state, seen.refusal.reason) == (State[state], Reason[reason])
    assert (grasp.report.outcome.name if grasp else "-") == outcome
    assert bool(seen.refusal.text) is (seen.refusal.reason is not Reason.NONE)
    assert seen.wrapped is (held == "held")
    if seen.state is State.GRASPING:
        assert (seen.radius_age, seen.refused[Reason.RADIUS_NOT_FINITE]) == (None, 0)


@pytest.mark.parametrize("is_measured", [True, False])
def test_a_grasp_reports_its_way_and_its_end(bench, is_measured):
    bench.is_measured = is_measured
    grasp = bench.grasp()
    bench.run(0.2)
    assert (grasp.report.progress, grasp.report.elapsed) == pytest.approx((0.4, 0.2))
    assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)
    report = grasp.report
    # The ramp, then the settling time or what a measurement takes to persist.
    assert report.elapsed == pytest.approx(0.8, abs=0.1 if is_measured else 2.0 * TICK)
    assert (report.plan.pressure, report.progress, report.radius) == (WRAP, 1.0, 0.02)
    bench.run(1.0)
    assert grasp.report == report


# The reason, and the goal after some steps.
IMPOSSIBLE = """
RADIUS_TOO_LARGE: hold; goal 0.2
PRESSURE_CAP: hold; goal 0.0105
INVALID_REQUEST: goal; wait 0.2; goal overpressure=nan
INVALID_REQUEST: goal; wait 0.2; goal overpressure=-1
INVALID_REQUEST: goal; wait 0.2; goal timeout=inf
INVALID_REQUEST: goal; wait 0.2; goal timeout=-1
INVALID_REQUEST: goal; wait 0.2; goal pressure=-1
INVALID_REQUEST: track; goal timeout=0
INVALID_REQUEST: track; goal pressure=1 overpressure=1
PRESSURE_CAP: goal; wait 0.2; goal overpressure=1e308
PRESSURE_CAP: hold; goal none pressure=1e308
NOT_CERTIFIED: uncertified; goal
INVALID_REQUEST: gravity loss=1.3; track; goal overpressure=1.51e4
PRESSURE_LOW: hold; leaks; wait 1; goal 0.03
NO_RADIUS: hold; goal none
RADIUS_NOT_FINITE: track; wait 0.1 nan; goal none
RELEASED: call release; goal none
"""


@pytest.mark.parametrize("row", rows(IMPOSSIBLE))
def test_a_goal_that_cannot_be_is_refused_and_changes_nothing(bench, row):
    reason, steps = row.split(": ")
    steps, _, last = steps.rpartition("; ")
    bench.follow(steps)
    before, grasp = bench.seen, bench.grasped
    assert bench.follow(last).reason is Reason[reason]
    assert bench.seen == before
    if grasp:
        assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)


def test_a_continually_tilting_arm_does_not_keep_a_grasp_from_being_reached(bench):
    grasp = bench.grasp()
    for step in range(100):
        bench.follow(f"gravity product={1.0e3 + 0.2 * step}; wait {TICK}")
    assert grasp.report.outcome is SUCCEEDED


def test_a_wrap_without_force_is_not_held(bench):
    bench.follow("limit grip_ratio=1.1; track")
    for force in (0.0, -1.0, 1.0e-9):
        bench.control.observe(bench.now, WrapRegime.PERFECT_WRAP, force)
        assert bench.seen.wrapped is (force > 0.0)


@pytest.mark.parametrize("radius", [None, math.nan])
@pytest.mark.parametrize("policy", ["hold", "vent", "ramp"])
def test_a_stream_that_stops_or_turns_bad_is_stale_at_its_time_out(bench, policy, radius):
    bench.follow(f"limit radius_timeout_policy=stale_{policy}; track")
    assert bench.seen.accepted == 75
    reasons = []
    for _ in range(150):
        bench.tick(radius)
        reasons.append(bench.reason)
    before = Reason.NONE if radius is None else Reason.RADIUS_NOT_FINITE
    # Bad radii after the time-out change the reason no more.
    assert reasons == [before] * 25 + [Reason.RADIUS_STALE] * 125
    bad = {} if radius is None else {Reason.RADIUS_NOT_FINITE: 150}
    assert bench.seen.refused == {Reason.RADIUS_STALE: 1} | bad
    assert ("last refused: object_radius must be" in bench.seen.refusal.text) is bool(bad)
    bench.control.activate()
    assert (bench.seen.accepted, bench.seen.refused) == (0, {})


@pytest.mark.parametrize(("fault", "stuck_at", "reason"), FAULTS)
@pytest.mark.parametrize("steps", ["track", "hold"])
def test_policy_vent_vents_at_a_fault_until_it_is_mended_and_rearmed(
    bench, steps, fault, stuck_at, reason
):
    bench.follow(f"vents; {steps}")
    bench.follow(f"breaks {fault} {max(stuck_at, 0.5 * bench.regulator.pressure)}; wait 3 0.02")
    assert (bench.state, bench.reason, bench.seen.pressure_command) == (State.FAULT, reason, 0.0)
    assert bool(bench.seen.refused[Reason.PRESSURE_INVALID]) is (fault == "unplugged")
    remains = bench.seen.pressure_fault.reason is not Reason.NONE
    assert (bench.control.rearm() is not None) is remains
    bench.follow("call fail again; breaks sound")
    assert set(bench.run(2.0, radius=0.02)) == {0.0}
    assert bench.control.rearm() is None
    assert bench.run(2.0, radius=0.02)[-1] == WRAP


@pytest.mark.parametrize(("fault", "stuck_at", "reason"), FAULTS)
def test_a_fault_of_the_measured_pressure_lets_a_grasp_fail(bench, fault, stuck_at, reason):
    bench.follow(f"wait 0.5; keeps; breaks {fault} {stuck_at}")
    assert bench.end(bench.grasped) == (FAILED, reason)
    assert len(set(bench.run(1.0))) == 1
    assert (bench.state, bench.reason) == (State.GRASPING, reason)


# Of time, pressure, its age, fault, and the end; from before the ramp that the release ended, at a
# leak, at a failed sensor, until it is late (without evidence, with pressure), without any sensor.
RELEASES = """
0 500 0.08 NONE RUNNING; 0.02 5300 0 NONE RUNNING; 0.1 500 0.02 NONE SUCCEEDED
0 3e4 0.01 PRESSURE_LOW RUNNING; 0.02 2e4 0 PRESSURE_LOW RUNNING; 0.3 200 0 PRESSURE_LOW SUCCEEDED
0 -1e5 0.01 PRESSURE_LOW RUNNING; 0.02 -1e5 0 PRESSURE_LOW PRESSURE_LOW
2.9 0 4 NONE RUNNING; 3.1 0 4.2 NONE PRESSURE_LOST
2.9 3e4 0 NONE RUNNING; 3.1 3e4 0 NONE PRESSURE_HIGH
0.1 3e4 4 PRESSURE_LOST PRESSURE_LOST
0.29 - 0 NONE RUNNING; 0.31 - 0 NONE SUCCEEDED
"""


@pytest.mark.parametrize("timeout", [math.nan, math.inf, 0.0, -1.0])
def test_a_release_whose_time_out_is_none_vents_but_is_no_success(timeout):
    report = Release(ReleaseGoal(timeout), 10.0, LIMITS).report
    assert (report.outcome, report.refusal.reason) == (FAILED, Reason.INVALID_REQUEST)
    assert "vented all the same" in report.refusal.text


@pytest.mark.parametrize("course", rows(RELEASES))
def test_a_release_is_done_by_what_is_measured_after_it_began(bench, course):
    release = Release(ReleaseGoal(), 10.0, LIMITS)
    vented = replace(bench.seen, state=State.RELEASED)
    for row in course.split("; "):
        time, pressure, age, fault, expected = row.split()
        seen = None if pressure == "-" else MeasuredPressure(float(pressure), float(age))
        told = Refusal(Reason[fault], "a fault")
        values = {"measured": seen, "is_measured": seen is not None, "pressure_fault": told}
        release.update(10.0 + float(time), replace(vented, **values))
        report = release.report
        assert (report.elapsed, report.progress) == pytest.approx((float(time), 1.0))
        end = report.refusal.reason if report.outcome is FAILED else report.outcome
        assert end.name == expected


@pytest.mark.parametrize(
    ("end", "outcome", "reason"),
    [
        ("call deactivate", FAILED, Reason.NOT_ACTIVE),
        ("call fail defect", FAILED, Reason.INTERNAL_ERROR),
        ("cancel", CANCELED, Reason.GRASP_CANCELED),
        ("goal; wait 0.02", FAILED, Reason.GRASP_REPLACED),
    ],
)
def test_a_release_is_answered_though_nothing_is_commanded_any_more(holding, end, outcome, reason):
    holding.grasped = release = holding.control.start_release(holding.now, ReleaseGoal())
    assert release.report.outcome is RUNNING
    holding.follow(f"leap 0.3; call keep_alive {holding.now + 0.3}; {end}")
    assert (release.report.outcome, release.report.refusal.reason) == (outcome, reason)
    assert release.report.elapsed == pytest.approx(0.3, abs=1.1 * TICK)


@drawn(readings=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=2))
def test_inner_time_never_runs_backwards_and_never_ends(readings):
    clock = MonotonicClock()
    for before, after in pairwise([clock.advance(reading) for reading in readings]):
        assert 0.0 <= after - before <= LONGEST_LEAP * (1.0 + 1e-9)
    for bad in (math.nan, math.inf):
        with pytest.raises(InvalidInputError, match="now"):
            clock.advance(bad)
    before = clock.advance(0.0)
    assert clock.advance(0.02) - before == pytest.approx(0.02, abs=1e-6)
