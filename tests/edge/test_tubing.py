# SPDX-License-Identifier: Apache-2.0
"""Tubing files: the shipped sizes, and every way a file can be wrong."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from spiral_core import DesignRequirement, InvalidInputError, MooneyRivlin
from spiral_core.design.requirement import SECTION_OVER_UNIFORM
from spiral_gripper import (
    DescriptionError,
    available_grippers,
    available_tubing,
    load_tubing,
    parse_tube_size,
)
from spiral_gripper.files.tubing import parse_tubing

GOOD = """\
name: mine
material: {law: neo_hookean, c1: 145 kPa, density: 950 kg/m^3}
sizes: [8 mm x 1 mm, 3/8 in x 1/32 in]
"""


def test_the_shipped_list() -> None:
    assert available_tubing() == ("natural_latex",)
    assert "natural_latex" not in available_grippers()
    tubing = load_tubing("natural_latex")
    assert tubing.elastomer.law == MooneyRivlin(130.0e3, 15.0e3)
    assert (tubing.name, tubing.elastomer.density) == ("natural latex", 950.0)
    assert len(tubing.sizes) == len({size.name for size in tubing.sizes}) == 14
    paper = next(size for size in tubing.sizes if size.name == "3/8 in x 1/32 in")
    assert paper.inner_radius == pytest.approx(4.7625e-3, rel=1e-12)
    assert paper.wall_thickness == pytest.approx(0.79375e-3, rel=1e-12)


def test_the_tubing_that_the_page_offers_for_helical_fibers_is_designed_with() -> None:
    page = (Path(__file__).parents[2] / "docs" / "design.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    tubing = parse_tubing(example, Path("section.yaml"))
    shipped = load_tubing("natural_latex").elastomer.law
    assert isinstance(shipped, MooneyRivlin)
    scaled = MooneyRivlin(SECTION_OVER_UNIFORM * shipped.c1, SECTION_OVER_UNIFORM * shipped.c2)
    assert tubing.elastomer.law == scaled
    gamma = math.radians(2.0)
    requirement = DesignRequirement(
        0.011, 0.03, tubing.sizes, (tubing.elastomer,), fiber_angles_gamma=(gamma,)
    )
    assert {candidate.fiber_angle_gamma for candidate in requirement.candidates()} == {gamma}


def test_a_good_file() -> None:
    tubing = parse_tubing(GOOD, Path("mine.yaml"))
    assert [size.name for size in tubing.sizes] == ["8 mm x 1 mm", "3/8 in x 1/32 in"]
    assert tubing.sizes[0].inner_radius == pytest.approx(4e-3)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("sizes: [8 mm x 1 mm, ", "sizes: [8 x 1, ", "mine.yaml:3:9: sizes must be bore and wall"),
        ("8 mm x 1 mm", "8 mm x 1 kPa", "not a length"),
        ("8 mm x 1 mm", "8 mm x 0 mm", "wall_thickness"),
        ("8 mm x 1 mm", "8 mm", "bore and wall"),
        ("sizes: [8 mm x 1 mm, 3/8 in x 1/32 in]", "sizes: []", "a list of"),
        ("sizes: [8 mm x 1 mm, 3/8 in x 1/32 in]", "", "sizes is missing"),
        ("c1: 145 kPa, ", "", "material.c1 is missing"),
        ("c1: 145 kPa", "c1: -145 kPa", "material.c1 must be a positive"),
        ("density: 950 kg/m^3", "density: 950", "material.density must be a density"),
        ("law: neo_hookean", "law: rubber", "material.law must be one of"),
        ("name: mine", "nme: mine", "nme is not a field here"),
        (GOOD, "", "cannot be read: it is empty"),
    ],
)
def test_a_bad_file_is_refused_in_its_place(old: str, new: str, expected: str) -> None:
    with pytest.raises(DescriptionError) as raised:
        parse_tubing(GOOD.replace(old, new), Path("mine.yaml"))
    assert expected in str(raised.value)
    assert "gripper description" not in str(raised.value)


def test_unknown_names_are_told_what_there_is() -> None:
    with pytest.raises(DescriptionError, match="the shipped tubing is natural_latex"):
        load_tubing("silicone")
    with pytest.raises(DescriptionError, match="did you mean natural_latex"):
        load_tubing("natural_latx.yaml")


@pytest.mark.parametrize("text", ["8 mm", "8 mm x", "x 1 mm", "8 x 1", "8 mm x 1 mm x 2 mm", ""])
def test_sizes_need_two_lengths(text: str) -> None:
    with pytest.raises(InvalidInputError, match="tube size must be bore and wall"):
        parse_tube_size(text)
