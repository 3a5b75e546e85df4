# SPDX-License-Identifier: Apache-2.0
"""From files to a calibration: what is fitted, refused, doubted, reported, drawn and written."""

import contextlib
import io
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spiral_core import (
    FittedQuantity,
    FreeActuation,
    InvalidInputError,
    MeasuredActuation,
    NeoHookean,
    measured_actuation_from_readings,
)
from spiral_gripper import load_description, load_gripper
from spiral_gripper.bench.calibrated_file import (
    calibrated_text,
    write_calibrated_description,
)
from spiral_gripper.bench.measurements import load_measurements
from spiral_gripper.bench.options import CalibrationOptions
from spiral_gripper.bench.residual_plot import residual_figure
from spiral_gripper.bench.run import run_calibration
from spiral_gripper.cli.main import run
from spiral_gripper.files.storage import FileError
from spiral_gripper.files.table import TableError

pytestmark = pytest.mark.long

PSI = 6894.757293168361
TRUE_C1 = 160.0e3
SHIPPED = load_description("paper_design_70")


def bench_test(unit="psi", per_unit=PSI, stiffer=1.0, rows=range(1, 15), error="0.1"):
    """Return a synthetic bench test: extension of a 100 mm section, noise of 0.1 mm."""
    truth = FreeActuation(replace(SHIPPED.actuator, material=NeoHookean(c1=TRUE_C1)))
    noise = np.random.default_rng(8)
    lines = [f"pressure [{unit}],extension [mm],extension_error [mm],section_length [mm]"]
    for row in rows:
        extension = 100.0 * (truth.stretch_from_pressure(row * PSI) - 1.0)
        pressure = row * stiffer * PSI / per_unit
        lines.append(f"{pressure:.6g},{extension + 0.1 * noise.standard_normal():.3f},{error},100")
    return "\n".join(lines) + "\n"


class Bench:
    """A folder with a gripper file of wrong constants and a bench test of the right ones."""

    def __init__(self, folder):
        self.folder = folder
        self.file, self.csv = folder / "mine.yaml", folder / "bench.csv"
        shutil.copy(SHIPPED.source, self.file)
        self.csv.write_text(bench_test(), encoding="utf-8")

    def fitted(self, **request):
        """Return the choice of laws."""
        self.description = load_description(self.file)
        tube = self.description.actuator.tube
        self.measurements = load_measurements(self.csv, tube.length)
        options = CalibrationOptions(**request)
        return run_calibration(self.description, [self.measurements], options)

    def said(self, *arguments, code=0):
        """Run the command on the files of the folder."""
        written = io.StringIO()
        with contextlib.redirect_stdout(written), contextlib.redirect_stderr(written):
            assert run(["calibrate", str(self.file), str(self.csv), *arguments]) == code
        return written.getvalue()

    def judged(self, text, *arguments, code=0):
        """Run the command on a bench test for neo-Hooke's law, and save nothing."""
        self.csv.write_text(text, encoding="utf-8")
        return self.said("--law", "neo_hookean", "--no-save", *arguments, code=code)


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)


def test_the_command_goes_from_csv_to_file_picture_and_report(bench):
    picture, report = bench.folder / "residuals.png", bench.folder / "report.html"
    asked = ["--radius", "20 mm", "--radius", "1 m", "--plot", str(picture)]
    # A radius out of reach comes after file, picture and report.
    *lines, refused = bench.said(*asked, "--report", str(report), code=2).splitlines()
    assert lines[0] == "law: NeoHookean"
    assert refused.startswith("spiral-gripper: an object of radius 1 m cannot be gripped")
    assert picture.read_bytes()[:4] == b"\x89PNG"
    written = load_description(bench.folder / "mine_calibrated.yaml").actuator.material
    assert written.c1 == pytest.approx(TRUE_C1, rel=0.02)
    text = report.read_text(encoding="utf-8").replace("&#x27;", "'")
    rows = [line for line in lines if ": " in line and not line.startswith("wrote")]
    for name in ("c1: 1", "leave-one-out error: ", "20 mm: ", "warning: "):
        assert any(line.startswith(name) for line in rows)
    for line in rows:
        name, _, value = line.partition(": ")
        assert name.strip() in text
        assert value in text
    assert "an object of radius 1 m cannot be gripped" in text
    assert text.count("data:image/png;base64,") == 2  # the residuals, and pressure against radius


