# SPDX-License-Identifier: Apache-2.0
"""Write a synthetic free swing of the tip into examples/data.

It is computed, not measured: the gripper of examples/data/my_gripper.yaml without pressure, with a
retardation time of 20 ms in air, let go from 30 mm aside, with random errors of a seed that the
file states.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from spiral_core import Damping, RodElement, inertia_of, solve_motion, solve_rod
from spiral_core.grip.setup import free_problem
from spiral_gripper import load_description

FILE = Path(__file__).parent / "data" / "free_swing.csv"
SEED = (20260104, 5)
TRUE_DAMPING = Damping(retardation_time=0.020, air=1.0)
# Force that holds the tip aside before it is let go [N], times of the pictures [s], the first after
# the faster vibrations have died away, and standard error [m].
PULL, PICTURES, ERROR = 0.0062, np.arange(1.0, 9.0, 0.04), 0.3e-3


def free_swing() -> str:
    """Return the text of the file."""
    gripper = load_description(FILE.parent / "my_gripper.yaml").gripper
    problem = free_problem(gripper, 0.0)
    aside = replace(problem.load, tip_force=(0.0, PULL, 0.0))
    start = solve_rod(replace(problem, load=aside), element=RodElement.MIXED, elements=30)
    motion = solve_motion(
        lambda _: problem, inertia_of(gripper), (0.0, *PICTURES), start=start, damping=TRUE_DAMPING
    )
    noise = np.random.default_rng(SEED)
    lines = [
        f"# SYNTHETIC: computed by examples/synthetic_free_swing.py with seed {SEED}.",
        "time [s],displacement [mm],displacement_error [mm],pressure [kPa]",
    ]
    for frame in motion.frames[1:]:
        read = frame.state.tip_position[1] + ERROR * noise.standard_normal()
        lines.append(f"{frame.time:.2f},{1e3 * read:.2f},{1e3 * ERROR:g},0")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    FILE.write_text(free_swing(), encoding="utf-8")
