# SPDX-License-Identifier: Apache-2.0
"""The smoke test: how it judges, and the whole of it as people start it, well and with faults."""

import json
import math
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from ros.harness import START_DEADLINE

from spiral_gripper.doctor.checks import Mark
from spiral_gripper_ros.smoke.verdict import HELD, SmokeRecord, verdicts

COMMAND = [sys.executable, "-c", "from spiral_gripper.cli.main import main; main()", "smoke"]
GRASPED = ("status", "object", "measured", "shape")


def good_record():
    return SmokeRecord(
        pressure_max=1.1e5,
        active_after=2.0,
        radius=0.02,
        wrapped_after=1.0,
        says_wrapped=True,
        grip=HELD,
        command=5.5e4,
        measured=5.49e4,
        poses=((0.1, 0.0, 0.0),) * 50,
        commands=[0.0, 5.5e4, 0.0],
        measured_at_end=100.0,
        vented_after=0.5,
        exit_codes={"node": 0, "simulator": 0},
    )


def marks_of(record):
    return {a.name.removeprefix("smoke."): a.finding.mark for a in verdicts(record)}


def run(*arguments):
    return subprocess.run(
        [*COMMAND, *arguments],
        capture_output=True,
        text=True,
        timeout=2 * START_DEADLINE,
        check=False,
    )


def processes_of(command):
    """Return the ids of the processes whose command line names a run's namespace."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            text = entry.read_bytes()
        except OSError:  # ended in the meantime
            continue
        if f"spiral_gripper_smoke_{command.pid}".encode() in text:
            found.append(entry.parent.name)
    return found


def test_what_should_happen_is_well():
    assert set(marks_of(good_record()).values()) == {Mark.OK}


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"active_after": None}, "start"),
        ({"wrapped_after": None}, "grasp"),
        ({"says_wrapped": False}, "status"),
        ({"grip": "overhang"}, "object"),
        ({"grip": ""}, "object"),
        ({"measured": 4.0e4}, "measured"),
        ({"measured": None}, "measured"),
        ({"measured": math.nan}, "measured"),
        ({"measured": 0.0, "command": 0.0}, "measured"),
        ({"poses": ()}, "shape"),
        ({"poses": ((math.nan, 0.0, 0.0),) * 50}, "shape"),
        ({"commands": []}, "commands"),
        ({"commands": [0.0, 1.2e5, 0.0]}, "commands"),
        ({"commands": [0.0, math.nan, 0.0]}, "commands"),
        ({"commands": [0.0, -1.0, 0.0]}, "commands"),
        ({"vented_after": None}, "release"),
        ({"measured_at_end": None}, "release"),
        ({"commands": [0.0, 5.5e4]}, "end"),
        ({"exit_codes": {"node": -9, "simulator": 0}}, "end"),
        ({"exit_codes": {}}, "end"),
    ],
)
def test_whatever_goes_wrong_is_one_problem(change, problem):
    record = good_record()
    for name, value in change.items():
        setattr(record, name, value)
    marks = marks_of(record)
    assert [name for name, mark in marks.items() if mark is Mark.PROBLEM] == [problem]
    skipped = {name for name, mark in marks.items() if mark is Mark.SKIPPED}
    expected = {
        "start": {"grasp", *GRASPED, "release", "commands"},
        "grasp": {*GRASPED},
    }
    assert skipped == expected.get(problem, set())


def test_why_something_failed_is_said():
    record = good_record()
    record.wrapped_after, record.answer = None, "a leak"
    record.measured_at_end, record.release_answer = None, "release does not answer"
    texts = {answer.name: answer.finding.text for answer in verdicts(record)}
    assert texts["smoke.grasp"] == "a leak"
    assert texts["smoke.release"] == "release does not answer"


def test_a_grasp_of_real_processes_goes_well():
    done = run()
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stderr == ""
    assert "all well: 9 checks" in done.stdout
    assert "grasping 21.2 mm: " in done.stdout
    assert "\x1b" not in done.stdout


@pytest.mark.slow
def test_a_leak_is_noticed_and_said():
    done = run("prototype_p1", "--fault", "leak", "--json")
    assert done.returncode == 1, done.stdout + done.stderr
    document = json.loads(done.stdout)
    found = {check["name"]: check for check in document["checks"]}
    assert found["smoke.grasp"]["mark"] == "problem"
    assert "leak" in found["smoke.grasp"]["text"]
    assert found["smoke.status"]["mark"] == "skipped"
    assert found["smoke.end"]["mark"] == "ok"
    assert any("leak" in line for line in document["log"])


@pytest.mark.slow
def test_a_lost_link_is_noticed_though_the_node_cannot_know():
    done = run("--fault", "lost_link", "--json")
    assert done.returncode == 1, done.stdout + done.stderr
    marks = {check["name"]: check["mark"] for check in json.loads(done.stdout)["checks"]}
    assert marks["smoke.grasp"] == "ok"
    assert marks["smoke.object"] == marks["smoke.measured"] == marks["smoke.release"] == "problem"


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)]
)
def test_a_stop_signal_ends_everything(number):
    with subprocess.Popen(
        COMMAND, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1
    ) as command:
        try:
            for line in command.stdout:
                if line.startswith("node active"):
                    break
            assert processes_of(command)
            os.kill(command.pid, number)
            _, errors = command.communicate(timeout=START_DEADLINE)
        finally:
            command.kill()
    assert errors.splitlines()[-1] == "spiral-gripper: interrupted"
    assert command.returncode == 2
    assert processes_of(command) == []


def test_a_gripper_that_does_not_exist_starts_nothing():
    done = run("no_such_gripper")
    assert done.returncode == 2
    assert done.stdout == ""
    assert "no_such_gripper" in done.stderr
