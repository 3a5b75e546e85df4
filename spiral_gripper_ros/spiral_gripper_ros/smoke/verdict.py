# SPDX-License-Identifier: Apache-2.0
"""The messages that the smoke test received, compared with the expected ones. No ROS."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from spiral_gripper.doctor.checks import Answer, Finding, Mark
from spiral_gripper.files.shown import shown
from spiral_gripper_ros.simulation.simulated_gripper import Grip

SECTION = "Smoke"
# What the measured pressure may be off by when it has settled [Pa]: twice what the node tolerates
# while it moves.
PRESSURE_TOLERANCE = 2.0e3
# A gripper is vented below this gauge pressure [Pa].
VENTED = 500.0
HELD = Grip.PERFECT_WRAP.value
FEWEST_POSES = 10


@dataclass(slots=True)
class SmokeRecord:
    """The events of one run; None: it did not happen.

    Attributes:
        pressure_max: what no command may exceed [Pa].
        active_after: time from the start until the node was active and the object heard of [s].
        radius: of the simulated object [m].
        wrapped_after: time from the goal until the wrap was reached [s].
        answer: what the node said at the end of the goal, or why it did not accept it.
        says_wrapped: whether the node's status says that the object is held.
        grip: how the simulated gripper really holds it.
        command: at the end of the goal [Pa].
        measured: then [Pa].
        poses: of the newest backbone: their positions [m].
        commands: all of them [Pa].
        measured_at_end: measured when the release was over [Pa].
        vented_after: time from the release until the gripper was vented [s].
        release_answer: why the release was not answered.
        exit_codes: of the processes, by what they are.
    """

    pressure_max: float
    active_after: float | None = None
    radius: float | None = None
    wrapped_after: float | None = None
    answer: str = ""
    says_wrapped: bool = False
    grip: str = ""
    command: float | None = None
    measured: float | None = None
    poses: tuple[tuple[float, float, float], ...] = ()
    commands: list[float] = field(default_factory=list)
    measured_at_end: float | None = None
    vented_after: float | None = None
    release_answer: str = ""
    exit_codes: dict[str, int | None] = field(default_factory=dict)


def verdicts(record: SmokeRecord) -> list[Answer]:
    """Return what was expected and what came, one answer each, in the order of events."""
    marks: dict[str, Mark] = {}
    answers = []
    for name, title, judge, needs in _EXPECTATIONS:
        if any(marks[need] in (Mark.PROBLEM, Mark.SKIPPED) for need in needs):
            finding = Finding(Mark.SKIPPED, f"not checked, because of {needs[-1]}")
        else:
            finding = judge(record)
        marks[name] = finding.mark
        answers.append(Answer(SECTION, f"smoke.{name}", title, finding, 0.0))
    return answers


def _start(record: SmokeRecord) -> Finding:
    if record.active_after is None:
        return Finding(Mark.PROBLEM, record.answer or "the node did not become active")
    return Finding(Mark.OK, f"node active and object there after {record.active_after:.1f} s")


def _grasp(record: SmokeRecord) -> Finding:
    if record.wrapped_after is None or record.radius is None:
        return Finding(Mark.PROBLEM, record.answer or "the goal did not end")
    return Finding(
        Mark.OK,
        f"object of {record.radius * 1e3:.1f} mm radius wrapped after {record.wrapped_after:.1f} s",
    )


def _status(record: SmokeRecord) -> Finding:
    if record.says_wrapped:
        return Finding(Mark.OK, "the node says that the object is held")
    return Finding(Mark.PROBLEM, "the node does not say that the object is held")


def _object(record: SmokeRecord) -> Finding:
    if record.grip == HELD:
        return Finding(Mark.OK, f"it is really in a {HELD}")
    return Finding(Mark.PROBLEM, f"it is not in a {HELD}, but: {record.grip or 'not heard of'}")


def _measured(record: SmokeRecord) -> Finding:
    if record.command is None or record.measured is None:
        return Finding(Mark.PROBLEM, "no measured pressure arrived")
    text = f"{_pressure(record.measured)} measured, {_pressure(record.command)} commanded"
    follows = abs(record.measured - record.command) <= PRESSURE_TOLERANCE
    return Finding(Mark.OK if follows and record.command > 0.0 else Mark.PROBLEM, text)


def _commands(record: SmokeRecord) -> Finding:
    if not record.commands:
        return Finding(Mark.PROBLEM, "no command arrived")
    limit = _pressure(record.pressure_max)
    bad = [p for p in record.commands if not 0.0 <= p <= record.pressure_max]
    if bad:
        return Finding(Mark.PROBLEM, f"{bad[0]:g} Pa was commanded, which is not in 0 to {limit}")
    largest = _pressure(max(record.commands))
    return Finding(Mark.OK, f"{len(record.commands)} of 0 to {largest}; the limit is {limit}")


def _shape(record: SmokeRecord) -> Finding:
    if len(record.poses) < FEWEST_POSES:
        return Finding(Mark.PROBLEM, f"a backbone of {len(record.poses)} poses")
    if not all(math.isfinite(x) for position in record.poses for x in position):
        return Finding(Mark.PROBLEM, "the backbone has positions that are not finite")
    tip = ", ".join(shown(c, "m", 3) for c in record.poses[-1])
    return Finding(Mark.OK, f"{len(record.poses)} finite poses, tip at {tip}")


def _release(record: SmokeRecord) -> Finding:
    if record.measured_at_end is None:
        text = record.release_answer or "no measured pressure arrived after it"
        return Finding(Mark.PROBLEM, text)
    measured = _pressure(record.measured_at_end)
    if record.vented_after is None:
        return Finding(Mark.PROBLEM, f"not vented: {measured} measured at the end")
    return Finding(Mark.OK, f"vented after {record.vented_after:.1f} s: {measured} measured")


def _end(record: SmokeRecord) -> Finding:
    codes = ", ".join(f"{name} {code}" for name, code in record.exit_codes.items())
    if any(code != 0 for code in record.exit_codes.values()) or not record.exit_codes:
        return Finding(Mark.PROBLEM, f"exit codes: {codes or 'none'}")
    if record.commands and record.commands[-1] != 0.0:
        return Finding(Mark.PROBLEM, f"the last command was {record.commands[-1]:g} Pa, not a vent")
    return Finding(Mark.OK, f"exit codes: {codes}; the last command was a vent")


def _pressure(pressure: float) -> str:
    return shown(pressure, "Pa")


# Name, title, judge, and the names of earlier ones without which it says nothing.
_EXPECTATIONS: tuple[tuple[str, str, Callable[[SmokeRecord], Finding], tuple[str, ...]], ...] = (
    ("start", "start", _start, ()),
    ("grasp", "grasp", _grasp, ("start",)),
    ("status", "status", _status, ("start", "grasp")),
    ("object", "simulated object", _object, ("start", "grasp")),
    ("measured", "measured pressure", _measured, ("start", "grasp")),
    ("shape", "shape", _shape, ("start", "grasp")),
    ("release", "release", _release, ("start",)),
    ("commands", "commands", _commands, ("start",)),
    ("end", "end", _end, ()),
)
