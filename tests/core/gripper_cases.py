# SPDX-License-Identifier: Apache-2.0
"""The paper's grippers, built by hand (the shipped files belong to the layer above)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from core.actuator_cases import PAPER_TUBE, actuator

from spiral_core import Gripper, MeasuredActuation, Section, gripper_from_actuator

PRESSURE_MAX = 137_895.0  # 20 psi
DESIGNS = {"P1": (50.0, 0.5), "P2": (60.0, 0.5), "70 degrees": (70.0, 0.361)}


def paper_gripper(name, gravity=(9.80665, 0.0, 0.0), object_axis=None):
    """Return one of the paper's grippers in some mount."""
    beta, length = DESIGNS[name]
    return gripper_from_actuator(
        name,
        actuator(beta=beta, tube=replace(PAPER_TUBE, length=length)),
        density=930.0,
        pressure_max=PRESSURE_MAX,
        gravity=gravity,
        object_axis=object_axis,
    )


SHARES = np.linspace(0.0, 1.0, 3)


def linear_gripper(curvature=50.0, torsion=-20.0, length=0.5, weight=0.0, **options):
    """Return a gripper whose helix is known in closed form."""
    return Gripper(
        name="linear",
        tube=replace(PAPER_TUBE, length=length),
        actuation=MeasuredActuation(1e5 * SHARES, curvature * SHARES, torsion * SHARES, length),
        stiffness=Section.inextensible(3.0e-4, 2.0e-4),
        weight_per_length=weight,
        pressure_max=1.0e5,
        **options,  # type: ignore[arg-type]
    )
