# SPDX-License-Identifier: Apache-2.0
"""Courses of the control logic: where each leads, what is commanded then, and what is held."""

import math
import re
from itertools import pairwise

import pytest
from hypothesis import given as drawn
from hypothesis import strategies as st
from ros.control_bench import LIMITS, TICK, WRAP, ending, rows, snapshot, value

from spiral_core import InvalidInputError
from spiral_gripper_ros.control.release import Release, ReleaseGoal
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.control.timing import LONGEST_LEAP, WATCHDOG_TIMEOUT, MonotonicClock
from spiral_gripper_ros.regulators.command_watch import CommandWatch

# State, reason, ends of the goals, command (nan: silent), whether the object is held: the steps.
COURSES = """
TRACKING NONE - 5e4 held: track
TRACKING NONE - 5e4 held: track; run 1 0.0200999
TRACKING NONE - 49750.996 held: track; run 1 0.0201001
TRACKING NONE - 5e4 held: track; cut; raised; track
TRACKING NONE - 6e4 held: track; heavy; run 0.4 0.02
TRACKING NONE - 5e4 held: run 0.1 0.02; leap -1e3; track
TRACKING NONE - 28571.43 held: track; call deactivate; call activate; run 1 0.035
TRACKING NONE - 5e4 no: track; leaks; run 2 0.02
TRACKING NONE - 5e4 held: vents; track; unmeasured; track; call activate; track
TRACKING NONE - 5e4 no: vents; track; unmeasured; track;
  limit pressure_fault_policy=FaultPolicy.REPORT; call rearm; track
TRACKING NONE - 5.5e4 held: limit grip_ratio=1.1; track
TRACKING NONE - 5.1e4 held: limit grip_ratio=1.1 pressure_cap=5.1e4; track
TRACKING NONE - 5.5e4 held: unknown; track
TRACKING NONE - 5e4 held: unknown; gravity recommended=0.97; track
TRACKING NONE - 6e4 held: unknown; gravity recommended=1.3 highest_good=1.2; track
TRACKING NONE - 5e4 held: limit grip_ratio=1.1; track; limit pressure_cap=5e4; run 0.02 0.02
TRACKING NONE - 5.5e4 held: unknown; track; gravity recommended=1.04; run 0.2 0.02
TRACKING NONE - 5.35e4 held: unknown; track; gravity recommended=1.04; gravity highest_good=1.07;
  track
TRACKING NONE - 49523.81 held: unknown; track; gravity recommended=1.04; run 1 0.021
TRACKING NONE - 4.4e4 held: unknown; track; gravity recommended=1.04; gravity product=8e2;
  run 0.4 0.02
TRACKING NONE - 5.25e4 held: unknown; gravity recommended=1.05; track; gravity recommended=1.2;
  track; gravity recommended=1.05; track
TRACKING NONE - 5.25e4 held: limit grip_ratio=1.2; track; gravity recommended=1.05; track; unknown;
  track
WAITING RADIUS_NOT_FINITE - 0 no: run 0.2 nan
WAITING PRESSURE_CAP - 0 no: run 0.2 0.0105
WAITING INVALID_REQUEST - 0 no: gravity product=nan; track
HOLDING RADIUS_NOT_FINITE - 5e4 held: track; run 0.02 inf
HOLDING PRESSURE_CAP - 3e4 no: track; cut; run 0.02 0.02
HOLDING NOT_CERTIFIED - 5e4 held: track; uncertified; run 0.2 0.02
HOLDING NOT_CERTIFIED - 5e4 held: track; plan error=uncertified; run 0.02 0.021
HOLDING RADIUS_STALE - 5e4 held: track; leap -1e3; run 1
HOLDING RADIUS_STALE - 3e4 no: track; cut; raised; run 3
INACTIVE NOT_ACTIVE - 0 no: vents; call deactivate; run 1; breaks fault=RegulatorFault.ABSOLUTE;
  track
GRASPING NONE SUCCEEDED 5e4 held: hold; run 60
GRASPING NONE SUCCEEDED 5.5e4 held: grasp overpressure=5e3; run 2
GRASPING NONE SUCCEEDED 6.49e4 held: gravity loss=1.3; grasp overpressure=1.49e4; run 2
GRASPING NONE SUCCEEDED 1e4 no: run 1 0.025; grasp radius=none pressure=1e4; run 2 0.02
GRASPING NONE SUCCEEDED 5e4 held: grasp; run 0.5 0.03; run 0.5 nan; run 2 0.03
GRASPING NONE SUCCEEDED 5e4 held: limit radius_timeout_policy=TimeoutPolicy.HOLD; track;
  grasp none; run 3
GRASPING NONE SUCCEEDED 5e4 held: limit radius_timeout_policy=TimeoutPolicy.VENT; track;
  grasp none; run 3
GRASPING NONE SUCCEEDED 5e4 held: limit radius_timeout_policy=TimeoutPolicy.RAMP_DOWN; track;
  grasp none; run 3
GRASPING NONE SUCCEEDED 5e4 no: hold; unmeasured; run 2
GRASPING NONE SUCCEEDED 5e4 no: hold; give sees=WrapRegime.CURLING; run 0.02
GRASPING NONE SUCCEEDED 6e4 held: hold; heavy; run 1
GRASPING NONE SUCCEEDED 6.5e4 held: grasp overpressure=5e3; heavy; run 2
GRASPING NONE SUCCEEDED 5e4 held: grasp; uncertified; run 2; certified; run 0.02
GRASPING NONE GRASP_REPLACED,SUCCEEDED 5e4 held: grasp; cut; raised; run 1; hold
GRASPING NONE SUCCEEDED,SUCCEEDED 1e5 held: hold; gravity product=2e3; limit pressure_cap=1.2e5;
  hold
GRASPING NONE GRASP_CANCELED,SUCCEEDED 5e4 held: keeps; run 0.2; cancel; hold
GRASPING NONE GRASP_REPLACED,SUCCEEDED 2.5e4 held: grasp; run 0.3; grasp 0.04; run 1.5
GRASPING NONE SUCCEEDED 5e4 held: hold; limit keep_alive_timeout=0.5; run 0.24
GRASPING NONE RUNNING 5e4 no: limit keep_alive_timeout=1; run 60; grasp; give sees=none; run 0.76
GRASPING PRESSURE_CAP RUNNING 3e4 no: grasp; run 0.5; cut; run 1; raised; certified
GRASPING PRESSURE_CAP RUNNING 1e4 no: grasp none pressure=6e4; run 0.2; limit pressure_cap=1e4
GRASPING PRESSURE_CAP SUCCEEDED 5e4 held: hold; gravity product=2e3; limit pressure_cap=1.2e5
GRASPING NOT_CERTIFIED RUNNING 5e4 held: grasp; uncertified; run 2
GRASPING NOT_CERTIFIED SUCCEEDED 3e4 no: hold; uncertified; cut; run 0.02; raised
GRASPING WRAP_FAILED WRAP_FAILED 5e4 no: give sees=WrapRegime.OVERHANG; keeps; run 3.1
GRASPING WRAP_FAILED WRAP_FAILED 5e4 no: unmeasured; give sees=none; keeps; run 3.1
GRASPING GRASP_TIMEOUT GRASP_TIMEOUT 2e4 no: keeps; run 0.2; leap 60
RELEASED GRASP_TIMEOUT GRASP_TIMEOUT 0 no: grasp timeout=0.3; run 0.32
RELEASED GRASP_TIMEOUT GRASP_TIMEOUT 0 no: grasp; uncertified; run 3.02
RELEASED GRASP_TIMEOUT GRASP_TIMEOUT 0 no: grasp none pressure=6e4; run 0.2;
  limit pressure_cap=1e4; run 3
GRASPING GRASP_CANCELED GRASP_CANCELED 2e4 no: keeps; run 0.2; cancel; heavy; run 1 0.02
GRASPING GRASP_CANCELED GRASP_CANCELED 1e4 no: keeps; run 0.2; cancel; limit pressure_cap=1e4;
  run 0.1; raised
GRASPING GRASP_CANCELED GRASP_CANCELED 2e4 no: limit grasp_abort_policy=AbortPolicy.HOLD; grasp;
  run 0.2; cancel
RELEASED GRASP_CANCELED GRASP_CANCELED 0 no: limit grasp_abort_policy=AbortPolicy.HOLD;
  grasp abort_policy=AbortPolicy.VENT; run 0.2; cancel
RELEASED CLIENT_LOST SUCCEEDED 0 no: hold; run 5; limit keep_alive_timeout=0.5; run 0.6
FAULT PRESSURE_LOW PRESSURE_LOW 0 no: vents; keeps; run 0.2; leaks; run 2
HOLDING RADIUS_JUMP - 5e4 held: track; run 0.02 0.03
RELEASED RELEASED - 0 no: track; call release; track
TRACKING NONE - 5e4 held: track; call release; call rearm; track
RELEASED RECONFIGURED RECONFIGURED 0 no: grasp; run 0.2; call release reconfigured
INACTIVE NOT_ACTIVE NOT_ACTIVE 0 no: grasp; run 0.2; call deactivate
RELEASED RELEASED RELEASED 0 no: grasp; run 0.2; call release
GRASPING NONE SUCCEEDED 3e4 no: call release; grasp none pressure=3e4; run 2
GRASPING NONE SUCCEEDED 5.1e4 held: track; grasp none overpressure=1e3; run 2
RELEASED PRESSURE_HIGH PRESSURE_HIGH 0 no: grasp; run 0.2; breaks fault=RegulatorFault.ABSOLUTE;
  run 1
RELEASED RELEASED SUCCEEDED,PRESSURE_HIGH 0 no: hold;
  breaks fault=RegulatorFault.STUCK pressure=4e4; open 2; run 2.2
RELEASED RELEASED SUCCEEDED,PRESSURE_LOST 0 no: hold; unmeasured; open 2; run 2.2
RELEASED PRESSURE_LOW SUCCEEDED 0 no: hold; hang; run 1
RELEASED PRESSURE_LOW SUCCEEDED 0 no: hold; unmeasured; run 1;
  breaks fault=RegulatorFault.STUCK pressure=0; run 1
RELEASED PRESSURE_LOW SUCCEEDED 0 no: limit measured_pressure_timeout=9; hold; unmeasured; run 0.3;
  breaks fault=RegulatorFault.STUCK pressure=0; run 1
GRASPING NONE SUCCEEDED 5e4 no: limit measured_pressure_timeout=9; hold; unmeasured; run 0.2;
  breaks fault=RegulatorFault.STUCK pressure=0; run 1
RELEASED PRESSURE_LOW PRESSURE_LOW 0 no: unmeasured; keeps; run 0.3; leap 0.5; run 1
RELEASED PRESSURE_LOW SUCCEEDED 0 no: unmeasured; hold; leap 0.4; run 1
RELEASED PRESSURE_LOW SUCCEEDED 0 no: unmeasured; hold; leap 0.34; run 1
GRASPING NONE SUCCEEDED 5e4 held: unmeasured; hold; leap 0.32; run 1
GRASPING NONE SUCCEEDED 5e4 held: unmeasured; limit publish_rate=1; hold; leap 0.9;
  limit publish_rate=50; tick; run 1
RELEASED PRESSURE_LOW SUCCEEDED 0 no: hold; unmeasured; run 3; leap 0.5; run 1
FAULT PRESSURE_LOST - 0 no: vents; track; unmeasured; tick none 1; tick none 1; tick none 1;
  tick none 1; tick none 1
TRACKING NONE - 5e4 no: track; leaks; run 3 0.02; unmeasured; run 0.3 0.02; leaks; run 0.04 0.02
GRASPING PRESSURE_LOW PRESSURE_LOW 5e4 no: keeps; leaks; run 2; leap 0.3; run 0.1
WAITING PRESSURE_LOW - 0 no: track; leaks; run 3 0.02; hang; run 0.4
GRASPING NONE SUCCEEDED 5e4 held: unmeasured; limit publish_rate=1; hold; tick none 1.4; run 1
GRASPING NONE RUNNING 0 no: unmeasured; run 1; leap 0.5; grasp; run 0.2
GRASPING NONE SUCCEEDED 5e4 held: unmeasured; run 1; leap 0.5; grasp; run 2
WAITING PRESSURE_LOW - 0 no: unmeasured; track; leap 0.5; run 1
TRACKING NONE - 5e4 held: unmeasured; track; leap 0.5; run 0.1; track; track
FAULT PRESSURE_LOW - 0 no: vents; unmeasured; track; leap 0.5; track; track
WAITING PRESSURE_LOW - 0 no: unmeasured; limit radius_timeout_policy=TimeoutPolicy.RAMP_DOWN; track;
  limit pressure_rate_down=2e4; run 0.6; leap 0.5; run 0.1
FAULT PRESSURE_LOW - 0 no: vents; track; leaks; run 3 0.02
FAULT PRESSURE_LOW PRESSURE_LOW 0 no: vents; keeps; leaks; run 1
FAULT PRESSURE_LOW SUCCEEDED 0 no: vents; hold; leaks; run 3
FAULT PRESSURE_HIGH - 0 no: vents; track; breaks fault=RegulatorFault.STUCK pressure=9e4; run 3 0.02
FAULT PRESSURE_HIGH SUCCEEDED 0 no: vents; hold; breaks fault=RegulatorFault.STUCK pressure=9e4;
  run 3; call rearm; run 1 0.02
FAULT PRESSURE_LOST SUCCEEDED 0 no: vents; hold; unmeasured; run 3; call rearm; run 1 0.02
FAULT PRESSURE_INVALID SUCCEEDED 0 no: vents; hold; breaks fault=RegulatorFault.NAN; run 3 0.02
FAULT INTERNAL_ERROR - 0 no: vents; track; leaks; run 1; call fail again; sound; run 2 0.02
TRACKING NONE - 5e4 held: vents; track; leaks; run 1 0.02; call fail again; sound; run 2 0.02;
  call rearm; track
TRACKING NONE - 5e4 held: vents; track; unmeasured; run 3 0.02; sound; run 2 0.02; call rearm; track
GRASPING PRESSURE_LOW PRESSURE_LOW 5e4 no: keeps; leaks; run 3
GRASPING PRESSURE_LOW PRESSURE_LOW 5e4 no: keeps; breaks fault=RegulatorFault.STUCK; run 3
GRASPING PRESSURE_HIGH PRESSURE_HIGH 5e4 no: keeps; breaks fault=RegulatorFault.STUCK pressure=9e4;
  run 3
GRASPING PRESSURE_LOST PRESSURE_LOST 4e4 no: run 0.5; keeps; unmeasured; run 3
GRASPING PRESSURE_INVALID PRESSURE_INVALID 2.2e4 no: run 0.5; keeps;
  breaks fault=RegulatorFault.NAN; run 3
GRASPING NONE RUNNING 5e4 no: unmeasured; grasp; give sees=none; run 0.58
GRASPING NONE RUNNING 5e4 held: unmeasured; grasp; run 0.58
GRASPING NONE SUCCEEDED 5e4 held: unmeasured; grasp; run 0.66
TRACKING NONE - 5e4 held: track; run 0.28
HOLDING RADIUS_NOT_FINITE - 5e4 held: track; run 0.28 nan
HOLDING RADIUS_STALE - 5e4 held: track; run 0.52
HOLDING RADIUS_STALE - 5e4 held: track; run 1 nan
VENTED RADIUS_STALE - 0 no: limit radius_timeout_policy=TimeoutPolicy.VENT; track; run 0.52 nan
VENTED RADIUS_STALE - 0 no: limit radius_timeout_policy=TimeoutPolicy.RAMP_DOWN; track; run 1
RELEASED RELEASED SUCCEEDED,INVALID_REQUEST 0 no: hold; open nan
RELEASED RELEASED SUCCEEDED,INVALID_REQUEST 0 no: hold; open inf
RELEASED RELEASED SUCCEEDED,INVALID_REQUEST 0 no: hold; open 0
RELEASED RELEASED SUCCEEDED,RUNNING 0 no: hold; breaks fault=RegulatorFault.STUCK; open; run 2
INACTIVE NOT_ACTIVE SUCCEEDED,NOT_ACTIVE 0 no: hold; open; call deactivate
FAULT INTERNAL_ERROR SUCCEEDED,INTERNAL_ERROR 0 no: hold; open; call fail defect
RELEASED RELEASED SUCCEEDED,GRASP_CANCELED 0 no: hold; open; cancel
RELEASED RELEASED SUCCEEDED,SUCCEEDED 0 no: hold; open; run 1
TAKEN_OVER TAKEN_OVER - 4e4 no: restart; measure 4e4
WAITING NO_RADIUS - 0 no: restart; measure 10
WAITING NO_RADIUS - 0 no: restart; measure 0
WAITING TAKEN_OVER - nan no: restart; run 0.04; unmeasured; run 20 0.02
RELEASED RELEASED - 0 no: restart; run 0.04; unmeasured; run 20; call release; sound; run 0.3
INACTIVE NOT_ACTIVE - 0 no: restart; run 0.04; unmeasured; run 20; call deactivate; sound; run 0.3
FAULT INTERNAL_ERROR - 0 no: restart; run 0.04; unmeasured; run 20; call fail broken; sound; run 0.3
WAITING TAKEN_OVER - nan no: restart; unmeasured; run 4.7
WAITING NO_RADIUS - 0 no: restart; unmeasured; run 5.04
WAITING TAKEN_OVER - nan no: restart; breaks fault=RegulatorFault.NAN; run 4.7
WAITING NO_RADIUS - 0 no: restart; breaks fault=RegulatorFault.NAN; run 5.04
WAITING TAKEN_OVER - nan no: restart; unmeasured; leap 10; run 0.02; leap 10; run 0.02; leap 10;
  run 0.02
WAITING TAKEN_OVER - nan no: restart; measure 2.5e5
WAITING TAKEN_OVER - nan no: restart; measure 101325
WAITING TAKEN_OVER - nan no: restart; measure -101325
WAITING TAKEN_OVER - nan no: restart; measure 0 6.275e4
WAITING TAKEN_OVER - nan no: restart; measure 0 0 0 0 0 6.275e4 6.275e4 6.275e4 6.275e4 6.275e4
TAKEN_OVER TAKEN_OVER - 4e4 no: restart; measure 2.5e5; measure 0 6.275e4; measure 4e4
HOLDING RADIUS_STALE - 3e4 held: vents; track; breaks fault=RegulatorFault.STUCK; cut;
  run 0.34 0.02; limit pressure_settle_time=1; run 0.4 0.02
WAITING NO_RADIUS - 0 no: restart; unmeasured; run 0.02; call offer_measured 100.1 4e4;
  call offer_measured 100.4 4e4; call offer_measured 100.5 9; call offer_measured 100.8 9; leap 0.8;
  run 0.02
WAITING TAKEN_OVER - nan no: restart; unmeasured; run 0.02; call offer_measured 100.1 4e4;
  call offer_measured 100.4 4e4; call offer_measured 100.5 9; leap 0.5; run 0.02
TRACKING NONE - 5e4 no: limit publish_rate=1 radius_timeout=9; track; leaks; tick 0.02 1;
  tick 0.02 1; tick 0.02 1
VENTED RADIUS_STALE - 0 no: limit publish_rate=1 radius_timeout_policy=TimeoutPolicy.VENT; track;
  tick none 1
GRASPING NONE RUNNING 6e4 held: unmeasured; grasp; run 0.7; heavy; run 0.18
GRASPING NONE SUCCEEDED 6e4 held: unmeasured; grasp; run 0.7; heavy; run 0.26
RELEASED RELEASED SUCCEEDED,GRASP_REPLACED,RELEASED,SUCCEEDED 0 no: hold; open; grasp; run 0.02;
  open; run 1
GRASPING NONE RUNNING 5e4 held: grasp; run 0.66
GRASPING NONE SUCCEEDED 5e4 held: grasp; run 0.7
GRASPING NONE RUNNING 5e4 held: track; grasp; run 0.02
GRASPING NONE SUCCEEDED 5e4 held: track; grasp; run 0.06
GRASPING NONE RUNNING 5e4 held: grasp; run 0.6; breaks pressure=4e4; run 0.16
GRASPING NONE SUCCEEDED 5e4 held: grasp; run 0.6; breaks pressure=4e4; run 0.22
GRASPING NONE RUNNING 5e4 held: limit pressure_tolerance=200; grasp; run 0.74
GRASPING NONE SUCCEEDED 5e4 held: limit pressure_tolerance=200; grasp; run 0.78
TRACKING NONE - 6.5e4 held: unknown; gravity recommended=1.3; track; gravity recommended=none; track
TRACKING NONE - 4.4e4 held: unknown; gravity recommended=1.3; track; gravity recommended=none;
  run 1 0.025
TRACKING NONE - 5.5e4 no: limit grip_ratio=1.1; give force=0; track
TRACKING NONE - 5.5e4 no: limit grip_ratio=1.1; give force=-1; track
TRACKING NONE - 5.5e4 held: limit grip_ratio=1.1; give force=1e-9; track
WAITING RADIUS_NOT_FINITE - 0 no: run 0.2 -inf
WAITING RADIUS_NOT_POSITIVE - 0 no: run 0.2 0
WAITING RADIUS_NOT_POSITIVE - 0 no: run 0.2 -0.02
WAITING RADIUS_TOO_SMALL - 0 no: run 0.2 0.009999999999999998
WAITING RADIUS_TOO_LARGE - 0 no: run 0.2 0.04000000000000001
HOLDING RADIUS_TOO_LARGE - 5e4 held: track; run 0.1 0.05
TRACKING NONE - 1e5 held: limit pressure_cap=2e5; run 1.5 0.01
TRACKING NONE - 2.5e4 held: run 1.5 0.04
TRACKING NONE - 5e4 held: run 0.02 nan; run 0.02 -1; run 0.02 0.2; track; run 0.02 nan; run 0.1 0.02
GRASPING NONE SUCCEEDED 5e4 no: hold; leap 1; run 1.9;
  breaks fault=RegulatorFault.STUCK pressure=0; run 1
RELEASED PRESSURE_LOW SUCCEEDED 0 no: hold; leap 1; run 1.5;
  breaks fault=RegulatorFault.STUCK pressure=0; run 1
GRASPING PRESSURE_CAP SUCCEEDED 5.2e4 held: grasp overpressure=5e3; run 2; limit pressure_cap=5.2e4
"""
# The reason, and the goal after some steps.
IMPOSSIBLE = """
RADIUS_TOO_LARGE: hold; grasp 0.2
PRESSURE_CAP: hold; grasp 0.0105
INVALID_REQUEST: grasp; run 0.2; grasp overpressure=nan
INVALID_REQUEST: grasp; run 0.2; grasp overpressure=-1
INVALID_REQUEST: grasp; run 0.2; grasp timeout=inf
INVALID_REQUEST: grasp; run 0.2; grasp timeout=-1
INVALID_REQUEST: grasp; run 0.2; grasp pressure=-1
INVALID_REQUEST: track; grasp timeout=0
INVALID_REQUEST: track; grasp pressure=1 overpressure=1
PRESSURE_CAP: grasp; run 0.2; grasp overpressure=1e308
PRESSURE_CAP: hold; grasp none pressure=1e308
NOT_CERTIFIED: uncertified; grasp
INVALID_REQUEST: gravity loss=1.3; track; grasp overpressure=1.51e4
PRESSURE_LOW: hold; leaks; run 1; grasp 0.03
NO_RADIUS: hold; grasp none
RADIUS_NOT_FINITE: track; run 0.1 nan; grasp none
RELEASED: call release; grasp none
TAKEN_OVER: restart; grasp
"""
# The reason why rearm is refused after some steps.
REARMED = """
NONE: run 0.1
NONE: track; call release
NONE: call fail broken
NONE: limit radius_timeout_policy=TimeoutPolicy.VENT; track; run 1
INVALID_REQUEST: track
INVALID_REQUEST: track; run 0.02 nan
INVALID_REQUEST: hold
INVALID_REQUEST: restart; measure 4e4
TAKEN_OVER: restart; unmeasured; run 1
NOT_ACTIVE: call deactivate
"""
# Of time, pressure, its age, fault, and the end; from before the ramp that the release ended, at a
# leak, at a failed sensor, until it is late (without evidence, with pressure), without any sensor.
RELEASES = """
0 500 0.08 NONE RUNNING; 0.02 5300 0 NONE RUNNING; 0.1 500 0.02 NONE SUCCEEDED
0 3e4 0.01 PRESSURE_LOW RUNNING; 0.02 2e4 0 PRESSURE_LOW RUNNING; 0.3 200 0 PRESSURE_LOW SUCCEEDED
0 -1e5 0.01 PRESSURE_LOW RUNNING; 0.02 -1e5 0 PRESSURE_LOW PRESSURE_LOW
2.9 0 4 NONE RUNNING; 3.1 0 4.2 NONE PRESSURE_LOST
2.9 3e4 0 NONE RUNNING; 3.1 3e4 0 NONE PRESSURE_HIGH
0.1 3e4 4 PRESSURE_LOST PRESSURE_LOST
0.29 none 0 NONE RUNNING; 0.31 none 0 NONE SUCCEEDED
"""
# The end of a release at its timeout, and after it, while the clock stands still.
STANDSTILLS = """
RUNNING PRESSURE_LOST: unmeasured; grasp; run 2
RUNNING PRESSURE_HIGH: hold
SUCCEEDED SUCCEEDED: run 0.1
"""
# State and reason: what must not be silent.
SILENCES = """
VENTED RADIUS_STALE: limit radius_timeout=0.5 radius_timeout_policy=TimeoutPolicy.VENT
RELEASED CLIENT_LOST: limit keep_alive_timeout=0.5
FAULT GRAVITY_STALE: limit gravity_timeout=0.5 gravity_timeout_policy=FaultPolicy.VENT
"""


