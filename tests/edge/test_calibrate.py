# SPDX-License-Identifier: Apache-2.0
"""From files to a calibrated gripper file: the run, the file, the picture and the command."""

import contextlib
import io
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from spiral_core import (
    FittedQuantity,
    FreeActuation,
    InvalidInputError,
    MeasuredActuation,
    MooneyRivlin,
    NeoHookean,
    ShapeReading,
    WrapCurve,
    measured_actuation_from_readings,
)
from spiral_core.calibration.result import DEFAULT_LEVEL
from spiral_core.calibration.uncertainty import DRAWS_MIN
from spiral_gripper import DescriptionError, load_description, load_gripper
from spiral_gripper.bench.calibrated_file import (
    calibrated_text,
    write_calibrated_description,
    write_measured_description,
)
from spiral_gripper.bench.errors import MeasurementError
from spiral_gripper.bench.measurements import Measurements, load_measurements
from spiral_gripper.bench.report import outlier_warnings, warnings_of
from spiral_gripper.bench.residual_plot import residual_figure
from spiral_gripper.bench.run import CalibrationRequest, run_calibration
from spiral_gripper.cli import calibrate as cli_calibrate
from spiral_gripper.cli import main as cli
from spiral_gripper.files.fields import LAWS
from spiral_gripper.files.storage import FileError
from spiral_gripper.reports.style import save_figure

PSI = 6894.757293168361
TRUE_C1 = 160.0e3


@pytest.fixture
def folder(tmp_path):
    """Return a folder with a gripper file of wrong constants and a bench test of the right ones."""
    source = load_description("paper_design_70").source
    shutil.copy(source, tmp_path / "mine.yaml")
    (tmp_path / "bench.csv").write_text(bench_test(), encoding="utf-8")
    return tmp_path


def bench_test(unit="psi", per_unit=PSI, stiffer=1.0, rows=range(1, 15)):
    """Return a synthetic bench test: extension of a 100 mm section, noise of 0.1 mm."""
    actuator = load_description("paper_design_70").actuator
    truth = FreeActuation(replace(actuator, material=NeoHookean(c1=TRUE_C1)))
    noise = np.random.default_rng(8)
    lines = [f"pressure [{unit}],extension [mm],extension_error [mm],section_length [mm]"]
    for row in rows:
        extension = 100.0 * (truth.stretch_from_pressure(row * PSI) - 1.0)
        pressure = row * stiffer * PSI / per_unit
        lines.append(f"{pressure:.6g},{extension + 0.1 * noise.standard_normal():.3f},0.1,100")
    return "\n".join(lines) + "\n"


def fitted(folder, **request):
    """Return the description, the measurements and the choice of laws."""
    description = load_description(folder / "mine.yaml")
    measurements = load_measurements(folder / "bench.csv", description.actuator.tube.length)
    return (
        description,
        measurements,
        run_calibration(description, [measurements], CalibrationRequest(**request)),
    )


class Result(NamedTuple):
    """What a command did: its exit code, and what it wrote to both streams."""

    exit_code: int
    output: str


def run(folder, *arguments):
    """Run the command on the files of the folder."""
    files = [str(folder / "mine.yaml"), str(folder / "bench.csv")]
    written = io.StringIO()
    with contextlib.redirect_stdout(written), contextlib.redirect_stderr(written):
        exit_code = cli.run(["calibrate", *files, *arguments])
    return Result(exit_code, written.getvalue())


def test_the_description_gives_law_start_and_mount(folder):
    description, _, choice = fitted(folder, laws=("mooney_rivlin",))
    assert choice.best.model.fitted_law is MooneyRivlin
    assert choice.best.model.gripper is description.gripper
    _, _, choice = fitted(folder, laws=("neo_hookean", "mooney_rivlin"))
    assert choice.best.model.fitted_law is NeoHookean
    low, high = choice.best.interval("c1")
    assert low < TRUE_C1 < high


def test_stiffness_is_kept_only_where_the_file_states_it(folder):
    _, _, choice = fitted(folder)
    assert choice.best.model.bending_stiffness is None
    path = folder / "mine.yaml"
    path.write_text(path.read_text() + "\nstiffness:\n  bending: 5e-4 N m^2\n")
    _, _, choice = fitted(folder)
    assert choice.best.model.bending_stiffness == 5.0e-4
    assert choice.best.model.torsional_stiffness is None


def in_bars(text):
    """Return a bench test whose kilopascals are called bars."""
    return text.replace("pressure [kPa]", "pressure [bar]")


