# SPDX-License-Identifier: Apache-2.0
"""Animation of the pull: the object moves out of the coil, and the coil follows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from spiral_core import Grip, Pull, RodState
from spiral_core.grip.holding import pull_direction
from spiral_core.rod.contact.solve import follow_contact
from spiral_core.rod.state import RodStatus
from spiral_core.rod.types import Array

# Frames of the pull, up to the displacement of the largest force and this much farther.
FRAMES = 24
BEYOND = 1.3


@dataclass(frozen=True, slots=True, eq=False)
class PullFrame:
    """One moment of a pull.

    Args:
        displacement: of the object (3,) [m], base frame.
        state: of the tube.
        force: that resists [N].
    """

    displacement: Array
    state: RodState
    force: float


def pull_frames(grip: Grip, pressure: float) -> list[PullFrame]:
    """Return a pull away from the base, at the solved pressure nearest to the given one [Pa].

    The frames end early where the coil snaps.
    """
    number = int(np.argmin(np.abs(grip.pressures - pressure)))
    point, held = grip.points[number], grip.forces[Pull.AWAY][number]
    direction = pull_direction(point, Pull.AWAY)
    setup, state = point.setup, point.state
    frames = [PullFrame(np.zeros(3), state, -float(state.on_obstacle().force @ direction))]
    start = np.asarray(setup.obstacle.position)
    # Of a force that is not known the pull has no displacement either.
    reach = np.nan_to_num(BEYOND * held.displacement)
    for distance in np.linspace(0.0, reach, FRAMES)[1:] if reach > 0.0 else ():
        x, y, z = (start + distance * direction).tolist()
        moved = replace(setup.obstacle, position=(x, y, z))
        path = follow_contact([setup.problem(point.pressure, moved)], start=state)
        followed = path.states and path.states[-1].status is RodStatus.CONVERGED
        if path.events or not followed:
            break
        state = path.states[-1]
        force = -float(state.on_obstacle().force @ direction)
        frames.append(PullFrame(distance * direction, state, force))
    return frames
