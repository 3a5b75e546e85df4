# SPDX-License-Identifier: Apache-2.0
"""The command ``grip``: what it prints for people and for programs, and its picture."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from spiral_gripper.cli.main import run

ASKED = ["grip", "paper_design_70", "--radius", "25 mm", "--frictionless-closing"]
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
