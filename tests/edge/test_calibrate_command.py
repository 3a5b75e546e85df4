# SPDX-License-Identifier: Apache-2.0
"""The command calibrate: from CSV files to what people read."""

import json

import numpy as np
import pytest
from edge.calibrate_cases import TRUE_C1, bench_folder, bench_test, run

from spiral_core import (
    FittedQuantity,
    FreeActuation,
    InvalidInputError,
    measured_actuation_from_readings,
)
from spiral_core.calibration.regression import DEFAULT_LEVEL
from spiral_core.calibration.uncertainty import DRAWS_MIN
from spiral_gripper import load_description, load_gripper
from spiral_gripper.cli import calibrate as cli_calibrate
from spiral_gripper.files.fields import LAWS

pytestmark = pytest.mark.long


@pytest.fixture
def folder(tmp_path):
    return bench_folder(tmp_path)


def test_the_command_goes_from_csv_to_file_and_picture(folder):
    result = run(
        folder, "--law", "neo_hookean", "--law", "mooney_rivlin", "--radius", "20 mm",
        "--plot", str(folder / "residuals.png"),
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    lines = result.output.splitlines()
    assert lines[0] == "law: NeoHookean"
    assert any(line.startswith("c1: 1") and "95 % interval" in line for line in lines)
    assert any(line.startswith("leave-one-out error: ") for line in lines)
    assert any(line.startswith("20 mm: ") for line in lines)
    assert lines[-1] == f"wrote {folder / 'mine_calibrated.yaml'}"
    assert (folder / "residuals.png").exists()
    c1 = load_description(folder / "mine_calibrated.yaml").actuator.material.c1
    assert c1 == pytest.approx(TRUE_C1, rel=0.02)


def test_the_command_reports_only_if_asked(folder):
    result = run(folder, "--law", "neo_hookean", "--no-save", "--draws", "40",
                 "--radius", "2 cm", "--level", "0.9", "--hold", "c1=150 kPa")  # fmt: skip
    assert result.exit_code == 2  # nothing is left to fit
    result = run(folder, "--hold", "c2=0 kPa", "--no-save", "--draws", "40", "--radius", "2 cm",
                 "--level", "0.9", "--robust")  # fmt: skip
    assert result.exit_code == 0, result.output
    assert "90 % interval" in result.output
    assert not list(folder.glob("*_calibrated*"))


def test_the_command_writes_a_measured_curve(folder):
    description = load_description(folder / "mine.yaml")
    lines = ["pressure [kPa],bend_angle [deg],twist [deg]"]
    length = description.actuator.tube.length
    for kilopascals in (20, 40, 60, 80, 100, 111):
        shape = FreeActuation(description.actuator).unloaded_shape(kilopascals * 1e3)
        bend, twist = np.degrees([shape.curvature * length, shape.torsion * length])
        lines.append(f"{kilopascals},{bend:.4f},{twist:.4f}")
    (folder / "bench.csv").write_text("\n".join(lines) + "\n")
    result = run(
        folder, "--measured-curve", "--error", "bend_angle=1 deg", "--error", "twist=1 deg"
    )
    assert result.exit_code == 0, result.output
    assert result.output.splitlines()[0] == "measured up to 111 kPa"
    errors = ["--error", "bend_angle=1 deg", "--error", "twist=1 deg"]
    before = set(folder.iterdir())
    assert run(folder, "--measured-curve", *errors, "--no-save").exit_code == 0
    assert set(folder.iterdir()) == before
    refused = run(folder, "--measured-curve", *errors, "--radius", "20 mm")
    assert "--measured-curve fits nothing: leave --radius out" in refused.output
    bends = "\n".join(line.rpartition(",")[0] for line in lines) + "\n"
    (folder / "bench.csv").write_text(bends)
    refused = run(folder, "--measured-curve", *errors[:2])
    assert refused.exit_code == 2
    assert "bend angles and twists: fibers at alpha and beta" in refused.output
    expected = description.gripper.unloaded_shape(50.0e3).curvature
    found = load_gripper(folder / "mine_measured.yaml").unloaded_shape(50.0e3).curvature
    assert found == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--hold", "c2"], 'of the form NAME=VALUE, such as "c2='),
        (["--error", "2 mm"], 'of the form NAME=VALUE, such as "extension=0.2 mm", got'),
        (["--error", "coil=2 mm"], "--error must be for one of pressure, extension, twist, bend"),
        (["--error", "twist=2 deg"], "a column of the files: extension, pressure, got 'twist'"),
        (["--error", "extension=2 psi"], "--error extension must be a length with its unit"),
        (["--error", "extension=-1 %"], "--error extension must be positive, got '-1 %'"),
        (["--hold", "density=1 kPa"], "a constant of the law"),
        (["--hold", "c2=1 mm"], "--hold c2"),
        (["--hold", "c2=1e9kPa"], "--hold c2 must be at most 100 MPa in size"),
        (["--hold", "c2=-101 MPa"], "those of rubber are 0.01 to 1 MPa"),
        (["--hold", "extension_limit=1e-9"], "must be from 0.1 to 10000: I1 - 3 at full"),
        (["--hold", "c2=50 MPa"], "held constants must be such that some c1 makes a law"),
        (["--hold", "c2=-1 MPa"], "held constants must be such that some c1 makes a law"),
        (["--unit", "pressure=psi", "--unit", "pressure=kPa"], "given once"),
        (["--section-length", "100"], "--section-length"),
        (["--radius", "20"], "length"),
        (["--ignore", "remark"], "no such heading"),
        (["--radius", "1 m"], "cannot be gripped"),
        (["--save", "{folder}/mine.yaml"], "exists already and is kept"),
        (["--save", "{folder}/new.yaml", "--no-save"], "exclude each other"),
        (["--plot", "{folder}/x.bmp"], ".png, .svg, .pdf"),
        (["--section-length", "1e300 m"], "at most 10 m"),
        (["--section-length", "-1 mm"], "above 0"),
        (["--unit", "twist=deg"], "extension_error, pressure, section_length, got 'twist'"),
    ],
)
def test_the_command_explains_what_is_wrong(folder, arguments, message):
    result = run(folder, *(text.format(folder=folder) for text in arguments))
    assert result.exit_code == 2
    assert message in result.output
    assert "Traceback" not in result.output


