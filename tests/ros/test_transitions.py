# SPDX-License-Identifier: Apache-2.0
"""Every event in every state does what the table of docs/node.md says, and nothing else."""

from itertools import pairwise, product

import pytest
from ros.control_bench import TICK, Bench, ending, rows
from ros.records import agrees

from spiral_gripper_ros.control.states import TRANSITIONS, CommandRule, Event, State

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
ACTIVATE: call activate
DEACTIVATE: call deactivate
RADIUS: radius 0.021
REFUSED: refused
STALE_HOLD: stale HOLD
STALE_VENT: stale VENT
STALE_RAMP_DOWN: stale RAMP_DOWN
EMPTY: run 2.5
AGREED: restart; measure 4e4
GOAL: grasp 0.03
ABORT_HOLD: cancel
RELEASE: call release
WATCHDOG: hang; run 0.42
FAULT: call fail broken
REARM: call rearm
"""
# What cannot happen in every state: it needs a goal, a stream, a command or a node that starts.
ONLY_WHERE_LISTED = "ACTIVATE AGREED EMPTY ABORT_HOLD WATCHDOG"


def stale(steps):
    """Write out the steps to a stream that is stale."""
    limits = f"limit pressure_rate_down={SLOW} radius_timeout_policy=TimeoutPolicy."
    return steps.replace("stale ", limits) + "; run 0.52" * ("stale" in steps)


def is_ruled(rule, commands, target):
    """Return whether commands one after the other are as a rule says; without one, as before."""
    if rule is CommandRule.VENT:
        return set(commands) == {0.0}
    falls = [a - b for a, b in pairwise(commands[:10])]
    if rule is CommandRule.TARGET:
        return abs(commands[-1] - target) <= abs(commands[0] - target) <= target != 0.0
    return falls == pytest.approx([SLOW * TICK * (rule is CommandRule.RAMP_DOWN)] * 9)


def test_every_event_in_every_state_does_what_the_table_says():
    """Reason, radius, count of refusals, ends of goals, commands before and after are on record."""
    found = []
    for reached, happens in product(rows(REACHED), rows(HAPPENS)):
        (name, way), (event, steps) = reached.split(": "), happens.split(": ")
        state, key = State[name], (State[name], Event[event])
        if event in ONLY_WHERE_LISTED and key not in TRANSITIONS:
            continue
        bench = Bench()
        bench.follow(stale(way))
        before, asked = bench.seen, len(bench.planner.asked)
        assert before.state is state
        bench.follow(stale(steps))
        seen, ends = bench.seen, ",".join(map(ending, bench.goals))
        new, rule = TRANSITIONS.get(key, (state, None))
        commands = [seen.pressure_command, *bench.run(0.4)]
        assert seen.state is new
        assert rule is None or is_ruled(rule, commands, seen.pressure_target), (reached, happens)
        assert rule or (len(bench.planner.asked), seen.radius) == (asked, before.radius)
        words = new.name, seen.refusal.reason.name, seen.radius, seen.refused.total(), ends
        pressures = " ".join(f"{one:.7g}" for one in (before.pressure_command, *commands[::10]))
        found.append(f"{name} {event}: {' '.join(map(str, words))} {pressures}")
    agrees("transitions", "\n".join(found))
