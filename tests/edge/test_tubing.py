# SPDX-License-Identifier: Apache-2.0
"""Tubing files: the shipped sizes, every way a file can be wrong, and what is hardly meant."""

from dataclasses import astuple, replace
from pathlib import Path

import pytest
from repo.source_tree import FENCED, ROOT

from spiral_core import DesignRequirement, MooneyRivlin, PressureLaw
from spiral_core.design.requirement import SECTION_OVER_UNIFORM
from spiral_gripper import DescriptionError, load_tubing
from spiral_gripper.files.tubing import parse_tubing

GOOD = """\
name: mine
material: {law: neo_hookean, c1: 145 kPa, density: 950 kg/m^3}
sizes: [8 mm x 1 mm, 6 mm x 3 mm]
"""


def changed(change):
    old, new = change.split(" -> ")
    assert old in GOOD
    return parse_tubing(GOOD.replace(old, new), Path("mine.yaml"))


def test_the_shipped_list_and_a_file_of_ones_own():
    tubing = load_tubing("natural_latex")
    assert tubing.elastomer.law == MooneyRivlin(130.0e3, 15.0e3)
    assert (tubing.name, tubing.elastomer.density) == ("natural latex", 950.0)
    sizes = {size.name: (size.inner_radius, size.wall_thickness) for size in tubing.sizes}
    assert len(sizes) == len(tubing.sizes) == 14
    assert sizes["3/8 in x 1/32 in"] == pytest.approx((4.7625e-3, 0.79375e-3))
    own = changed("mine -> mine")
    assert (own.warnings, own.elastomer.pressure_law) == ((), PressureLaw.SECTION)


def test_the_tubing_that_the_page_offers_for_helical_fibers_is_designed_with():
    page = (ROOT / "docs" / "design.md").read_text("utf-8")
    (example,) = [text for language, text in FENCED.findall(page) if language == "yaml"]
    tubing = parse_tubing(example, Path("section.yaml"))
    scaled = [SECTION_OVER_UNIFORM * c for c in astuple(load_tubing("natural_latex").elastomer.law)]
    assert tubing.elastomer.law == MooneyRivlin(*scaled)
    requirement = DesignRequirement(0.011, 0.03, tubing.sizes, (tubing.elastomer,))
    assert replace(requirement, fiber_angles_gamma=(0.03,)).candidates()


# What is changed in the file -> a part of the refusal, or of the warning.
BAD = {
    "8 mm x 1 mm -> 8 x 1": "mine.yaml:3:9: sizes must be bore and wall",
    "8 mm x 1 mm -> 8 mm x 0 mm": "wall_thickness",
    "8 mm x 1 mm -> 1 mm x 8 mm": 'did you mean "8 mm x 1 mm"?',
    "[8 mm x 1 mm, 6 mm x 3 mm] -> []": "a list of",
    "sizes: [8 mm x 1 mm, 6 mm x 3 mm] -> ": "sizes is missing",
    "c1: 145 kPa,  -> ": "material.c1 is missing",
    "145 kPa -> -145 kPa": "material.c1 must be a positive",
    "950 kg/m^3 -> 950": "material.density must be a density",
    "name: mine -> nme: mine": "nme is not a field here",
    f"{GOOD} -> ": "cannot be read: it is empty",
}
HARDLY_MEANT = {
    "8 mm x 1 mm -> 8 m x 1 m": "mine.yaml:3:9: inner_radius of 8 m x 1 m is not between",
    "6 mm x 3 mm -> 6 mm x 9 mm": "mine.yaml:3:22: wall_thickness of 6 mm x 9 mm is 3 times",
    "145 kPa -> 145 MPa": "mine.yaml:2:1: material has a Young's modulus of 870 MPa",
    "950 kg/m^3 -> 0.95 kg/m^3": "mine.yaml:2:52: material.density 0.95 kg/m^3 is not",
}


@pytest.mark.parametrize("change", BAD)
def test_a_bad_file_is_refused_in_its_place(change):
    with pytest.raises(DescriptionError) as raised:
        changed(change)
    assert BAD[change] in str(raised.value)


@pytest.mark.parametrize("change", HARDLY_MEANT)
def test_tubing_that_is_hardly_meant_is_named(change):
    (found,) = changed(change).warnings
    assert found.startswith(HARDLY_MEANT[change])


def test_the_design_names_what_is_hardly_meant_of_the_tubing_it_takes(said):
    Path("mine.yaml").write_text(GOOD.replace("950 kg", "0.95 kg"))
    needs = "--radius-min 8mm --radius-max 15mm --beta 70deg --paper --tube '6 mm x 1 mm'"
    printed = said("design --tubing mine.yaml", needs)
    assert "warning: mine.yaml:2:52: material.density" in printed
    assert "warning: wall_thickness of 6 mm x 1 mm is 0.33 of the bore radius" in printed
