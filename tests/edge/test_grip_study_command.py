# SPDX-License-Identifier: Apache-2.0
"""The command ``sweep grips``: every combination, and a file from which it goes on."""

from pathlib import Path

import pytest
from edge.recorded import cases

from spiral_core.grip import grip
from spiral_core.grip.grip import GripOutcome

SWEEP = "sweep grips paper_design_70 --radius 15mm --radius 20mm --jobs 1"


@pytest.fixture
def solved(monkeypatch):
    """Radii that were solved; the answers are made up."""
    radii = []

    def solve(case):
        radii.append(case.radius)
        if case.radius > 0.019:
            return GripOutcome("too thick for this test")
        return GripOutcome("", 66e3, 65e3, 74e3, 86e3, 70e3, 0.2, 0.7, 0.9, 0.15)

    monkeypatch.setattr(grip, "solve_case", solve)
    return radii


def test_a_study_goes_on_from_its_file(solved, answer):
    kept = Path("study.jsonl")
    asked = f"{SWEEP} --results {kept}"
    first = answer(asked)
    assert [(grip["radius"], grip["away"]) for grip in first] == [(0.015, 0.9), (0.02, None)]
    lines = kept.read_text("utf-8").splitlines()
    kept.write_text(lines[0] + "\n" + lines[1][:40], "utf-8")  # interrupted while writing
    assert answer(asked) == first
    assert kept.read_text("utf-8").splitlines() == lines
    answer(asked, "--friction 0.5")
    assert solved == [0.015, 0.020, 0.020, 0.015, 0.020]


def test_another_gripper_of_the_same_name_is_solved_anew_with_its_own_friction(
    solved, answer, mine
):
    text = mine.read_text("utf-8")
    asked = "sweep grips mine.yaml --radius 20mm --jobs 1 --results study.jsonl"
    for old, new in 2 * (
        ("beta: 70 deg", "beta: 65 deg"),
        ("density: 0.95 g/cm^3", "density: 1.2 g/cm^3"),
        ("  turns_required:", "  friction_coefficient: 0.6\n  turns_required:"),
    ):
        mine.write_text(text.replace(old, new), "utf-8")
        (found,) = answer(asked)
    assert solved == [0.02] * 3
    assert found["friction"] == 0.6


def test_people_get_a_table_and_a_force_that_is_not_known_is_no_refusal(recorded, monkeypatch):
    held = GripOutcome("", 66e3, 65e3, None, None, 70e3, 0.2, 0.7, 0.9, None, True)
    answers = iter((held, GripOutcome("too thick")))
    monkeypatch.setattr(grip, "solve_case", lambda _: next(answers))
    (asked,) = cases("grip_study.txt")
    recorded("grip_study.txt", asked)


@pytest.mark.parametrize("text", ['{"precious": 1}', "a: 1\nb: 2", '{"case": 1}\n{"case": [2'])
def test_a_file_that_is_no_study_is_kept(said, text):
    precious = Path("precious.jsonl")
    precious.write_text(text, "utf-8")
    refused = said(SWEEP, "--results precious.jsonl", code=2)
    assert "line 1 must be an outcome of a study" in refused
    assert precious.read_text("utf-8") == text
