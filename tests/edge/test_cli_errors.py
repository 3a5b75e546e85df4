# SPDX-License-Identifier: Apache-2.0
"""The command line: one clear line for whatever is wrong."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from edge.cli_cases import WRAP, error_of

from spiral_core import (
    InvalidInputError,
    NoCoilError,
    NotGrippableError,
    SpiralError,
)
from spiral_core.message import Message, Quantity
from spiral_gripper.cli.main import run
from spiral_gripper.cli.types import TypedValue, error_text

TOO_THIN = Message("too thin for the limit of {}", Quantity(162000.0, "Pa"))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("position, radius [mm]\n0, 1\n", 'has no unit; write "position [mm]"'),
        ("position [mm]\n0\n", "columns with units"),
        ("position [mm], radius [mm]\n0,\n", "is blank, but a profile requires it"),
        ("position [mm], radius [kPa]\n0, 1\n", "not a length"),
        ("position [mm], radius [mm]\n0, a\n", "number"),
        ("position [mm], radius [mm]\n0\n", "has 1 cells, but the header has 2"),
        (
            f"position [mm], radius [mm]\n0, {'9' * 200_000}\n",
            "not a line of comma-separated values",
        ),
        ("", "holds no table"),
    ],
)
def test_a_bad_profile_is_named(
    text: str, expected: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "profile.csv"
    path.write_text(text, encoding="utf-8")
    assert expected in error_of(capsys, "wrap", "prototype_p1", "--profile", str(path))


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (
            NotGrippableError(0.06, "too thick for 1.05 turns", -0.0222, 0.0378211),
            (
                "an object of radius 6 cm cannot be gripped: too thick for 1.05 turns; "
                "the nearest grippable radius is 3.782 cm"
            ),
        ),
        (
            NotGrippableError(0.001, TOO_THIN, -1.0, 0.00378219),
            (
                "an object of radius 1 mm cannot be gripped: too thin for the limit of 23.5 psi; "
                "the nearest grippable radius is 0.3783 cm"
            ),
        ),
        (
            NotGrippableError(0.5, "no", -1.0, None),
            "the object cannot be gripped: no",
        ),
        (
            InvalidInputError("radius_max", 0.06, Message("at least {}", Quantity(0.1, "m"))),
            "--radius-max must be at least 10 cm, got 6 cm",
        ),
        (
            InvalidInputError("angle", 0.5, "at most 1 m", "rad"),
            "angle must be at most 1 m, got 28.65 deg",
        ),
        (
            NoCoilError(0.5, 1.05, 82737.0),
            (
                "the gripper makes 0.5 turns at most (at 12 psi) but 1.05 are required; "
                "lengthen it, raise the pressure limit or ask for fewer turns"
            ),
        ),
    ],
)
def test_messages_are_in_the_units_that_were_typed(error: SpiralError, expected: str) -> None:
    givens = {
        "radius_max": [TypedValue("--radius-max", 0.06, "6 cm", "LENGTH")],
        "radius_min": [TypedValue("--radius-min", 0.001, "1 mm", "LENGTH")],
        "pressure_max": [TypedValue("--pressure-max", 89631.0, "13 psi", "PRESSURE")],
        "turns": [TypedValue("--turns", 0.5, "0.5", "")],
    }
    assert error_text(error, givens) == expected


def test_a_full_disk_is_said_in_one_line() -> None:
    for command in (["--help"], WRAP, ["doctor", "nowhere"]):
        with Path("/dev/full").open("w", encoding="utf-8") as full:
            done = subprocess.run(
                [sys.executable, "-m", "spiral_gripper.cli.main", *command],
                stdout=full, stderr=subprocess.PIPE, text=True, check=False,
            )  # fmt: skip
        assert done.returncode == 2
        assert done.stderr == "spiral-gripper: the answer cannot be printed: the disk is full\n"


def test_a_diameter_is_told_to_be_halved(capsys):
    said = error_of(capsys, "wrap", "prototype_p1", "--diameter", "32 mm")
    assert said.endswith("No such option '--diameter'. Give the radius, half the diameter.\n")


def test_without_viser_one_line_says_what_to_install(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    assert "the studio needs viser: pip install 'spiral-gripper[studio]'" in error_of(
        capsys, "studio", "prototype_p1", "--no-browser"
    )


def test_defects_are_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("a defect")

    monkeypatch.setattr("spiral_gripper.reports.wrap_document.solve_shape", broken)
    with pytest.raises(ZeroDivisionError, match="a defect"):
        run(["shape", "prototype_p1", "--pressure", "5 kPa"])