@pytest.mark.parametrize("row", rows(COURSES))
def test_a_course_ends_as_it_should_and_stays_so(bench, row):
    expected, steps = row.split(": ")
    *states, pressure, held = expected.split()
    bench.follow(steps)
    commands = bench.run(0.2)
    seen, silent = bench.seen, bench.control.is_silent
    assert commands == [None if silent else pytest.approx(float(pressure))] * 10
    ends = ",".join(map(ending, bench.goals)) or "-"
    assert [seen.state.name, seen.refusal.reason.name, ends] == states
    assert bool(seen.refusal.text) is (seen.refusal.reason is not Reason.NONE)
    assert seen.wrapped is (held == "held")
    assert silent is (pressure == "nan")
    if seen.state is State.GRASPING:
        assert seen.refused[Reason.RADIUS_NOT_FINITE] == 0


@pytest.mark.parametrize("row", rows(REARMED))
def test_rearm_says_why_it_changes_nothing_unless_0_pa_is_commanded(bench, row):
    reason, steps = row.split(": ")
    bench.follow(steps)
    refusal = bench.control.rearm()
    before, commands = bench.seen, bench.run(0.1)
    assert (refusal.reason.name if refusal else "NONE") == reason
    if not bench.control.is_silent:
        assert set(commands) == {before.pressure_command if refusal else 0.0}
    bench.run(1.0, 0.02)
    assert refusal or bench.state is State.TRACKING


