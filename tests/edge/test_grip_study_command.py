# SPDX-License-Identifier: Apache-2.0
"""The command ``sweep grips``: every combination, and a file from which it goes on."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from edge.recorded import cases
from numpy.testing import assert_allclose

from spiral_core import MeasuredActuation
from spiral_core.grip import grip
from spiral_core.grip.grip import GripCase, GripOutcome
from spiral_gripper import load_gripper
from spiral_gripper.files.storage import LARGEST_FILE
from spiral_gripper.reports.grip.study import key_of

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


def test_another_reading_of_a_measured_curve_is_another_gripper(mine):
    """Wherever it lies, and if its first six digits are the same."""
    gripper = load_gripper(mine)
    readings = np.linspace(0.0, 80e3, 18)
    made = []
    for changed in range(1, 19):
        curvatures = readings / 2e3
        curvatures[changed:][:1] *= 1.0 + 1e-9
        torsions = tuple(-0.5 * curvatures)
        curve = MeasuredActuation(tuple(readings), tuple(curvatures), torsions, 0.361)
        made.append(replace(gripper, actuation=curve, pressure_max=79e3))
    keys = {key_of(GripCase(each, 0.015, 0.3)) for each in (gripper, *made, *made)}
    assert len(keys) == 1 + len(made)


def test_a_mount_keeps_the_magnitude_of_the_file_and_has_one_table(solved, answer, said, mine):
    text = mine.read_text("utf-8")
    mine.write_text(text.replace("gravity_magnitude: 9.80665", "gravity_magnitude: 1.62"), "utf-8")
    asked = "sweep grips mine.yaml paper_design_70 --radius 15mm --radius 20mm --jobs 1"
    turned = f"{asked} --gravity-direction 0 0 -1 --gravity-direction 1 0 0"
    lunar, earthly = np.split(np.array([grip["gravity"] for grip in answer(turned)]), 2)
    assert_allclose(lunar, 2 * [(0.0, 0.0, -1.62), (1.62, 0.0, 0.0)], atol=1e-12)
    assert_allclose(earthly, 9.80665 / 1.62 * lunar, atol=1e-12)
    assert said(turned).count(", 2 grips") == 4
    assert len(solved) == 16


def test_a_study_goes_on_from_more_than_a_description_may_have(solved, answer):
    kept, asked = Path("study.jsonl"), f"{SWEEP} --results study.jsonl"
    first = answer(asked)
    lines = kept.read_text("utf-8")
    kept.write_text(lines * (1 + LARGEST_FILE // len(lines)), "utf-8")
    assert answer(asked) == first
    assert solved == [0.015, 0.020]


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
