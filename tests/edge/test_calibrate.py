# SPDX-License-Identifier: Apache-2.0
"""From files to a calibration: what is fitted, refused, doubted, reported, drawn and written."""

import json
import shlex
import shutil
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest
from edge.recorded import cases
from numpy.testing import assert_allclose

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
from spiral_gripper.files.storage import FileError

pytestmark = pytest.mark.long

PSI = 6894.757293168361
TRUE_C1 = 160.0e3
SHIPPED = load_description("paper_design_70")
FILE, CSV = Path("mine.yaml"), Path("bench.csv")
COMMAND = "calibrate mine.yaml bench.csv"


def bench_test(stiffer=1.0, rows=range(1, 15), error=0.1, unit="psi", fifth="{0},{1},{2}"):
    """Return a synthetic bench test: extension of a 100 mm section, noise of 0.1 mm."""
    truth = FreeActuation(replace(SHIPPED.actuator, material=NeoHookean(c1=TRUE_C1)))
    noise = np.random.default_rng(8)
    text = f"pressure [{unit}],extension [mm],extension_error [mm],section_length [mm]\n"
    for row in rows:
        extension = 100.0 * (truth.stretch_from_pressure(row * PSI) - 1.0)
        extension += 0.1 * noise.standard_normal()
        line = fifth if row == 5 else "{0},{1},{2}"
        text += line.format(f"{row * stiffer:.6g}", f"{extension:.3f}", f"{error},100") + "\n"
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


@pytest.mark.parametrize("case", cases("calibrations.txt"))
def test_what_is_fitted_doubted_and_refused_is_as_recorded(recorded, case):
    """Each command is followed by what is special of its bench test."""
    asked, _, bench = case.partition(" # ")
    CSV.write_text(bench_test(**json.loads(bench or "{}")))
    recorded("calibrations.txt", case, asked)


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
    assert_allclose(found.actuator.straight_fiber_radius, 5.0e-3, 1e-6)


def test_the_command_writes_a_measured_curve(said):
    length, actuation = SHIPPED.actuator.tube.length, SHIPPED.gripper.actuation
    text = "pressure [kPa],bend_angle [rad],twist [rad]\n"
    for kilopascals in (20, 40, 60, 80, 111):
        shape = actuation.unloaded_shape(kilopascals * 1e3)
        text += f"{kilopascals},{shape.curvature * length},{shape.torsion * length}\n"
    CSV.write_text(text)
    errors = "--error bend_angle=1deg --error twist=1deg"
    assert said(COMMAND, "--measured-curve", errors).startswith("measured up to 111 kPa ")
    found = load_gripper("mine_measured.yaml").actuation
    assert isinstance(found, MeasuredActuation)
    measured, expected = (astuple(each.unloaded_shape(60e3))[:2] for each in (found, actuation))
    assert_allclose(measured, expected, 1e-6)
    twist = text.splitlines()[3].split(",")[2]
    for doubtful, reason in (
        (text.replace(",-", ","), '"twist": must be negative for these fibers'),
        (text.replace("bend_angle [rad]", "bend_angle [deg]"), "rad taken for deg"),
        (f"{text}60,40,{twist}\n", "standard errors of their difference apart"),
    ):
        CSV.write_text(doubtful)
        assert reason in said(COMMAND, "--measured-curve", errors, code=2)
    CSV.write_text("pressure [kPa],x [mm],y [mm],z [mm],arc_length [mm]\n40,9,1,-3,362\n")
    far = said(COMMAND, shlex.quote("--error=position=1 mm"), code=2)
    assert 'bench.csv:2: "arc_length": must be at most the tube\'s length, 361 mm' in far
