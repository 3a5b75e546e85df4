# SPDX-License-Identifier: Apache-2.0
"""The payload of a design: its grip on the smallest and the largest object, with contact."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from spiral_core.design.requirement import DesignRequirement
from spiral_core.errors import NotGrippableError, SolverError
from spiral_core.grip.grip import PAYLOAD_SAFETY, Grip, solve_grip
from spiral_core.grip.holding import Pull
from spiral_core.grip.setup import GripSetup, lay_into_coil
from spiral_core.grip.window import grip_window
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper

# Pressures at which the payload is judged, from the onset of the wrap to the last that may carry.
LOOKED_AT = 4
# An object that lies outside of the range by less than this fraction is the one at its end: the
# range, solved up to another pressure, ends elsewhere by a tenth of this.
ROUNDING = 1e-4


def object_in_coil(gripper: Gripper, radius: float, friction: float) -> GripSetup:
    """Return the setup of an object that a design wraps; see :func:`lay_into_coil`."""
    curve = WrapCurve(replace(gripper, object_axis=None))
    nearest = min(max(radius, curve.radius_min), curve.radius_max)
    reached = nearest if abs(nearest - radius) < ROUNDING * radius else radius
    return lay_into_coil(gripper, reached, friction=friction, curve=curve)


def carried_mass(requirement: DesignRequirement, gripper: Gripper) -> tuple[float, float]:
    """Return the mass that a gripper carries twice over, of its extreme objects the lesser [kg].

    And the lowest pressure looked at that carries the payload required, or the most [Pa].

    It is carried at a pressure that :meth:`Grip.recommended_pressure` allows: with the object
    wrapped, the tip on it, and a tenth below the loss. Zero where an object is not held at all.
    Each object takes a window and a few pulls along gravity: about two seconds.

    Args:
        requirement: objects, friction and payload.
        gripper: of a candidate, with the largest pressure that is commanded.
    """
    radii = {requirement.radius_min, requirement.radius_max}
    carried = [_carried(requirement, gripper, radius) for radius in radii]
    masses, pressures = zip(*carried, strict=True)
    return min(masses), max(pressures)


def _carried(
    requirement: DesignRequirement, gripper: Gripper, radius: float
) -> tuple[float, float]:
    """Return the largest mass that is carried [kg], and the pressure that is enough [Pa]."""
    try:
        window = grip_window(object_in_coil(gripper, radius, requirement.friction_coefficient))
        if window.onset_wrap is None:
            return 0.0, 0.0
        allowed = Grip(window, (), {}).carrying_range
        pressures = np.unique(np.linspace(*allowed, LOOKED_AT))
        held = solve_grip(window.setup, (Pull.DOWN,), pressures=pressures.tolist(), window=window)
    except (NotGrippableError, SolverError):
        return 0.0, 0.0
    masses = np.nan_to_num(held.force(Pull.DOWN)) / (PAYLOAD_SAFETY * math.hypot(*gripper.gravity))
    most = float(masses.max())
    return most, float(pressures[masses >= min(requirement.payload or 0.0, most)][0])
