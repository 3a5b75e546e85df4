# SPDX-License-Identifier: Apache-2.0
"""Every event in every state does what the table of docs/node.md says, and nothing else."""

from itertools import pairwise

import pytest
from ros.control_bench import (
    FAILED,
    LIMITS,
    TICK,
    WRAP,
)

from spiral_gripper_ros.control.states import (
    TRANSITIONS,
    CommandRule,
    Event,
    Reason,
    State,
)

HELD = 4.0e4  # taken over [Pa]
SLOW = 2.0e4  # pressure_rate_down [Pa/s]
STALE = f"limit pressure_rate_down={SLOW} radius_timeout_policy=stale_{{}}; wait 0.52"
REACHED = {
    State.INACTIVE: "call deactivate",
    State.WAITING: "",
    State.TRACKING: "track",
    State.HOLDING: "track; refused",
    State.RAMPING_DOWN: f"track; {STALE.format('ramp')}",
    State.VENTED: f"track; {STALE.format('vent')}",
    State.RELEASED: "call release",
    State.FAULT: "call fail boom",
    # A wrap that nobody sees:
    State.GRASPING: "given sees=overhang; goal abort_policy=hold timeout=60; wait 1",
    State.TAKEN_OVER: f"measure {HELD}",
}
HAPPENS = {
    Event.ACTIVATE: "NO_RADIUS: call activate",
    Event.DEACTIVATE: "NOT_ACTIVE: call deactivate",
    Event.RADIUS: "NONE: offer 0.0201",
    Event.REFUSED: "GRAVITY_INVALID: refused",
    Event.STALE_HOLD: f"RADIUS_STALE: {STALE.format('hold')}",
    Event.STALE_VENT: f"RADIUS_STALE: {STALE.format('vent')}",
    Event.STALE_RAMP_DOWN: f"RADIUS_STALE: {STALE.format('ramp')}",
    Event.EMPTY: "RADIUS_STALE: wait 2.5",
    Event.AGREED: f"TAKEN_OVER: measure {HELD}",
    Event.GOAL: "NONE: goal 0.03",
    Event.ABORT_HOLD: "GRASP_CANCELED: cancel",
    Event.RELEASE: "RELEASED: call release",
    Event.WATCHDOG: "PRESSURE_LOW: hang; notice",
    Event.FAULT: "INTERNAL_ERROR: call fail broken",
    Event.REARM: "NO_RADIUS: call rearm",
}
# What cannot happen in every state: it needs a goal, a stream, a command or a node that starts.
ONLY_WHERE_LISTED = {
    Event.ACTIVATE,
    Event.AGREED,
    Event.EMPTY,
    Event.ABORT_HOLD,
    Event.WATCHDOG,
}
CASES = [
    (state, event)
    for state in State
    for event in Event
    if event not in ONLY_WHERE_LISTED or (state, event) in TRANSITIONS
]


@pytest.mark.parametrize(("state", "event"), CASES, ids=lambda value: value.name)
def test_every_event_in_every_state_does_what_the_table_says(bench, state, event):
    bench.follow(REACHED[state])
    before, asked, grasp = bench.seen, len(bench.planner.asked), bench.grasped
    assert before.state is state
    reason, steps = HAPPENS[event].split(": ")
    reason, answer = Reason[reason], bench.follow(steps)
    assert event is not Event.REFUSED or bench.seen.refused[reason] == before.refused[reason] + 1
    if (state, event) not in TRANSITIONS:
        is_told = event is Event.REFUSED and state in (State.WAITING, State.HOLDING)
        assert (bench.state, bench.seen.radius) == (state, before.radius)
        assert bench.reason is (reason if is_told else before.refusal.reason)
        assert len(bench.planner.asked) == asked
        if event is Event.GOAL:
            assert answer.reason is before.refusal.reason
        return
    new, rule = TRANSITIONS[state, event]
    assert (bench.state, bench.reason) == (new, reason)
    if state is State.GRASPING and event is not Event.ABORT_HOLD:
        report, why = grasp.report, Reason.GRASP_REPLACED if event is Event.GOAL else reason
        assert (report.outcome, report.refusal.reason) == (FAILED, why)
        assert report.plan.pressure == WRAP
    if rule is CommandRule.VENT:
        assert (bench.seen.pressure_command, bench.seen.radius) == (0.0, None)
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
