# SPDX-License-Identifier: Apache-2.0
"""The free tube in time, computed in a process of its own: it lags behind and swings. No ROS."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

from spiral_core.wrap.gripper import Gripper
from spiral_gripper_ros.planning.grip_figures import TubeShape
from spiral_gripper_ros.planning.worker_process import WorkerProcess

# Run as a program, it imports what the process that asks does not need.
MOTION = "spiral_gripper_ros.simulation.tube_motion"


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
        self._process = WorkerProcess(MOTION, "shape in time")
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
