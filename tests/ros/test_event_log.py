# SPDX-License-Identifier: Apache-2.0
"""The operator's log: each change once, at a bearable rate, at the level of who must act."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from ros.control_bench import LIMITS, snapshot

from spiral_gripper.files.storage import FileError
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.runtime.event_log import BURST, PERIOD, EventLog


@pytest.fixture
def log():
    """A log that can be read."""
    lines = []
    levels = {
        level: lambda text, level=level: lines.append((level, text))
        for level in ("info", "warning", "error")
    }
    log = EventLog(SimpleNamespace(**levels))
    log.lines = lines
    return log


JUMP = Refusal(Reason.RADIUS_JUMP, "far away")
LEAK = Refusal(Reason.PRESSURE_LOW, "measured_pressure stays below")
TRACKING = snapshot(State.TRACKING, radius=0.02, pressure_target=6.2e4)
HOLDING = snapshot(State.HOLDING, JUMP)
WRAPPED = replace(TRACKING, wrapped=True, pressure_command=6.2e4)


def test_each_change_is_told_once(log):
    leaking = replace(TRACKING, pressure_fault=LEAK)
    moved = replace(TRACKING, radius=0.021)
    course = (TRACKING, moved, HOLDING, HOLDING, leaking, WRAPPED, WRAPPED, TRACKING)
    for i, one in enumerate(course):
        log.tell(10.0 * i, one)
    assert log.lines == [
        ("info", "following object_radius, radius 20 mm, target 62 kPa"),
        ("warning", "holding at 0 kPa: far away"),
        ("info", "following object_radius, radius 20 mm, target 62 kPa"),
        ("error", LEAK.text),
        ("info", "measured_pressure is as commanded again"),
        ("info", "the object is wrapped at 62 kPa"),
        ("info", "no object is wrapped any more"),
    ]


@pytest.mark.parametrize("state", State)
def test_the_level_says_who_must_act(log, state):
    for i, reason in enumerate((Reason.RADIUS_STALE, Reason.RECONFIGURED)):
        log.tell(i, snapshot(state, Refusal(reason, "because")))
    levels = ["error"] * 2 if state is State.FAULT else ["warning", "info"]
    assert [level for level, text in log.lines if text.endswith(": because")] == levels


def test_a_chattering_state_is_told_at_a_bearable_rate_and_its_end_is_not_lost(log):
    for i in range(1000):
        log.tell(0.01 * i, TRACKING if i % 2 else HOLDING)
    assert BURST <= len(log.lines) <= BURST + 10.0 / PERIOD + 1
    end = Refusal(Reason.PRESSURE_CAP, "the end")
    for state in (State.INACTIVE, State.RELEASED, State.FAULT, State.HOLDING):
        log.tell(10.0, snapshot(state, end))
    # What ends the chatter for good is told at once.
    assert len([text for _, text in log.lines if "the end" in text]) == 3
    log.tell(10.0 + PERIOD, snapshot(State.HOLDING, end))
    assert log.lines[-1] == ("warning", "holding at 0 kPa: the end")


def test_clock_range_limits_and_other_commanders_are_told(log):
    for stands_still in (False, True, True, False):
        log.tell_clock(stands_still)
    for publishers in (1, 2, 2, 1):
        log.tell_others(publishers)
    log.tell_range("p1", (0.01, 0.0412), 5.5e4)
    log.tell_limits(LIMITS)
    for action in ("read", "used"):
        log.tell_nothing_beside(FileError("a.json", action, "what to do"))
    levels, texts = zip(*log.lines, strict=True)
    assert levels == ("warning", "info", "warning", "info", "info", "info", "warning")
    assert "from 10 to 41.2 mm, with at most 55 kPa" in texts[3]
    assert "at most 90 kPa, 100 kPa/s up, 200 kPa/s down, grip.ratio 1;" in texts[4]
    assert all(text.endswith(": what to do") for text in texts[5:])