@pytest.mark.parametrize("row", rows(IMPOSSIBLE))
def test_a_goal_that_cannot_be_is_refused_and_changes_nothing(bench, row):
    reason, steps = row.split(": ")
    steps, _, last = steps.rpartition("; ")
    bench.follow(steps)
    before, goals = bench.seen, bench.goals[:]
    assert ending(bench.follow(last)) == reason
    assert bench.seen == before
    bench.run(3.0)
    assert {*map(ending, goals)} <= {"SUCCEEDED"}


def test_a_continually_tilting_arm_does_not_keep_a_grasp_from_being_reached(bench):
    grasp = bench.grasp()
    for step in range(100):
        bench.follow(f"gravity product={1.0e3 + 0.2 * step}; run {TICK}")
    assert ending(grasp) == "SUCCEEDED"


def test_a_stream_that_stops_or_turns_bad_is_stale_at_its_time_out(bench):
    bench.follow("track; run 1 nan")
    refused = {Reason.RADIUS_STALE: 1, Reason.RADIUS_NOT_FINITE: 50}
    assert bench.seen.accepted == 75
    assert bench.seen.refused == refused
    assert "last refused: object_radius must be" in bench.seen.refusal.text
    bench.control.activate()
    assert bench.seen.accepted == 0
    assert bench.seen.refused == {}


