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
    NOT_CERTIFIED,
    RUNNING,
    SUCCEEDED,
    TICK,
    WRAP,
    breaks,
    call,
    cancel,
    given,
    goal,
    gravity,
    hang,
    hold,
    leap,
    limit,
    track,
    wait,
)
from ros.fakes import RegulatorFault, regime_at

from spiral_core import InvalidInputError, WrapRegime
from spiral_gripper_ros.control.limits import AbortPolicy, FaultPolicy, TimeoutPolicy
from spiral_gripper_ros.control.release import Release, ReleaseGoal
from spiral_gripper_ros.control.snapshot import MeasuredPressure
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.control.timing import LONGEST_LEAP, MonotonicClock


def sees(regime):
    return given(sees=lambda pressure, perfect: regime)


unmeasured = given(is_measured=False)
keeps = goal(abort_policy=AbortPolicy.HOLD)
cut, raised = limit(pressure_cap=3.0e4), limit(pressure_cap=9.0e4)
unknown, settled = limit(grip_ratio=None), gravity(recommended=1.04)
uncertified, certified = gravity(error=NOT_CERTIFIED), gravity(error=None)
heavy, beyond = gravity(product=1.2e3), gravity(product=2.0e3)
vents = limit(pressure_fault_policy=FaultPolicy.VENT)
leaks = breaks(RegulatorFault.LEAK)


def fails(bench):
    """Let the planner certify nothing from now on."""
    bench.planner.error = NOT_CERTIFIED


