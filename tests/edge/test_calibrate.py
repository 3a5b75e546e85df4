# SPDX-License-Identifier: Apache-2.0
"""From files to a calibration: what is fitted, refused, doubted, reported, drawn and written."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from edge.recorded import cases, written

from spiral_core import (
    FittedQuantity,
    FreeActuation,
    MeasuredActuation,
    NeoHookean,
)
from spiral_gripper import load_description, load_gripper
from spiral_gripper.bench.calibrated_file import (
    calibrated_text,
    write_calibrated_description,
)
from spiral_gripper.bench.measurements import load_measurements
from spiral_gripper.bench.options import CalibrationOptions
from spiral_gripper.bench.run import run_calibration
from spiral_gripper.cli.main import run
from spiral_gripper.files.storage import FileError

pytestmark = pytest.mark.long

PSI = 6894.757293168361
TRUE_C1 = 160.0e3
SHIPPED = load_description("paper_design_70")
FILE, CSV = Path("mine.yaml"), Path("bench.csv")
COMMAND = "calibrate mine.yaml bench.csv"


def bench_test(stiffer=1.0, rows=range(1, 15), error=0.1):
    """Return a synthetic bench test: extension of a 100 mm section, noise of 0.1 mm."""
    truth = FreeActuation(replace(SHIPPED.actuator, material=NeoHookean(c1=TRUE_C1)))
    noise = np.random.default_rng(8)
    text = "pressure [psi],extension [mm],extension_error [mm],section_length [mm]\n"
    for row in rows:
        extension = 100.0 * (truth.stretch_from_pressure(row * PSI) - 1.0)
        extension += 0.1 * noise.standard_normal()
        text += f"{row * stiffer:.6g},{extension:.3f},{error},100\n"
    return text


@pytest.fixture(autouse=True)
def _bench():
    """A gripper file of wrong constants and a bench test of the right ones."""
    shutil.copy(SHIPPED.source, FILE)
    CSV.write_text(bench_test())


def fitted(**request):
    """Return the choice of laws."""
    measurements = load_measurements(CSV, SHIPPED.gripper.tube.length)
    options = CalibrationOptions(**request)
    return run_calibration(load_description(FILE), [measurements], options)


def neo_hooke():
    """Return the fit of neo-Hooke's law."""
    return fitted(laws=("neo_hookean",)).best


@pytest.fixture
def judged(said):
    """Return a function that runs the command on a bench test, and saves nothing."""

    def judged(text, *words, code=0):
        CSV.write_text(text)
        return said(COMMAND, "--law neo_hookean --no-save", *words, code=code)

    return judged


def test_a_report_has_all_that_is_printed_and_comes_before_a_refusal(capsys):
    asked = f"{COMMAND} --radius 20mm --radius 1m --report report.html"
    assert run(asked.split()) == 2
    printed, said = capsys.readouterr()
    refused = said.splitlines()[-1]
    assert refused.startswith("spiral-gripper: an object of radius 1m cannot be gripped")
    written = load_description("mine_calibrated.yaml").actuator.material
    assert written.c1 == pytest.approx(TRUE_C1, rel=0.02)
    text = Path("report.html").read_text("utf-8").replace("&#x27;", "'")
    rows = dict(re.findall("^ *(.*?): (.*)$", printed, re.MULTILINE))
    assert {"c1", "leave-one-out error", "20 mm", "warning"} <= rows.keys()
    assert all(name in text and value in text for name, value in rows.items())
    assert refused.split(": ")[1] in text
    assert text.count("data:image/png;base64,") == 2  # the residuals, and pressure against radius


def test_intervals_hold_the_truth_and_the_pressures_of_rivals(answer):
    document = answer(COMMAND, "--radius 20mm --level 0.9 --no-save --law neo_hookean")
    low, high = document["values"]["c1"]["interval"]
    assert low < TRUE_C1 < high
    (pressure,) = document["pressures"]
    (low, high), (rival,) = pressure["interval"], pressure["rivals"]
    assert low < pressure["pressure"] < pressure["own_interval"][1] < rival["pressure"] < high


@pytest.mark.parametrize("asked", cases("calibrations.txt"))
def test_the_law_is_the_files_unless_the_readings_tell_no_more_or_another_is_asked(recorded, asked):
    recorded("calibrations.txt", asked)


def test_several_readings_at_one_pressure_tell_one_constant(said):
    CSV.write_text(bench_test(rows=[6] * 6))
    assert "fits it anyway" not in said(COMMAND, "--no-save")
    refused = said(COMMAND, "--no-save --law mooney_rivlin", code=2)
    assert "at 2 different pressures above 0 at least" in refused


def test_stiffness_is_kept_only_where_the_file_states_it():
    text = FILE.read_text("utf-8")
    section = text.replace("pressure_law: uniform", "pressure_law: section")
    for changed, bending in (
        (text, None),
        (f"{text}\nstiffness:\n  bending: 5e-4 N m^2\n", 5.0e-4),
        (f"{section}\nstiffness:\n  section_at: 20 kPa\n", None),
    ):
        FILE.write_text(changed, "utf-8")
        model = fitted().best.model
        assert (model.bending_stiffness, model.torsional_stiffness) == (bending, None)


