# SPDX-License-Identifier: Apache-2.0
from collections import Counter

import pytest

from spiral_gripper_ros.control.limits import AbortPolicy, FaultPolicy, Limits, TimeoutPolicy
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State
from spiral_gripper_ros.runtime.event_log import BURST, PERIOD, EventLog


class Notes:
    """A logger that can be read."""

    def __init__(self):
        self.lines = []

    def info(self, text):
        self.lines.append(("info", text))

    def warning(self, text):
        self.lines.append(("warning", text))

    def error(self, text):
        self.lines.append(("error", text))


def snapshot(state, refusal=NOT_REFUSED, **fields):
    nothing = {
        "radius": None,
        "plan": None,
        "radius_age": None,
        "pressure_target": 0.0,
        "pressure_command": 0.0,
        "accepted": 0,
        "refused": Counter(),
    }
    return Snapshot(state=state, refusal=refusal, **{**nothing, **fields})


def told(*snapshots, period=10.0):
    notes = Notes()
    log = EventLog(notes)
    for i, one in enumerate(snapshots):
        log.tell(i * period, one)
    return notes.lines


JUMP = Refusal(Reason.RADIUS_JUMP, "object_radius 0.03 m is far away")
TRACKING = snapshot(State.TRACKING, radius=0.02, pressure_target=6.2e4)


def test_each_change_is_told_once():
    lines = told(TRACKING, TRACKING, snapshot(State.HOLDING, JUMP), snapshot(State.HOLDING, JUMP))
    assert lines == [
        ("info", "following object_radius, radius 20 mm, target 62 kPa"),
        ("warning", "holding at 0 kPa: object_radius 0.03 m is far away"),
    ]


def test_radii_that_are_followed_are_not_told_one_by_one():
    other = snapshot(State.TRACKING, radius=0.021, pressure_target=6.0e4)
    assert len(told(TRACKING, other, TRACKING, other)) == 1


def test_each_grasp_is_told():
    grasps = [snapshot(State.GRASPING, radius=r, pressure_target=6.0e4) for r in (0.02, 0.03)]
    assert [text for _, text in told(*grasps)] == [
        "grasping, radius 20 mm, target 60 kPa",
        "grasping, radius 30 mm, target 60 kPa",
    ]


@pytest.mark.parametrize(
    ("state", "reason", "level"),
    [
        (State.WAITING, Reason.NO_RADIUS, "info"),
        (State.RELEASED, Reason.RELEASED, "info"),
        (State.RELEASED, Reason.RECONFIGURED, "info"),
        (State.RELEASED, Reason.WRAP_FAILED, "warning"),
        (State.VENTED, Reason.RADIUS_STALE, "warning"),
        (State.RAMPING_DOWN, Reason.RADIUS_STALE, "warning"),
        (State.FAULT, Reason.INTERNAL_ERROR, "error"),
        (State.FAULT, Reason.PRESSURE_LOW, "error"),
    ],
)
def test_the_level_says_who_must_act(state, reason, level):
    (found,) = told(snapshot(state, Refusal(reason, "because")))
    assert found[0] == level
    assert found[1].endswith(": because")


def test_every_state_has_words():
    for state in State:
        assert told(snapshot(state, JUMP))


def test_a_pressure_fault_and_its_end_are_told():
    leak = Refusal(Reason.PRESSURE_LOW, "measured_pressure 1 Pa stays below")
    lines = told(TRACKING, snapshot(State.TRACKING, pressure_fault=leak), TRACKING)
    assert lines[1:] == [
        ("error", "measured_pressure 1 Pa stays below"),
        ("info", "measured_pressure is as commanded again"),
    ]


def test_a_wrap_and_its_loss_are_told():
    held = snapshot(State.TRACKING, pressure_command=6.2e4, wrapped=True)
    lines = told(TRACKING, held, held, TRACKING)
    assert lines[1:] == [
        ("info", "the object is wrapped at 62 kPa"),
        ("info", "no object is wrapped any more"),
    ]


def test_a_chattering_state_is_told_at_a_bearable_rate_and_its_end_is_not_lost():
    notes = Notes()
    log = EventLog(notes)
    holding = snapshot(State.HOLDING, JUMP)
    for i in range(1000):
        log.tell(0.01 * i, TRACKING if i % 2 else holding)
    assert BURST <= len(notes.lines) <= BURST + 10.0 / PERIOD + 1
    jump = Refusal(Reason.RADIUS_TOO_LARGE, "too large")
    for i in range(200):
        log.tell(10.0 + 0.01 * i, snapshot(State.HOLDING, jump))
    assert "too large" in notes.lines[-1][1]


@pytest.mark.parametrize("state", [State.INACTIVE, State.RELEASED, State.FAULT])
def test_what_ends_the_chatter_for_good_is_told_at_once(state):
    notes = Notes()
    log = EventLog(notes)
    for i in range(1001):
        log.tell(0.0, TRACKING if i % 2 else snapshot(State.HOLDING, JUMP))
    log.tell(0.0, snapshot(state, Refusal(Reason.INTERNAL_ERROR, "the end")))
    assert "the end" in notes.lines[-1][1]


def test_a_clock_that_stops_and_runs_is_told():
    notes = Notes()
    log = EventLog(notes)
    for stands_still in (False, True, True, False):
        log.tell_clock(stands_still)
    assert [level for level, _ in notes.lines] == ["warning", "info"]


def test_a_loaded_gripper_is_told_with_its_range():
    notes = Notes()
    EventLog(notes).tell_range("p1", (0.01, 0.0412), 5.5e4)
    assert notes.lines == [("info", "p1: grips radii from 10 to 41.2 mm, with at most 55 kPa")]


def test_what_bounds_the_commands_is_told_at_activation():
    notes = Notes()
    limits = Limits(
        pressure_cap=8.0e4,
        pressure_rate_up=5.0e4,
        pressure_rate_down=3.0e5,
        grip_ratio=1.15,
        radius_timeout_policy=TimeoutPolicy.RAMP_DOWN,
        pressure_fault_policy=FaultPolicy.VENT,
        grasp_abort_policy=AbortPolicy.HOLD,
    )
    EventLog(notes).tell_limits(limits)
    expected = (
        "active: at most 80 kPa, 50 kPa/s up, 300 kPa/s down, grip.ratio 1.15; when radii stop: "
        "ramp_down, at a pressure fault: vent, when a grasp fails: hold"
    )
    assert notes.lines == [("info", expected)]


@pytest.mark.parametrize(("publishers", "warnings"), [(1, 0), (2, 1)])
def test_another_node_that_commands_the_same_regulator_is_told(publishers, warnings):
    notes = Notes()
    EventLog(notes).tell_others(publishers)
    assert [level for level, _ in notes.lines] == ["warning"] * warnings
