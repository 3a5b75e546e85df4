"""Work that takes longer than a callback may: one thread for gravity, one for questions.

Designs take seconds of pure Python, which would keep even another thread from the control loop:
they are computed in a process of their own, started with the first design that is asked for.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any

import rclpy.executors
import rclpy.task

from spiral_core.design.requirement import DesignRequirement
from spiral_gripper_ros.planning.design_question import answer_in_worker, ignore_interrupts


class Background:
    """Two threads and a process: no question delays the commands or a change of gravity."""

    def __init__(self) -> None:
        self.gravity = ThreadPoolExecutor(1, thread_name_prefix="gravity")
        self._questions = ThreadPoolExecutor(1, thread_name_prefix="questions")
        self._designs: ProcessPoolExecutor | None = None

    def ask(
        self, executor: rclpy.executors.Executor, question: Callable[[], Any]
    ) -> rclpy.task.Future:
        """Return a future of rclpy, to be awaited, for the answer of ``question``.

        Args:
            executor: the executor that awaits it; it is woken when the answer is there.
            question: called in the background.
        """
        return _awaitable(executor, self._questions.submit(question))

    def ask_design(
        self, executor: rclpy.executors.Executor, requirement: DesignRequirement
    ) -> rclpy.task.Future:
        """Return a future of rclpy, to be awaited, for the report of a design.

        Args:
            executor: the executor that awaits it.
            requirement: the question.
        """
        try:
            job = self._design_process().submit(answer_in_worker, requirement)
        except BrokenProcessPool:  # somebody has killed it
            self._designs = None
            job = self._design_process().submit(answer_in_worker, requirement)
        return _awaitable(executor, job)

    def _design_process(self) -> ProcessPoolExecutor:
        """Return the process for designs; a fork would copy locks of the middleware's threads."""
        if self._designs is None:
            self._designs = ProcessPoolExecutor(
                1,
                mp_context=multiprocessing.get_context("spawn"),
                initializer=ignore_interrupts,
            )
        return self._designs

    def end(self) -> None:
        """Drop what has not been started; a design that is being computed is cut off."""
        pools: tuple[Executor | None, ...] = (self.gravity, self._questions, self._designs)
        for pool in pools:
            if pool is not None:
                pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.terminate()


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
