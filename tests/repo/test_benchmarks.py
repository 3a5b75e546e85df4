# SPDX-License-Identifier: Apache-2.0
"""The benchmarks run, measure what they say, and their page shows what the summary holds."""

from __future__ import annotations

import json
import math
from io import StringIO

import numpy as np
import pytest
from repo.source_tree import ROOT
from rich.console import Console

from benchmarks import __main__ as command
from benchmarks import accuracy, collocation, dynamics, goals, peers, report, robustness
from benchmarks.cases import WEIGHT, random_case, usual_case
from benchmarks.results import SMOKE, Section, Table

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def sections() -> dict[str, Section]:
    """Every section with tiny counts."""
    slow = {"bvp": lambda effort: peers.collocation_section(effort, nodes=(32,))}
    return {
        name: slow.get(name, measure)(SMOKE) for name, measure in command.SUITE.sections.items()
    }


def test_every_section_has_tables_that_fit_their_columns(sections: dict[str, Section]) -> None:
    for section in sections.values():
        for table in section.tables:
            assert table.rows or table.note
            assert {len(row) for row in table.rows} <= {len(table.columns)}


def test_goals_find_their_figures(sections: dict[str, Section]) -> None:
    measured = {name: section.values for name, section in sections.items()}
    if not dynamics.available():
        assert not measured.pop("elastica")
    wanted = {goal.section for goal in goals.GOALS} | {"robustness"}
    found = [goal for goal in goals.GOALS if goal.key in measured.get(goal.section, {})]
    assert {goal.section for goal in goals.GOALS if goal not in found} <= {
        "elastica",
        "scenarios",  # its ratios of times: tiny counts run no peer
    }
    assert wanted - measured.keys() <= {"elastica"}
    assert len(goals.goal_table(measured).rows) == len(found) + 1


def test_random_rods_are_solved(sections: dict[str, Section]) -> None:
    values = sections["robustness"].values
    assert values["solved"] == values["rods"] == SMOKE.rods


def test_observed_order_is_four(sections: dict[str, Section]) -> None:
    values = sections["accuracy"].values
    assert values["order_tip"] == pytest.approx(4.0, abs=0.1)
    assert values["order_shape"] == pytest.approx(4.0, abs=0.1)


def test_fewest_elements_meet_the_error_and_fewer_do_not() -> None:
    few = accuracy.elements_for(accuracy.TIP_ERROR)
    assert accuracy.errors(few)[0] <= accuracy.TIP_ERROR < accuracy.errors(few - 2)[0]


def test_jacobian_of_the_collocation_is_the_derivative() -> None:
    slope, jacobian = collocation.equations(random_case(3))
    rng = np.random.default_rng(0)
    sites, states = np.linspace(0.0, 0.1, 4), rng.normal(size=(7, 4))
    analytic = jacobian(sites, states)
    for k in range(7):
        step = np.zeros((7, 1))
        step[k] = 1e-6
        numeric = (slope(sites, states + step) - slope(sites, states - step)) / 2e-6
        # Central differences with a step of 1e-6 leave about 1e-9 of the largest entry.
        assert np.abs(numeric - analytic[:, k]).max() < 1e-8 * np.abs(analytic).max()


def test_both_collocations_find_the_usual_shape() -> None:
    case = usual_case()
    tip = accuracy.usual_reference().tip
    guess = collocation.helix_guess(case, 40)
    for solve in (collocation.solve, collocation.solve_plainly):
        found = solve(case, guess, 1e-5)
        assert found.success
        assert np.linalg.norm(found.tip - tip) < 1e-5 * case.length


def test_random_rods_are_what_they_are_said_to_be() -> None:
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


def test_peer_that_is_not_installed_is_skipped_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dynamics, "available", lambda: False)
    (table,) = peers.dynamics_section(SMOKE).tables
    assert not table.rows
    assert table.note.startswith("Skipped: PyElastica is not installed")


def test_failures_are_named() -> None:
    bad = robustness.Outcome(3, "UNSTABLE", False, 5, 0, 24, -1.0, 1e-3)
    good = robustness.Outcome(4, "CONVERGED", True, 5, 0, 24, 1.0, 1e-3)
    table, values = robustness.sample_table([bad, good])
    assert values["solved"] == 1.0
    assert "rod 3: UNSTABLE" in table.note


def test_goal_is_not_met_by_nothing() -> None:
    assert not any(goal.met(math.nan) for goal in goals.GOALS)


def test_table_is_shown_with_its_note() -> None:
    text = StringIO()
    report.show(Table("title", ("a", "b"), (("1", "2"),), "note"), Console(file=text, width=100))
    assert all(word in text.getvalue() for word in ("title", "a", "b", "1", "2", "note"))


def test_page_shows_the_summary() -> None:
    summary = json.loads(report.PAGE.summary.read_text(encoding="utf-8"))
    measured = summary["sections"]
    assert list(measured) == [name for name in command.SUITE.sections if name in measured]
    assert command.SUITE.sections.keys() == measured.keys()
    page = report.PAGE.path.read_text(encoding="utf-8")
    assert report.PAGE.markdown(summary) in page
    assert (ROOT / "docs" / "figures" / "rod_accuracy.png").is_file()


def test_summary_does_not_name_the_machine() -> None:
    text = report.PAGE.summary.read_text(encoding="utf-8")
    assert not any(word in text for word in ("/home", "/root", "/tmp", "/work", "hostname"))