def test_readings_that_only_a_mix_up_of_units_gives_are_refused_unless_accepted(folder):
    (folder / "bench.csv").write_text(in_bars(bench_test("kPa", per_unit=1.0e3)))
    with pytest.raises(MeasurementError) as caught:
        fitted(folder)
    (problem,) = caught.value.problems
    assert (problem.line, problem.heading) == (2, "pressure, extension")
    assert "no elastomer gives these readings with the described tube, but kPa" in problem.reason
    _, _, choice = fitted(folder, accept_implausible=True, laws=("neo_hookean",))
    assert choice.best.value("c1") == pytest.approx(TRUE_C1 * 100.0, rel=0.02)


@pytest.mark.parametrize("factor", [0.15, 4.0, 6.0, 8.0])
def test_a_rubber_of_another_stiffness_is_fitted_and_named(folder, factor):
    (folder / "bench.csv").write_text(bench_test(stiffer=factor))
    result = run(folder)
    assert result.exit_code == 0, result.output
    (warning,) = [line for line in result.output.splitlines() if "modulus" in line]
    assert warning.startswith("warning: the fitted rubber's modulus is ")
    assert ("taken for" in warning) == (factor in (0.15, 6.0, 8.0))
    assert "(--section-length)" in warning
    c1 = load_description(folder / "mine_calibrated.yaml").actuator.material.c1
    assert c1 == pytest.approx(TRUE_C1 * factor, rel=0.05)


def test_laws_that_fail_are_reported_and_all_failing_is_an_error(folder):
    request = {"laws": ("mooney_rivlin", "neo_hookean"), "fixed": {"c2": 0.0}}
    _, _, choice = fitted(folder, **request)
    assert [name for name, _ in choice.failures] == ["neo_hookean"]
    with pytest.raises(InvalidInputError):
        fitted(folder, fixed={"c3": 0.0})
    with pytest.raises(InvalidInputError, match="one of neo_hookean"):
        CalibrationRequest(laws=("ogden",))


def test_the_calibrated_file_keeps_comments_and_gives_back_the_fit(folder):
    description, measurements, choice = fitted(folder, laws=("neo_hookean",))
    path = write_calibrated_description(description, choice.best, [measurements.source])
    assert path == folder / "mine_calibrated.yaml"
    text = path.read_text(encoding="utf-8")
    opening, _, rest = text.partition("\n")
    assert opening.startswith("# Calibrated: neo_hookean fitted to bench.csv, 14 readings")
    original = (folder / "mine.yaml").read_text(encoding="utf-8")
    changed = {"law:", "c1:", "c2:"}
    kept = [line for line in original.splitlines() if not changed & set(line.split())]
    assert [line for line in rest.splitlines() if not changed & set(line.split())] == kept
    assert "  law: neo_hookean" in rest
    assert "c2" not in rest
    calibrated = load_description(path)
    assert calibrated.actuator.material.c1 == pytest.approx(choice.best.value("c1"), rel=1e-9)
    low, high = (f"{end * 1e-3:.4g} kPa" for end in choice.best.interval("c1"))
    assert f"# fitted; {low} to {high}" in rest


def test_no_file_is_overwritten(folder):
    description, measurements, choice = fitted(folder)
    before = (folder / "mine.yaml").read_bytes()
    names = [write_calibrated_description(description, choice.best).name for _ in range(3)]
    assert names == ["mine_calibrated.yaml", "mine_calibrated_2.yaml", "mine_calibrated_3.yaml"]
    assert (folder / "mine.yaml").read_bytes() == before
    with pytest.raises(FileError, match="exists already and is kept"):
        write_calibrated_description(
            description, choice.best, [measurements.source], folder / "mine.yaml"
        )
    assert (folder / "mine.yaml").read_bytes() == before


def test_nothing_is_written_into_the_package(folder, monkeypatch):
    _, _, choice = fitted(folder)
    shipped = load_description("paper_design_70")
    monkeypatch.chdir(folder)
    path = write_calibrated_description(shipped, choice.best)
    assert path == Path("paper_design_70_calibrated.yaml")
    assert (folder / path).is_file()
    assert not shipped.source.with_name(path.name).exists()


def test_other_quantities_get_their_fields_and_units(folder):
    description, _, choice = fitted(folder, laws=("mooney_rivlin",))
    quantities = tuple(FittedQuantity)
    model = replace(choice.best.model, quantities=quantities)
    values = np.array([*choice.best.values, 3.0e-4, 2.0e-4, 5.0e-3])
    calibration = replace(
        choice.best,
        model=model,
        values=values,
        covariance=np.diag((0.01 * values) ** 2),
        actuation=FreeActuation(model.actuator_from(values.tolist())),
    )
    path = folder / "all.yaml"
    path.write_text(calibrated_text(description, calibration))
    found = load_description(path)
    assert found.gripper.stiffness == calibration.stiffness
    assert found.actuator.straight_fiber_radius == pytest.approx(5.0e-3)


