# SPDX-License-Identifier: Apache-2.0
"""The command ``capture``: limits in rows, data and a picture, and a file from which it goes on."""

import math
from unittest.mock import Mock

import numpy as np
import pytest
from edge.recorded import cases

from spiral_core import NotGrippableError, lay_into_coil
from spiral_core.grip import capture, grip
from spiral_core.grip.capture import CaptureOutcome, MisplacedGrip, capture_region
from spiral_core.rod.state import RodStatus
from spiral_gripper import load_description
from spiral_gripper.files.regions import read_regions
from spiral_gripper.files.storage import FileError

ASKED = "capture paper_design_70 --radius 15mm --jobs 1"
AT = f"{ASKED} --pressure 72kPa"
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


@pytest.mark.usefixtures("closed")
def test_limits_are_printed_rounded_into_the_region(said):
    printed = said(AT, "--payload 20g --units in,deg")
    for text, exact in (("shift across", 0.006 / 0.0254), ("tilt about away", 12.3)):
        ends = printed.split(text)[1].split()[1:7:5]
        assert all(0.9 * exact < abs(float(end)) <= exact for end in ends)


def test_programs_get_si_and_a_file_to_go_on_from(closed, answer):
    asked = f"{AT} --results capture.jsonl"
    found = answer(asked)
    assert found["closings"] == len(closed)
    limits = np.abs(list(found["limits"].values())).T / SEMI_AXES
    assert 0.9 <= limits.min() <= limits.max() <= 1.0
    assert answer(asked) == found
    assert len(closed) == found["closings"]
    for option in ("--payload 20g", "--friction 0.4"):
        answer(asked, option)
    assert len(closed) == 3 * found["closings"]


def test_what_no_pressure_holds_is_not_held_in_its_place(closed, said, monkeypatch):
    refusal = NotGrippableError(0.015, "no pressure holds it", -1.0, None)
    monkeypatch.setattr(grip, "recommended_grip", Mock(side_effect=refusal))
    assert "not held: the object cannot be gripped: no pressure holds it" in said(ASKED, code=1)
    assert not closed


@pytest.mark.usefixtures("closed")
@pytest.mark.parametrize("asked", cases("capture.txt"))
def test_limits_are_printed_and_drawn_as_recorded(asked, recorded):
    recorded("capture.txt", asked)


TABLE = "capture mine.yaml --jobs 1 --table"


@pytest.mark.usefixtures("closed")
def test_a_region_beside_the_description_has_the_margins_of_the_region(said, mine):
    said(TABLE, "--radius 15mm --pressure 72kPa --payload 20g")
    description = load_description(mine)
    setup = lay_into_coil(description.gripper, 0.015)
    region, (stored,) = capture_region(setup, 72e3, 0.02), read_regions(description)
    off = (0.001, 0.03, -0.1, 0.2)
    there = setup.moved(np.array((0.0, *off)))
    point = np.array(there.obstacle.position) + 0.1 * there.axis
    margin = region.margin((*off, 0.0))
    assert stored.margin(point, -there.axis) == pytest.approx(margin, abs=1e-3)
    asked = (72e3, 0.015, description.gripper.gravity, 0.3, 0.02)
    assert stored.is_for(*asked)
    assert stored.is_for(*asked[:4], None)
    for number, value in enumerate((71e3, 0.0148, (9.0, 0.0, 0.0), 0.31, 0.021)):
        assert not stored.is_for(*asked[:number], value, *asked[number + 1 :])


@pytest.mark.usefixtures("closed")
def test_regions_are_added_and_replaced_and_other_descriptions_have_none(said, mine):
    for asked in (
        "--radius 15mm --pressure 72kPa",
        "--radius 20mm --pressure 60kPa",
        "--radius 15mm --pressure 72kPa --payload 20g",
        "--radius 15mm --pressure 70kPa",
    ):
        said(TABLE, asked)
    regions = read_regions(load_description(mine))
    found = [(each.radius, each.pressure, each.payload) for each in regions]
    assert found == [(0.02, 6e4, None), (0.015, 7.2e4, 0.02), (0.015, 7e4, None)]
    weak = "--radius 15mm --pressure 72kPa --payload 1kg"
    assert "no region is written" in said(TABLE, weak, code=1)
    assert read_regions(load_description(mine)) == regions
    with mine.open("a", encoding="utf-8") as file:
        file.write("extra_mass_per_length: 1 g/m\n")
    with pytest.raises(FileError, match=r"capture .*mine.yaml --radius .* --table makes it anew"):
        read_regions(load_description(mine))
    said(TABLE, "--radius 15mm --pressure 72kPa")
    assert len(read_regions(load_description(mine))) == 1
