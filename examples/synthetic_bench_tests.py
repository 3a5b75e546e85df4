# SPDX-License-Identifier: Apache-2.0
"""Write one synthetic bench test of each kind into examples/data.

They are computed, not measured: the gripper of examples/data/my_gripper.yaml, made of a rubber of
C1 = 152 kPa and C2 = 8 kPa, with random errors of a seed that each file states.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from spiral_core import (
    FreeActuation,
    MooneyRivlin,
    WrapCurve,
    grip_window,
    lay_into_coil,
    stiffness_from_actuator,
)
from spiral_core.grip.window import sharp_onset
from spiral_gripper import load_description

FOLDER = Path(__file__).parent / "data"
SEED = 20260104
TRUE_MATERIAL = MooneyRivlin(c1=152.0e3, c2=8.0e3)
PSI = 6894.757293168361  # [Pa]
SECTION = 0.1  # length of the straight section, without the straight fiber [m]
described = load_description(FOLDER / "my_gripper.yaml")
finished = FreeActuation(replace(described.actuator, material=TRUE_MATERIAL))
straight = FreeActuation(replace(finished.actuator, single_fibers=()))
gripper = replace(
    described.gripper, actuation=finished, stiffness=stiffness_from_actuator(finished.actuator)
)
curve = WrapCurve(gripper)
radii = [0.029, 0.025, 0.021, 0.017, 0.014, 0.011]  # of cylinders [m]
onsets = [
    sharp_onset(grip_window(lay_into_coil(gripper, radius), until_wrapped=True)) for radius in radii
]
touched = CubicSpline(onsets, radii)


def measured(kind: str, pressure: float) -> list[float]:
    """Return what an exact test of a kind reads at a pressure [Pa], in the units of its columns."""
    plain, bent = straight.unloaded_shape(pressure), gripper.unloaded_shape(pressure)
    if kind == "extension":  # of the straight section
        return [1e3 * SECTION * (straight.stretch_from_pressure(pressure) - 1.0)]
    if kind == "twist":  # of its far end
        rate = plain.torsion * plain.backbone_length / gripper.tube.length
        return [math.degrees(rate * SECTION)]
    if kind == "bend_angle":  # of the finished gripper, unloaded: curvature times length
        return [math.degrees(bent.curvature * bent.backbone_length)]
    if kind == "position":  # of the tip of the hanging gripper, in the base frame
        return [1e3 * float(x) for x in curve.state_at_pressure(pressure).tip_position]
    return [1e3 * float(touched(pressure))]  # of the cylinder that the tip just touches


# Kind of test: its columns, the standard error in their unit, the lowest pressure [psi].
TESTS = {
    "extension": ("extension [mm]", 0.2, 2),
    "twist": ("twist [deg]", 1.0, 2),
    "bend_angle": ("bend_angle [deg]", 5.0, 2),
    "position": ("x [mm],y [mm],z [mm]", 1.5, 2),
    "object_radius": ("object_radius [mm]", 0.5, 10),
}


def bench_test(kind: str) -> str:
    """Return the text of the file of one kind of test."""
    columns, error, lowest = TESTS[kind]
    noise = np.random.default_rng((SEED, list(TESTS).index(kind)))
    unit = columns.rpartition(" ")[2]
    length = f",{1e3 * SECTION:g}" if kind in {"extension", "twist"} else ""
    lines = [
        f"# SYNTHETIC: computed by examples/synthetic_bench_tests.py with seed {SEED}.",
        f"pressure [psi],{columns},{kind}_error {unit}"
        + (",section_length [mm]" if length else ""),
    ]
    for psi in range(lowest, 17, 2):
        cells = [value + error * noise.standard_normal() for value in measured(kind, psi * PSI)]
        lines.append(
            ",".join([f"{psi}", *(f"{cell:.2f}" for cell in cells), f"{error:g}"]) + length
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    for kind in TESTS:
        (FOLDER / f"bench_{kind}.csv").write_text(bench_test(kind), encoding="utf-8")