def test_a_fit_that_does_not_reach_the_pressure_limit_is_not_written(folder):
    description, _, choice = fitted(folder, laws=("mooney_rivlin",))
    soft = replace(choice.best, values=np.array([1.0e3, 0.0]))
    soft = replace(soft, actuation=FreeActuation(soft.model.actuator_from([1.0e3, 0.0])))
    with pytest.raises(FileError, match=r"pressure_max, 16 psi in .*mine\.yaml, must be"):
        write_calibrated_description(description, soft)
    assert not (folder / "mine_calibrated.yaml").exists()


def test_a_measured_curve_goes_into_the_file_and_comes_back(folder):
    description = load_description(folder / "mine.yaml")
    pressures = np.linspace(0.0, 16.0 * PSI, 9).tolist()
    shapes = [description.gripper.unloaded_shape(min(p, 16.0 * PSI)) for p in pressures]
    actuation = MeasuredActuation(
        pressures=pressures,
        curvatures=[shape.curvature for shape in shapes],
        torsions=[shape.torsion for shape in shapes],
        backbone_length=description.actuator.tube.length,
    )
    path = write_measured_description(description, actuation, [Path("bend.csv")])
    assert path.name == "mine_measured.yaml"
    assert path.read_text().startswith("# The actuation curve was measured in bend.csv; ")
    gripper = load_gripper(path)
    assert isinstance(gripper.actuation, MeasuredActuation)
    assert gripper.actuation.curvatures == pytest.approx(actuation.curvatures, rel=1e-9)
    assert gripper.actuation.torsions == pytest.approx(actuation.torsions, rel=1e-9)
    assert gripper.stiffness == description.gripper.stiffness
    # Eight intervals interpolate the law's curve to a few parts in a thousand.
    lawful = WrapCurve(description.gripper).pressure_from_radius(0.02)
    assert WrapCurve(gripper).pressure_from_radius(0.02) == pytest.approx(lawful, rel=5e-3)


def test_incomplete_measured_curves_are_refused(folder):
    path = folder / "mine.yaml"
    path.write_text(path.read_text() + "\nmeasured:\n  pressures: [0 kPa, 60 kPa, 120 kPa]\n")
    with pytest.raises(DescriptionError) as caught:
        load_description(path)
    assert [p.field for p in caught.value.problems] == ["measured.curvatures", "measured.torsions"]
    text = path.read_text().replace("120 kPa]", "120]")
    path.write_text(text)
    with pytest.raises(DescriptionError, match=r"measured\.pressures must be a list of pressures"):
        load_description(path)
    path.write_text(text.replace("[0 kPa, 60 kPa, 120]", "60 kPa"))
    with pytest.raises(DescriptionError, match=r"measured\.pressures must be a list of pressures"):
        load_description(path)


def test_the_picture_shows_what_was_measured_and_fitted(folder):
    _, measurements, choice = fitted(folder, laws=("neo_hookean",))
    figure = residual_figure(choice.best, "mine")
    fit, left_over = figure.axes
    assert fit.get_ylabel() == "extension [mm]"
    assert fit.get_xlabel() == left_over.get_xlabel() == "pressure [kPa]"
    measured, curve = fit.lines[0], fit.lines[-1]
    extensions = [1e3 * reading.extension for reading in measurements.readings]
    assert measured.get_ydata() == pytest.approx(extensions)
    assert curve.get_ydata() == pytest.approx(1e3 * choice.best.predictions)
    assert left_over.lines[-1].get_ydata() == pytest.approx(choice.best.residuals)
    save_figure(figure, folder / "residuals.png")
    assert (folder / "residuals.png").read_bytes()[:4] == b"\x89PNG"


def test_the_picture_of_shapes_has_three_coordinates(folder):
    description = load_description(folder / "mine.yaml")
    curve = WrapCurve(description.gripper)
    readings = tuple(
        ShapeReading(p, tuple(curve.state_at_pressure(p).tip_position.tolist()), None, 1e-3)
        for p in (3.0e4, 6.0e4, 9.0e4)
    )
    measurements = Measurements(Path("shape.csv"), readings, (2, 3, 4))
    shapes = run_calibration(description, [measurements])
    figure = residual_figure(shapes.best, "mine")
    assert figure.axes[0].get_ylabel() == "coordinate [mm]"
    texts = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert texts == ["fitted", "x, measured", "y, measured", "z, measured"]


