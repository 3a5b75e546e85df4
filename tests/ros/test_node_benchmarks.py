# SPDX-License-Identifier: Apache-2.0
"""The benchmarks of the node run, measure what they say, and their page shows what was measured."""

import json

import pytest

from benchmarks.ros import __main__ as command
from benchmarks.ros import goals
from benchmarks.ros.effort import SMOKE

# What tiny counts leave out.
NOT_IN_SMOKE = {"compiling"}


@pytest.mark.slow
def test_goals_find_their_figures_and_nothing_is_left():
    sections = {name: measure(SMOKE) for name, measure in command.SUITE.sections.items()}
    for goal in goals.GOALS:
        assert goal.key in sections[goal.section].values or goal.key in NOT_IN_SMOKE, goal
    # A busy machine may let the newest win now and then.
    assert sections["latency"].values["gripper_50_answered"] > 0.5
    assert sections["many"].values["isolated"] == 1.0
    found = sections["lifecycle"].values
    assert (found["thread_growth"], found["file_growth"], found["entity_growth"]) == (0, 0, 0)


def test_page_shows_the_summary():
    summary = json.loads(command.PAGE.summary.read_text(encoding="utf-8"))
    assert list(summary["sections"]) == list(command.SUITE.sections)
    assert command.PAGE.markdown(summary) in command.PAGE.path.read_text(encoding="utf-8")
