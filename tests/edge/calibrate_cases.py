# SPDX-License-Identifier: Apache-2.0
"""A folder with a gripper file and a bench test, and the ways to calibrate it."""

import contextlib
import io
import shutil
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from spiral_core import (
    FreeActuation,
    NeoHookean,
)
from spiral_gripper import load_description
from spiral_gripper.bench.measurements import load_measurements
from spiral_gripper.bench.options import CalibrationOptions
from spiral_gripper.bench.run import run_calibration
from spiral_gripper.cli import main as cli

PSI = 6894.757293168361


TRUE_C1 = 160.0e3


def bench_folder(tmp_path):
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
        run_calibration(description, [measurements], CalibrationOptions(**request)),
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
