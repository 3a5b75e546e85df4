# SPDX-License-Identifier: Apache-2.0
"""Tubing files: the shipped sizes, every way a file can be wrong, and what is hardly meant."""

from dataclasses import astuple, replace
from pathlib import Path

import pytest
from edge.recorded import cases, changed, check
from repo.source_tree import FENCED, ROOT

from spiral_core import DesignRequirement, MooneyRivlin, PressureLaw
from spiral_core.design.requirement import SECTION_OVER_UNIFORM
from spiral_gripper import DescriptionError, load_tubing

GOOD = """\
name: mine
material: {law: neo_hookean, c1: 145 kPa, density: 950 kg/m^3}
sizes: [8 mm x 1 mm, 6 mm x 3 mm]
"""


def parse(text):
    Path("mine.yaml").write_text(text, "utf-8")
    return load_tubing("mine.yaml")


def test_the_shipped_list_and_a_file_of_ones_own():
    tubing = load_tubing("natural_latex")
    assert tubing.elastomer.law == MooneyRivlin(130.0e3, 15.0e3)
    assert (tubing.name, tubing.elastomer.density) == ("natural latex", 950.0)
    sizes = {size.name: (size.inner_radius, size.wall_thickness) for size in tubing.sizes}
    assert len(sizes) == len(tubing.sizes) == 14
    assert sizes["3/8 in x 1/32 in"] == pytest.approx((4.7625e-3, 0.79375e-3))
    own = parse(GOOD)
    assert (own.warnings, own.elastomer.pressure_law) == ((), PressureLaw.SECTION)


def test_the_tubing_that_the_page_offers_for_helical_fibers_is_designed_with():
    page = (ROOT / "docs" / "design.md").read_text("utf-8")
    (example,) = [text for language, text in FENCED.findall(page) if language == "yaml"]
    tubing = parse(example)
    scaled = [SECTION_OVER_UNIFORM * c for c in astuple(load_tubing("natural_latex").elastomer.law)]
    assert tubing.elastomer.law == MooneyRivlin(*scaled)
    requirement = DesignRequirement(0.011, 0.03, tubing.sizes, (tubing.elastomer,))
    assert replace(requirement, fiber_angles_gamma=(0.03,)).candidates()


@pytest.mark.parametrize("change", cases("tubing.txt"))
def test_what_is_wrong_or_hardly_meant_is_named_in_its_place(change):
    try:
        said = parse(changed(GOOD, change)).warnings
    except DescriptionError as error:
        said = str(error).splitlines()
    check("tubing.txt", change, said)


def test_the_design_names_what_is_hardly_meant_of_the_tubing_it_takes(said):
    Path("mine.yaml").write_text(GOOD.replace("950 kg", "0.95 kg"))
    needs = "--radius-min 8mm --radius-max 15mm --beta 70deg --paper --tube '6 mm x 1 mm'"
    printed = said("design --tubing mine.yaml", needs)
    assert "warning: mine.yaml:2:52: material.density" in printed
    assert "warning: wall_thickness of 6 mm x 1 mm is 0.33 of the bore radius" in printed
