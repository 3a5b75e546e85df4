# SPDX-License-Identifier: Apache-2.0
"""Write the synthetic bench test of the calibration example, into examples/data.

It is computed, not measured: a 100 mm straight section of the 70 degree design, made of a rubber of
C1 = 152 kPa and C2 = 8 kPa, with random errors of a seed that is stated in the file.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from spiral_core import FreeActuation, MooneyRivlin
from spiral_gripper import load_description

FILE = Path(__file__).parent / "data" / "synthetic_bench_test.csv"
SEED = 20260104
TRUE_MATERIAL = MooneyRivlin(c1=152.0e3, c2=8.0e3)
PSI = 6894.757293168361  # [Pa]
EXTENSION_ERROR, PRESSURE_ERROR = 0.2, 0.05  # standard errors [mm], [psi]


def bench_test() -> str:
    """Return the text of the file."""
    actuator = replace(load_description("paper_design_70").actuator, material=TRUE_MATERIAL)
    actuation, noise = FreeActuation(actuator), np.random.default_rng(SEED)
    lines = [
        "# SYNTHETIC: computed by examples/synthetic_bench_test.py, not measured.",
        f"# Mooney-Rivlin, C1 = 152 kPa, C2 = 8 kPa; random errors with seed {SEED}.",
        "# Straight section, 100 mm, without the straight fiber.",
        "pressure [psi],extension [mm],extension_error [mm],pressure_error [psi]",
    ]
    for psi in range(1, 17):
        true_psi = psi + PRESSURE_ERROR * noise.standard_normal()
        extension = 100.0 * (actuation.stretch_from_pressure(true_psi * PSI) - 1.0)
        extension += EXTENSION_ERROR * noise.standard_normal()
        lines.append(f"{psi},{extension:.2f},{EXTENSION_ERROR},{PRESSURE_ERROR}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    FILE.write_text(bench_test(), encoding="utf-8")
