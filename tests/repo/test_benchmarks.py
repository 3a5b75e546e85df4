# SPDX-License-Identifier: Apache-2.0
"""The benchmarks run and measure what they say; what was measured is strict JSON, on its page."""

import json
import math

import numpy as np
import pytest
from repo.source_tree import ROOT

from benchmarks import __main__ as command
from benchmarks import accuracy, collocation, dynamics, goals, peers, report, robustness
from benchmarks.cases import WEIGHT, random_case, usual_case
from benchmarks.results import SMOKE, Section, Table


def strict(text):
    """Return what strict JSON holds, which knows neither NaN nor infinity."""

    def refuse(constant):
        raise ValueError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.mark.slow
def test_every_section_runs_and_the_goals_find_their_figures():
    """With tiny counts; ratios of times to peers that these do not run may be missing."""
    slow = {"bvp": lambda effort: peers.collocation_section(effort, nodes=(32,))}
    sections = {
        name: slow.get(name, measure)(SMOKE) for name, measure in command.SUITE.sections.items()
    }
    for table in (table for section in sections.values() for table in section.tables):
        assert table.rows or table.note
        assert {len(row) for row in table.rows} <= {len(table.columns)}
    measured = {name: section.values for name, section in sections.items()}
    assert bool(measured["elastica"]) == dynamics.available()
    found = [goal for goal in goals.GOALS if goal.key in measured[goal.section]]
    assert {goal.section for goal in goals.GOALS if goal not in found} <= {"elastica", "scenarios"}
    assert len(goals.goal_table(measured).rows) == len(found) + 1
    assert measured["robustness"]["solved"] == measured["robustness"]["rods"] == SMOKE.rods
    for key in ("order_tip", "order_shape"):
        assert measured["accuracy"][key] == pytest.approx(4.0, abs=0.1)


@pytest.mark.slow
def test_fewest_elements_meet_the_error_and_fewer_do_not():
    few = accuracy.elements_for(accuracy.TIP_ERROR)
    assert accuracy.errors(few)[0] <= accuracy.TIP_ERROR < accuracy.errors(few - 2)[0]


@pytest.mark.slow
def test_both_collocations_find_the_usual_shape_and_one_knows_its_derivative():
    case = usual_case()
    tip = accuracy.usual_reference().tip
    for solve in (collocation.solve, collocation.solve_plainly):
        found = solve(case, collocation.helix_guess(case, 40), 1e-5)
        assert found.success
        assert np.linalg.norm(found.tip - tip) < 1e-5 * case.length
    slope, jacobian = collocation.equations(random_case(3))
    sites, states = np.linspace(0.0, 0.1, 4), np.random.default_rng(0).normal(size=(7, 4))
    analytic = jacobian(sites, states)
    for k, step in enumerate(1e-6 * np.eye(7)[:, :, None]):
        numeric = (slope(sites, states + step) - slope(sites, states - step)) / 2e-6
        # Central differences with a step of 1e-6 leave about 1e-9 of the largest entry.
        assert np.abs(numeric - analytic[:, k]).max() < 1e-8 * np.abs(analytic).max()


def test_random_rods_are_what_they_are_said_to_be():
    cases = [random_case(index) for index in range(200)]
    assert random_case(7) == random_case(7)
    for case in cases:
        torsion, across, curvature = case.rest_strain
        assert 0.1 <= case.length <= 1.0
        assert across == 0.0
        assert 3.0 <= curvature <= 60.0
        assert abs(torsion) <= 0.95 * curvature
        assert math.hypot(*case.distributed) == pytest.approx(WEIGHT)
        assert math.hypot(*case.tip_force) <= WEIGHT * case.length
    down = np.array([case.distributed for case in cases]) / WEIGHT
    # Uniform on the sphere: the mean of 200 directions is within three standard deviations of 0.
    assert np.abs(down.mean(axis=0)).max() < 3.0 * math.sqrt(1.0 / 3.0 / len(cases))


def test_what_failed_is_named_and_nothing_meets_no_goal():
    bad = robustness.Outcome(3, "UNSTABLE", False, 5, 0, 24, -1.0, 1e-3)
    good = robustness.Outcome(4, "CONVERGED", True, 5, 0, 24, 1.0, 1e-3)
    table, values = robustness.sample_table([bad, good])
    assert values["solved"] == 1.0
    assert "rod 3: UNSTABLE" in table.note
    assert not any(goal.met(math.nan) for goal in goals.GOALS)


def test_the_results_are_strict_json_of_no_named_machine_and_on_the_page():
    kept = {path.name: path.read_text(encoding="utf-8") for path in report.RESULTS.glob("*.json")}
    assert kept.keys() == {"summary.json", "ros_summary.json"}
    for text in kept.values():
        assert strict(text)
        assert not any(word in text for word in ("/home", "/root", "/tmp", "/work", "hostname"))
    summary = strict(kept["summary.json"])
    assert list(summary["sections"]) == list(command.SUITE.sections)
    assert report.PAGE.markdown(summary) in report.PAGE.path.read_text(encoding="utf-8")
    assert (ROOT / "docs/figures/rod_accuracy.png").is_file()
    values = {"nan": math.nan, "inf": -math.inf, "good": 1.5}
    goal = Table("goals", ("what",), (("is",),), "")
    written = strict(report.as_json({}, goal, {"part": Section((goal,), values)}))
    assert written["sections"]["part"]["values"] == {"nan": None, "inf": None, "good": 1.5}