# By state, reason and end of the goal: the command, whether the object is held, and the steps.
COURSES = {
    (State.TRACKING, Reason.NONE, None): [
        (WRAP, True, track),
        (WRAP, True, track, wait(1.0, 0.0200999)),  # within the hysteresis
        (1.0e3 / 0.0201001, True, track, wait(1.0, 0.0201001)),
        (WRAP, True, track, cut, raised, track),
        (6.0e4, True, track, heavy, wait(0.4, 0.02)),
        (WRAP, True, wait(0.1, 0.02), leap(-1.0e3), track),
        (1.0e3 / 0.035, True, track, call("deactivate"), call("activate"), wait(1.0, 0.035)),
        (WRAP, False, track, leaks, wait(2.0, 0.02)),  # it is only reported
        # A sensor that stays lost is overcome by policy report, or by an activation without it.
        (WRAP, True, vents, track, unmeasured, track, call("activate"), track),
        (
            *(WRAP, False, vents, track, unmeasured, track),
            *(limit(pressure_fault_policy=FaultPolicy.REPORT), call("rearm"), track),
        ),
        # The default grip: the ratio or what is recommended, within the cap and the good grips.
        (1.1 * WRAP, True, limit(grip_ratio=1.1), track),
        (1.02 * WRAP, True, limit(grip_ratio=1.1, pressure_cap=1.02 * WRAP), track),
        (1.1 * WRAP, True, unknown, track),
        (WRAP, True, unknown, gravity(recommended=0.97), track),
        (1.2 * WRAP, True, unknown, gravity(recommended=1.3, highest_good=1.2), track),
        # A lowered cap takes the overpressure first.
        (WRAP, True, limit(grip_ratio=1.1), track, limit(pressure_cap=WRAP), wait(0.02, 0.02)),
        # A grip that becomes known is not loosened, at another gravity neither.
        (1.1 * WRAP, True, unknown, track, settled, wait(0.2, 0.02)),
        (1.07 * WRAP, True, unknown, track, settled, gravity(highest_good=1.07), track),
        (1.04 * WRAP / 1.05, True, unknown, track, settled, wait(1.0, 0.021)),
        (0.88 * WRAP, True, unknown, track, settled, gravity(product=8.0e2), wait(0.4, 0.02)),
        # What was recommended at another mount, or a ratio that was given up, is not kept.
        (
            *(1.05 * WRAP, True, unknown, gravity(recommended=1.05), track),
            *(gravity(recommended=1.2), track, gravity(recommended=1.05), track),
        ),
        (
            *(1.05 * WRAP, True, limit(grip_ratio=1.2), track),
            *(gravity(recommended=1.05), track, unknown, track),
        ),
    ],
    (State.WAITING, Reason.RADIUS_NOT_FINITE, None): [(0.0, False, wait(0.2, math.nan))],
    (State.WAITING, Reason.PRESSURE_CAP, None): [(0.0, False, wait(0.2, 0.0105))],
    # A plan without a finite pressure is none.
    (State.WAITING, Reason.INVALID_REQUEST, None): [(0.0, False, gravity(product=math.nan), track)],
    (State.HOLDING, Reason.RADIUS_NOT_FINITE, None): [(WRAP, True, track, wait(0.02, math.inf))],
    (State.HOLDING, Reason.RADIUS_JUMP, None): [(WRAP, True, track, wait(0.02, 0.03))],
    (State.HOLDING, Reason.PRESSURE_CAP, None): [
        (3.0e4, False, track, cut, wait(0.02, 0.02)),
    ],
    (State.HOLDING, Reason.NOT_CERTIFIED, None): [
        (WRAP, True, track, uncertified, wait(0.2, 0.02)),
        (WRAP, True, track, fails, wait(0.02, 0.021)),
    ],
    (State.HOLDING, Reason.RADIUS_STALE, None): [
        (WRAP, True, track, leap(-1.0e3), wait(1.0)),
        # A cap that is raised again raises no command before the next radius.
        (3.0e4, False, track, cut, raised, wait(3.0)),
    ],
    (State.INACTIVE, Reason.NOT_ACTIVE, None): [
        (0.0, False, vents, call("deactivate"), wait(1.0), breaks(RegulatorFault.ABSOLUTE), track),
    ],
    (State.GRASPING, Reason.NONE, SUCCEEDED): [
        (WRAP, True, *hold),
        (WRAP, True, *hold, wait(60.0)),
        (5.5e4, True, goal(overpressure=5.0e3), wait(2.0)),
        (4.0e4, True, wait(1.0, 0.025), goal(None), wait(2.0)),
        (1.0e4, False, wait(1.0, 0.025), goal(None, pressure=1.0e4), wait(2.0, 0.02)),
        (WRAP, True, goal(), wait(0.5, 0.03), wait(0.5, math.nan), wait(2.0, 0.03)),
        *(
            (WRAP, True, limit(radius_timeout_policy=policy), track, goal(None), wait(3.0))
            for policy in TimeoutPolicy
        ),
        (WRAP, False, *hold, breaks(RegulatorFault.LOST), wait(2.0)),  # nobody knows
        (WRAP, False, *hold, sees(WrapRegime.CURLING), wait(0.02)),
        (WRAP, True, sees(WrapRegime.OVERHANG), *hold, given(sees=regime_at), wait(0.02)),
        (6.0e4, True, *hold, heavy, wait(1.0)),
        (6.5e4, True, goal(overpressure=5.0e3), heavy, wait(2.0)),
        (WRAP, True, goal(), uncertified, wait(2.0), certified, wait(0.02)),
        (WRAP, True, goal(), cut, raised, wait(1.0), *hold),
        (1.0e5, True, *hold, beyond, limit(pressure_cap=1.2e5), *hold),
        (WRAP, True, keeps, wait(0.2), cancel, *hold),
        (2.5e4, True, goal(), wait(0.3), goal(0.04), wait(1.5)),
        # A client is expected from the begin of a grip, or of the time-out, on.
        (WRAP, True, *hold, limit(keep_alive_timeout=0.5), wait(0.24)),
    ],
    (State.GRASPING, Reason.NONE, RUNNING): [
        (WRAP, False, limit(keep_alive_timeout=1.0), wait(60.0), goal(), sees(None), wait(0.76)),
    ],
    (State.GRASPING, Reason.PRESSURE_CAP, RUNNING): [
        (3.0e4, False, goal(), wait(0.5), cut, wait(1.0), raised, certified),
        (1.0e4, False, goal(None, pressure=6.0e4), wait(0.2), limit(pressure_cap=1.0e4)),
    ],
    (State.GRASPING, Reason.PRESSURE_CAP, SUCCEEDED): [
        (WRAP, True, *hold, beyond, limit(pressure_cap=1.2e5)),
    ],
    (State.GRASPING, Reason.NOT_CERTIFIED, RUNNING): [(WRAP, True, goal(), uncertified, wait(2.0))],
    # Raising the cap does not hide that gravity forbids the grasp.
    (State.GRASPING, Reason.NOT_CERTIFIED, SUCCEEDED): [
        (3.0e4, False, *hold, uncertified, cut, wait(0.02), raised),
    ],
    (State.GRASPING, Reason.WRAP_FAILED, FAILED): [
        (WRAP, False, first, sees(regime), keeps, wait(3.1))
        for first in (wait(0.0), unmeasured)
        for regime in (WrapRegime.OVERHANG, None)
    ],
    (State.GRASPING, Reason.GRASP_TIMEOUT, FAILED): [
        (2.0e4, False, keeps, wait(0.2), leap(60.0)),
    ],
    (State.RELEASED, Reason.GRASP_TIMEOUT, FAILED): [
        (0.0, False, goal(timeout=0.3), wait(0.32)),
        (0.0, False, goal(), uncertified, wait(3.02)),
        (0.0, False, goal(None, pressure=6e4), wait(0.2), limit(pressure_cap=1.0e4), wait(3.0)),
    ],
    # What an abort leaves standing moves for nothing but the cap.
    (State.GRASPING, Reason.GRASP_CANCELED, CANCELED): [
        (2.0e4, False, keeps, wait(0.2), cancel, heavy, wait(1.0, 0.02)),
        (1.0e4, False, keeps, wait(0.2), cancel, limit(pressure_cap=1.0e4), wait(0.1), raised),
        (2.0e4, False, limit(grasp_abort_policy=AbortPolicy.HOLD), goal(), wait(0.2), cancel),
    ],
    (State.RELEASED, Reason.GRASP_CANCELED, CANCELED): [
        (0.0, False, goal(), wait(0.2), cancel),
        (
            *(0.0, False, limit(grasp_abort_policy=AbortPolicy.HOLD)),
            *(goal(abort_policy=AbortPolicy.VENT), wait(0.2), cancel),
        ),
    ],
    (State.RELEASED, Reason.CLIENT_LOST, SUCCEEDED): [
        (0.0, False, *hold, wait(5.0), limit(keep_alive_timeout=0.5), wait(0.6)),
    ],
    # The policy for faults goes before that of the grasp.
    (State.FAULT, Reason.PRESSURE_LOW, FAILED): [
        (0.0, False, vents, keeps, wait(0.2), leaks, wait(2.0)),
    ],
    (State.RELEASED, Reason.PRESSURE_LOW, SUCCEEDED): [
        (0.0, False, *hold, hang, wait(1.0)),
        # Found empty after its link was lost for a while: its watchdog has vented.
        (
            *(0.0, False, *hold, unmeasured, wait(1.0), given(is_measured=True)),
            *(breaks(RegulatorFault.STUCK, 0.0), wait(1.0)),
        ),
    ],
}


