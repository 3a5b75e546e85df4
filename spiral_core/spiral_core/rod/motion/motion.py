# SPDX-License-Identifier: Apache-2.0
"""The result of a motion: frames, events and status."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Array


class MotionStatus(Enum):
    """How a motion ended; the value is advice to the user."""

    COMPLETED = "all the time asked for was computed"
    STALLED = (
        "no step could be solved beyond this time; use more elements, a slower ramp or more damping"
    )


class EventKind(Enum):
    """What happens to the contact with an obstacle."""

    TOUCH = "the rod touches an obstacle that it did not touch"
    SLIP = "the rod begins to slide where every place in contact stuck"
    LOSS = "the rod leaves the obstacle"


@dataclass(frozen=True, slots=True)
class MotionEvent:
    """An event in time.

    Args:
        kind: what happens.
        obstacle: index of the obstacle.
        time: when [s]; it lies at most ``within`` earlier.
        within: duration of the step that holds it [s].
    """

    kind: EventKind
    obstacle: int
    time: float
    within: float


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A rod at one time.

    Args:
        time: [s].
        state: shape, forces and contacts. Its base reaction includes inertia; ``moments`` are those
            of elasticity and damping together, its energy without both, its iterations those since
            the previous frame. It has no certificate: its smallest pivot is NaN.
        velocities: of the nodes (n, 3) [m/s].
        kinetic_energy: [J].
        steps: taken since the beginning.
        error: sum of the steps' estimated errors so far [m]: an upper bound where errors do not
            grow; impacts are not included.
        residual: largest imbalance of a step since the previous frame, as a fraction of the scales
            of static forces and lengths: 1e-7, and up to 1e-4 where many nodes strike at once.
        events: since the previous frame.
    """

    __repr__ = brief_repr

    time: float
    state: RodState
    velocities: Array
    kinetic_energy: float
    steps: int
    error: float
    residual: float
    events: tuple[MotionEvent, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A rod in time.

    Args:
        status: how it ended.
        frames: at the times asked for, as far as they were reached.
    """

    __repr__ = brief_repr

    status: MotionStatus
    frames: tuple[Frame, ...]

    @property
    def times(self) -> Array:
        """Times of the frames (k,) [s]."""
        return np.array([frame.time for frame in self.frames])

    @property
    def positions(self) -> Array:
        """Positions of the nodes (k, n, 3) [m]."""
        return np.array([frame.state.positions for frame in self.frames])

    @property
    def contact_fractions(self) -> Array:
        """Part of the rod's length that touches any obstacle (k,)."""
        return np.array([contact_fraction(frame.state) for frame in self.frames])

    @property
    def events(self) -> tuple[MotionEvent, ...]:
        """All events, in order."""
        return tuple(event for frame in self.frames for event in frame.events)


def contact_fraction(state: RodState) -> float:
    """Return the part of the rod's length that touches any obstacle."""
    touching = state.touching.any(axis=0)
    return float(np.sum(state.node_lengths[touching]) / state.arc_lengths[-1])
