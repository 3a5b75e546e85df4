# SPDX-License-Identifier: Apache-2.0
"""The demo: what it plays, how it judges, and the whole of it as people start it."""

import math
import os
import re
import signal
import subprocess
import sys

import pytest
from ros.harness import DEADLINE
from ros.programs import start, wait_for_the_end_of

from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.tools import demo as run
from spiral_gripper_ros.tools.demo_report import EXPECTED_REFUSALS, DemoReport

COMMAND = [sys.executable, "-m", "spiral_gripper_ros.tools.demo"]


def test_the_stream_is_mostly_good_and_holds_every_kind_of_bad_radius():
    radii = [run.estimate(number, 0.03) for number in range(run.CYCLE)]
    finite = [radius for radius in radii if radius is not None and math.isfinite(radius)]
    good = [radius for radius in finite if abs(radius - 0.03) < 6.0 * run.NOISE]
    assert len(good) > 0.6 * run.CYCLE
    assert radii.count(None) > 0
    assert len(finite) + radii.count(None) < run.CYCLE  # NaN
    assert min(finite) < 0.0 < 0.05 < max(finite)


@pytest.mark.parametrize(
    ("spoil", "problems"),
    [
        (lambda r: None, []),
        (lambda r: r.refused.pop(Reason.RADIUS_JUMP), ["RADIUS_JUMP"]),
        (lambda r: r.wrapped.clear(), ["never wrapped"]),
        (lambda r: r.pressures.insert(1, math.nan), ["outside its limits"]),
        (lambda r: r.pressures.insert(1, 1.1e5), ["outside its limits"]),
        (lambda r: r.pressures.append(1.0), ["not a vent"]),
        (lambda r: r.pressures.clear(), ["not a vent"]),
    ],
)
def test_whatever_goes_wrong_is_a_problem_and_nothing_else(spoil, problems):
    report = DemoReport({"pipe": 0.03}, pressure_max=1.0e5)
    report.refused.update(EXPECTED_REFUSALS)
    report.pressures += [0.0, 4.0e4, 0.0]
    report.wrap(0.0301, 4.0e4)
    assert "  pipe, 30 mm: 40.00 kPa" in report.summary()
    spoil(report)
    found = report.problems()
    assert [words for words, line in zip(problems, found, strict=True) if words not in line] == []


@pytest.mark.parametrize(
    ("argument", "code", "lines"), [("-h", 0, 0), ("--help", 0, 0), ("--fast", 2, 1)]
)
def test_help_is_shown_what_is_none_is_refused_and_nothing_is_started(
    argument, code, lines, capsys
):
    assert run.main([argument]) == code
    captured = capsys.readouterr()
    assert captured.out == ("" if lines else run.USAGE)
    assert captured.err.count("\n") == captured.err.count(argument) == lines


@pytest.mark.slow
def test_two_demos_at_once_play_to_their_ends_without_hearing_each_other():
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    with subprocess.Popen(COMMAND, **pipes) as one, subprocess.Popen(COMMAND, **pipes) as other:
        outputs = {demo: demo.communicate(timeout=DEADLINE)[0] for demo in (one, other)}
    for demo, output in outputs.items():
        assert demo.returncode == 0, output
        assert "all as expected" in output
        assert "object_radius must be a finite number" in output
        assert "Traceback" not in output
        assert "\x1b" not in output
        # The steady state once a second, and what changes.
        assert len(re.findall(r"^ *\d+\.\d  ", output, re.MULTILINE)) > 25


@pytest.mark.slow
def test_control_c_stops_demo_and_node_without_a_traceback():
    with start(COMMAND) as process:
        lines = []
        for line in process.stdout:
            lines.append(line)
            if "tracking" in line:
                break
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: the node gets it too
        lines += process.stdout
        assert process.wait(DEADLINE) == 130
    output = "".join(lines)
    assert "interrupted" in output
    assert "Traceback" not in output
    wait_for_the_end_of(process.pid)
