# SPDX-License-Identifier: Apache-2.0
"""The demo as people start it."""

import re
import signal
import sys

import pytest
from ros.programs import line_with, rest_of, start

from spiral_gripper_ros.tools import demo

COMMAND = sys.executable, "-m", "spiral_gripper_ros.tools.demo"


def test_help_is_shown_for_whatever_is_given_and_nothing_is_started(capsys):
    assert [demo.main([argument]) for argument in ("--help", "--fast")] == [0, 2]
    assert capsys.readouterr().out == 2 * demo.USAGE


@pytest.mark.slow
def test_two_demos_at_once_play_to_their_ends_without_hearing_each_other():
    with start(*COMMAND) as one, start(*COMMAND) as other:
        for code, said in map(rest_of, (one, other)):
            assert code == 0, said
            for words in (
                "object_radius must be a finite number",
                "is above the grippable range",
                "object_radius must be positive",
                "perfect wrap",
            ):
                assert words in said
            assert "\x1b" not in said
            # The steady state once a second, and what changes.
            assert len(re.findall(r"^ *\d+\.\d  ", said, re.MULTILINE)) > 25


@pytest.mark.slow
def test_control_c_stops_demo_and_node_without_a_traceback():
    with start(*COMMAND) as process:
        line_with(process, "tracking")
        code, said = rest_of(process, signal.SIGINT)
    assert (code, "vented; node and simulator have ended" in said) == (0, True), said
