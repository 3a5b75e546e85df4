# SPDX-License-Identifier: Apache-2.0
"""The free tube in time, computed in a process of its own: it lags behind and swings. No ROS."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module

import numpy as np

from spiral_core import ContactProblem, Frame, Gripper, SpiralError, inertia_of, motion_frames
from spiral_core.grip.setup import FREE_ELEMENTS, free_problem
from spiral_gripper_ros.planning.grip_figures import TubeShape
from spiral_gripper_ros.planning.worker_process import WorkerProcess, serve
from spiral_gripper_ros.simulation.pacing import LONGEST_STEP

MODULE = "spiral_gripper_ros.simulation.moving_tube"


@dataclass(frozen=True, slots=True)
class TubeQuestion:
    """Where a tube is at a time.

    Args:
        gripper: the same in all questions.
        time: of the tube, later than in the question before [s].
        pressure: at that time; it went there evenly [Pa].
    """

    gripper: Gripper
    time: float
    pressure: float


class MovingTube:
    """The shape of a free tube in time, as new as a background process has it.

    The tube has its own time, which passes as the simulation's does while the process keeps up and
    more slowly while it does not: the motion is then shown in slow motion, no part of it is
    skipped.

    Args:
        gripper: as it really is.
        ask: answers a question, blocking; None asks a process that is started for it.
    """

    def __init__(
        self, gripper: Gripper, ask: Callable[[TubeQuestion], TubeShape] | None = None
    ) -> None:
        self._gripper = gripper
        self._process = WorkerProcess(MODULE, "shape in time")
        self._ask = ask or self._process.ask
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="tube")
        self._asked: Future[TubeShape] | None = None
        self._shape: TubeShape | None = None
        self._seen = self._asked_at = self._time = 0.0

    @property
    def is_computing(self) -> bool:
        """Whether the shape that was asked for last is not there yet."""
        return self._asked is not None and not self._asked.done()

    def follow(self, time: float, pressure: float) -> TubeShape | None:
        """Return the newest shape, at once; None before the first and where none was found.

        Args:
            time: of the simulation now [s].
            pressure: in the tube now [Pa].
        """
        period, self._seen = time - self._seen, time
        if self.is_computing:
            return self._shape
        if self._asked is not None:
            error = self._asked.exception()
            self._shape = None if error is not None else self._asked.result()
        self._time += min(time - self._asked_at, max(LONGEST_STEP, period))
        self._asked_at = time
        question = TubeQuestion(self._gripper, self._time, pressure)
        self._asked = self._pool.submit(self._ask, question)
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
        self._way = (self._way[1], (question.time, question.pressure))
        if self._frames is None:
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

        return motion_frames(problem, inertia_of(gripper), times(), elements=FREE_ELEMENTS)


def main() -> None:
    """Move a tube until standard input is closed."""
    serve(SteppedTube().answer)


if __name__ == "__main__":  # by its full name: what it answers is pickled
    import_module(MODULE).main()
