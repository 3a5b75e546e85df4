# SPDX-License-Identifier: Apache-2.0
"""The payload of a design: its grip on the smallest and the largest object, with contact."""

from __future__ import annotations

import math

from spiral_core.design.requirement import Candidate, DesignRequirement
from spiral_core.design.rod_correction import gripper_of
from spiral_core.errors import NotGrippableError, SolverError
from spiral_core.grip.grip import LOSS_MARGIN, PAYLOAD_SAFETY
from spiral_core.grip.holding import Pull, holding_force
from spiral_core.grip.setup import lay_into_coil
from spiral_core.grip.window import grip_window
from spiral_core.wrap.gripper import Gripper


def carried_mass(requirement: DesignRequirement, candidate: Candidate, length: float) -> float:
    """Return the mass that a candidate carries twice over, of its extreme objects the lesser [kg].

    Zero where it does not hold an object at all. Each object takes a window and a pull along
    gravity: about two seconds.

    Args:
        requirement: objects, mount, friction and the pressure limit.
        candidate: tube, material, angles.
        length: of the gripper [m].
    """
    gripper = gripper_of(requirement, candidate, length, requirement.pressure_max)
    radii = {requirement.radius_min, requirement.radius_max}
    return min(_carried(gripper, radius, requirement.friction_coefficient) for radius in radii)


def _carried(gripper: Gripper, radius: float, friction: float) -> float:
    """Return the mass carried at the highest pressure a tenth below the loss [kg]."""
    try:
        window = grip_window(lay_into_coil(gripper, radius, friction=friction))
        if window.onset_wrap is None:
            return 0.0
        highest = math.inf if window.loss is None else (1.0 - LOSS_MARGIN) * window.loss
        point = window.at(min(window.top, max(window.onset_wrap, highest)))
    except (NotGrippableError, SolverError):
        return 0.0
    held = holding_force(point, Pull.DOWN).force
    return max(0.0, held) / (PAYLOAD_SAFETY * math.hypot(*gripper.gravity))
