# SPDX-License-Identifier: Apache-2.0
"""``calibrate --free-swing``: from a CSV file to the damping, and refusals by name."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from spiral_gripper.cli.main import run

DATA = Path(__file__).parents[2] / "examples" / "data"
GRIPPER, SWING = str(DATA / "my_gripper.yaml"), DATA / "free_swing.csv"


def asked(path: Path, *options: str) -> list[str]:
    return ["calibrate", GRIPPER, str(path), "--free-swing", *options]


def test_the_example_tells_the_damping_it_was_made_with(capsys) -> None:
    assert run(asked(SWING, "--json")) == 0
    told = json.loads(capsys.readouterr().out)
    low, high = told["values"]["retardation_time"]["interval"]
    assert low < 0.020 < high
    low, high = told["values"]["air"]["interval"]
    assert low < 1.0 < high
    assert told["warnings"] == []


def test_the_report_holds_values_intervals_and_what_is_held(capsys) -> None:
    assert run(asked(SWING, "--hold", "air=1")) == 0
    told = capsys.readouterr().out
    assert "free swing of 1.1" in told
    assert "retardation_time: 0.0" in told
    assert "95 % interval" in told
    assert "air:" not in told


def test_an_error_stated_beside_the_file_is_that_of_its_column(tmp_path, capsys) -> None:
    path = tmp_path / "swing.csv"
    cells = [line.split(",") for line in SWING.read_text(encoding="utf-8").splitlines()[1:]]
    path.write_text("\n".join(f"{t},{y},{p}" for t, y, _, p in cells), encoding="utf-8")
    assert run(asked(SWING, "--json")) == 0
    told = capsys.readouterr().out
    assert run(asked(path, "--json", "--error", "displacement=0.3 mm")) == 0
    assert capsys.readouterr().out == told


def changed(folder: Path, old: str, new: str) -> Path:
    path = folder / "swing.csv"
    text = SWING.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("time [s]", "time [min]", "check the unit of time"),
        ("displacement [mm]", "displacement [in]", "check the unit"),
        (
            "displacement [mm]",
            "extension [mm]",
            "no column holds a measurement: one of displacement",
        ),
        ("displacement_error [mm]", "arc_length [mm]", '"displacement_error": is missing'),
        ("displacement_error [mm]", "arc_length [mm]", "does not belong to a free swing"),
        ("1.04,", "1.00,", "holds a time twice"),
        ("1.04,", ",", "is blank"),
        ("1.04,", "abc,", ":4: column 1"),
        ("0.3,0\n1.04", "0.3,5\n1.04", "one gauge pressure"),
        ("0.3,0\n1.04", "-0.3,0\n1.04", "positive"),
        ("0.3,0\n", "0.3,900\n", "at most the gripper's limit"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_by_name(tmp_path, capsys, old, new, said) -> None:
    assert run(asked(changed(tmp_path, old, new))) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--hold", "c1=100 kPa"], "air: a free swing"),
        (["--hold", "air=-1"], "air"),
        (["--law", "yeoh"], "leave --law out"),
        (["--plot", "a.png"], "leave --plot out"),
        (["--measured-curve"], "excludes other kinds"),
        (["--save", "a.yaml"], "writes no gripper file"),
        (["--error", "extension=1 mm"], "only these can have one: displacement"),
        ([str(SWING)], "one file, one swing"),
    ],
)
def test_options_that_do_not_belong_are_refused_by_name(capsys, options, said) -> None:
    assert run(asked(SWING, *options)) == 2
    assert said in capsys.readouterr().err


def test_a_swing_is_no_reading_of_the_law(capsys) -> None:
    assert run(["calibrate", GRIPPER, str(SWING)]) == 2
    assert "use --free-swing" in capsys.readouterr().err


def test_a_large_swing_is_warned_of(tmp_path, capsys) -> None:
    path = tmp_path / "swing.csv"
    _, head, *rows = SWING.read_text(encoding="utf-8").splitlines()
    cells = [row.split(",") for row in rows]
    wide = [f"{t},{2.0 * float(y)},{e},{p}" for t, y, e, p in cells]
    path.write_text("\n".join([head, *wide]), encoding="utf-8")
    assert run(asked(path)) == 0
    assert "the swing is large" in capsys.readouterr().out
