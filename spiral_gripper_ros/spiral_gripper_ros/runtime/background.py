# SPDX-License-Identifier: Apache-2.0
"""Background threads for long computations: one for each kind of question."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import rclpy.executors
import rclpy.task

from spiral_core.design.report import DesignReport
from spiral_core.design.requirement import DesignRequirement
from spiral_core.errors import SpiralError
from spiral_gripper_ros.planning.design import design
from spiral_gripper_ros.planning.worker import SharedGrips, Worker

# More questions of one kind do not wait: they are answered that the node is busy.
MOST_WAITING = 50


class BusyError(SpiralError):
    """So many questions wait that one more is not taken."""


class QuestionPool(ThreadPoolExecutor):
    """A thread that answers one question after the other; what is too much is refused.

    Args:
        name: of the thread.
    """

    def __init__(self, name: str) -> None:
        super().__init__(1, thread_name_prefix=name)
        self._jobs: list[Future[Any]] = []

    def ask(
        self, executor: rclpy.executors.Executor, question: Callable[[], Any]
    ) -> rclpy.task.Future:
        """Return a future of rclpy, to be awaited, for the answer of ``question``.

        Args:
            executor: the executor that awaits it; it is woken when the answer is there.
            question: called in the background.

        Raises:
            BusyError: ``MOST_WAITING`` questions are not answered yet.
        """
        self._jobs = [job for job in self._jobs if not job.done()]
        if len(self._jobs) >= MOST_WAITING:
            raise BusyError(f"busy: {len(self._jobs)} such questions wait already; ask again later")
        answer = rclpy.task.Future(executor=executor)

        def hand_over(done: Future[Any]) -> None:
            if done.cancelled():  # the node has ended: nobody waits
                return
            error = done.exception()
            if error is None:
                answer.set_result(done.result())
            else:
                answer.set_exception(error)
            executor.wake()

        self._jobs.append(self.submit(question))
        self._jobs[-1].add_done_callback(hand_over)
        return answer


class Background:
    """Background threads; a long question delays neither commands nor other kinds of questions.

    Attributes:
        gravity, plans, exact, batches, approaches, designs, grips: the threads of each kind of
            question.
        solve_grip: returns a grip, in seconds; called in the background.
        has_ended: whether the node has ended; long computations then stop.
    """

    def __init__(self) -> None:
        self.gravity, self.grips = QuestionPool("gravity"), QuestionPool("grips")
        self.plans, self.exact = QuestionPool("plans"), QuestionPool("exact")
        self.batches, self.approaches = QuestionPool("batches"), QuestionPool("approaches")
        self.designs = QuestionPool("designs")
        self._grips_shared = SharedGrips()
        self.solve_grip = self._grips_shared.answer
        self._design: Worker | None = None
        self.has_ended = False

    async def design(
        self,
        executor: rclpy.executors.Executor,
        requirement: Callable[[], DesignRequirement],
    ) -> DesignReport:
        """Return the report of a design, computed in a process of its own.

        Args:
            executor: the executor that awaits it.
            requirement: returns what is asked; called in the background.

        Raises:
            SpiralError: the question cannot be answered, or the design was ended.
        """
        worker = self._design = Worker("design")
        try:
            report: DesignReport = await self.designs.ask(
                executor, lambda: worker.answer(design, requirement())
            )
        finally:
            self._design = None
            worker.end("it is done")
        return report

    def cancel_design(self, why: str) -> bool:
        """End the design that is being computed; return whether there was one."""
        worker = self._design
        if worker is not None:
            worker.end(why)
        return worker is not None

    def end(self) -> None:
        """Drop the waiting questions, and end the running design and batch."""
        self.has_ended = True
        for pool in vars(self).values():
            if isinstance(pool, QuestionPool):
                pool.shutdown(wait=False, cancel_futures=True)
        self._grips_shared.end()
        self.cancel_design("the node has ended")