def test_readings_that_only_a_mix_up_of_units_gives_are_refused_unless_accepted(judged):
    refused = judged(bench_test().replace("[psi]", "[MPa]"), code=2)
    assert 'bench.csv:2: "pressure, extension": no elastomer gives these readings' in refused
    assert "but psi taken for MPa would" in refused
    choice = fitted(accept_implausible=True, laws=("neo_hookean",))
    assert choice.best.value("c1") == pytest.approx(TRUE_C1 * 1e6 / PSI, rel=0.02)


@pytest.mark.parametrize("factor", [0.15, 4.0])
def test_a_rubber_of_another_stiffness_is_fitted_and_named(said, factor):
    CSV.write_text(bench_test(stiffer=factor))
    printed = said(COMMAND)
    assert "warning: the fitted rubber's modulus is" in printed
    assert ("taken for" in printed) == (factor != 0.15)  # the file is in psi
    c1 = load_description("mine_calibrated.yaml").actuator.material.c1
    assert c1 == pytest.approx(TRUE_C1 * factor, rel=0.05)


@pytest.mark.parametrize("reading", cases("contradictions.txt"))
def test_readings_that_contradict_are_refused_and_copies_and_outliers_named(recorded, reading):
    rows = bench_test().splitlines()
    rows[5] = written(reading).format(*rows[5].split(",", 2))
    CSV.write_text("\n".join(rows))
    robust = "--robust" * (",9," in reading)
    recorded("contradictions.txt", reading, f"{COMMAND} --law neo_hookean --no-save {robust}")


def test_few_readings_readings_at_rest_and_impossible_errors_are_named(judged):
    assert "at least 2, to fit c1 and judge" in judged(bench_test(rows=[1]), code=2)
    resting = bench_test(rows=[0] * 4).replace("0,-", "0,")
    assert "nan" not in judged(resting, code=2)
    rest = judged(bench_test(rows=range(15)))
    share = re.search(r"stated errors \(rms\), ([\d.]+)% of the largest reading", rest)
    assert 0.0 < float(share[1]) < 10.0
    for error, said in ((0.002, "more"), (10, "less")):
        printed = judged(bench_test(error=error))
        assert f"far {said} than the stated errors allow" in printed


def test_the_calibrated_file_keeps_comments_and_gives_back_the_fit():
    best, changed = neo_hooke(), re.compile(".*(law|c1|c2):.*\n")
    path = write_calibrated_description(load_description(FILE), best, [CSV])
    opening, _, rest = path.read_text("utf-8").partition("\n")
    assert opening.startswith("# Calibrated: neo_hookean fitted to bench.csv, 14 readings")
    assert changed.sub("", rest) == changed.sub("", FILE.read_text("utf-8"))
    material = load_description(path).actuator.material
    assert material.c1 == pytest.approx(best.value("c1"), rel=1e-9)
    assert f"# fitted; {1e-3 * best.interval('c1').low:.4g} kPa to " in rest


def test_no_file_is_overwritten_and_none_written_into_the_package():
    best, write, mine = neo_hooke(), write_calibrated_description, load_description(FILE)
    names = [write(mine, best).name for _ in range(2)]
    assert names == ["mine_calibrated.yaml", "mine_calibrated_2.yaml"]
    assert write(SHIPPED, best) == Path("paper_design_70_calibrated.yaml")
    soft = replace(best, values=np.array([1.0e3]))
    with pytest.raises(FileError, match=r"pressure_max, 16 psi in .*mine\.yaml, must be"):
        write(mine, soft)


def test_other_quantities_get_their_fields_and_units():
    best = neo_hooke()
    model = replace(best.model, quantities=tuple(FittedQuantity))
    values = np.array([*best.values, 3.0e-4, 2.0e-4, 5.0e-3])
    fit = replace(best, names=model.names, model=model, values=values, covariance=np.eye(4))
    FILE.write_text(calibrated_text(load_description(FILE), fit))
    found = load_description(FILE)
    assert found.gripper.stiffness == fit.stiffness
    assert found.actuator.straight_fiber_radius == pytest.approx(5.0e-3)


def test_the_command_writes_a_measured_curve(said):
    length = SHIPPED.actuator.tube.length
    text = "pressure [kPa],bend_angle [rad],twist [rad]\n"
    for kilopascals in (20, 40, 60, 80, 111):
        shape = SHIPPED.gripper.actuation.unloaded_shape(kilopascals * 1e3)
        text += f"{kilopascals},{shape.curvature * length},{shape.torsion * length}\n"
    CSV.write_text(text)
    errors = "--error bend_angle=1deg --error twist=1deg"
    assert said(COMMAND, "--measured-curve", errors).startswith("measured up to 111 kPa ")
    found = load_gripper("mine_measured.yaml")
    assert isinstance(found.actuation, MeasuredActuation)
    measured, expected = (each.unloaded_shape(60e3) for each in (found, SHIPPED.gripper))
    figures = (measured.curvature, measured.torsion)
    assert figures == pytest.approx((expected.curvature, expected.torsion))