def test_the_calibration_in_json_is_the_report_and_nothing_is_saved_unless_wanted(bench):
    asked = ["--radius", "20 mm", "--law", "neo_hookean", "--no-save", "--level", "0.9"]
    document = json.loads(bench.said(*asked, "--json"))
    assert (document["law"], document["level"]) == ("NeoHookean", 0.9)
    low, high = document["values"]["c1"]["interval"]
    assert low < TRUE_C1 < high
    (pressure,), (warning,) = document["pressures"], document["warnings"]
    (low, high), (rival,) = pressure["interval"], pressure["rivals"]
    assert low < pressure["pressure"] < high
    assert pressure["own_interval"][1] < rival["pressure"] < high
    assert "do not tell the fitted law from NeoHookean, exact curvature" in warning
    assert max(map(abs, document["standardized_residuals"])) < 4.0
    held = bench.said("--hold", "c2=0 kPa", "--draws", "40", "--robust", *asked[:2], *asked[-3:])
    assert "90 % interval" in held
    assert not list(bench.folder.glob("*_calibrated*"))


def test_the_law_is_the_files_unless_the_readings_tell_no_more_or_another_is_asked(bench):
    asked = ["--no-save", "--law", "mooney_rivlin"]
    simple = bench.said("--no-save")
    assert simple.startswith("law: NeoHookean\n")
    assert "rubber's modulus" not in simple
    assert "do not tell the constants of mooney_rivlin, the file's law" in simple
    assert "--law mooney_rivlin fits it anyway" in simple
    fitted = bench.said(*asked)
    assert fitted.startswith("law: MooneyRivlin\n")
    assert "the file's law" not in fitted
    assert "c1 and c2 cannot be told" in fitted
    # Several readings at one pressure tell one constant.
    bench.csv.write_text(bench_test(rows=[6] * 6))
    assert "fits it anyway" not in bench.said("--no-save")
    assert "at 2 different pressures above 0 at least" in bench.said(*asked, code=2)


def test_laws_that_fail_are_reported_and_all_failing_is_an_error(bench):
    choice = bench.fitted(laws=("mooney_rivlin", "neo_hookean"), fixed={"c2": 0.0})
    assert [name for name, _ in choice.failures] == ["neo_hookean"]
    assert choice.best.model.gripper is bench.description.gripper
    with pytest.raises(InvalidInputError):
        bench.fitted(fixed={"c3": 0.0})
    with pytest.raises(InvalidInputError):  # curves need bend angles
        measured_actuation_from_readings([], 0.5, SHIPPED.actuator.fibers)


def test_stiffness_is_kept_only_where_the_file_states_it(bench):
    text = bench.file.read_text(encoding="utf-8")
    section = text.replace("pressure_law: uniform", "pressure_law: section")
    for changed, bending in (
        (text, None),
        (f"{text}\nstiffness:\n  bending: 5e-4 N m^2\n", 5.0e-4),
        (f"{section}\nstiffness:\n  section_at: 20 kPa\n", None),
    ):
        bench.file.write_text(changed, encoding="utf-8")
        model = bench.fitted().best.model
        assert (model.bending_stiffness, model.torsional_stiffness) == (bending, None)


def test_readings_that_only_a_mix_up_of_units_gives_are_refused_unless_accepted(bench):
    in_kilopascals = bench_test("kPa", per_unit=1.0e3)
    bench.csv.write_text(in_kilopascals.replace("pressure [kPa]", "pressure [bar]"))
    with pytest.raises(TableError) as caught:
        bench.fitted()
    (problem,) = caught.value.problems
    assert (problem.line, problem.heading) == (2, "pressure, extension")
    assert "no elastomer gives these readings with the described tube, but kPa" in problem.reason
    choice = bench.fitted(accept_implausible=True, laws=("neo_hookean",))
    assert choice.best.value("c1") == pytest.approx(TRUE_C1 * 100.0, rel=0.02)