@pytest.mark.parametrize(
    ("end", "row"), [(end, row) for end, rows in COURSES.items() for row in rows]
)
def test_a_course_ends_as_it_should_and_stays_so(bench, end, row):
    pressure, held, *steps = row
    bench.follow(*steps)
    assert bench.run(0.2) == [pytest.approx(pressure)] * 10
    seen, grasp = bench.seen, bench.grasped
    assert (seen.state, seen.refusal.reason, grasp and grasp.report.outcome) == end
    assert bool(seen.refusal.text) is (seen.refusal.reason is not Reason.NONE)
    assert seen.wrapped is held
    if end[0] is State.GRASPING:
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


@pytest.mark.parametrize(
    ("reason", "fields", "steps"),
    [
        (Reason.RADIUS_TOO_LARGE, {"radius": 0.2}, hold),
        (Reason.PRESSURE_CAP, {"radius": 0.0105}, hold),
        *(
            (Reason.INVALID_REQUEST, {name: value}, [goal(), wait(0.2)])
            for name in ("overpressure", "timeout", "pressure")
            for value in (math.nan, math.inf, -1.0)
        ),
        (Reason.INVALID_REQUEST, {"timeout": 0.0}, [track]),
        (Reason.INVALID_REQUEST, {"pressure": 1.0, "overpressure": 1.0}, [track]),
        (Reason.PRESSURE_CAP, {"overpressure": 1.0e308}, [goal(), wait(0.2)]),
        (Reason.PRESSURE_CAP, {"radius": None, "pressure": 1.0e308}, hold),
        (Reason.NOT_CERTIFIED, {}, [uncertified]),
        (Reason.PRESSURE_LOW, {"radius": 0.03}, [*hold, leaks, wait(1.0)]),
        # Nothing is followed whose radius could be grasped.
        (Reason.NO_RADIUS, {"radius": None}, hold),
        (Reason.RADIUS_NOT_FINITE, {"radius": None}, [track, wait(0.1, math.nan)]),
        (Reason.RELEASED, {"radius": None}, [call("release")]),
    ],
)
def test_a_goal_that_cannot_be_is_refused_and_changes_nothing(bench, reason, fields, steps):
    bench.follow(*steps)
    before, grasp = bench.seen, bench.grasped
    assert bench.grasp(**fields).reason is reason
    assert bench.seen == before
    if grasp:
        assert bench.end(grasp) == (SUCCEEDED, Reason.NONE)


