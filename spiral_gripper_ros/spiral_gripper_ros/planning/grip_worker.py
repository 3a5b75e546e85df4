# SPDX-License-Identifier: Apache-2.0
"""Grips in a separate process, one for all nodes of a program, which ends with them. No ROS.

One process for each of ten nodes would take the processors from their control loops.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import ClassVar

from spiral_gripper_ros.planning.grip_figures import GripFigures, GripQuestion
from spiral_gripper_ros.planning.worker_process import EndedError, WorkerProcess

# Run as a program, it imports what the node itself does not need.
SOLUTION = "spiral_gripper_ros.planning.grip_solution"


class GripProcess(WorkerProcess):
    """Computes grips, one after the other, in a process that starts with the first question."""

    def __init__(self) -> None:
        super().__init__(SOLUTION, "grip")

    def answer(
        self, question: GripQuestion, is_wanted: Callable[[], bool] = lambda: True
    ) -> GripFigures:
        """Return the grip that a question asks for; blocks until it is computed.

        Args:
            question: what is asked.
            is_wanted: whether somebody still waits.

        Raises:
            SpiralError: the object cannot be held, a state could not be certified, nobody waits,
                or the process has ended.
        """
        figures: GripFigures = self.ask(question, is_wanted)
        return figures


class SharedGripProcess:
    """A node's share in the one process that computes grips for all nodes of this program."""

    _lock: ClassVar[threading.Lock] = threading.Lock()
    _process: ClassVar[GripProcess] = GripProcess()
    _users: ClassVar[int] = 0

    def __init__(self) -> None:
        self._has_ended = False
        with self._lock:
            if SharedGripProcess._users == 0:
                SharedGripProcess._process = GripProcess()
            SharedGripProcess._users += 1
            self._shared = SharedGripProcess._process

    def answer(
        self, question: GripQuestion, is_wanted: Callable[[], bool] = lambda: True
    ) -> GripFigures:
        """Return :meth:`GripProcess.answer`; blocks until the questions before it are answered."""
        if self._has_ended:
            raise EndedError("no grip: the node has ended")
        return self._shared.answer(question, is_wanted)

    def end(self) -> None:
        """Release this node's share; the process ends with the last one."""
        with self._lock:
            if self._has_ended:
                return
            self._has_ended = True
            SharedGripProcess._users -= 1
            if SharedGripProcess._users == 0:
                self._shared.end()