def test_a_bad_file_is_reported_by_the_command_with_its_place(folder):
    (folder / "bench.csv").write_text(bench_test().replace("\n3,", "\nthree,"))
    result = run(folder)
    assert result.exit_code == 2
    assert f'{folder / "bench.csv"}:4: column 1 "pressure [psi]": must be' in result.output


def test_curves_need_bend_angles(folder):
    description = load_description(folder / "mine.yaml")
    with pytest.raises(InvalidInputError):
        measured_actuation_from_readings([], 0.5, description.actuator.fibers)


def test_the_commands_choices_are_those_of_the_code():
    assert tuple(LAWS) == cli_calibrate.LAWS
    assert tuple(quantity.value for quantity in FittedQuantity) == cli_calibrate.QUANTITIES
    assert cli_calibrate.DEFAULT_LEVEL == DEFAULT_LEVEL
    assert cli_calibrate.DRAWS_MIN == DRAWS_MIN


@pytest.mark.parametrize("option", [("--seed", "-1"), ("--draws", "1000000000")])
def test_draws_that_cannot_be_are_refused(folder, option):
    result = run(folder, "--no-save", "--radius", "20 mm", *option)
    assert result.exit_code == 2
    assert f"'{option[0]}'" in result.output


def test_the_calibration_in_json_is_the_report(folder):
    result = run(folder, "--json", "--radius", "20 mm", "--law", "neo_hookean", "--no-save")
    document = json.loads(result.output)
    assert document["law"] == "NeoHookean"
    low, high = document["values"]["c1"]["interval"]
    assert low < TRUE_C1 < high
    (pressure,) = document["pressures"]
    assert pressure["radius"] == 0.02
    assert pressure["interval"][0] < pressure["pressure"] < pressure["interval"][1]
    (warning,) = document["warnings"]
    (rival,) = pressure["rivals"]
    assert "do not tell the fitted law from NeoHookean, exact curvature" in warning
    assert pressure["own_interval"][1] < rival["pressure"] < pressure["interval"][1]
    assert max(map(abs, document["standardized_residuals"])) < 4.0


def test_a_radius_out_of_reach_comes_after_file_and_picture(folder):
    picture = folder / "residuals.png"
    result = run(folder, "--radius", "20 mm", "--radius", "1 m", "--plot", str(picture))
    assert result.exit_code == 2
    assert picture.exists()
    assert (folder / "mine_calibrated.yaml").exists()
    assert "\n20 mm: " in result.output
    assert result.output.splitlines()[-1].startswith(
        "spiral-gripper: an object of radius 1 m cannot be gripped"
    )


@pytest.mark.parametrize("suffix", [".md", ".html"])
def test_the_report_in_one_file_holds_every_figure_and_the_picture(folder, suffix):
    file = folder / f"report{suffix}"
    arguments = ("--radius", "20 mm", "--radius", "1 m", "--no-save", "--report", str(file))
    result = run(folder, *arguments)
    assert result.exit_code == 2
    text = file.read_text(encoding="utf-8")
    printed = result.output.split("spiral-gripper:")[0].splitlines()
    lines = [line for line in printed if ": " in line and not line.startswith("wrote")]
    assert any(line.startswith("warning: ") for line in lines)
    assert len(lines) > 5
    for line in lines:
        name, _, value = line.partition(": ")
        assert name.strip() in text
        assert value in text.replace("&#x27;", "'")
    assert "an object of radius 1 m cannot be gripped" in text
    assert text.count("data:image/png;base64,") == 2  # the residuals, and pressure against radius