def test_a_planner_that_breaks_leaves_everything_as_it_was(holding):
    before = holding.seen
    holding.planner.error = ZeroDivisionError()
    with pytest.raises(ZeroDivisionError):
        holding.grasp(0.03)
    assert holding.seen == before


def test_what_was_seen_of_another_object_does_not_count(holding):
    assert holding.seen.wrapped
    holding.grasp(0.03)
    assert not holding.seen.wrapped
    holding.run(2.0)
    assert holding.seen.wrapped
    holding.follow(call("release"), call("rearm"))
    holding.radius(0.02)
    assert (holding.state, holding.seen.wrapped) == (State.TRACKING, False)


def test_a_continually_tilting_arm_does_not_keep_a_grasp_from_being_reached(bench):
    grasp = bench.grasp()
    for step in range(100):
        bench.follow(gravity(product=1.0e3 + 0.2 * step), wait(TICK))
    assert grasp.report.outcome is SUCCEEDED


def test_a_wrap_without_force_is_not_held(bench):
    bench.follow(limit(grip_ratio=1.1), track)
    for force in (0.0, -1.0, 1.0e-9):
        bench.control.observe(bench.now, WrapRegime.PERFECT_WRAP, force)
        assert bench.seen.wrapped is (force > 0.0)


@pytest.mark.parametrize("radius", [None, math.nan])
@pytest.mark.parametrize("policy", TimeoutPolicy)
def test_a_stream_that_stops_or_turns_bad_is_stale_at_its_time_out(bench, policy, radius):
    bench.follow(limit(radius_timeout_policy=policy), track)
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
@pytest.mark.parametrize("steps", [[track], hold])
def test_policy_vent_vents_at_a_fault_until_it_is_mended_and_rearmed(
    bench, steps, fault, stuck_at, reason
):
    bench.follow(vents, *steps)
    bench.follow(breaks(fault, max(stuck_at, 0.5 * bench.regulator.pressure)), wait(3.0, 0.02))
    assert (bench.state, bench.reason, bench.seen.pressure_command) == (State.FAULT, reason, 0.0)
    assert bool(bench.seen.refused[Reason.PRESSURE_INVALID]) is (fault is RegulatorFault.NAN)
    remains = bench.seen.pressure_fault.reason is not Reason.NONE
    assert (bench.control.rearm() is not None) is remains
    bench.follow(call("fail", "again"), breaks(RegulatorFault.NONE))
    assert set(bench.run(2.0, radius=0.02)) == {0.0}
    assert bench.control.rearm() is None
    assert bench.run(2.0, radius=0.02)[-1] == WRAP


