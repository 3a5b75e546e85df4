# SPDX-License-Identifier: Apache-2.0
"""The command ``grip``: what it prints for people and for programs, and its picture."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from spiral_core.grip import grip
from spiral_core.grip.setup import GripSetup
from spiral_core.grip.window import GripPoint, GripWindow, WindowEnd
from spiral_gripper.cli.main import run
from spiral_gripper.reports.grip import document
from spiral_gripper.reports.grip.document import GripQuestion, SolvedGrip

pytestmark = pytest.mark.long

ASKED = ["grip", "paper_design_70", "--radius", "25 mm", "--friction", "0.2"]
ASKED += ["--frictionless-closing"]
SECTION_LAW = """name: mine
tube: {inner_radius: 4.7625 mm, wall_thickness: 1/32 in, length: 400 mm}
fibers: {alpha: 88 deg, beta: 70 deg}
material: {law: neo_hookean, c1: 100 kPa, density: 0.95 g/cm^3}
mount: {gravity_direction: [1, 0, 0]}
limits: {pressure_max: 14 psi}
"""
KEYS = (
    "pressures", "contact_length", "normal_force", "holding_force_away", "holding_force_towards",
    "onset_wrap", "onset_curling", "loss", "recommended_pressure", "contact_pressure",
)  # fmt: skip


solved: dict[bytes, SolvedGrip] = {}
windows: dict[bytes, GripWindow] = {}
rests: dict[int, GripPoint | None] = {}


@pytest.fixture(autouse=True)
def each_question_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Solve a question, a window and what remains after it once for all tests of this file.

    Forces are computed at four pressures instead of ten.
    """
    solve, window, loss = document.solve_question, document.grip_window, document.follow_loss

    def remembered(question: GripQuestion, progress: object) -> SolvedGrip:
        key = pickle.dumps(question)
        if key not in solved:
            solved[key] = solve(question, progress)
        return solved[key]

    def remembered_window(setup: GripSetup, **options: Any) -> GripWindow:
        key = pickle.dumps(setup)
        if key not in windows:
            windows[key] = window(setup, **options)
        return windows[key]

    monkeypatch.setattr(document, "solve_question", remembered)
    monkeypatch.setattr(document, "grip_window", remembered_window)

    def remembered_loss(found: GripWindow) -> GripPoint | None:
        if id(found) not in rests:
            rests[id(found)] = loss(found)
        return rests[id(found)]

    monkeypatch.setattr(document, "follow_loss", remembered_loss)
    monkeypatch.setattr(grip, "FORCE_PRESSURES", 4)


