# SPDX-License-Identifier: Apache-2.0
"""What errors of building one do to the pressure of a wrap: prints the table of docs/building.md.

Run as ``python docs/scatter.py``.
"""

from __future__ import annotations

import math
from dataclasses import replace

from spiral_core import Actuator, FiberAngles, FreeActuation, WrapCurve, stiffness_from_actuator
from spiral_gripper import load_description

GRIPPER, OBJECT_RADIUS = "paper_design_70", 0.02
described = load_description(GRIPPER)


def wrap_pressure(actuator: Actuator) -> float:
    """Return the pressure [Pa] at which a gripper of this actuator wraps the object."""
    gripper = replace(
        described.gripper,
        tube=actuator.tube,
        actuation=FreeActuation(actuator),
        stiffness=stiffness_from_actuator(actuator),
    )
    return WrapCurve(gripper).pressure_from_radius(OBJECT_RADIUS)


def changed_actuators() -> list[tuple[str, str, Actuator]]:
    """Return what is changed, by how much, and the actuator that results."""
    actuator = described.actuator
    tube, fibers, law = actuator.tube, actuator.fiber_pair, actuator.material
    alpha, beta, two = fibers.alpha, fibers.beta, math.radians(2.0)
    stiffer = replace(law, c1=1.1 * law.c1, c2=1.1 * law.c2)
    tubes = {
        ("wall", "+10 %"): replace(tube, wall_thickness=1.1 * tube.wall_thickness),
        ("bore", "+3 %"): replace(tube, inner_radius=1.03 * tube.inner_radius),
        ("length", "+3 %"): replace(tube, length=1.03 * tube.length),
    }
    return [
        *((*key, replace(actuator, tube=other)) for key, other in tubes.items()),
        ("elastomer's constants", "+10 %", replace(actuator, material=stiffer)),
        ("angle β", "+2°", replace(actuator, fibers=FiberAngles(alpha, beta + two))),
        ("angle α", "-2°", replace(actuator, fibers=FiberAngles(alpha - two, beta))),
        (
            "distance of the straight fiber from the axis",
            "+10 %",
            replace(actuator, straight_fiber_radius=1.1 * tube.inner_radius),
        ),
    ]


def table() -> str:
    """Return the table's rows."""
    usual = wrap_pressure(described.actuator)
    return "\n".join(
        f"| {name} | {change} | {100.0 * (wrap_pressure(actuator) / usual - 1.0):+.1f} % |"
        for name, change, actuator in changed_actuators()
    )


if __name__ == "__main__":
    print(table())
