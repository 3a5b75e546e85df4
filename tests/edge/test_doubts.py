# SPDX-License-Identifier: Apache-2.0
"""Values that are possible but most likely not meant are named, with their place."""

from pathlib import Path

import pytest

from spiral_gripper import available_grippers, load_description
from spiral_gripper.cli.main import run
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.description import parse_description

TEXT = (GRIPPERS.path / "prototype_p1.yaml").read_text(encoding="utf-8")


def doubts(old, new):
    """Return the doubts about the shipped file with one text replaced, its limit out of reach."""
    assert old in TEXT
    text = TEXT.replace(old, new).replace("pressure_max: 16 psi", "pressure_max: 1 Pa")
    return parse_description(text, Path("mine.yaml")).doubts


@pytest.mark.parametrize("name", available_grippers())
def test_the_shipped_grippers_are_beyond_doubt(name):
    assert load_description(name).doubts == ()


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            "inner_radius: 4.7625 mm",
            "inner_radius: 4.7625 m",
            "mine.yaml:12:17: tube.inner_radius 4.7625 m is not between 0.1 mm and 100 mm",
        ),
        ("inner_radius: 4.7625 mm", "inner_radius: 99 mm", None),
        ("inner_radius: 4.7625 mm", "inner_radius: 0.05 mm", "is not between 0.1 mm"),
        ("wall_thickness: 0.794 mm", "wall_thickness: 1.19 mm", None),
        (
            "wall_thickness: 0.794 mm",
            "wall_thickness: 1.2 mm",
            "is 0.25 of the bore radius: the model takes one strain for the whole wall",
        ),
        ("wall_thickness: 0.794 mm", "wall_thickness: 9 mm", "is 1.9 of the bore radius"),
        ("wall_thickness: 0.794 mm", "wall_thickness: 10 mm", "is 2.1 times the bore radius"),
        ("c1: 130 kPa", "c1: 130 MPa", "material has a Young's modulus of 780 MPa"),
        ("c1: 130 kPa", "c1: 3 MPa", None),
        ("c1: 130 kPa", "c1: -14 kPa", "modulus of 0.006 MPa; elastomers have 0.01 to 20 MPa"),
        ("density: 0.95 g/cm^3", "density: 0.95 kg/m^3", "material.density 0.95 kg/m^3 is not"),
        ("density: 0.95 g/cm^3", "density: 4.1 g/cm^3", "100 and 4000 kg/m^3"),
    ],
)
def test_a_value_that_is_hardly_meant_is_named(old, new, expected):
    found = doubts(old, new)
    if expected is None:
        assert found == ()
        return
    assert any(expected in doubt for doubt in found), found


def test_the_command_line_warns_and_goes_on(tmp_path, capsys):
    path = tmp_path / "mine.yaml"
    path.write_text(TEXT.replace("0.95 g/cm^3", "0.95 kg/m^3"), encoding="utf-8")
    assert run(["shape", str(path), "--pressure", "8 psi"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("prototype_p1 at 8 psi")
    assert captured.err.startswith(f"warning: {path}:")
    assert captured.err.count("\n") == 1