def test_the_report_warns_of_weak_directions_bounds_and_outliers(folder):
    text = bench_test().splitlines()
    cells = text[5].split(",")
    text[5] = ",".join([cells[0], f"{float(cells[1]) + 3.0:.3f}", *cells[2:]])
    (folder / "bench.csv").write_text("\n".join(text) + "\n")
    _, measurements, choice = fitted(folder, laws=("mooney_rivlin",))
    assert any("c1 and c2 cannot be told apart" in line for line in warnings_of(choice.best))
    (outlier,) = outlier_warnings(choice.best, [measurements])
    assert f"bench.csv:6: the reading at {5 * PSI * 1e-3:.4g} kPa" in outlier


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
        (["--hold", "c2"], "of the form NAME=VALUE"),
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
        (["--unit", "twist=deg"], "--unit must be for a column of the files, got 'twist'"),
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


def test_a_forgotten_section_length_makes_a_modulus_that_is_doubted(folder):
    assert "warning: the fitted rubber's modulus" not in run(folder, "--no-save").output
    text = (folder / "bench.csv").read_text(encoding="utf-8")
    forgotten = [line.rpartition(",")[0] for line in text.splitlines()]
    (folder / "bench.csv").write_text("\n".join(forgotten), encoding="utf-8")
    result = run(folder, "--no-save")
    assert result.exit_code == 0, result.output
    (warning,) = [line for line in result.output.splitlines() if "modulus" in line]
    length = float(warning.partition("a measured section of ")[2].split()[0])
    assert length == pytest.approx(100.0, rel=0.2)  # by the file's rubber, not by the true one


def test_the_files_law_is_simplified_only_where_the_readings_tell_no_more(folder):
    result = run(folder, "--no-save")
    assert result.output.splitlines()[0] == "law: NeoHookean"
    assert "do not tell the constants of mooney_rivlin, the file's law" in result.output
    asked = run(folder, "--no-save", "--law", "mooney_rivlin")
    assert asked.output.splitlines()[0] == "law: MooneyRivlin"
    assert "the file's law" not in asked.output
    # Several readings at one pressure tell one constant.
    (folder / "bench.csv").write_text(bench_test(rows=[6] * 6))
    result = run(folder, "--no-save")
    assert result.output.splitlines()[0] == "law: NeoHookean"
    refused = run(folder, "--no-save", "--law", "mooney_rivlin")
    assert refused.exit_code == 2
    assert "at 2 different pressures above 0 at least" in refused.output


def test_readings_at_rest_tell_nothing_and_disturb_nothing(folder):
    (folder / "bench.csv").write_text(bench_test(rows=[0] * 4))
    assert run(folder, "--no-save").exit_code == 2
    (folder / "bench.csv").write_text(bench_test(rows=[0, *range(1, 15)]).replace("0,-0.", "0,0."))
    result = run(folder, "--no-save")
    assert result.exit_code == 0, result.output
    assert "nan" not in result.output
    share = re.search(r"stated errors \(rms\), ([\d.]+)% of the largest reading", result.output)
    assert 0.0 < float(share[1]) < 10.0


def test_readings_that_contradict_their_errors_are_named(folder):
    text = bench_test().replace(",0.1,100", ",0.002,100")
    (folder / "bench.csv").write_text(text)
    assert "far more than the stated errors allow" in run(folder, "--no-save").output
    (folder / "bench.csv").write_text(text.replace(",0.002,100", ",10,100"))
    assert "far less than the stated errors allow" in run(folder, "--no-save").output


def test_the_calibration_in_json_is_the_report(folder):
    result = run(folder, "--json", "--radius", "20 mm", "--law", "neo_hookean", "--no-save")
    document = json.loads(result.output)
    assert document["law"] == "NeoHookean"
    low, high = document["values"]["c1"]["interval"]
    assert low < TRUE_C1 < high
    (pressure,) = document["pressures"]
    assert pressure["radius"] == 0.02
    assert pressure["interval"][0] < pressure["pressure"] < pressure["interval"][1]
    assert document["warnings"] == []


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
    assert text.count("data:image/png;base64,") == 1


def test_bars_are_the_stated_errors(folder):
    text = bench_test().replace(",0.1,100", ",0.5,100")
    (folder / "bench.csv").write_text(text)
    _, _, choice = fitted(folder)
    fit, left_over = residual_figure(choice.best, "mine").axes
    bars = fit.containers[0].lines[2][0].get_segments()
    assert all(top[1] - bottom[1] == pytest.approx(2.0) for bottom, top in bars)  # +- 2 of 0.5 mm
    assert left_over.get_legend().get_texts()[0].get_text() == "± 2 stated errors"
