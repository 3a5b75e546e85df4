# SPDX-License-Identifier: Apache-2.0
"""The benchmarks run and measure what they say; what was measured is strict JSON, on its page."""

import json
import re

import pytest

from benchmarks import __main__ as command
from benchmarks import dynamics, goals, peers, report
from benchmarks.results import SMOKE


@pytest.mark.slow
def test_every_section_runs_and_the_goals_find_their_figures():
    """With tiny counts; ratios of times to peers that these do not run may be missing."""
    slow = {"bvp": lambda effort: peers.collocation_section(effort, nodes=(32,))}
    measures = {**command.SUITE.sections, **slow}
    sections = {name: measure(SMOKE) for name, measure in measures.items()}
    for section in sections.values():
        assert all(table.rows or table.note for table in section.tables)
    measured = {name: section.values for name, section in sections.items()}
    assert bool(measured["elastica"]) == dynamics.available()
    missing = {goal.section for goal in goals.GOALS if goal.key not in measured[goal.section]}
    assert missing <= {"elastica", "scenarios"}
    assert measured["robustness"]["solved"] == measured["robustness"]["rods"] == SMOKE.rods
    for key in ("order_tip", "order_shape"):
        assert measured["accuracy"][key] == pytest.approx(4.0, abs=0.1)


def test_the_results_are_strict_json_of_no_named_machine_and_on_the_page():
    for path in report.RESULTS.glob("*.json"):
        text = path.read_text("utf-8")
        assert not re.search(r"/home|/root|/tmp|/work|hostname|NaN|Infinity", text)
        assert json.loads(text)
    summary = json.loads(report.PAGE.summary.read_text("utf-8"))
    assert list(summary["sections"]) == list(command.SUITE.sections)
    assert report.PAGE.markdown(summary) in report.PAGE.path.read_text("utf-8")
