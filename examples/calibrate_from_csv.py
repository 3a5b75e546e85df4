# SPDX-License-Identifier: Apache-2.0
r"""From a bench test to a calibrated gripper: CSV in, gripper file and plot out.

Run as ``python examples/calibrate_from_csv.py FOLDER``; FOLDER gets the files. The bench test is
synthetic (examples/synthetic_bench_tests.py), so the true constants are known: C1 = 152 kPa,
C2 = 8 kPa.

The same from the command line::

    spiral-gripper calibrate my_gripper.yaml examples/data/bench_extension.csv \
        --law neo_hookean --law mooney_rivlin --radius "20 mm" --plot residuals.png
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from spiral_core import WrapCurve, leave_one_out, pressure_uncertainty, weak_directions
from spiral_gripper import load_description, load_gripper
from spiral_gripper.bench.calibrated_file import write_calibrated_description
from spiral_gripper.bench.measurements import load_measurements
from spiral_gripper.bench.options import CalibrationOptions
from spiral_gripper.bench.residual_plot import residual_figure
from spiral_gripper.bench.run import run_calibration
from spiral_gripper.reports.style import save_figure

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
source = Path(__file__).parent / "data"
data = source / "bench_extension.csv"

# The gripper as it is described before calibration, with handbook constants.
shutil.copy(source / "my_gripper.yaml", folder)
description = load_description(folder / "my_gripper.yaml")

# Every cell is checked; a psi taken for a kPa would be refused here.
measurements = load_measurements(data, description.actuator.tube.length)

# Fit two laws, and let AICc choose.
options = CalibrationOptions(laws=("neo_hookean", "mooney_rivlin"))
choice = run_calibration(description, [measurements], options)
for fit, weight in zip(choice.calibrations, choice.weights, strict=True):
    print(f"{fit.model.fitted_law.__name__}: weight {weight:.2f}")
    for name in fit.names:
        low, high = (1e-3 * end for end in fit.interval(name))
        print(f"  {name} = {1e-3 * fit.value(name):.1f} kPa ({low:.1f} to {high:.1f})")
    for weak in weak_directions(fit):
        print(f"  {weak}")
best = choice.best
print(f"leave-one-out error {leave_one_out(best).relative_error:.1%}")

# How the fit changes the pressures for some objects.
before = WrapCurve(description.gripper)
results = pressure_uncertainty(best, (0.012, 0.020, 0.030))
for result in results:
    old = 1e-3 * before.pressure_from_radius(result.radius)
    half = 0.5e-3 * (result.interval.high - result.interval.low)
    new = 1e-3 * result.pressure
    print(f"{1e3 * result.radius:.0f} mm: {old:.1f} kPa before, {new:.1f} ± {half:.1f} kPa now")

# The calibrated file is written beside the original and keeps its comments.
written = write_calibrated_description(description, best, [data])
save_figure(residual_figure(best, description.gripper.name), folder / "residuals.png")
calibrated = load_gripper(written)
print(f"wrote {written.name} and residuals.png")
