# SPDX-License-Identifier: Apache-2.0
"""The place of the object relative to the base: search for the best, effect of misplacements."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from spiral_core.errors import NotGrippableError, SolverError
from spiral_core.grip.holding import Pull, holding_force
from spiral_core.grip.setup import GripSetup
from spiral_core.grip.window import GripWindow, grip_window
from spiral_core.rod.types import Array, Vector
from spiral_core.validation import require_in_range, require_positive

# The search begins with steps of this many radii and this many radians, and halves them until they
# are a quarter.
SHIFT_STEP = 0.2
TILT_STEP = math.radians(10.0)
HALVINGS = 2
MOST_TRIES = 60


class MountAim(Enum):
    """What a mount is judged by; the value says it in words."""

    WINDOW = "width of the window from the wrap to the loss, as a fraction of its middle"
    FORCE = "holding force away from the base at 1.1 times the onset of the wrap [N]"


@dataclass(frozen=True, slots=True)
class Mount:
    """An object somewhere else than in its first place, and how it is held there.

    Args:
        shift: of the object [m]: along its axis, away from the base square to it, and across both.
        tilt: of the object about the second and the third of these directions [rad].
        setup: with the object there.
        window: what a rising pressure does; None where the object cannot be gripped.
        score: by the search's aim; minus infinity where it cannot be gripped.
    """

    shift: Vector
    tilt: tuple[float, float]
    setup: GripSetup
    window: GripWindow | None
    score: float

    def __repr__(self) -> str:
        shift = ", ".join(f"{1e3 * s:+.1f}" for s in self.shift)
        tilt = ", ".join(f"{math.degrees(t):+.1f}" for t in self.tilt)
        return f"Mount(shift ({shift}) mm, tilt ({tilt}) deg: {self.score:.4g}, {self.window!r})"


def place_mount(
    setup: GripSetup,
    shift: Vector = (0.0, 0.0, 0.0),
    tilt: tuple[float, float] = (0.0, 0.0),
    aim: MountAim = MountAim.WINDOW,
) -> Mount:
    """Return how an object is held that lies elsewhere relative to the base.

    To move the object one way is to move the arm's end the other way.

    Args:
        setup: the gripper and its object in its first place.
        shift: see :class:`Mount` [m].
        tilt: see :class:`Mount` [rad].
        aim: what the score is.
    """
    there = moved(setup, shift, tilt)
    try:
        window = grip_window(there)
        score = _score(window, aim)
    except (NotGrippableError, SolverError):
        return Mount(shift, tilt, there, None, -math.inf)
    return Mount(shift, tilt, there, window, score)


def moved(setup: GripSetup, shift: Vector, tilt: tuple[float, float]) -> GripSetup:
    """Return the setup with its object shifted [m] and tilted [rad] as :class:`Mount` says."""
    frame = mount_frame(setup)
    obstacle = setup.obstacle.moved(
        translation=tuple((np.asarray(shift) @ frame).tolist()),
        rotation=tuple((np.asarray(tilt) @ frame[1:]).tolist()),
    )
    return replace(setup, obstacle=obstacle)


def mount_frame(setup: GripSetup) -> Array:
    """Return the directions of shifts as rows (3, 3): along, away from the base, across both."""
    axis = setup.axis
    away = np.asarray(setup.obstacle.position)
    away = away - (away @ axis) * axis
    norm = float(np.linalg.norm(away))
    if not norm > 0.0:
        away, norm = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]), 1.0
    away = away / np.linalg.norm(away)
    return np.array((axis, away, np.cross(axis, away)))


def search_mount(
    setup: GripSetup,
    aim: MountAim = MountAim.WINDOW,
    *,
    most_tries: int = MOST_TRIES,
    progress: Callable[[int, int], None] | None = None,
) -> Mount:
    """Return the best place of an object relative to the base that a local search finds.

    A compass search: one step each way along the three shifts and two tilts, taken where the score
    rises, halved where none does. It finds a local optimum near the place it begins at.

    Args:
        setup: the gripper and its object in the place where the search begins.
        aim: what is made as large as possible.
        most_tries: closings to compute at the most; each takes as long as a window.
        progress: called with the number of closings done and the most there are, after each.
    """
    require_in_range("most_tries", most_tries, 1, 10_000)
    sizes = np.array(
        (*(3 * (SHIFT_STEP * setup.obstacle.shape.feature_radius,)), *(2 * (TILT_STEP,)))
    )
    steps = [
        sign * size * unit for unit, size in zip(np.eye(5), sizes, strict=True) for sign in (1, -1)
    ]
    place, best, tries = np.zeros(5), place_mount(setup, aim=aim), 1
    for level in range(HALVINGS + 1):
        improved = True
        while improved and tries < most_tries:
            improved = False
            for step in steps:
                if tries >= most_tries:
                    break
                there = place + 0.5**level * step
                other = _placed(setup, there, aim)
                tries += 1
                if progress is not None:
                    progress(tries, most_tries)
                if other.score > best.score:
                    place, best, improved = there, other, True
    return best


def misplacements(
    setup: GripSetup,
    shift: float = 3e-3,
    tilt: float = math.radians(3.0),
    aim: MountAim = MountAim.WINDOW,
) -> tuple[Mount, ...]:
    """Return how an object is held that is off by a few millimeters or degrees, each way.

    Args:
        setup: the gripper and its object where it should be.
        shift: how far off [m], along, away from the base and across.
        tilt: how far turned [rad].
        aim: what the scores are.

    Returns:
        The place itself, then plus and minus each of three shifts and two tilts.
    """
    require_positive("shift", shift)
    require_positive("tilt", tilt)
    sizes = (shift, shift, shift, tilt, tilt)
    places = [np.zeros(5)]
    for unit, size in zip(np.eye(5), sizes, strict=True):
        places += [size * unit, -size * unit]
    return tuple(_placed(setup, place, aim) for place in places)


def _placed(setup: GripSetup, place: Array, aim: MountAim) -> Mount:
    """Return the mount of a place: three shifts [m] and two tilts [rad]."""
    along, away, across, first, second = place.tolist()
    return place_mount(setup, (along, away, across), (first, second), aim)


def _score(window: GripWindow, aim: MountAim) -> float:
    """Return how good a window is: minus infinity where nothing is wrapped, or known."""
    if window.onset_wrap is None:
        return -math.inf
    if aim is MountAim.FORCE:
        point = window.at(min(1.1 * window.onset_wrap, window.top))
        force = holding_force(point, Pull.AWAY).force
        return -math.inf if math.isnan(force) else force
    end = window.top if window.loss is None else window.loss
    return (end - window.onset_wrap) / (0.5 * (end + window.onset_wrap))
