# SPDX-License-Identifier: Apache-2.0
"""Values that are possible but most likely mistakes cause warnings, with their place."""

from pathlib import Path

import pytest

from spiral_gripper import DescriptionError, available_grippers, load_description
from spiral_gripper.cli.main import run
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.description import parse_description
from spiral_gripper.files.tubing import parse_tubing

TEXT = (GRIPPERS.path / "prototype_p1.yaml").read_text(encoding="utf-8")


def warnings(old, new):
    """Return the warnings about the shipped file with one text replaced, its limit out of reach."""
    assert old in TEXT
    text = TEXT.replace(old, new).replace("pressure_max: 16 psi", "pressure_max: 1 Pa")
    return parse_description(text, Path("mine.yaml")).warnings


@pytest.mark.parametrize("name", available_grippers())
def test_the_shipped_grippers_have_no_warnings(name):
    assert load_description(name).warnings == ()


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
            "holds up to 0.25; calibrate it, or set model.thick_wall to true",
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
    found = warnings(old, new)
    if expected is None:
        assert found == ()
        return
    assert any(expected in warning for warning in found), found


def test_a_pressure_limit_far_beyond_the_tube_is_named():
    text = TEXT.replace("beta: 50 deg", "beta: 86 deg").replace("16 psi", "1.2 MPa")
    (warning,) = parse_description(text, Path("mine.yaml")).warnings
    assert warning.startswith("mine.yaml:")
    assert "limits.pressure_max 1.2 MPa stresses the wall alone with 8.3 times" in warning


def test_a_pressure_that_a_doubtful_value_rules_out_is_refused_with_the_doubt():
    text = TEXT.replace("inner_radius: 4.7625 mm", "inner_radius: 4.75 m")
    with pytest.raises(DescriptionError, match=r"limits\.pressure_max must be at most") as caught:
        parse_description(text, Path("mine.yaml"))
    assert "mine.yaml:12:17: tube.inner_radius 4.75 m is not between" in str(caught.value)


def test_the_command_line_warns_and_goes_on(tmp_path, capsys):
    path = tmp_path / "mine.yaml"
    path.write_text(TEXT.replace("0.95 g/cm^3", "0.95 kg/m^3"), encoding="utf-8")
    assert run(["shape", str(path), "--pressure", "8 psi"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("prototype_p1 at 8 psi")
    assert captured.err.startswith(f"warning: {path}:")
    assert captured.err.count("\n") == 1


TUBING_TEXT = """\
name: mine
material: {law: neo_hookean, c1: 145 kPa, density: 950 kg/m^3}
sizes: [8 mm x 1 mm, 6 mm x 3 mm]
"""


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("8 mm x 1 mm", "8 mm x 1 mm", None),
        ("8 mm x 1 mm", "8 m x 1 m", "mine.yaml:3:9: inner_radius of 8 m x 1 m is not between"),
        ("6 mm x 3 mm", "6 mm x 9 mm", "mine.yaml:3:22: wall_thickness of 6 mm x 9 mm is 3 times"),
        ("145 kPa", "145 MPa", "mine.yaml:2:1: material has a Young's modulus of 870 MPa"),
        ("950 kg/m^3", "0.95 kg/m^3", "mine.yaml:2:52: material.density 0.95 kg/m^3 is not"),
    ],
)
def test_tubing_that_is_hardly_meant_is_named(old, new, expected):
    found = parse_tubing(TUBING_TEXT.replace(old, new), Path("mine.yaml")).warnings
    if expected is None:
        assert found == ()
    else:
        assert len(found) == 1
        assert found[0].startswith(expected)


def test_the_design_names_what_is_hardly_meant_of_the_tubing_it_takes(tmp_path, capsys):
    path = tmp_path / "mine.yaml"
    path.write_text(TUBING_TEXT.replace("950 kg", "0.95 kg"), encoding="utf-8")
    radii = ["--radius-min", "8 mm", "--radius-max", "15 mm", "--beta", "70 deg"]
    assert run(["design", *radii, "--tubing", str(path), "--tube", "6 mm x 1 mm"]) == 0
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith(f"warning: {path}:2:52: material.density")
    assert second.startswith("warning: wall_thickness of 6 mm x 1 mm is 0.33 of the bore radius")