@pytest.mark.parametrize("course", rows(RELEASES))
def test_a_release_is_done_by_what_is_measured_after_it_began(course):
    release = Release(ReleaseGoal(), 10.0, LIMITS)
    for row in course.split("; "):
        time, pressure, age, fault, expected = map(value, row.split())
        told = {"measured_pressure": pressure, "is_measured": pressure is not None}
        told["measured_age"] = None if pressure is None else age
        told["pressure_fault"] = Refusal(Reason[fault], "a fault")
        release.update(10.0 + time, snapshot(State.RELEASED, **told))
        assert release.report.elapsed == pytest.approx(time)
        assert release.report.progress == 1.0
        assert ending(release) == expected


@pytest.mark.parametrize("row", rows(STANDSTILLS))
def test_a_release_ends_by_real_time_where_its_clock_stands_still(bench, row):
    *expected, steps = re.split(": | ", row, maxsplit=2)
    bench.follow(f"{steps}; open 2")
    found = []
    for real_time in (50.0, 52.0, 52.1):
        bench.control.stand_still(real_time)
        found.append(ending(bench.goals[-1]))
    assert [found[1], found[2]] == expected
    assert ("clock stands still" in bench.goals[-1].report.refusal.text) is (found[1] == "RUNNING")


def test_a_clock_that_goes_on_begins_a_release_s_standstill_anew(bench):
    bench.follow("hold; breaks fault=RegulatorFault.STUCK pressure=5e4; open 5")
    ends = []
    for times in ((100.0,), (106.0, 110.9, 111.1)):
        for real_time in times:
            bench.control.stand_still(real_time)
            ends.append(ending(bench.goals[-1]))
        bench.run(0.2)
    assert ends == ["RUNNING", "RUNNING", "RUNNING", "PRESSURE_HIGH"]


