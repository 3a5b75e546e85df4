# SPDX-License-Identifier: Apache-2.0
"""The operator's log: each change once, at a bearable rate, at the level of who must act."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import pytest
from ros.control_bench import LIMITS, snapshot

from spiral_gripper.files.storage import FileError
from spiral_gripper_ros.control.limits import TimeoutPolicy
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.runtime.event_log import BURST, PERIOD, EventLog


class Log:
    """A log that can be read."""

    def __init__(self):
        self.lines = []
        levels = ("info", "warning", "error")
        self.log = EventLog(
            SimpleNamespace(**{level: partial(self.note, level) for level in levels})
        )

    def note(self, level, text):
        self.lines.append((level, text))


@pytest.fixture
def log():
    return Log()


JUMP = Refusal(Reason.RADIUS_JUMP, "object_radius 0.03 m is far away")
TRACKING = snapshot(State.TRACKING, radius=0.02, pressure_target=6.2e4)
HOLDING = snapshot(State.HOLDING, JUMP)
LEAK = Refusal(Reason.PRESSURE_LOW, "measured_pressure 1 Pa stays below")
FOLLOWING = ("info", "following object_radius, radius 20 mm, target 62 kPa")


@pytest.mark.parametrize(
    ("snapshots", "lines"),
    [
        (
            [TRACKING, snapshot(State.TRACKING, radius=0.021), HOLDING, HOLDING],
            [FOLLOWING, ("warning", "holding at 0 kPa: object_radius 0.03 m is far away")],
        ),
        (
            [TRACKING, snapshot(State.TRACKING, pressure_fault=LEAK), TRACKING],
            [FOLLOWING, ("error", LEAK.text), ("info", "measured_pressure is as commanded again")],
        ),
        (
            [TRACKING, *[replace(TRACKING, wrapped=True, pressure_command=6.2e4)] * 2, TRACKING],
            [
                FOLLOWING,
                ("info", "the object is wrapped at 62 kPa"),
                ("info", "no object is wrapped any more"),
            ],
        ),
    ],
)
def test_each_change_is_told_once(log, snapshots, lines):
    for i, one in enumerate(snapshots):
        log.log.tell(10.0 * i, one)
    assert log.lines == lines


LEVELS = ["RELEASED RECONFIGURED info", "RELEASED WRAP_FAILED warning", "FAULT PRESSURE_LOW error"]
LEVELS += [f"{state.name} RADIUS_STALE warning" for state in set(State) - {State.FAULT}]


@pytest.mark.parametrize("row", sorted(LEVELS))
def test_the_level_says_who_must_act(log, row):
    state, reason, level = row.split()
    state, reason = State[state], Reason[reason]
    log.log.tell(0.0, snapshot(state, Refusal(reason, "because")))
    (found,) = log.lines
    assert found[0] == level
    assert found[1].endswith(": because")


def test_a_chattering_state_is_told_at_a_bearable_rate_and_its_end_is_not_lost(log):
    for i in range(1000):
        log.log.tell(0.01 * i, TRACKING if i % 2 else HOLDING)
    assert BURST <= len(log.lines) <= BURST + 10.0 / PERIOD + 1
    end = Refusal(Reason.PRESSURE_CAP, "the end")
    for state in (State.INACTIVE, State.RELEASED, State.FAULT, State.HOLDING):
        log.log.tell(10.0, snapshot(state, end))
    # What ends the chatter for good is told at once.
    assert len([text for _, text in log.lines if "the end" in text]) == 3
    log.log.tell(10.0 + PERIOD, snapshot(State.HOLDING, end))
    assert log.lines[-1] == ("warning", "holding at 0 kPa: the end")


def test_clock_range_limits_and_other_commanders_are_told(log):
    for stands_still in (False, True, True, False):
        log.log.tell_clock(stands_still)
    for publishers in (1, 2, 2, 1):
        log.log.tell_others(publishers)
    assert [level for level, _ in log.lines] == ["warning", "info", "warning"]
    log.log.tell_range("p1", (0.01, 0.0412), 5.5e4)
    log.log.tell_limits(replace(LIMITS, radius_timeout_policy=TimeoutPolicy.RAMP_DOWN))
    assert log.lines[3] == ("info", "p1: grips radii from 10 to 41.2 mm, with at most 55 kPa")
    for told in ("at most 90 kPa, 100 kPa/s up, 200 kPa/s down, grip.ratio 1;", "stop: ramp_down"):
        assert told in log.lines[4][1]
    for action in ("read", "used"):
        log.log.tell_nothing_beside(FileError("a.json", action, "what to do"))
    said = "a.json cannot be {}: what to do"
    assert log.lines[5:] == [("info", said.format("read")), ("warning", said.format("used"))]
