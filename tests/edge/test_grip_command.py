# SPDX-License-Identifier: Apache-2.0
"""The command ``grip``: what it prints for people and for programs, and its picture."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from spiral_core.grip import grip
from spiral_core.grip.window import GripWindow, WindowEnd
from spiral_gripper.cli.main import run
from spiral_gripper.reports.grip import document

pytestmark = pytest.mark.long

ASKED = ["grip", "paper_design_70", "--radius", "25 mm", "--friction", "0.2"]
ASKED += ["--frictionless-closing"]
# Questions, windows and what remains after them, by what was asked: once for all tests here.
solved = {}


def once(solve):
    def remembered(asked, *arguments, **options):
        key = solve, pickle.dumps(asked)
        if key not in solved:
            solved[key] = solve(asked, *arguments, **options)
        return solved[key]

    return remembered


@pytest.fixture(autouse=True)
def each_question_once(monkeypatch):
    """Solve each once for all tests of this file, forces at four pressures instead of ten."""
    for name in ("solve_question", "grip_window", "follow_loss"):
        monkeypatch.setattr(document, name, once(getattr(document, name)))
    monkeypatch.setattr(grip, "FORCE_PRESSURES", 4)


def test_programs_get_the_window_and_the_forces(answer, tmp_path):
    picture = tmp_path / "grip.svg"
    found = answer(*ASKED, "--payload", "1 kg", "--plot", str(picture), code=1)
    assert found["onset_wrap"] == pytest.approx(found["tip_criterion"], rel=0.05)
    assert found["onset_wrap"] < found["onset_curling"] < found["loss"]
    left = found["after_loss"]
    assert found["loss"] < left["pressure"] <= 1.02 * found["loss"]
    assert left["wrapped"] is False
    assert left["contact_length"] < 0.7 * found["contact_length"][-1]
    assert left["normal_force"] < found["normal_force"][-1]
    away, towards = (np.array(found[f"holding_force_{way}"]) for way in ("away", "towards"))
    assert 0.0 <= left["holding_force_towards"] <= left["holding_force_away"] < away[-1]
    assert np.all(away > towards)
    assert len(found["pressures"]) == len(found["contact_pressure"]) == len(away)
    assert found["recommended_pressure"] is None
    assert "no pressure holds 1 kg" in found["refusal"]
    text = picture.read_text(encoding="utf-8")
    for part in ("tip criterion", "along gravity", "90 and 180 elements: window differs by"):
        assert part in text


def test_people_get_rows_and_a_table(said):
    printed = said(*ASKED)
    for text in (
        "wrapped from", "from the tip criterion's", "loses stability", "away from",
        "friction coefficient │ 0.2", "after that │", "the end has let go;",
    ):  # fmt: skip
        assert text in printed


def test_one_pressure_is_looked_at_alone(answer, capsys):
    """With all directions the tables fit 80 columns, and no figure is cut."""
    asked = ["grip", "paper_design_70", "--radius", "20 mm", "--every-direction"]
    asked += ["--pressure", "60 kPa", "--pressure", "56 kPa"]
    found = answer(*asked)
    assert found["pressures"] == [56e3, 60e3]
    assert found["at_pressure"]["pressure"] == 60e3
    held = found["holding_force_towards"][1]
    assert found["at_pressure"]["holding_force_towards"] == pytest.approx(held)
    assert found["holding_force_towards_within_diameter"][1] < held
    assert (found["range_end"], found["lift_off"]) == ("curling", None)
    assert run(asked) == 0
    printed = capsys.readouterr().out
    assert "…" not in printed
    assert max(map(len, printed.splitlines())) <= 80
    rows = " ".join(printed.split())
    for row in (
        "at 60 kPa │ perfect wrap",
        "holds away from the base │ 0.25 N, peak at 18 mm;",
        "recommended range │ 55.47 kPa to 62.48 kPa: the end curls from",
    ):
        assert row in rows


def test_what_a_grip_owes_to_next_to_nothing_is_printed_on_request(answer, said, monkeypatch):
    asked = [*ASKED, "--pressure", "50 kPa", "--spread"]
    found = answer(*asked)
    for end in ("onset_wrap", "onset_curling", "loss"):
        assert found["spread"][end] == pytest.approx([found[end]] * 3, rel=2e-3)
    as_it_is = next(one for one in solved.values() if isinstance(one, GripWindow))
    never = replace(as_it_is, onset_wrap=None, end=WindowEnd.PASSED_BY)
    monkeypatch.setattr(document, "nudged_windows", lambda _: (as_it_is, never))
    solved.clear()
    rows = said(*asked).replace("│ ", "")
    assert "moved aside by 0.0004 mm" in rows
    assert "or not at all" in rows
    solved.clear()
    monkeypatch.setattr(document, "grip_window", lambda *_, **__: never)
    assert "moved aside by 0.000361 mm it is wrapped from" in said(*asked, code=2)


@pytest.mark.slow
def test_a_profile_says_which_part_of_it_is_held(answer, said, tmp_path):
    file = tmp_path / "cone.csv"
    file.write_text("position [mm],radius [mm]\n0,18\n300,22\n", encoding="utf-8")
    asked = ["grip", "paper_design_70", "--profile", str(file), "--pressure", "56 kPa"]
    found = answer(*asked)
    place = 1e3 * found["profile_position"]
    assert 0.0 < place < 300.0
    assert f"object's {place:.4g} mm mark at (x, y, z)" in said(*asked)
    # The profile is thinnest at 0: its middle of the coil has this radius.
    assert found["object_radius"] == pytest.approx(0.018)


@pytest.mark.slow
def test_a_true_zero_is_explained(said):
    """Close below its loss this coil drives the object towards the base, and snaps."""
    printed = said("grip", "paper_design_70", "--radius", "20 mm", "--pressure", "85 kPa")
    assert "holds towards the base │ 0 N: the coil itself drives it this way" in printed
    assert "the coil itself drives the object this way, and gives way before it" in printed