@pytest.mark.parametrize(("fault", "stuck_at", "reason"), FAULTS)
def test_a_fault_of_the_measured_pressure_lets_a_grasp_fail(bench, fault, stuck_at, reason):
    bench.follow(wait(0.5), keeps, breaks(fault, stuck_at))
    assert bench.end(bench.grasped) == (FAILED, reason)
    assert len(set(bench.run(1.0))) == 1
    assert (bench.state, bench.reason) == (State.GRASPING, reason)


LOST, HIGH = Reason.PRESSURE_LOST, Reason.PRESSURE_HIGH
LOW, NO_FAULT = Refusal(Reason.PRESSURE_LOW, "a leak"), Refusal(Reason.NONE, "")


@pytest.mark.parametrize(
    "course",
    [
        # Of time, pressure, its age, fault, outcome. From before the ramp that the release ended:
        [
            (0.0, 500.0, 0.08, NO_FAULT, RUNNING),
            (0.02, 5.3e3, 0.0, NO_FAULT, RUNNING),
            (0.1, 500.0, 0.02, NO_FAULT, SUCCEEDED),
        ],
        # A leak or a burst hose: too low for the grip before, on its way to 0 now.
        [
            (0.0, 3.0e4, 0.01, LOW, RUNNING),
            (0.02, 2.0e4, 0.0, LOW, RUNNING),
            (0.3, 200.0, 0.0, LOW, SUCCEEDED),
        ],
        # A sensor that has failed:
        [(0.0, -1.0e5, 0.01, LOW, RUNNING), (0.02, -1.0e5, 0.0, LOW, LOW.reason)],
        # Nothing, or the same pressure, until it is late:
        [(2.9, 0.0, 4.0, NO_FAULT, RUNNING), (3.1, 0.0, 4.2, NO_FAULT, LOST)],
        [(2.9, 3.0e4, 0.0, NO_FAULT, RUNNING), (3.1, 3.0e4, 0.0, NO_FAULT, HIGH)],
        [(0.1, 3.0e4, 4.0, Refusal(LOST, "silent"), LOST)],
        # Nothing was ever measured:
        [(0.29, None, 0.0, NO_FAULT, RUNNING), (0.31, None, 0.0, NO_FAULT, SUCCEEDED)],
    ],
)
def test_a_release_is_done_by_what_is_measured_after_it_began(bench, course):
    release = Release(ReleaseGoal(), 10.0, LIMITS)
    vented = replace(bench.seen, state=State.RELEASED)
    for time, pressure, age, fault, expected in course:
        seen = None if pressure is None else MeasuredPressure(pressure, age)
        told = {"measured": seen, "is_measured": seen is not None, "pressure_fault": fault}
        release.update(10.0 + time, replace(vented, **told))
        report = release.report
        assert (report.elapsed, report.progress) == pytest.approx((time, 1.0))
        assert expected is (report.refusal.reason if report.outcome is FAILED else report.outcome)


@pytest.mark.parametrize(
    ("end", "outcome", "reason"),
    [
        (call("deactivate"), FAILED, Reason.NOT_ACTIVE),
        (call("fail", "a defect"), FAILED, Reason.INTERNAL_ERROR),
        (cancel, CANCELED, Reason.GRASP_CANCELED),
        (lambda bench: bench.follow(goal(), wait(TICK)), FAILED, Reason.GRASP_REPLACED),
    ],
)
def test_a_release_is_answered_though_nothing_is_commanded_any_more(holding, end, outcome, reason):
    holding.grasped = release = holding.control.start_release(holding.now, ReleaseGoal())
    assert release.report.outcome is RUNNING
    holding.follow(leap(0.3), call("keep_alive", holding.now + 0.3), end)
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
