# SPDX-License-Identifier: Apache-2.0
"""The operator's log: each change once, at a bearable rate, at the level of who must act."""

from itertools import product
from types import SimpleNamespace

import pytest
from ros.control_bench import LIMITS, rows, snapshot
from ros.records import agrees

from spiral_gripper.files.storage import FileError
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.runtime.event_log import BURST, PERIOD, EventLog


@pytest.fixture
def log():
    """A log that can be read."""
    lines = []
    levels = ("info", "warning", "error")
    told = {one: lambda text, level=one: lines.append((level, text)) for one in levels}
    log = EventLog(SimpleNamespace(**told))
    log.lines = lines
    return log


TRACKING = snapshot(State.TRACKING, radius=0.02, pressure_target=6.2e4)
HOLDING = snapshot(State.HOLDING, Refusal(Reason.RADIUS_JUMP, "far away"))
# The log tells what is seen after each step; each change once.
COURSES = """
leap 0; run 0.5 0.02; run 1 0.02; run 1 0.0201; run 0.02 nan; run 0.1 0.02; leaks; run 1 0.02
sound; run 1 0.02; call release; run 1 0.02; call rearm; track; run 1; track; refused; hold
limit gravity_timeout=0.5; hear; run 1; hear; run 0.02
call deactivate; run 0.1; call activate; track; vents; unmeasured; run 1 0.02
call release reconfigured; run 1; restart; measure 4e4;
  call deactivate
"""


def test_the_log_of_a_course_is_that_on_record(log, bench):
    for step in "; ".join(rows(COURSES)).split("; "):
        bench.follow(step)
        log.lines.append((f"# {step}", ""))
        log.tell(bench.now, bench.seen)
    for i, (state, reason) in enumerate(product(State, (Reason.RADIUS_STALE, Reason.RECONFIGURED))):
        log.tell(bench.now + i, snapshot(state, Refusal(reason, "because")))
    for stands_still in (False, True, True, False):
        log.tell_clock(stands_still)
    for publishers in (1, 2, 2, 1):
        log.tell_others(publishers)
    log.tell_range("p1", (0.01, 0.0412), 5.5e4)
    log.tell_limits(LIMITS)
    for action in ("read", "used"):
        log.tell_nothing_beside(FileError("a.json", action, "what to do"))
    agrees("log", "\n".join(" ".join(line).strip() for line in log.lines))


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