@pytest.mark.parametrize("factor", [0.15, 4.0, 8.0])
def test_a_rubber_of_another_stiffness_is_fitted_and_named(bench, factor):
    bench.csv.write_text(bench_test(stiffer=factor))
    (warning,) = re.findall(".*rubber's modulus.*", bench.said())
    assert warning.startswith("warning: the fitted rubber's modulus is ")
    assert ("taken for" in warning) == (factor != 0.15)  # the file is in psi
    assert "(--section-length)" in warning
    c1 = load_description(bench.folder / "mine_calibrated.yaml").actuator.material.c1
    assert c1 == pytest.approx(TRUE_C1 * factor, rel=0.05)


# A reading in place of the sixth line's -> exit code, and what is said.
CONTRADICTIONS = {
    "{0},{1},{2}\n{0},{1},{2}": (0, "copies of other readings: {file}:7 (of {file}:6)"),
    "{0},{1},{2}\n{0},1{1},{2}": (2, '{file}:6: "extension": must be alike: at one pressure'),
    "{0},-{1},{2}": (2, '{file}:6: "extension": must be positive for these fibers'),
    "five,{1},{2}": (2, '{file}:6: column 1 "pressure [psi]": must be'),
    "{0},9,{2}": (0, "{file}:6: the reading at 34.47 kPa is "),
}


@pytest.mark.parametrize("reading", CONTRADICTIONS)
def test_readings_that_contradict_are_refused_and_copies_and_outliers_named(bench, reading):
    rows, (code, said) = bench_test().splitlines(), CONTRADICTIONS[reading]
    rows[5] = reading.format(*rows[5].split(",", 2))
    printed = bench.judged("\n".join(rows), code=code)
    assert said.format(file=bench.csv) in printed
    if "the reading" in said:
        assert "leave it out with --robust" in printed
        document = json.loads(bench.judged("\n".join(rows), "--robust", "--json"))
        assert document["left_out"] == document["outliers"] == [4]
        assert document["standardized_residuals"][4] < -8.0
        assert "--robust left it out" in document["warnings"][0]


def test_few_readings_readings_at_rest_and_impossible_errors_are_named(bench):
    few = bench.judged(bench_test(rows=[1]), code=2)
    assert "at least 2, to fit c1 and judge the errors" in few
    assert "nan" not in few + bench.judged(bench_test(rows=[0] * 4).replace("0,-", "0,"), code=2)
    rest = bench.judged(bench_test(rows=range(15)))
    share = re.search(r"stated errors \(rms\), ([\d.]+)% of the largest reading", rest)
    assert 0.0 < float(share[1]) < 10.0
    for error, said in (("0.002", "more"), ("10", "less")):
        printed = bench.judged(bench_test(error=error))
        assert f"far {said} than the stated errors allow" in printed


def test_the_picture_shows_what_was_measured_and_fitted(bench):
    bench.csv.write_text(bench_test(error="0.5"))
    best = bench.fitted(laws=("neo_hookean",)).best
    fit, left_over = residual_figure(best, "mine").axes
    assert (fit.get_ylabel(), left_over.get_xlabel()) == ("extension [mm]", "pressure [kPa]")
    extensions = [1e3 * reading.extension for reading in bench.measurements.readings]
    assert fit.lines[0].get_ydata() == pytest.approx(extensions)
    assert fit.lines[-1].get_ydata() == pytest.approx(1e3 * best.predictions)
    assert left_over.lines[-1].get_ydata() == pytest.approx(best.residuals)
    bars = np.array(fit.containers[0].lines[2][0].get_segments())
    assert np.ptp(bars[:, :, 1], axis=1) == pytest.approx(2.0)  # +- 2 of 0.5 mm


