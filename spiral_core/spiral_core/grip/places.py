# SPDX-License-Identifier: Apache-2.0
"""Places and radii of objects: which are held, where the nearest is, and why one is not."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import groupby, pairwise

import numpy as np

from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.setup import Closing, GripSetup, lay_into_coil
from spiral_core.grip.window import TOUCH_GAP, GripWindow, WindowEnd, grip_window
from spiral_core.message import Message, Quantity
from spiral_core.numerics.tasks import Progress, in_turn
from spiral_core.rod.contact.shapes import Cylinder
from spiral_core.rod.types import Array, Vector
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
# Where an object is not held in its place, others are tried, this many in all: up to this many
# radii of object and tube, and this many radians, away.
PLACES_TRIED = 40
FARTHEST_SHIFT = 1.5
LARGEST_TILT = math.radians(10.0)
# So many of them fill that box; the others lie around the best found so far, this many around each
# of so many, first within this part of the box, then each time within that part of the last.
EXPLORED = 16
NARROWED, BEST = 5, 2
FIRST_PART, NEXT_PART = 0.5, 0.6
# A place is the better the nearer the tip comes and the more of the tube touches: nothing at all
# counts as much as so many radii of the tube, this part of it as none.
UNTOUCHED, ENOUGH = 6.0, 0.3
LEAST_MISSING = 1e-6
# Rolls of the base about the tube that are tried where no place is found: a turn's eighths.
ROLLS = 8


def not_held(window: GripWindow, progress: Progress | None = None) -> NotGrippableError:
    """Return the refusal of a window without a perfect wrap: why, and the nearest radius held.

    Takes seconds to a minute; progress as of :func:`nearest_held_radius`.
    """
    setup, (reason, gap) = window.setup, why_not_held(window)
    radius = float(setup.obstacle.shape.feature_radius)
    if not window.is_cut_short and _held_back(setup):
        friction = "; closed without friction it would be wrapped: friction holds the tube back"
        reason = Message("{}{}", reason, friction)
    return NotGrippableError(radius, reason, -gap, nearest_held_radius(setup, progress))


def why_not_held(window: GripWindow) -> tuple[Message, float]:
    """Return why a window has no perfect wrap, and how far its tip stays from the object [m]."""
    best = min(window.points, key=lambda point: point.tip_gap)
    gap = best.tip_gap
    ends: dict[WindowEnd, str] = {
        WindowEnd.LOST: "the coil lets go before its tip touches",
        WindowEnd.LIMIT: "the tip does not touch up to the pressure limit",
        WindowEnd.PASSED_BY: (
            "the tip passes the object by and does not touch up to far above the tip criterion's "
            "pressure"
        ),
        WindowEnd.SELF_CONTACT: "turns of the tube touch each other before the tip touches it",
        WindowEnd.NOT_FOLLOWED: "the closing tube finds no rest that could be certified",
    }
    if window.is_cut_short:
        top = Quantity(window.top, "Pa")
        ends[window.end] = Message("the tip does not touch up to {}, the last looked at", top)
    pressure = Quantity(best.pressure, "Pa")
    reason = Message(
        "{}; it comes nearest at {}, {} from the surface",
        ends[window.end],
        pressure,
        Quantity(gap, "m"),
    )
    if gap <= TOUCH_GAP * best.outer_radius:
        reason = Message(
            "the tip touches at {}, but never with more than a tenth of the tube; {}",
            pressure,
            window.end.value,
        )
    # A tip that touches sinks in by a rounding error.
    return reason, max(gap, 0.0)


def _held_back(setup: GripSetup) -> bool:
    """Return whether only friction keeps a closing tube from the wrap."""
    rubs = setup.closing is Closing.SLOW and setup.obstacle.friction > 0.0
    if not rubs or setup.tip_pressure is None:
        return False
    return _is_wrapped(replace(setup, closing=Closing.FRICTIONLESS))


def nearest_held_radius(setup: GripSetup, progress: Progress | None = None) -> float | None:
    """Return the nearest radius that is held [m], of a cylinder that was laid into the coil.

    Radii above and below are tried in steps of 8 %; where one is held, the end of what is held is
    located to a percent. None if none of them is held, or the object is none that was laid into the
    coil. ``progress`` is called with the number of radii tried and the most there are.
    """
    shape = setup.obstacle.shape
    if setup.tip_pressure is None or not isinstance(shape, Cylinder):
        return None
    own, obstacle = setup.gripper, setup.obstacle
    curve = WrapCurve(replace(own, object_axis=None))
    laid = lay_into_coil(own, shape.radius, curve=curve).obstacle
    if (laid.position, laid.orientation) != (obstacle.position, obstacle.orientation):
        return None
    asked = obstacle.friction, setup.closing
    for number in range(1, RADIUS_TRIES + 1):
        held = []
        for side, step in enumerate((RADIUS_STEP, -RADIUS_STEP)):
            before, radius = ((1.0 + n * step) * shape.radius for n in (number - 1, number))
            inside = curve.radius_min <= radius <= curve.radius_max
            if inside and _is_held(own, curve, radius, *asked):
                tried = _end(
                    own, curve, (min(before, radius), max(before, radius), step < 0.0), *asked
                )
                held += [radius, *(each for each, good in tried.items() if good)]
            if progress is not None:
                progress(2 * number - 1 + side, 2 * RADIUS_TRIES)
        if held:
            return min(held, key=lambda radius: abs(radius - shape.radius))
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
    tried = in_turn(partial(_is_held, gripper, curve), radii, executor, progress)
    held = dict(zip(radii, tried, strict=True))
    ends = [(*pair, held[pair[0]]) for pair in pairwise(radii) if held[pair[0]] != held[pair[1]]]
    for found in in_turn(partial(_end, gripper, curve), ends, executor, progress, len(radii)):
        held |= found
    runs = (list(run) for is_held, run in groupby(sorted(held), held.__getitem__) if is_held)
    return tuple((run[0], run[-1]) for run in runs)


def _is_held(
    gripper: Gripper,
    curve: WrapCurve,
    radius: float,
    friction: float | None = None,
    closing: Closing = Closing.SLOW,
) -> bool:
    """Return whether a cylinder of a radius [m] is wrapped where the free coil lies."""
    try:
        return _is_wrapped(
            lay_into_coil(gripper, radius, friction=friction, closing=closing, curve=curve)
        )
    except SpiralError:
        return False


def _end(
    gripper: Gripper,
    curve: WrapCurve,
    pair: tuple[float, float, bool],
    friction: float | None = None,
    closing: Closing = Closing.SLOW,
) -> dict[float, bool]:
    """Return which radii are held between two [m] of which one is: the third says if the lower."""
    (low, high, first), found = pair, {}
    while high > (1.0 + END_TOLERANCE) * low:
        middle = math.sqrt(low * high)
        found[middle] = _is_held(gripper, curve, middle, friction, closing)
        low, high = (middle, high) if found[middle] == first else (low, middle)
    return found


def find_place(
    setup: GripSetup, executor: Executor | None = None, progress: Progress | None = None
) -> GripSetup | None:
    """Return an object in its place or, where it is not held there, in a place near it where it is.

    Forty places are tried: first some that fill a box about the first one, the nearest first, then
    others around those in which the tip came nearest and most of the tube touched. With the
    gripper's ``object_axis`` the object keeps its direction; else it is also tilted by up to 10
    degrees about each of two axes.

    Args:
        setup: the gripper and its object in its first place.
        executor: where; None tries one after the other, here.
        progress: called with the number of places tried and the most there are.

    Returns:
        The object in the first place found; None if it is held in none of them.
    """
    reach = FARTHEST_SHIFT * (setup.obstacle.shape.feature_radius + setup.gripper.tube.outer_radius)
    tilt = LARGEST_TILT if setup.gripper.object_axis is None else 0.0
    sizes = np.array((reach, reach, reach, tilt, tilt))
    steps, part = evenly(PLACES_TRIED, len(sizes)), FIRST_PART
    tried: list[tuple[float, Array]] = []
    batch = [np.zeros(len(sizes)), *evenly(EXPLORED, len(sizes))]
    while batch:
        places = [setup.moved(sizes * shift) for shift in batch]
        for shift, place, missing in zip(
            batch, places, in_turn(_missing, places, executor), strict=True
        ):
            if missing == 0.0:
                return place
            tried.append((missing, shift))
            if progress is not None:
                progress(len(tried), PLACES_TRIED)
        best = sorted(tried, key=lambda one: one[0])[:BEST]
        around = steps[len(tried) - EXPLORED - 1 :]
        batch = [
            np.clip(shift + part * step, -1.0, 1.0)
            for number, (_, shift) in enumerate(best)
            for step in around[number * NARROWED : (number + 1) * NARROWED]
        ][: PLACES_TRIED - len(tried)]
        part *= NEXT_PART
    return None


def _missing(setup: GripSetup) -> float:
    """Return how far a closing gripper is from the wrap: 0 where it wraps, inf without answer."""
    try:
        return missing_to_wrap(grip_window(setup, until_wrapped=True))
    except SpiralError:
        return math.inf


def missing_to_wrap(window: GripWindow) -> float:
    """Return how far a closed gripper stayed from the wrap: 0 where it wraps.

    The nearest the tip came, in outer radii of the tube, and what of the tube did not touch there.
    """
    if window.onset_wrap is not None:
        return 0.0
    tube = window.setup.gripper.tube
    return min(
        LEAST_MISSING
        + max(point.tip_gap, 0.0) / tube.outer_radius
        + UNTOUCHED * max(0.0, 1.0 - point.contact_length / (ENOUGH * tube.length))
        for point in window.points
    )


def what_helps(setup: GripSetup, executor: Executor | None = None) -> str:
    """Return what would make a gripper hold an object that it holds in no place nearby, in words.

    Tried in this order: another roll of the base about the tube, the direction that fits the coil.
    """
    own, obstacle = setup.gripper, setup.obstacle
    grippers = {
        f"the base rolled by {360 * number // ROLLS} deg about the tube": _rolled(
            own, 2.0 * math.pi * number / ROLLS
        )
        for number in range(1, ROLLS)
    }
    if own.object_axis is not None:
        along = replace(own, object_axis=None)
        grippers["the object along the direction that fits the coil"] = along
    others: dict[str, GripSetup] = {}
    for name, gripper in grippers.items():
        with suppress(SpiralError):
            others[name] = lay_into_coil(
                gripper,
                float(obstacle.shape.feature_radius),
                shape=obstacle.shape,
                friction=obstacle.friction,
                closing=setup.closing,
            )
    held = in_turn(_is_wrapped, others.values(), executor)
    helps = next((name for name, is_held in zip(others, held, strict=True) if is_held), None)
    if helps is None:
        return "nor would another roll of the base or another direction of the object help"
    return f"it would be held with {helps}"


def _rolled(gripper: Gripper, angle: float) -> Gripper:
    """Return a gripper whose base is turned by an angle [rad] about the tube in the world."""
    c, s = math.cos(angle), math.sin(angle)

    def turned(vector: Vector) -> Vector:
        x, y, z = vector
        return (x, c * y + s * z, c * z - s * y)

    axis = gripper.object_axis
    return replace(
        gripper,
        gravity=turned(gripper.gravity),
        object_axis=None if axis is None else turned(axis),
    )


def evenly(count: int, dimensions: int) -> Array:
    """Return points (count, dimensions) that fill [-1, 1] evenly, those near zero first.

    An additive recurrence whose steps are powers of the root of x^(dimensions + 1) = x + 1.

    Source:
        M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018.
    """
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (dimensions + 1))
    steps = root ** -np.arange(1.0, dimensions + 1.0)
    points = 2.0 * ((0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0) - 1.0
    nearest: Array = points[np.argsort(np.linalg.norm(points, axis=1))]
    return nearest


def _is_wrapped(setup: GripSetup) -> bool:
    """Return whether a rising pressure wraps the object, for certain."""
    try:
        return grip_window(setup, until_wrapped=True).onset_wrap is not None
    except SpiralError:
        return False
