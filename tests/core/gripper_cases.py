# SPDX-License-Identifier: Apache-2.0
"""The paper's grippers, built by hand (the shipped files belong to the layer above)."""

from __future__ import annotations

from dataclasses import replace

from core.actuator_cases import PAPER_TUBE, actuator

from spiral_core import (
    Gripper,
    Section,
    gripper_from_actuator,
)
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.errors import ActuationLimit

PRESSURE_MAX = 137_895.0  # 20 psi
DESIGNS = {"P1": (50.0, 0.5), "P2": (60.0, 0.5), "70 degrees": (70.0, 0.361)}


def paper_gripper(
    name,
    gravity=(9.80665, 0.0, 0.0),
    object_axis=None,
):
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


class LinearActuation:
    """A made-up actuator: curvature and torsion proportional to pressure."""

    pressure_limit = 1.0e5
    limit = ActuationLimit.DATA_END

    def __init__(self, curvature, torsion, length):
        """Take the values at the limit."""
        self.curvature, self.torsion, self.length = curvature, torsion, length

    def unloaded_shape(self, pressure):
        """Return the shape at a pressure."""
        x = pressure / self.pressure_limit
        return UnloadedShape(self.curvature * x, self.torsion * x, self.length)


def linear_gripper(
    curvature=50.0,
    torsion=-20.0,
    length=0.5,
    weight=0.0,
    **options,
):
    """Return a gripper whose helix is known in closed form."""
    return Gripper(
        name="linear",
        tube=replace(PAPER_TUBE, length=length),
        actuation=LinearActuation(curvature, torsion, length),
        stiffness=Section.inextensible(3.0e-4, 2.0e-4),
        weight_per_length=weight,
        pressure_max=1.0e5,
        **options,  # type: ignore[arg-type]
    )
