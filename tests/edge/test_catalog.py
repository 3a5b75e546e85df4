# SPDX-License-Identifier: Apache-2.0
"""The shipped grippers, and how a name or a path finds its file."""

import math
from pathlib import Path

import pytest

from spiral_core import MooneyRivlin, PressureLaw
from spiral_gripper import DescriptionError, available_grippers, load_description, load_gripper
from spiral_gripper.files.catalog import find_description

CONFIG = Path(__file__).parents[2] / "spiral_gripper/spiral_gripper/config"
SHIPPED = ("paper_design_70", "prototype_p1", "prototype_p2")


def test_the_shipped_grippers_are_the_files_in_config():
    assert available_grippers() == SHIPPED
    assert available_grippers() == tuple(sorted(path.stem for path in CONFIG.glob("*.yaml")))


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_files_load_under_their_name(name):
    description = load_description(name)
    assert description.gripper.name == name
    assert description.description
    assert description.source.read_bytes() == (CONFIG / f"{name}.yaml").read_bytes()
    assert load_gripper(CONFIG / f"{name}.yaml") == load_gripper(name)


@pytest.mark.parametrize(
    ("name", "beta", "length"),
    [("prototype_p1", 50, 0.5), ("prototype_p2", 60, 0.5), ("paper_design_70", 70, 0.361)],
)
def test_shipped_files_say_what_the_paper_and_our_readings_say(name, beta, length):
    description = load_description(name)
    actuator, gripper = description.actuator, description.gripper
    assert actuator.tube.inner_radius == 4.7625e-3
    assert actuator.tube.wall_thickness == 0.794e-3
    assert actuator.tube.length == length
    assert actuator.fibers.alpha == pytest.approx(math.radians(88), rel=1e-15)
    assert actuator.fibers.beta == pytest.approx(math.radians(beta), rel=1e-15)
    assert actuator.material == MooneyRivlin(c1=130e3, c2=15e3)
    assert description.density == 950.0
    assert gripper.gravity == (9.80665, 0.0, 0.0)
    assert gripper.object_axis is None
    # The highest pressure at which the paper shows shapes: eight steps of 2 psi.
    assert gripper.pressure_max == pytest.approx(8 * 13.7895e3, rel=2e-6)  # stated to six digits
    assert gripper.turns_required == 1.05


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_files_say_where_each_figure_comes_from(name):
    lines = (CONFIG / f"{name}.yaml").read_text(encoding="utf-8").splitlines()
    figures = [line for line in lines if ": " in line and not line.lstrip().startswith("#")]
    commented = [line for line in figures if " # " in line]
    # Explained by a comment above them or by their unit alone.
    plain = ("name", "description", "c1", "c2", "density", "gravity_magnitude")
    assert len(commented) >= 10
    assert all(line.strip().startswith(plain) for line in figures if line not in commented)
    assert all(len(line) <= 100 for line in lines)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_files_say_which_law_their_constants_belong_to(name):
    description = load_description(name)
    assert description.written["model.pressure_law"] == "uniform"
    assert description.actuator.pressure_law is PressureLaw.UNIFORM
    comments = (CONFIG / f"{name}.yaml").read_text(encoding="utf-8").split("model:")[1]
    said = " ".join(line.strip().removeprefix("#").strip() for line in comments.splitlines())
    assert "which assumes an evenly stretched wall; they are valid only with it" in said


def test_a_name_is_a_shipped_gripper_whatever_the_folder_holds(tmp_path, monkeypatch):
    (tmp_path / "prototype_p1").write_text("name: impostor\n")
    monkeypatch.chdir(tmp_path)
    assert load_gripper("prototype_p1").name == "prototype_p1"
    with pytest.raises(DescriptionError):
        load_gripper("./prototype_p1")


@pytest.mark.parametrize("path", ["mine.yaml", "./mine", "folder/mine", Path("mine")])
def test_everything_else_is_a_path(path):
    assert find_description(path) == Path(path)


LIST = (
    "the shipped grippers are paper_design_70, prototype_p1, prototype_p2; "
    "write a path for any other file"
)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        (
            "prototype_p3",
            (
                "prototype_p3: this file cannot be read: no gripper has this name; "
                f"did you mean prototype_p2? {LIST}"
            ),
        ),
        (
            "xyzzy",
            f"xyzzy: this file cannot be read: no gripper has this name; {LIST}",
        ),
        (
            "",
            '"": this file cannot be read: no gripper has this name; ' + LIST,
        ),
        (
            "protoype_p1.yaml",
            (
                "protoype_p1.yaml: this file cannot be read: there is no such file; "
                f"did you mean prototype_p1? {LIST}"
            ),
        ),
        (
            ".",
            ".: this file cannot be read: it is a folder",
        ),
        (
            "a\x00b.yaml",
            (f"a\x00b.yaml: this file cannot be read: its name holds a null character; {LIST}"),
        ),
    ],
)
def test_a_file_that_is_not_there(tmp_path, monkeypatch, asked, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DescriptionError) as caught:
        load_gripper(asked)
    assert str(caught.value) == message
    assert caught.value.problems[0].line is None


def test_a_file_that_is_no_text(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_bytes(b"name: \xff\n")
    with pytest.raises(DescriptionError, match=r"it is not text in UTF-8 \(byte 7 is 0xff\)"):
        load_gripper(path)


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path):
    text = (CONFIG / "prototype_p1.yaml").read_text(encoding="utf-8")
    path = tmp_path / "mine.yaml"
    path.write_bytes(text.replace("\n", "\r\n").encode("utf-8-sig"))
    assert load_gripper(path) == load_gripper("prototype_p1")
    path.write_bytes(text.replace("500 mm", "500").replace("\n", "\r\n").encode("utf-8-sig"))
    with pytest.raises(DescriptionError) as caught:
        load_gripper(path)
    assert (
        caught.value.problems[0].line
        == text.splitlines().index("  length: 500 mm                # the paper") + 1
    )