def test_the_calibrated_file_keeps_comments_and_gives_back_the_fit(bench):
    best, changed = bench.fitted(laws=("neo_hookean",)).best, re.compile(".*(law|c1|c2):.*\n")
    path = write_calibrated_description(bench.description, best, [bench.measurements.source])
    opening, _, rest = path.read_text(encoding="utf-8").partition("\n")
    assert opening.startswith("# Calibrated: neo_hookean fitted to bench.csv, 14 readings")
    assert changed.sub("", rest) == changed.sub("", bench.file.read_text(encoding="utf-8"))
    assert "  law: neo_hookean" in rest
    assert "c2" not in rest
    c1 = load_description(path).actuator.material.c1
    assert c1 == pytest.approx(best.value("c1"), rel=1e-9)
    low, high = (f"{end * 1e-3:.4g} kPa" for end in best.interval("c1"))
    assert f"# fitted; {low} to {high}" in rest


def test_no_file_is_overwritten_and_none_written_into_the_package(bench, monkeypatch):
    best, before = bench.fitted(laws=("mooney_rivlin",)).best, bench.file.read_bytes()
    write = write_calibrated_description
    names = [write(bench.description, best).name for _ in range(2)]
    assert names == ["mine_calibrated.yaml", "mine_calibrated_2.yaml"]
    with pytest.raises(FileError, match="exists already and is kept"):
        write(bench.description, best, [bench.measurements.source], bench.file)
    assert bench.file.read_bytes() == before
    monkeypatch.chdir(bench.folder)
    assert write(SHIPPED, best) == Path("paper_design_70_calibrated.yaml")
    soft = replace(best, values=np.array([1.0e3, 0.0]))
    with pytest.raises(FileError, match=r"pressure_max, 16 psi in .*mine\.yaml, must be"):
        write(bench.description, soft)


def test_other_quantities_get_their_fields_and_units(bench):
    best = bench.fitted(laws=("mooney_rivlin",)).best
    model = replace(best.model, quantities=tuple(FittedQuantity))
    values = np.array([*best.values, 3.0e-4, 2.0e-4, 5.0e-3])
    covariance = np.diag((0.01 * values) ** 2)
    fit = replace(best, names=model.names, model=model, values=values, covariance=covariance)
    bench.file.write_text(calibrated_text(bench.description, fit))
    found = load_description(bench.file)
    assert found.gripper.stiffness == fit.stiffness
    assert found.actuator.straight_fiber_radius == pytest.approx(5.0e-3)


def test_the_command_writes_a_measured_curve(bench):
    gripper, length = SHIPPED.gripper, SHIPPED.actuator.tube.length
    lines = ["pressure [kPa],bend_angle [deg],twist [deg]"]
    for kilopascals in (20, 40, 60, 80, 100, 111):
        shape = FreeActuation(SHIPPED.actuator).unloaded_shape(kilopascals * 1e3)
        bend, twist = np.degrees([shape.curvature * length, shape.torsion * length])
        lines.append(f"{kilopascals},{bend:.4f},{twist:.4f}")
    bench.csv.write_text("\n".join(lines))
    asked = ["--measured-curve", "--error", "bend_angle=1 deg", "--error", "twist=1 deg"]
    path = bench.folder / "mine_measured.yaml"
    bench.said(*asked, "--no-save")
    assert not path.exists()
    assert bench.said(*asked).startswith("measured up to 111 kPa\n")
    assert path.read_text().startswith("# The actuation curve was measured in bench.csv; ")
    found = load_gripper(path)
    assert isinstance(found.actuation, MeasuredActuation)
    assert found.stiffness == gripper.stiffness
    # Six intervals interpolate the law's curve to a few parts in a thousand.
    for name in ("curvature", "torsion"):
        expected = getattr(gripper.unloaded_shape(50.0e3), name)
        assert getattr(found.unloaded_shape(50.0e3), name) == pytest.approx(expected, rel=5e-3)
