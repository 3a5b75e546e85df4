# SPDX-License-Identifier: Apache-2.0
"""The free tube in time, computed in a process of its own: it lags behind and swings. No ROS."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module

import numpy as np

from spiral_core import ContactProblem, Frame, Gripper, SpiralError, inertia_of, motion_frames
from spiral_core.grip.setup import LEAST_ELEMENTS, free_problem
from spiral_gripper_ros.planning.grip_figures import TubeShape
from spiral_gripper_ros.planning.worker_process import WorkerProcess, serve

# A tube that is not asked for during so long is at rest when it is asked for again [s].
LONGEST_GAP = 1.0


@dataclass(frozen=True, slots=True)
class TubeQuestion:
    """Where a tube is at a time.

    Args:
        gripper: the same in all questions.
        time: later than in the question before [s].
        pressure: at that time; it went there evenly [Pa].
    """

    gripper: Gripper
    time: float
    pressure: float


class MovingTube:
    """The shape of a free tube in time, as new as a background process has it.

    Args:
        gripper: as it really is.
    """

    def __init__(self, gripper: Gripper) -> None:
        self._gripper = gripper
        self._process = WorkerProcess(__name__, "shape in time")
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="tube")
        self._asked: Future[TubeShape] | None = None
        self._shape: TubeShape | None = None

    def follow(self, time: float, pressure: float) -> TubeShape | None:
        """Return the newest shape, at once; None before the first and where none was found.

        Args:
            time: now [s].
            pressure: in the tube now [Pa].
        """
        if self._asked is not None and not self._asked.done():
            return self._shape
        if self._asked is not None:
            error = self._asked.exception()
            self._shape = None if error is not None else self._asked.result()
        question = TubeQuestion(self._gripper, time, pressure)
        self._asked = self._pool.submit(self._process.ask, question)
        return self._shape

    def end(self) -> None:
        """End the process."""
        self._process.end()
        self._pool.shutdown(wait=False, cancel_futures=True)


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
    import_module("spiral_gripper_ros.planning.moving_tube").main()
