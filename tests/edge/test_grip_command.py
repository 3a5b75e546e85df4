# SPDX-License-Identifier: Apache-2.0
"""The command ``grip``: what it prints for people and for programs, and its picture."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from spiral_gripper.cli.main import run

ASKED = ["grip", "paper_design_70", "--radius", "25 mm", "--frictionless-closing"]
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
    assert "60 and 120 elements: window differs by" in text


def test_every_command_takes_the_sections_stiffness(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Shape, wrap and grip from a file that asks for it, and from one that does not."""
    answers = []
    for extra in ("", "stiffness: {section_at: 55 kPa}\n"):
        file = tmp_path / f"mine{len(extra)}.yaml"
        file.write_text(SECTION_LAW + extra, encoding="utf-8")
        asked = [["shape", "--pressure", "40 kPa"], ["wrap", "--radius", "20 mm"]]
        if extra:
            asked.append(["grip", "--radius", "20 mm"])
        found = []
        for command, *options in asked:
            assert run([command, str(file), *options, "--json"]) == 0
            found.append(json.loads(capsys.readouterr().out))
        answers.append(found)
    (_, wrapped), (_, wrap, grip) = answers
    assert grip["tip_criterion"] == pytest.approx(wrap["pressure"], rel=1e-6)
    assert grip["onset_wrap"] == pytest.approx(wrap["pressure"], rel=0.02)
    assert wrap["pressure"] < 0.99 * wrapped["pressure"]  # gravity unbends it less
    tips = [np.array(shape["positions"][-1]) for shape, *_ in answers]
    assert np.linalg.norm(tips[1] - tips[0]) > 0.02


def test_people_get_rows_and_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*ASKED, "--friction", "0.2"]) == 0
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
