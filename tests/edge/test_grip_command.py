# SPDX-License-Identifier: Apache-2.0
"""The command ``grip``: what it prints for people and for programs, and its picture."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spiral_core.grip import grip
from spiral_core.grip.window import WindowEnd, grip_window
from spiral_gripper.cli.main import run
from spiral_gripper.reports.grip import document

pytestmark = pytest.mark.long

ASKED = "grip paper_design_70 --radius 25mm --friction 0.2 --frictionless-closing"


@pytest.fixture(autouse=True)
def _few_forces(monkeypatch):
    """At four pressures instead of ten."""
    monkeypatch.setattr(grip, "FORCE_PRESSURES", 4)


def test_programs_get_the_window_and_the_forces(answer):
    found = answer(ASKED, "--payload 1kg --plot grip.svg", code=1)
    assert found["onset_wrap"] == pytest.approx(found["tip_criterion"], rel=0.05)
    assert found["onset_wrap"] < found["onset_curling"] < found["loss"]
    left = found["after_loss"]
    assert found["loss"] < left["pressure"] <= 1.02 * found["loss"]
    assert left["contact_length"] < 0.7 * found["contact_length"][-1]
    assert left["normal_force"] < found["normal_force"][-1]
    away, towards = (np.array(found[f"holding_force_{way}"]) for way in ("away", "towards"))
    assert 0.0 <= left["holding_force_towards"] <= left["holding_force_away"] < away[-1]
    assert np.all(away > towards)
    assert "no pressure holds 1 kg" in found["refusal"]
    text = Path("grip.svg").read_text("utf-8")
    for part in ("tip criterion", "along gravity", "90 and 180 elements: window differs by"):
        assert part in text


def test_one_pressure_is_looked_at_alone(answer, capsys):
    """With all directions the tables fit 80 columns, and no figure is cut."""
    asked = "grip paper_design_70 --radius 20mm --every-direction --pressure 60kPa --pressure 56kPa"
    found = answer(asked)
    assert found["pressures"] == [56e3, 60e3]
    held = found["holding_force_towards"][1]
    assert found["at_pressure"]["holding_force_towards"] == pytest.approx(held)
    assert found["holding_force_towards_within_diameter"][1] < held
    assert run(asked.split()) == 0
    printed = capsys.readouterr().out
    assert "…" not in printed
    assert max(map(len, printed.splitlines())) <= 80
    rows = " ".join(printed.replace("│", " ").split())
    for row in (
        "friction coefficient 0.3", "from the tip criterion's", "(the coil loses stability)",
        "after that the end has let go;", "at 60 kPa perfect wrap",
        "holds away from the base 0.25 N, peak at 18 mm;",
        "recommended range 55.47 kPa to 62.48 kPa: the end curls from",
    ):  # fmt: skip
        assert row in rows


def test_what_a_grip_owes_to_next_to_nothing_is_printed_on_request(answer, said, monkeypatch):
    asked = f"{ASKED} --pressure 50kPa --spread"
    found = answer(asked)
    for end in ("onset_wrap", "onset_curling", "loss"):
        assert found["spread"][end] == pytest.approx([found[end]] * 3, rel=2e-3)

    def never(*asked, **_):
        return replace(grip_window(*asked), onset_wrap=None, end=WindowEnd.PASSED_BY)

    monkeypatch.setattr(
        document, "nudged_windows", lambda setup: (grip_window(setup), never(setup))
    )
    rows = said(asked)
    assert "moved aside by" in rows
    assert "or not at all" in rows
    monkeypatch.setattr(document, "grip_window", never)
    assert "moved aside by 0.000361 mm it is wrapped from" in said(asked, code=2)


@pytest.mark.slow
def test_a_profile_says_which_part_of_it_is_held(answer, said):
    Path("cone.csv").write_text("position [mm],radius [mm]\n0,18\n300,22\n", "utf-8")
    asked = "grip paper_design_70 --profile cone.csv --pressure 56kPa"
    found = answer(asked)
    place = 1e3 * found["profile_position"]
    assert 0.0 < place < 300.0
    assert f"object's {place:.4g} mm mark at (x, y, z)" in said(asked)
    # The profile is thinnest at 0: its middle of the coil has this radius.
    assert found["object_radius"] == pytest.approx(0.018)


@pytest.mark.slow
def test_a_true_zero_is_explained(said):
    """Close below its loss this coil drives the object towards the base, and snaps."""
    printed = said("grip paper_design_70 --radius 20mm --pressure 85kPa")
    assert "holds towards the base │ 0 N: the coil itself drives it this way" in printed
    assert "the coil itself drives the object this way, and gives way before it" in printed
