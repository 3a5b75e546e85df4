# SPDX-License-Identifier: Apache-2.0
"""The command ``capture``: limits in rows, data and a picture, and a file from which it goes on."""

import math
import re

import numpy as np
import pytest

from spiral_core.grip import capture
from spiral_core.grip.capture import CaptureOutcome, MisplacedGrip
from spiral_core.rod.state import RodStatus

ASKED = ["capture", "paper_design_70", "--radius", "15 mm", "--pressure", "72 kPa", "--jobs", "1"]
SEMI_AXES = np.array((0.011, 0.006, math.radians(12.3), math.radians(7.7), 0.0023))


@pytest.fixture
def closed(monkeypatch):
    """Misplacements that were closed on; the answers are those of an ellipsoid."""
    places = []

    def close(_, pressure, misplacement, payload=None):
        places.append(misplacement)
        inside = np.linalg.norm(misplacement / SEMI_AXES) <= 1.0
        outcome = CaptureOutcome.HOLDS if inside else CaptureOutcome.TOO_WEAK
        if payload == 1.0:
            outcome = CaptureOutcome.NOT_ANSWERED
        return MisplacedGrip(outcome, pressure, RodStatus.CONVERGED)

    monkeypatch.setattr(capture, "close_misplaced", close)
    return places


def test_limits_are_printed_rounded_into_the_region(closed, said):
    printed = said(*ASKED, "--payload", "20 g", "--units", "in,deg")
    for part in ("wraps and holds", "0.02 kg", "all at once", f"{len(closed)}"):
        assert part in printed
    for text, exact in (("shift across", 0.006 / 0.0254), ("tilt about away", 12.3)):
        low, high = (float(printed.split(text)[1].split()[at]) for at in (1, 6))
        assert -exact <= low < -0.9 * exact
        assert 0.9 * exact < high <= exact


def test_programs_get_si_and_the_picture_is_drawn(closed, answer, tmp_path):
    picture = tmp_path / "capture.svg"
    found = answer(*ASKED, "--plot", str(picture))
    assert found["center"] == "holds"
    assert found["closings"] == len(closed)
    limits = np.abs(list(found["limits"].values()))
    assert np.all(limits <= SEMI_AXES[:, None])
    assert np.all(limits >= 0.9 * SEMI_AXES[:, None])
    assert found["beyond"]["radius"] == ["too_weak", "too_weak"]
    assert len(found["shifts"]) >= 16
    assert found["shifts"][0]["misplacement"] == [found["limits"]["away"][1], 0, 0, 0, 0]
    text = picture.read_text(encoding="utf-8")
    for part in ("tube without pressure", "too weak", "shift across [mm]", "all errors at once"):
        assert part in text


def test_an_interrupted_search_goes_on_and_another_question_begins_anew(closed, answer, tmp_path):
    file = tmp_path / "capture.jsonl"
    asked = [*ASKED, "--results", str(file)]
    first, count = answer(*asked), len(closed)
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    file.write_text("".join(lines[:100]) + lines[100][:40], encoding="utf-8")
    assert answer(*asked) == first
    assert len(closed) == 2 * count - 100
    for option in (["--payload", "20 g"], ["--friction", "0.4"]):
        answer(*asked, *option)
    assert len(closed) == 4 * count - 100


@pytest.mark.usefixtures("closed")
def test_an_object_that_is_not_held_in_its_place_is_the_answer_no(said, tmp_path):
    asked = [*ASKED, "--payload", "1 kg"]
    assert re.search("no certified answer.* closings │ 1 ", said(*asked, code=1))
    asked += ["--plot", str(tmp_path / "capture.png")]
    assert "held in its place" in said(*asked, code=2)


@pytest.mark.usefixtures("closed")
def test_the_recommended_pressure_is_that_of_the_payload(answer):
    asked = [part for part in ASKED if part not in ("--pressure", "72 kPa")]
    assert answer(*asked)["pressure"] == pytest.approx(72.017e3, abs=1.0)
