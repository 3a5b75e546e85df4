# SPDX-License-Identifier: Apache-2.0
"""The command ``sweep grips``: every combination, and a file from which it goes on."""

from __future__ import annotations

import json
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console

from spiral_core import InvalidInputError
from spiral_core.grip import grip
from spiral_core.grip.grip import GripOutcome
from spiral_gripper import load_gripper
from spiral_gripper.cli.main import run
from spiral_gripper.reports.grip.study import StudyFile, print_outcomes

SWEEP = [
    "sweep",
    "grips",
    "paper_design_70",
    "--radius",
    "15 mm",
    "--radius",
    "20 mm",
    "--jobs",
    "1",
]


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Radii that were solved; the answers are made up."""
    radii: list[float] = []

    def solve(case: grip.GripCase) -> GripOutcome:
        radii.append(case.radius)
        if case.radius > 0.019:
            return GripOutcome("too thick for this test")
        return GripOutcome("", 66e3, 65e3, 74e3, 86e3, 70e3, 0.2, 0.7, 0.9, 0.15)

    monkeypatch.setattr(grip, "solve_case", solve)
    return radii


def test_a_study_goes_on_from_its_file(
    solved: list[float], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = tmp_path / "study.jsonl"
    asked = [*SWEEP, "--results", str(kept), "--json"]
    assert run(asked) == 0
    first = json.loads(capsys.readouterr().out)
    assert [grip["radius"] for grip in first] == [0.015, 0.020]
    assert first[0]["away"] == 0.9
    lines = kept.read_text(encoding="utf-8").splitlines()
    assert len(lines) == 2
    kept.write_text(lines[0] + "\n" + lines[1][:40], encoding="utf-8")  # interrupted while writing
    solved.clear()
    assert run(asked) == 0
    assert json.loads(capsys.readouterr().out) == first
    assert solved == [0.020]
    assert kept.read_text(encoding="utf-8").splitlines() == lines
    assert run([*asked, "--friction", "0.5"]) == 0
    assert solved == [0.020, 0.015, 0.020]


@pytest.mark.parametrize(
    "changed",
    [("beta: 70 deg", "beta: 65 deg"), ("density: 0.95 g/cm^3", "density: 1.2 g/cm^3")],
)
def test_another_gripper_of_the_same_name_is_solved_anew(
    solved: list[float],
    changed: tuple[str, str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["grippers", "show", "paper_design_70"]) == 0
    text = capsys.readouterr().out
    assert changed[0] in text
    file = tmp_path / "mine.yaml"
    asked = ["sweep", "grips", str(file), "--radius", "15 mm", "--jobs", "1"]
    for content in (text, text.replace(*changed), text):
        file.write_text(content, encoding="utf-8")
        assert run([*asked, "--results", str(tmp_path / "study.jsonl")]) == 0
    assert solved == [0.015, 0.015]


def test_the_files_own_friction_is_used_unless_another_is_given(
    solved: list[float], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["grippers", "show", "paper_design_70"]) == 0
    text = capsys.readouterr().out
    file = tmp_path / "mine.yaml"
    turns = "  turns_required:"
    file.write_text(text.replace(turns, f"  friction_coefficient: 0.6\n{turns}"), encoding="utf-8")
    asked = ["sweep", "grips", str(file), "--radius", "15 mm", "--jobs", "1", "--json"]
    for options, friction in (([], 0.6), (["--friction", "0.4"], 0.4)):
        assert run([*asked, *options]) == 0
        assert json.loads(capsys.readouterr().out)[0]["friction"] == friction
    assert len(solved) == 2


def test_people_get_a_table_and_the_reasons(
    solved: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*SWEEP, "--gravity-direction", "0", "0", "2"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "2 grips" in said
    assert "15 mm" in said
    assert "9.81" in said
    assert "20 mm: too thick for this test" in said
    assert len(solved) == 2


def test_a_force_that_is_not_known_is_no_refusal() -> None:
    case = grip.GripCase(load_gripper("paper_design_70"), 0.015, 0.3)
    held = GripOutcome("", 66e3, 65e3, None, None, 70e3, 0.2, 0.7, 0.9, None, True)
    console = Console(record=True, width=100, file=StringIO())
    print_outcomes([case, case], [held, GripOutcome("too thick")], console)
    first, second = [line for line in console.export_text().splitlines() if "15 mm" in line][:2]
    assert "> 0.9" in first
    assert "?" in first
    assert "?" not in second


def test_a_file_that_is_no_study_is_kept(tmp_path: Path) -> None:
    for text in ('{"precious": 1}', "a: 1\nb: 2", '{"case": 1}\n{"case": [2'):
        precious = tmp_path / "precious.jsonl"
        precious.write_text(text, encoding="utf-8")
        with pytest.raises(InvalidInputError, match="line 1 must be an outcome of a study"):
            StudyFile(precious, [])
        assert precious.read_text(encoding="utf-8") == text


def test_misuse_is_answered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = tmp_path / "broken.jsonl"
    broken.write_text("{}\n", encoding="utf-8")
    for extra, text in (
        (["--results", str(broken)], "line 1 must be an outcome of a study"),
        (["--friction", "-1"], "at least 0 and at most 10"),
        (["--gravity-direction", "0", "0", "0"], "must not all be zero"),
    ):
        assert run([*SWEEP, *extra]) == 2
        assert text in " ".join(capsys.readouterr().err.split())