@pytest.mark.parametrize("row", rows(SILENCES))
def test_silence_vents_but_a_stall_is_no_silence_of_what_has_come_meanwhile(bench, row):
    states, steps = row.split(": ")
    bench.follow(f"limit radius_timeout=600; {steps}")

    def speak():
        bench.radius(0.02)
        bench.control.keep_alive(bench.now)
        bench.hear()

    for _ in range(100):
        speak()
        bench.tick()
    for _ in range(3):  # the timer comes first, then what has waited
        assert bench.follow("leap 1.2; tick") == WRAP
        speak()
    assert bench.run(0.48)[-1] == WRAP
    assert bench.run(0.04)[-1] == 0.0
    assert [bench.state.name, bench.reason.name] == states.split()


def test_gravity_grows_stale_and_is_reported(bench):
    bench.follow("limit gravity_timeout=2; track; hear 0.5")
    bench.follow("call deactivate; leap 1; call activate; run 0.02")
    assert bench.seen.gravity_age == pytest.approx(1.5, abs=2.0 * TICK)  # as old as it is
    assert bench.seen.gravity_fault.reason is Reason.NONE
    bench.follow("run 1 0.02")
    assert bench.seen.gravity_fault.reason is Reason.GRAVITY_STALE
    assert (bench.seen.fault, bench.reason) == (bench.seen.gravity_fault, Reason.NONE)
    bench.follow("call forget_gravity; run 0.02")
    assert bench.seen.gravity_fault.reason is Reason.NONE
    assert bench.seen.gravity_age is None


