# SPDX-License-Identifier: Apache-2.0
"""From files to a calibration: the run, what it refuses and doubts, and its pictures."""

import json
import re
from pathlib import Path

import pytest
from edge.calibrate_cases import PSI, TRUE_C1, bench_folder, bench_test, fitted, run

from spiral_core import (
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    ShapeReading,
    WrapCurve,
)
from spiral_gripper import load_description
from spiral_gripper.bench.doubts import outlier_warnings, warnings_of
from spiral_gripper.bench.measurements import Measurements
from spiral_gripper.bench.options import CalibrationOptions
from spiral_gripper.bench.residual_plot import residual_figure
from spiral_gripper.bench.run import run_calibration
from spiral_gripper.files.table import TableError
from spiral_gripper.reports.style import save_figure

pytestmark = pytest.mark.long


@pytest.fixture
def folder(tmp_path):
    return bench_folder(tmp_path)


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
    own = path.read_text().replace("bending: 5e-4 N m^2", "section_at: 20 kPa")
    path.write_text(own.replace("pressure_law: uniform", "pressure_law: section"))
    _, _, choice = fitted(folder)
    assert choice.best.model.bending_stiffness is None
    assert choice.best.model.torsional_stiffness is None


def in_bars(text):
    """Return a bench test whose kilopascals are called bars."""
    return text.replace("pressure [kPa]", "pressure [bar]")


def test_readings_that_only_a_mix_up_of_units_gives_are_refused_unless_accepted(folder):
    (folder / "bench.csv").write_text(in_bars(bench_test("kPa", per_unit=1.0e3)))
    with pytest.raises(TableError) as caught:
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
    assert ("taken for" in warning) == (factor != 0.15)  # the file is in psi
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
        CalibrationOptions(laws=("ogden",))


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
    assert f"bench.csv:6: the reading at {5 * PSI * 1e-3:.4g} kPa is " in outlier
    assert "leave it out with --robust" in outlier
    robust = run(folder, "--law", "neo_hookean", "--robust", "--no-save", "--json")
    document = json.loads(robust.output)
    assert document["left_out"] == document["outliers"] == [4]
    assert document["standardized_residuals"][4] < -10.0
    (outlier,) = document["warnings"]
    assert "bench.csv:6" in outlier
    assert "--robust left it out" in outlier


@pytest.mark.parametrize(
    ("change", "exit_code", "said"),
    [
        (lambda rows: [*rows, rows[4]], 0, "copies of other readings: {file}:16 (of {file}:5)"),
        (
            lambda rows: [*rows, rows[4].replace(",", ",1", 1)], 2,
            "{file}:5: \"extension\": must be alike: at one pressure",
        ),
        (
            lambda rows: [row.replace(",", ",-", 1) if row == rows[4] else row for row in rows], 2,
            "{file}:5: \"extension\": must be positive for these fibers",
        ),
        (lambda rows: rows[:2], 2, "at least 2, to fit c1 and judge the errors"),
    ],
    ids=["copy", "far apart", "wrong sign", "one row"],
)  # fmt: skip
def test_readings_that_contradict_are_refused_and_copies_named(folder, change, exit_code, said):
    file = folder / "bench.csv"
    head, *rows = bench_test().splitlines()
    file.write_text("\n".join([head, *change(["", *rows])[1:]]) + "\n")
    result = run(folder, "--law", "neo_hookean", "--no-save")
    assert result.exit_code == exit_code, result.output
    assert said.format(file=file) in result.output


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
    assert "--law mooney_rivlin fits it anyway" in result.output
    asked = run(folder, "--no-save", "--law", "mooney_rivlin")
    assert asked.output.splitlines()[0] == "law: MooneyRivlin"
    assert "the file's law" not in asked.output
    # Several readings at one pressure tell one constant.
    (folder / "bench.csv").write_text(bench_test(rows=[6] * 6))
    result = run(folder, "--no-save")
    assert result.output.splitlines()[0] == "law: NeoHookean"
    assert "fits it anyway" not in result.output
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


def test_bars_are_the_stated_errors(folder):
    text = bench_test().replace(",0.1,100", ",0.5,100")
    (folder / "bench.csv").write_text(text)
    _, _, choice = fitted(folder)
    fit, left_over = residual_figure(choice.best, "mine").axes
    bars = fit.containers[0].lines[2][0].get_segments()
    assert all(top[1] - bottom[1] == pytest.approx(2.0) for bottom, top in bars)  # +- 2 of 0.5 mm
    assert left_over.get_legend().get_texts()[0].get_text() == "± 2 stated errors"
