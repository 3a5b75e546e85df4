# SPDX-License-Identifier: Apache-2.0
"""Work that takes longer than a callback may: a thread each for gravity, plans and designs."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import rclpy.executors
import rclpy.task

from spiral_core.design.report import DesignReport
from spiral_gripper import GripperDescription
from spiral_gripper_ros.planning.design_question import DesignQuestion
from spiral_gripper_ros.planning.design_worker import DesignProcess


class Background:
    """No question delays the commands, a change of gravity or another kind of question."""

    def __init__(self) -> None:
        self.gravity = ThreadPoolExecutor(1, thread_name_prefix="gravity")
        self._plans = ThreadPoolExecutor(1, thread_name_prefix="plans")
        self._designs = ThreadPoolExecutor(1, thread_name_prefix="designs")
        self._design: DesignProcess | None = None

    def ask(
        self, executor: rclpy.executors.Executor, question: Callable[[], Any]
    ) -> rclpy.task.Future:
        """Return a future of rclpy, to be awaited, for the answer of ``question``.

        Args:
            executor: the executor that awaits it; it is woken when the answer is there.
            question: called in the background.
        """
        return _awaitable(executor, self._plans.submit(question))

    async def design(
        self,
        executor: rclpy.executors.Executor,
        question: DesignQuestion,
        description: GripperDescription,
    ) -> DesignReport:
        """Return the report of a design, computed in a process of its own.

        Args:
            executor: the executor that awaits it.
            question: what is asked.
            description: of the node's gripper, for what the question leaves open.

        Raises:
            SpiralError: the question cannot be answered, or the design was ended.
        """
        process = self._design = DesignProcess()
        job = self._designs.submit(process.answer, question, description)
        try:
            report: DesignReport = await _awaitable(executor, job)
        finally:
            self._design = None
        return report

    def cancel_design(self, why: str) -> bool:
        """End the design that is being computed; return whether there was one."""
        process = self._design
        if process is not None:
            process.end(why)
        return process is not None

    def end(self) -> None:
        """Drop what has not been started; a design that is being computed is cut off."""
        for pool in (self.gravity, self._plans, self._designs):
            pool.shutdown(wait=False, cancel_futures=True)
        self.cancel_design("the node has ended")


def _awaitable(executor: rclpy.executors.Executor, job: Future[Any]) -> rclpy.task.Future:
    """Return a future of rclpy that takes over a job's outcome and wakes the executor."""
    answer = rclpy.task.Future(executor=executor)

    def hand_over(done: Future[Any]) -> None:
        error = done.exception()
        if error is None:
            answer.set_result(done.result())
        else:
            answer.set_exception(error)
        executor.wake()

    job.add_done_callback(hand_over)
    return answer
