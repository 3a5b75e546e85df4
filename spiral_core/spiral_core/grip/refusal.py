# SPDX-License-Identifier: Apache-2.0
"""Why a gripper does not hold an object, and the nearest one that it holds."""

from __future__ import annotations

import math
from dataclasses import replace

from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.point import TOUCH_GAP
from spiral_core.grip.setup import Closing, GripSetup, lay_into_coil
from spiral_core.grip.window import GripWindow, WindowEnd, grip_window
from spiral_core.rod.contact.shapes import Cylinder
from spiral_core.wrap.curve import WrapCurve

# The nearest radius is looked for in steps of this fraction of the object's, outwards.
RADIUS_STEP = 0.08
RADIUS_TRIES = 6
# A radius counts as held where the tip touches at one of these fractions of the tip criterion's
# pressure.
FRACTIONS = (0.3, 0.6, 0.75, 0.85, 0.9, 0.94, 0.98, 1.02, 1.06)


def not_held(window: GripWindow) -> NotGrippableError:
    """Return the refusal of a window without a perfect wrap: why, and the nearest radius held."""
    setup = window.setup
    radius = float(setup.obstacle.shape.feature_radius)
    best = min(window.points, key=lambda point: point.tip_gap)
    gap = best.tip_gap
    ends = {
        WindowEnd.LOST: "the coil lets go before its tip touches",
        WindowEnd.LIMIT: "the tip does not touch up to the pressure limit",
        WindowEnd.PASSED_BY: (
            "the tip passes the object by and does not touch up to far above the tip criterion's "
            "pressure"
        ),
        WindowEnd.SELF_CONTACT: "turns of the tube touch each other before the tip touches it",
        WindowEnd.NOT_FOLLOWED: "the closing tube finds no rest that could be certified",
    }
    reason = (
        f"{ends[window.end]}; it comes nearest at {best.pressure:.6g} Pa, {gap:.4g} m from the "
        "surface"
    )
    if gap <= TOUCH_GAP * best.outer_radius:
        reason = (
            f"the tip touches at {best.pressure:.6g} Pa, but never with more than a tenth of the "
            f"tube; {window.end.value}"
        )
    if _held_back(setup):
        reason += "; closed without friction it would be wrapped: friction holds the tube back"
    return NotGrippableError(radius, reason, -gap, nearest_held_radius(setup))


def _held_back(setup: GripSetup) -> bool:
    """Return whether only friction keeps a closing tube from the wrap."""
    rubs = setup.closing is Closing.SLOW and setup.obstacle.friction > 0.0
    if not rubs or setup.tip_pressure is None:
        return False
    try:
        return _is_wrapped(replace(setup, closing=Closing.FRICTIONLESS))
    except SpiralError:
        return False


def nearest_held_radius(setup: GripSetup) -> float | None:
    """Return the nearest radius that is held [m], of a cylinder that was laid into the coil.

    Radii above and below are tried in turn, in steps of 8 %. None if none of them is held, or the
    object is none that was laid into the coil.
    """
    shape = setup.obstacle.shape
    if setup.tip_pressure is None or not isinstance(shape, Cylinder):
        return None
    curve = WrapCurve(replace(setup.gripper, object_axis=None))
    for number in range(1, RADIUS_TRIES + 1):
        for factor in (1.0 + number * RADIUS_STEP, 1.0 - number * RADIUS_STEP):
            radius = factor * shape.radius
            if not curve.radius_min <= radius <= curve.radius_max:
                continue
            try:
                other = lay_into_coil(
                    setup.gripper,
                    radius,
                    friction=setup.obstacle.friction,
                    closing=setup.closing,
                    curve=curve,
                )
                if _is_wrapped(other):
                    return radius
            except SpiralError:
                continue
    return None


def _is_wrapped(setup: GripSetup) -> bool:
    """Return whether the tip touches near the tip criterion's pressure."""
    limit, tip = setup.gripper.pressure_max, setup.tip_pressure or math.inf
    pressures = [fraction * tip for fraction in FRACTIONS if fraction * tip <= limit]
    return grip_window(setup, pressures).onset_wrap is not None
