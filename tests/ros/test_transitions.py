# SPDX-License-Identifier: Apache-2.0
"""Every event in every state does what the table of docs/node.md says, and nothing else."""

from dataclasses import replace
from itertools import pairwise

import pytest
from ros.control_bench import FAILED, LIMITS, TICK

from spiral_core import WrapRegime
from spiral_gripper_ros.control.limits import AbortPolicy, TimeoutPolicy
from spiral_gripper_ros.control.refusals import RECONFIGURED
from spiral_gripper_ros.control.states import (
    TRANSITIONS,
    CommandRule,
    Event,
    Reason,
    Refusal,
    State,
)

WRAP, HELD = 5.0e4, 4.0e4  # at 20 mm, and taken over [Pa]
SLOW = replace(LIMITS, pressure_rate_down=2.0e4)
BAD = Refusal(Reason.GRAVITY_INVALID, "gravity must be finite")


def stop_the_stream(bench, policy):
    bench.control.reconfigure(replace(SLOW, radius_timeout_policy=policy))
    bench.run(LIMITS.radius_timeout + TICK)


def track(bench):
    assert bench.run(1.0, radius=0.02)[-1] == WRAP


def held(bench):
    track(bench)
    bench.control.refuse(BAD)


def ramp_down(bench):
    track(bench)
    stop_the_stream(bench, TimeoutPolicy.RAMP_DOWN)


def vent(bench):
    track(bench)
    stop_the_stream(bench, TimeoutPolicy.VENT)


def grasp(bench):
    """Start a grasp whose wrap nobody sees: it runs on."""
    bench.sees = lambda pressure, perfect: WrapRegime.OVERHANG
    bench.grasped = bench.grasp(abort_policy=AbortPolicy.HOLD, timeout=60.0)
    assert bench.run(1.0)[-1] == WRAP


def measure(bench):
    """Start again, and measure the same pressure for long enough."""
    bench.control.activate(take_over=True)
    bench.regulator.pressure = HELD
    for _ in range(14):
        bench.now += TICK
        bench.control.offer_measured(bench.now, HELD)
        bench.control.command(bench.now)


def hang(bench):
    """Let the node hang, and the regulator's watchdog vent meanwhile."""
    bench.now += 1.0
    bench.regulator.pressure, bench.regulator.latched = 0.0, True
    while not bench.seen.pressure_fault.text:
        bench.tick()


REACHED = {
    State.INACTIVE: lambda bench: bench.control.deactivate(),
    State.WAITING: lambda bench: None,
    State.TRACKING: track,
    State.HOLDING: held,
    State.RAMPING_DOWN: ramp_down,
    State.VENTED: vent,
    State.RELEASED: lambda bench: bench.control.release(RECONFIGURED),
    State.FAULT: lambda bench: bench.control.fail("boom"),
    State.GRASPING: grasp,
    State.TAKEN_OVER: measure,
}
HAPPENS = {
    Event.ACTIVATE: (lambda bench: bench.control.activate(), Reason.NO_RADIUS),
    Event.DEACTIVATE: (lambda bench: bench.control.deactivate(), Reason.NOT_ACTIVE),
    Event.RADIUS: (lambda bench: bench.radius(0.0201), Reason.NONE),
    Event.REFUSED: (lambda bench: bench.control.refuse(BAD), Reason.GRAVITY_INVALID),
    Event.STALE_HOLD: (
        lambda bench: stop_the_stream(bench, TimeoutPolicy.HOLD),
        Reason.RADIUS_STALE,
    ),
    Event.STALE_RAMP_DOWN: (
        lambda bench: stop_the_stream(bench, TimeoutPolicy.RAMP_DOWN),
        Reason.RADIUS_STALE,
    ),
    Event.STALE_VENT: (
        lambda bench: stop_the_stream(bench, TimeoutPolicy.VENT),
        Reason.RADIUS_STALE,
    ),
    Event.EMPTY: (lambda bench: bench.run(2.5), Reason.RADIUS_STALE),
    Event.AGREED: (measure, Reason.TAKEN_OVER),
    Event.GOAL: (lambda bench: bench.grasp(0.03), Reason.NONE),
    Event.ABORT_HOLD: (
        lambda bench: bench.control.cancel(bench.now, bench.grasped),
        Reason.GRASP_CANCELED,
    ),
    Event.RELEASE: (lambda bench: bench.control.release(), Reason.RELEASED),
    Event.WATCHDOG: (hang, Reason.PRESSURE_LOW),
    Event.FAULT: (lambda bench: bench.control.fail("broken"), Reason.INTERNAL_ERROR),
    Event.REARM: (lambda bench: bench.control.rearm(), Reason.NO_RADIUS),
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
    bench.grasped = None
    REACHED[state](bench)
    before, asked = bench.seen, len(bench.planner.asked)
    assert before.state is state
    act, reason = HAPPENS[event]
    answer = act(bench)
    if event is Event.REFUSED:
        assert bench.seen.refused[BAD.reason] == before.refused[BAD.reason] + 1
    if (state, event) not in TRANSITIONS:
        assert bench.state is state
        is_told = event is Event.REFUSED and state in (State.WAITING, State.HOLDING)
        assert bench.reason is (reason if is_told else before.refusal.reason)
        assert bench.seen.radius == before.radius
        assert len(bench.planner.asked) == asked
        if event is Event.GOAL:
            assert answer.reason is before.refusal.reason
        return
    new, rule = TRANSITIONS[state, event]
    assert (bench.state, bench.reason) == (new, reason)
    if bench.grasped is not None and event is not Event.ABORT_HOLD:
        why = Reason.GRASP_REPLACED if event is Event.GOAL else reason
        report = bench.grasped.report
        assert (report.outcome, report.refusal.reason) == (FAILED, why)
        assert report.plan.pressure == WRAP
    if rule is CommandRule.VENT:
        assert (bench.seen.pressure_command, bench.seen.radius) == (0.0, None)
        assert set(bench.run(1.0)) == {0.0}
    elif rule is CommandRule.KEEP:
        assert set(bench.run(0.4)) == {before.pressure_command or HELD}
    elif rule is CommandRule.RAMP_DOWN:
        commands = [bench.seen.pressure_command, *bench.run(0.2)]
        assert commands[0] > commands[-1]
        steps = [before - after for before, after in pairwise(commands)]
        assert steps == [pytest.approx(SLOW.pressure_rate_down * TICK)] * len(steps)
    else:
        bench.control.reconfigure(replace(LIMITS, radius_timeout=60.0))
        assert bench.tick() >= before.pressure_command - LIMITS.pressure_rate_down * TICK
        assert bench.run(1.0)[-1] == bench.seen.pressure_target > 0.0
        assert bench.state is new
