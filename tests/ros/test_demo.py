# SPDX-License-Identifier: Apache-2.0
"""The demo: how it judges, and the whole of it as people start it."""

import re
import signal
import sys
from collections import Counter

import pytest
import yaml
from ros.programs import line_with, rest_of, start
from ros.records import agrees

from spiral_gripper_ros.tools import demo
from spiral_gripper_ros.tools.demo_report import EXPECTED_REFUSALS, DemoReport

COMMAND = sys.executable, "-m", "spiral_gripper_ros.tools.demo"


GOOD = {
    "pressures": [0.0, 4.0e4, 0.0],
    "refused": Counter(EXPECTED_REFUSALS),
    "wrapped": [(0.0301, 4.0e4)],
}


SPOILED = """
[{}, {wrapped: []}, {pressures: [.nan, 0.0]}, {pressures: [1.1e+5, 0.0]}, {pressures: [0.0, 1.0]},
{pressures: []}, {solve_times: [0.01, 0.02, 0.04]}]
"""


def test_whatever_goes_wrong_is_the_problem_on_record():
    found = []
    for spoiled in [*yaml.safe_load(SPOILED), {"refused": {}}]:
        report = DemoReport({"pipe": 0.03}, 1.0e5, **GOOD | spoiled)
        found += [f"# {spoiled}", *report.problems(), *report.summary()]
    agrees("demo", "\n".join(found))


def test_help_is_shown_what_is_none_is_refused_and_nothing_is_started(capsys):
    assert [demo.main([argument]) for argument in ("--help", "--fast")] == [0, 2]
    captured = capsys.readouterr()
    assert captured.out == demo.USAGE
    assert captured.err.count("\n") == captured.err.count("--fast") == 1


@pytest.mark.slow
def test_two_demos_at_once_play_to_their_ends_without_hearing_each_other():
    with start(*COMMAND) as one, start(*COMMAND) as other:
        for code, said in map(rest_of, (one, other)):
            assert code == 0, said
            assert "all as expected" in said
            assert "\x1b" not in said
            # The steady state once a second, and what changes.
            assert len(re.findall(r"^ *\d+\.\d  ", said, re.MULTILINE)) > 25


@pytest.mark.slow
def test_control_c_stops_demo_and_node_without_a_traceback():
    with start(*COMMAND) as process:
        line_with(process, "tracking")
        code, said = rest_of(process, signal.SIGINT)
    assert (code, "vented; node and simulator have ended" in said) == (0, True), said
