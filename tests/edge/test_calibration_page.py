# SPDX-License-Identifier: Apache-2.0
"""docs/calibration.md, its example and the study of public measurements against the code."""

import importlib.util
import re
import runpy
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spiral_core import FreeActuation, MooneyRivlin, PressureLaw
from spiral_gripper import load_description
from spiral_gripper.bench.measurements import COLUMNS
from spiral_gripper.files.table import read_table

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "calibration.md").read_text(encoding="utf-8")


def module(path):
    """Return a script of the repository as a module, without running its ``main``."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = loaded  # dataclasses look their module up
    spec.loader.exec_module(loaded)
    return loaded


@pytest.fixture(scope="module")
def study():
    return module(ROOT / "docs" / "validate_bending.py")


@pytest.fixture(scope="module")
def bench_tests():
    return module(ROOT / "examples" / "synthetic_bench_tests.py")


@pytest.fixture(scope="module")
def coverage_study():
    return module(ROOT / "benchmarks" / "calibration_coverage.py")


def test_every_column_is_on_the_page():
    named = set(re.findall(r"`([a-z_]+)", PAGE))
    unnamed = {name for name in COLUMNS if name not in named}
    # The errors of the other columns go by the rule that the page states with extension_error.
    assert unnamed == {"twist_error", "bend_angle_error", "object_radius_error"}
    assert "extension_error" in named


def test_the_error_example_is_what_the_code_says():
    block = re.search(r"```text\n(bench\.csv.*?)```", PAGE, re.DOTALL)[1]
    rows = ["1,1,1,1", "2,1,1,1", "three,1,1,1", *["4,1,1,1"] * 4, "5,1,1"]
    header = "pressure [psi],extension [mm],extension_error [mm],section_length [mm]"
    with pytest.raises(ValueError, match="bench") as caught:
        read_table("\n".join([header, *rows]), "bench.csv", COLUMNS)
    assert str(caught.value) == block.strip()


def test_stated_coverage_is_within_93_and_97_percent(coverage_study):
    kinds, *shares = re.search(
        r"each of (\d+) kinds.*?([\d.]+) to ([\d.]+) %", PAGE, re.DOTALL
    ).groups()
    assert int(kinds) == len(coverage_study.CASES)
    assert all(93.0 <= float(share) <= 97.0 for share in shares)


def test_the_coverage_study_counts_hits_and_failures(coverage_study):
    case = coverage_study.CASES["neo-Hookean"]
    shares, failed, seconds = coverage_study.coverage(case, 20)
    assert shares.keys() == {"c1"}
    assert 0.7 < shares["c1"] <= 1.0
    assert failed == 0
    assert seconds > 0.0


@pytest.mark.parametrize("kind", ["extension", "twist", "bend_angle", "position", "object_radius"])
def test_a_synthetic_bench_test_is_what_its_script_computes(bench_tests, kind):
    text = (bench_tests.FOLDER / f"bench_{kind}.csv").read_text(encoding="utf-8")
    assert text == bench_tests.bench_test(kind)
    assert text.startswith("# SYNTHETIC")
    assert f"seed {bench_tests.SEED}" in text


def test_there_is_an_example_of_every_kind_of_test(bench_tests):
    kinds = {column for column in COLUMNS if f"{column}_error" in COLUMNS} | {"position"}
    assert bench_tests.TESTS.keys() == kinds - {"pressure", "displacement"}


def test_the_synthetic_free_swing_is_what_its_script_computes():
    script = module(ROOT / "examples" / "synthetic_free_swing.py")
    text = script.FILE.read_text(encoding="utf-8")
    # the last digit may differ on another processor
    cells = [
        [float(cell) for row in one.splitlines()[2:] for cell in row.split(",")]
        for one in (text, script.free_swing())
    ]
    assert cells[0] == pytest.approx(cells[1], abs=0.011)
    assert text.startswith("# SYNTHETIC")
    assert f"seed {script.SEED}" in text


def test_the_example_goes_from_csv_to_gripper_file_and_plot(tmp_path, monkeypatch, capsys):
    path = ROOT / "examples" / "calibrate_from_csv.py"
    monkeypatch.setattr(sys, "argv", [str(path), str(tmp_path)])
    values = runpy.run_path(str(path))
    actuator = load_description(ROOT / "examples" / "data" / "my_gripper.yaml").actuator
    truth = FreeActuation(replace(actuator, material=MooneyRivlin(c1=152.0e3, c2=8.0e3)))
    assert capsys.readouterr().out.splitlines()[0] == "NeoHookean: weight 0.90"
    low, high = values["best"].interval("c1")
    assert low < 160.0e3 < high  # C1 + C2: nearly all that the tube's pressures depend on
    for result in values["results"]:
        assert result.standard_error < 0.01 * result.pressure
    shape = values["calibrated"].unloaded_shape(60.0e3)
    assert shape.curvature == pytest.approx(truth.unloaded_shape(60.0e3).curvature, rel=0.01)
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"my_gripper.yaml", "my_gripper_calibrated.yaml", "residuals.png"}


def synthetic_specimens(study, tmp_path, scatter):
    """Return specimens read from a file like the public one, of one rubber and known scatter."""
    noise = np.random.default_rng(5)
    lines = ["fiber_angle_alpha_deg,fiber_angle_beta_deg,length_cm,pressure_psi,bend_angle_rad"]
    for angle in (65, 70, 80):
        rubber = MooneyRivlin(c1=500.0e3, c2=100.0e3)
        actuation = FreeActuation(study.bending_actuator(angle, 0.18, rubber))
        for psi in (10, 15, 20, 25, 30, 35):
            bend = actuation.unloaded_shape(psi * study.PSI).curvature * 0.18
            bend *= 1.0 + scatter * noise.standard_normal()
            lines.append(f"{angle},-{angle},18,{psi},{bend!r}")
    path = tmp_path / "bending.csv"
    path.write_text("\n".join(lines) + "\n")
    return study.read_specimens(path)


@pytest.mark.slow
def test_the_study_finds_no_error_where_there_is_none(study, tmp_path):
    specimens = synthetic_specimens(study, tmp_path, scatter=0.0)
    outcomes = study.fit_all(specimens)
    for laws in outcomes.values():
        one = laws[MooneyRivlin]
        assert one.cross_validation.relative_error < 1e-6
    assert study.transferred(outcomes[65][MooneyRivlin].calibration, 80, specimens[80]) < 1e-5
    # Six points of a nearly straight curve interpolate well.
    assert study.rms(study.interpolation_errors(specimens[70])) < 0.02


@pytest.mark.slow
def test_the_studys_page_holds_its_figures(study, tmp_path):
    specimens = synthetic_specimens(study, tmp_path, scatter=0.02)
    page = study.page(specimens)
    assert page.count("\n| --- |") == 1
    assert "| pressure law | law | 65° | 70° | 80° |" in page
    for law in PressureLaw:
        assert page.count(f"\n| {law.value} | MooneyRivlin | ") == 1
    figure = study.draw(specimens)
    assert [axes.get_title() for axes in figure.axes] == [f"fibers at ±{a}°" for a in specimens]
    assert "{" not in page


def test_the_committed_page_is_of_the_study(study):
    committed = study.PAGE.read_text(encoding="utf-8")
    opening = study.HEAD.partition("{summary}")[0]
    assert committed.startswith(opening)
    assert study.FIGURE.is_file()
    for law in PressureLaw:
        row = re.search(rf"^\| {law.value} \| MooneyRivlin \| (.*) \|$", committed, re.MULTILINE)[1]
        errors = [float(x) for x in re.findall(r"([\d.]+) % \(", row)]
        assert len(errors) == 3
        assert errors[0] < 10.0  # 65 degrees
        assert errors[1] < 10.0  # 70 degrees
