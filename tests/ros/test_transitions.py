# SPDX-License-Identifier: Apache-2.0
"""Every event in every state does what the table of docs/node.md says, and nothing else."""

from itertools import pairwise

import pytest
from ros.control_bench import LIMITS, TICK, WRAP, ending, rows

from spiral_gripper_ros.control.states import TRANSITIONS, CommandRule, Event, Reason, State

HELD = 4.0e4  # taken over [Pa]
SLOW = 2.0e4  # pressure_rate_down [Pa/s]
REACHED = """
INACTIVE: call deactivate
WAITING: run 0
TRACKING: track
HOLDING: track; refused
RAMPING_DOWN: track; stale RAMP_DOWN
VENTED: track; stale VENT
RELEASED: call release
FAULT: call fail boom
GRASPING: give sees=WrapRegime.OVERHANG; grasp abort_policy=AbortPolicy.HOLD timeout=60; run 1
TAKEN_OVER: restart; measure 4e4
"""
HAPPENS = """
ACTIVATE NO_RADIUS: call activate
DEACTIVATE NOT_ACTIVE: call deactivate
RADIUS NONE: radius 0.021
REFUSED GRAVITY_INVALID: refused
STALE_HOLD RADIUS_STALE: stale HOLD
STALE_VENT RADIUS_STALE: stale VENT
STALE_RAMP_DOWN RADIUS_STALE: stale RAMP_DOWN
EMPTY RADIUS_STALE: run 2.5
AGREED TAKEN_OVER: restart; measure 4e4
GOAL NONE: grasp 0.03
ABORT_HOLD GRASP_CANCELED: cancel
RELEASE RELEASED: call release
WATCHDOG PRESSURE_LOW: hang; run 0.42
FAULT INTERNAL_ERROR: call fail broken
REARM NO_RADIUS: call rearm
"""
# What cannot happen in every state: it needs a goal, a stream, a command or a node that starts.
ONLY_WHERE_LISTED = "ACTIVATE AGREED EMPTY ABORT_HOLD WATCHDOG"


def stale(steps):
    """Write out the steps to a stream that is stale."""
    limits = f"limit pressure_rate_down={SLOW} radius_timeout_policy=TimeoutPolicy."
    return steps.replace("stale ", limits) + "; run 0.52" * ("stale" in steps)


@pytest.mark.parametrize("happens", rows(HAPPENS))
@pytest.mark.parametrize("reached", rows(REACHED))
def test_every_event_in_every_state_does_what_the_table_says(bench, reached, happens):
    state, way = reached.split(": ")
    (event, reason), steps = happens.split(": ")[0].split(), happens.split(": ")[1]
    state, event, reason = State[state], Event[event], Reason[reason]
    if event.name in ONLY_WHERE_LISTED and (state, event) not in TRANSITIONS:
        return
    bench.follow(stale(way))
    before, asked = bench.seen, len(bench.planner.asked)
    assert before.state is state
    answer = bench.follow(stale(steps))
    assert event is not Event.REFUSED or bench.seen.refused[reason] == before.refused[reason] + 1
    assert event is not Event.RADIUS or answer is ((state, event) in TRANSITIONS)
    if (state, event) not in TRANSITIONS:
        is_told = event is Event.REFUSED and state in (State.WAITING, State.HOLDING)
        assert bench.state == state
        assert bench.seen.radius == before.radius
        assert bench.reason is (reason if is_told else before.refusal.reason)
        assert len(bench.planner.asked) == asked
        if event is Event.GOAL:
            assert answer.reason is before.refusal.reason
        return
    new, rule = TRANSITIONS[state, event]
    assert bench.state == new
    assert bench.reason == reason
    if state is State.GRASPING and event is not Event.ABORT_HOLD:
        assert ending(bench.goals[0]) == ("GRASP_REPLACED" if event is Event.GOAL else reason.name)
        assert bench.goals[0].report.plan.pressure == WRAP
    if rule is CommandRule.VENT:
        assert bench.seen.pressure_command == 0.0
        assert bench.seen.radius is None
        assert set(bench.run(1.0)) == {0.0}
    elif rule is CommandRule.KEEP:
        assert set(bench.run(0.4)) == {before.pressure_command or HELD}
    elif rule is CommandRule.RAMP_DOWN:
        falls = [a - b for a, b in pairwise([bench.seen.pressure_command, *bench.run(0.2)])]
        assert falls == [pytest.approx(SLOW * TICK)] * 10
    else:
        bench.follow(f"limit pressure_rate_down={LIMITS.pressure_rate_down} radius_timeout=60")
        assert bench.tick() >= before.pressure_command - LIMITS.pressure_rate_down * TICK
        assert bench.run(1.0)[-1] == bench.seen.pressure_target > 0.0
        assert bench.state is new
