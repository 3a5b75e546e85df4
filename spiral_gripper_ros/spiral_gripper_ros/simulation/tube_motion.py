# SPDX-License-Identifier: Apache-2.0
"""The process that moves a free tube on in time, for the simulator. No ROS."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from importlib import import_module

import numpy as np

from spiral_core import ContactProblem, Frame, Gripper, SpiralError, inertia_of, motion_frames
from spiral_core.grip.setup import LEAST_ELEMENTS, free_problem
from spiral_gripper_ros.planning.grip_figures import TubeShape
from spiral_gripper_ros.planning.moving_tube import TubeQuestion
from spiral_gripper_ros.planning.worker_process import serve

# A tube that is not asked for during so long is at rest when it is asked for again [s].
LONGEST_GAP = 1.0


class SteppedTube:
    """What the process does: a tube that is moved on from question to question."""

    def __init__(self) -> None:
        self._frames: Iterator[Frame] | None = None
        self._way = ((0.0, 0.0), (0.0, 0.0))

    def answer(self, question: TubeQuestion) -> TubeShape:
        """Return the shape at a time.

        Raises:
            SpiralError: the pressure is beyond the gripper's, or no shape was found.
        """
        before = self._way[1]
        now = (question.time, question.pressure)
        self._way = (before, now)
        if self._frames is None or not 0.0 < now[0] - before[0] <= LONGEST_GAP:
            self._frames = self._begun(question.gripper)
        try:
            frame = next(self._frames)
        except (SpiralError, StopIteration):
            self._frames = self._begun(question.gripper)  # from rest
            frame = next(self._frames)
        return TubeShape(frame.state.positions, frame.state.orientations)

    def _begun(self, gripper: Gripper) -> Iterator[Frame]:
        """Return the frames of a tube that rests now, at the times that are asked for."""
        posed = lru_cache(maxsize=1)(lambda pressure: free_problem(gripper, pressure))

        def problem(time: float) -> ContactProblem:
            (first, low), (last, high) = self._way
            return posed(float(np.interp(time, (first, last), (low, high))))

        def times() -> Iterator[float]:
            while True:
                yield self._way[1][0]

        return motion_frames(problem, inertia_of(gripper), times(), elements=LEAST_ELEMENTS)


def main() -> None:
    """Move a tube until standard input is closed."""
    serve(SteppedTube().answer)


if __name__ == "__main__":  # by its full name: what it answers is pickled
    import_module("spiral_gripper_ros.simulation.tube_motion").main()