@pytest.mark.parametrize("stall", [0.3, 0.42, 0.49, 0.6, 1.5])
@pytest.mark.parametrize("begun", [0.0, TICK, 0.3, 1.5])
@pytest.mark.parametrize("is_goal", [False, True])
def test_what_the_adapters_watchdog_has_let_go_is_not_held(bench, stall, begun, is_goal):
    """Nothing is measured: a stalled node knows only how long it has commanded nothing."""
    watch = CommandWatch(pressure_limit=1.0e5, timeout=WATCHDOG_TIMEOUT)

    def run(duration, radius=None):
        for _ in range(round(duration / TICK)):
            command = bench.tick(radius)
            watch.offer(bench.now, command)
            assert watch.demand(bench.now) == command

    bench.follow("unmeasured")
    run(1.0)
    if is_goal:
        bench.grasp()
    run(begun, None if is_goal else 0.02)
    bench.leap(stall)
    run(4.0, None if is_goal else 0.02)
    assert not watch.is_latched
    assert bench.seen.wrapped or ending(bench.goals[0]) in ("PRESSURE_LOW", "SUCCEEDED")


@drawn(readings=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=2))
def test_inner_time_never_runs_backwards_and_never_ends(readings):
    clock = MonotonicClock()
    for before, after in pairwise([*map(clock.advance, readings), clock.advance(0.0)]):
        assert 0.0 <= after - before <= LONGEST_LEAP * (1.0 + 1e-9)
    assert clock.advance(0.02) - after == pytest.approx(0.02, abs=1e-6)
    for bad in (math.nan, math.inf):
        with pytest.raises(InvalidInputError, match="now"):
            clock.advance(bad)
