# SPDX-License-Identifier: Apache-2.0
"""Why a gripper does not hold an object, the nearest one that it holds, and all of them."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from itertools import groupby, pairwise

import numpy as np

from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.point import TOUCH_GAP
from spiral_core.grip.setup import Closing, GripSetup, lay_into_coil
from spiral_core.grip.window import GripWindow, Progress, WindowEnd, grip_window
from spiral_core.rod.contact.shapes import Cylinder
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper

# The nearest radius is looked for in steps of this fraction of the object's, outwards.
RADIUS_STEP = 0.08
RADIUS_TRIES = 6
# All radii are looked for on so many, evenly spaced: closer than the gap between two ranges that
# paper_design_70 has. Thinner than this fraction of the tube's outer radius is not tried: a coil
# that tight has no hole left.
RADII_TRIED = 16
THINNEST = 0.1
# To this fraction of itself an end of a range is located.
END_TOLERANCE = 0.01


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


def held_radii(
    gripper: Gripper, executor: Executor | None = None, progress: Progress | None = None
) -> tuple[tuple[float, float], ...]:
    """Return the ranges of radii that a gripper holds, each laid into its free coil [m], rising.

    Both ends of each range are held, and every radius between them that was tried: sixteen over the
    tip criterion's range, none thinner than a tenth of the tube's outer radius. An end is within a
    percent of a radius that is not held, or the end of what was tried.

    Args:
        gripper: as it is mounted, with its own friction or the default.
        executor: where; None tries one after the other, here.
        progress: called with the number of radii and ends that are done, and the number there are.

    Raises:
        NoCoilError: the gripper makes no coil.
        SolverError: a free shape could not be certified.
    """
    curve = WrapCurve(replace(gripper, object_axis=None))
    low, high = max(curve.radius_min, THINNEST * gripper.tube.outer_radius), curve.radius_max
    radii = [low, *np.linspace(low, high, RADII_TRIED)[1:-1].tolist(), high]
    in_turn = map if executor is None else executor.map
    done = (lambda *_: None) if progress is None else progress
    held: dict[float, bool] = {}
    for is_held in in_turn(partial(_is_held, gripper, curve), radii):
        held[radii[len(held)]] = is_held
        done(len(held), RADII_TRIED + 1)
    ends = [pair for pair in pairwise(radii) if held[pair[0]] != held[pair[1]]]
    firsts = [held[low] for low, _ in ends]
    for count, found in enumerate(in_turn(partial(_end, gripper, curve), ends, firsts), start=1):
        held |= found
        done(RADII_TRIED + count, RADII_TRIED + len(ends))
    return _ranges(held)


def _is_held(gripper: Gripper, curve: WrapCurve, radius: float) -> bool:
    """Return whether a cylinder of a radius [m] is wrapped where the free coil lies."""
    try:
        return _is_wrapped(lay_into_coil(gripper, radius, curve=curve))
    except SpiralError:
        return False


def _end(
    gripper: Gripper, curve: WrapCurve, pair: tuple[float, float], first: bool
) -> dict[float, bool]:
    """Return which radii are held between two [m] of which one is: ``first`` says of the lower."""
    (low, high), found = pair, {}
    while high > (1.0 + END_TOLERANCE) * low:
        middle = math.sqrt(low * high)
        found[middle] = _is_held(gripper, curve, middle)
        low, high = (middle, high) if found[middle] == first else (low, middle)
    return found


def _ranges(held: dict[float, bool]) -> tuple[tuple[float, float], ...]:
    """Return the first and the last radius of each run of radii that are held [m], rising."""
    found = (list(run) for is_held, run in groupby(sorted(held), held.__getitem__) if is_held)
    return tuple((run[0], run[-1]) for run in found)


def _is_wrapped(setup: GripSetup) -> bool:
    """Return whether a rising pressure wraps the object."""
    return grip_window(setup, until_wrapped=True).onset_wrap is not None