def test_programs_get_the_window_and_the_forces(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    picture = tmp_path / "grip.svg"
    assert run([*ASKED, "--payload", "1 kg", "--json", "--plot", str(picture)]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert set(KEYS) <= answer.keys()
    assert answer["onset_wrap"] == pytest.approx(answer["tip_criterion"], rel=0.05)
    assert answer["onset_wrap"] < answer["onset_curling"] < answer["loss"]
    left = answer["after_loss"]
    assert answer["loss"] < left["pressure"] <= 1.02 * answer["loss"]
    assert left["wrapped"] is False
    assert left["contact_length"] < 0.7 * answer["contact_length"][-1]
    assert left["normal_force"] < answer["normal_force"][-1]
    assert 0.0 <= left["holding_force_towards"] <= left["holding_force_away"]
    assert left["holding_force_away"] < answer["holding_force_away"][-1]
    away, towards = (np.array(answer[f"holding_force_{way}"]) for way in ("away", "towards"))
    assert len(away) == len(answer["pressures"]) == len(answer["contact_length"])
    assert np.all(away > towards)
    assert answer["recommended_pressure"] is None
    assert "no pressure holds 1 kg" in answer["refusal"]
    text = picture.read_text(encoding="utf-8")
    assert "tip criterion" in text
    assert "along gravity" in text
    assert "90 and 180 elements: window differs by" in text


@pytest.mark.slow
def test_every_command_takes_the_sections_stiffness(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Shape, wrap and grip from a file that asks for it, and from one that does not."""
    answers = []
    for extra in ("", "stiffness: {section_at: 55 kPa}\n"):
        file = tmp_path / f"mine{len(extra)}.yaml"
        file.write_text(SECTION_LAW + extra, encoding="utf-8")
        asked = [
            ["shape", "--pressure", "40 kPa"],
            ["wrap", "--radius", "20 mm", "--tip-criterion"],
        ]
        if extra:
            asked.append(["grip", "--radius", "20 mm", "--pressure", "60 kPa"])
        found = []
        for command, *options in asked:
            assert run([command, str(file), *options, "--json"]) == 0
            found.append(json.loads(capsys.readouterr().out))
        answers.append(found)
    (_, wrapped), (_, wrap, held) = answers
    assert held["tip_criterion"] == pytest.approx(wrap["pressure"], rel=1e-6)
    assert held["onset_wrap"] == pytest.approx(wrap["pressure"], rel=0.02)
    assert wrap["pressure"] < 0.99 * wrapped["pressure"]  # gravity unbends it less
    tips = [np.array(shape["positions"][-1]) for shape, *_ in answers]
    assert np.linalg.norm(tips[1] - tips[0]) > 0.02


def test_people_get_rows_and_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(ASKED) == 0
    said = " ".join(capsys.readouterr().out.split())
    for text in (
        "wrapped from",
        "from the tip criterion's",
        "loses stability",
        "away from",
    ):
        assert text in said
    assert "friction coefficient │ 0.2" in said
    assert "after that │" in said
    assert "the end has let go;" in said


def test_one_pressure_is_looked_at_alone(capsys: pytest.CaptureFixture[str]) -> None:
    """With all directions the tables fit 80 columns, and no figure is cut."""
    asked = ["grip", "paper_design_70", "--radius", "20 mm", "--every-direction"]
    asked += ["--pressure", "60 kPa", "--pressure", "56 kPa"]
    assert run(asked) == 0
    said = capsys.readouterr().out
    assert "…" not in said
    assert max(len(line) for line in said.splitlines()) <= 80
    rows = " ".join(said.split())
    assert "at 60 kPa │ perfect wrap" in rows
    assert "holds away from the base │ 0.25 N, peak at 18 mm;" in rows
    assert "0.0471 N within one" in rows
    assert "recommended range │ 55.47 kPa to 62.48 kPa: the end curls from" in rows
    assert run([*asked, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["pressures"] == [56e3, 60e3]
    assert answer["at_pressure"]["pressure"] == 60e3
    held = answer["holding_force_towards"]
    assert answer["at_pressure"]["holding_force_towards"] == pytest.approx(held[1])
    assert answer["holding_force_towards_within_diameter"][1] < held[1]
    assert answer["range_end"] == "curling"
    assert answer["lift_off"] is None


def test_what_a_grip_owes_to_next_to_nothing_is_printed_on_request(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = [*ASKED, "--pressure", "50 kPa", "--spread"]
    assert run([*asked, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    for end in ("onset_wrap", "onset_curling", "loss"):
        assert said["spread"][end] == pytest.approx([said[end]] * 3, rel=2e-3)
    as_it_is = next(iter(windows.values()))
    never = replace(as_it_is, onset_wrap=None, end=WindowEnd.PASSED_BY)
    monkeypatch.setattr(document, "nudged_windows", lambda _: (as_it_is, never))
    solved.clear()
    assert run(asked) == 0
    rows = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "moved aside by 0.0004 mm" in rows
    assert "or not at all" in rows
    solved.clear()
    monkeypatch.setattr(document, "grip_window", lambda *_, **__: never)
    assert run(asked) == 2
    assert "moved aside by 0.000361 mm it is wrapped from" in capsys.readouterr().err


def test_a_pressure_above_those_that_hold_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["grip", "paper_design_70", "--radius", "20 mm", "--pressure"]
    assert run([*asked, "95 kPa"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "95 kPa is too much: at 86.9" in said
    assert "the coil loses stability" in said
    assert run([*asked, "20 MPa"]) == 2
    assert "above limits.pressure_max" in capsys.readouterr().err


@pytest.mark.slow
def test_a_profile_says_which_part_of_it_is_held(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "cone.csv"
    file.write_text("position [mm],radius [mm]\n0,18\n300,22\n", encoding="utf-8")
    asked = ["grip", "paper_design_70", "--profile", str(file), "--pressure", "56 kPa"]
    assert run(asked) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "object radius │ 18 mm to 22 mm along its length" in said
    assert run([*asked, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    place = 1e3 * answer["profile_position"]
    assert 0.0 < place < 300.0
    assert f"object's {place:.4g} mm mark at (x, y, z)" in said
    # The profile is thinnest at 0: its middle of the coil has this radius.
    assert answer["object_radius"] == pytest.approx(0.018)


@pytest.mark.slow
def test_a_true_zero_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    """Close below its loss this coil drives the object towards the base, and snaps."""
    asked = ["grip", "paper_design_70", "--radius", "20 mm", "--pressure", "85 kPa"]
    assert run(asked) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "holds towards the base │ 0 N: the coil itself drives it this way" in said
    assert "0: the coil itself drives the object this way, and gives way before it holds" in said
