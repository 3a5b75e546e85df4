# SPDX-License-Identifier: Apache-2.0
"""The benchmarks of the node run, measure what they say, and their page shows what was measured."""

import json
import os
import threading
from pathlib import Path

import pytest

from benchmarks.ros import __main__ as command
from benchmarks.ros import goals, rate
from benchmarks.ros.effort import SMOKE
from benchmarks.ros.probe import Exchange
from benchmarks.ros.sweep import STEPS, radius_sweep
from benchmarks.ros.usage_of_process import usage

# What tiny counts leave out.
pytestmark = pytest.mark.slow

NOT_IN_SMOKE = {"compiling"}


@pytest.fixture(scope="module")
def sections():
    return {name: measure(SMOKE) for name, measure in command.SUITE.sections.items()}


def test_every_section_has_tables_that_fit_their_columns(sections):
    for section in sections.values():
        for table in section.tables:
            assert table.rows
            assert {len(row) for row in table.rows} == {len(table.columns)}


def test_goals_find_their_figures(sections):
    for goal in goals.GOALS:
        assert goal.key in sections[goal.section].values or goal.key in NOT_IN_SMOKE, goal


def test_answers_are_those_of_the_radii_sent(sections):
    # A busy machine may let the newest win now and then.
    assert sections["latency"].values["gripper_50_answered"] > 0.5
    assert sections["latency"].values["echo_50_answered"] > 0.5


def test_grippers_in_one_process_do_not_disturb_each_other(sections):
    assert sections["many"].values["isolated"] == 1.0


def test_nothing_is_left_by_the_life_cycle(sections):
    found = sections["lifecycle"].values
    assert (found["thread_growth"], found["file_growth"], found["entity_growth"]) == (0, 0, 0)


def test_every_radius_of_a_sweep_has_an_answer_of_its_own():
    sweep = radius_sweep()
    assert len(set(sweep.values)) == len(set(sweep.answers)) == STEPS
    around = sweep.part(STEPS - 1, 2)  # from its end to its beginning it is a step like any other
    steps = [abs(b - a) for a, b in zip(sweep.values, sweep.values[1:], strict=False)]
    assert abs(around.values[1] - around.values[0]) < 2.0 * max(steps)


def test_a_rate_is_sustained_without_losses_and_without_backlog():
    even = Exchange(100, (1e-3,) * 100, 1.0)
    assert rate.is_sustained(even, 100.0)
    assert not rate.is_sustained(Exchange(100, (1e-3,) * 98, 1.0), 100.0)
    assert not rate.is_sustained(Exchange(100, (1e-3,) * 50 + (3e-3,) * 50, 1.0), 100.0)
    assert not rate.is_sustained(even, 110.0)  # it was never sent that fast


def test_the_usage_of_a_process_is_told():
    before = usage(os.getpid())
    thread = threading.Thread(target=sum, args=(range(3_000_000),))
    thread.start()
    thread.join()
    block = bytearray(b"x") * 50_000_000
    with Path(os.devnull).open() as _:
        after = usage(os.getpid())
    assert after.cpu > before.cpu
    assert after.memory > before.memory + 0.5 * len(block)
    assert after.files == before.files + 1
    assert after.threads >= 1


def test_page_shows_the_summary():
    summary = json.loads(command.PAGE.summary.read_text(encoding="utf-8"))
    assert list(summary["sections"]) == list(command.SUITE.sections)
    assert command.PAGE.markdown(summary) in command.PAGE.path.read_text(encoding="utf-8")


def test_summary_does_not_name_the_machine():
    text = command.PAGE.summary.read_text(encoding="utf-8")
    assert not any(word in text for word in ("/home", "/root", "/tmp", "/work", "hostname"))
