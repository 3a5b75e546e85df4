# SPDX-License-Identifier: Apache-2.0
"""What a calibration writes: the calibrated file, the measured curve."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from edge.calibrate_cases import PSI, bench_folder, fitted

from spiral_core import (
    FittedQuantity,
    MeasuredActuation,
    WrapCurve,
)
from spiral_gripper import DescriptionError, load_description, load_gripper
from spiral_gripper.bench.calibrated_file import (
    calibrated_text,
    write_calibrated_description,
    write_measured_description,
)
from spiral_gripper.files.storage import FileError


@pytest.fixture
def folder(tmp_path):
    return bench_folder(tmp_path)


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
        names=model.names,
        model=model,
        values=values,
        covariance=np.diag((0.01 * values) ** 2),
    )
    path = folder / "all.yaml"
    path.write_text(calibrated_text(description, calibration))
    found = load_description(path)
    assert found.gripper.stiffness == calibration.stiffness
    assert found.actuator.straight_fiber_radius == pytest.approx(5.0e-3)


def test_a_fit_that_does_not_reach_the_pressure_limit_is_not_written(folder):
    description, _, choice = fitted(folder, laws=("mooney_rivlin",))
    soft = replace(choice.best, values=np.array([1.0e3, 0.0]))
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
