# SPDX-License-Identifier: Apache-2.0
"""The command ``capture``: limits in rows, data and a picture, and a file from which it goes on."""

import math
import re

import numpy as np
import pytest

from spiral_core import lay_into_coil
from spiral_core.grip import capture
from spiral_core.grip.capture import CaptureOutcome, MisplacedGrip, capture_region
from spiral_core.grip.places import moved
from spiral_core.rod.state import RodStatus
from spiral_gripper import load_description
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.regions import read_regions
from spiral_gripper.files.storage import FileError

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


@pytest.fixture
def mine(tmp_path):
    """A description file of our own."""
    path = tmp_path / "mine.yaml"
    path.write_text((GRIPPERS.path / "paper_design_70.yaml").read_text(encoding="utf-8"))
    return path


def ask(mine, radius, *options):
    return ["capture", str(mine), "--radius", radius, "--jobs", "1", "--table", *options]


@pytest.mark.usefixtures("closed")
def test_a_region_beside_the_description_has_the_margins_of_the_region(said, mine):
    said(*ask(mine, "15 mm", "--pressure", "72 kPa", "--payload", "20 g"))
    description = load_description(mine)
    setup = lay_into_coil(description.gripper, 0.015)
    region, (stored,) = capture_region(setup, 72e3, 0.02), read_regions(description)
    for off in ((0.0, 0.0, 0.0, 0.0), (0.004, -0.002, 0.0, 0.0), (0.001, 0.03, -0.1, 0.2)):
        there = moved(setup, np.array((0.0, *off)))
        place = np.array(there.obstacle.position)
        for point, axis in ((place, there.axis), (place + 0.1 * there.axis, -there.axis)):
            assert stored.margin(point, axis) == pytest.approx(region.margin((*off, 0.0)), abs=1e-3)
    asked = (72e3, 0.015, description.gripper.gravity, 0.3, 0.02)
    assert stored.is_for(*asked)
    assert stored.is_for(*asked[:4], None)
    other = (71e3, 0.0148, (9.0, 0.0, 0.0), 0.31, 0.021)
    for number, value in enumerate(other):
        assert not stored.is_for(*asked[:number], value, *asked[number + 1 :])


@pytest.mark.usefixtures("closed")
def test_regions_are_added_and_replaced_and_other_descriptions_have_none(said, mine):
    regions = []
    for radius, pressure, payload in (
        ("15 mm", "72 kPa", None),
        ("20 mm", "60 kPa", None),
        ("15 mm", "72 kPa", "20 g"),
        ("15 mm", "70 kPa", None),
    ):
        said(
            *ask(mine, radius, "--pressure", pressure),
            *(() if payload is None else ("--payload", payload)),
        )
        regions = read_regions(load_description(mine))
    found = [(each.radius, each.pressure, each.payload) for each in regions]
    assert found == [(0.02, 6e4, None), (0.015, 7.2e4, 0.02), (0.015, 7e4, None)]
    weak = ask(mine, "15 mm", "--pressure", "72 kPa", "--payload", "1 kg")
    assert "no region is written" in said(*weak, code=1)
    assert read_regions(load_description(mine)) == regions
    mine.write_text(mine.read_text(encoding="utf-8").replace("c1", "c1 "), encoding="utf-8")
    assert read_regions(load_description(mine)) == regions
    text = mine.read_text(encoding="utf-8")
    mine.write_text(text + "extra_mass_per_length: 1 g/m\n", encoding="utf-8")
    with pytest.raises(FileError, match=r"capture .*mine.yaml --radius .* --table makes it anew"):
        read_regions(load_description(mine))
    said(*ask(mine, "15 mm", "--pressure", "72 kPa"))
    assert len(read_regions(load_description(mine))) == 1
