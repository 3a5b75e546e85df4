# SPDX-License-Identifier: Apache-2.0
"""Grips in a separate process, one for all nodes of a program, which ends with them. No ROS.

A grip takes seconds of Python; even in another thread it would delay the control loop. One process
for each of ten nodes would take the processors from their control loops.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from typing import IO, Any, BinaryIO, ClassVar

from spiral_core.errors import SpiralError
from spiral_gripper_ros.planning.design_worker import give_way
from spiral_gripper_ros.planning.grip_figures import GripFigures, GripQuestion, solve_figures


class GripEndedError(SpiralError):
    """The process that computes grips has ended.

    Args:
        why: for people.
    """

    def __init__(self, why: str) -> None:
        super().__init__(f"no grip: {why}")


class WorkerProcess:
    """A process that answers one question after the other, started with the first of them.

    Args:
        module: its program, which calls :func:`serve`.
    """

    def __init__(self, module: str) -> None:
        self._module = module
        self._asking = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._has_ended = False
        self._lock = threading.Lock()

    def ask(self, question: object) -> Any:  # noqa: ANN401
        """Return the answer to a question; blocks until it is computed.

        Raises:
            SpiralError: there is none, or the process has ended.
        """
        with self._asking:
            process = self._started()
            try:
                pickle.dump(question, process.stdin)  # type: ignore[arg-type]
                process.stdin.flush()  # type: ignore[union-attr]
                outcome = pickle.load(process.stdout)  # type: ignore[arg-type]
            except (OSError, EOFError, pickle.UnpicklingError, ValueError):
                self._stop()
                raise GripEndedError("its process has ended") from None
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    def end(self) -> None:
        """End the process at once, from any thread; it is not started again."""
        self._has_ended = True
        self._stop()

    def _started(self) -> subprocess.Popen[bytes]:
        with self._lock:
            if self._has_ended:
                raise GripEndedError("the node has ended")
            if self._process is None:
                self._process = subprocess.Popen(
                    [sys.executable, "-m", self._module],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    start_new_session=True,  # Ctrl-C reaches every process of a terminal
                )
            return self._process

    def _stop(self) -> None:
        with self._lock:
            process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    _close(pipe)


class GripProcess(WorkerProcess):
    """Computes grips, one after the other, in a process that starts with the first question."""

    def __init__(self) -> None:
        super().__init__(__name__)

    def answer(self, question: GripQuestion) -> GripFigures:
        """Return the grip that a question asks for; blocks until it is computed.

        Raises:
            SpiralError: the object cannot be held, a state could not be certified, or the process
                has ended.
        """
        figures: GripFigures = self.ask(question)
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

    def answer(self, question: GripQuestion) -> GripFigures:
        """Return :meth:`GripProcess.answer`; blocks until the questions before it are answered."""
        if self._has_ended:
            raise GripEndedError("the node has ended")
        return self._shared.answer(question)

    def end(self) -> None:
        """Release this node's share; the process ends with the last one."""
        with self._lock:
            if self._has_ended:
                return
            self._has_ended = True
            SharedGripProcess._users -= 1
            if SharedGripProcess._users == 0:
                self._shared.end()


def _close(pipe: IO[bytes]) -> None:
    """Close a pipe whose other end may be gone."""
    with suppress(OSError):
        pipe.close()


def serve(answer: Callable[[Any], object]) -> None:
    """Answer the questions on standard input, on standard output, until that is closed."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever else is printed
    give_way()
    questions: queue.SimpleQueue[object] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(sys.stdin.buffer, questions), daemon=True).start()
    while True:
        pickle.dump(_outcome(answer, questions.get()), answers)
        answers.flush()


def _read(pipe: BinaryIO, questions: queue.SimpleQueue[object]) -> None:
    """Take questions until the process that asks has gone; then end."""
    try:
        while True:
            questions.put(pickle.load(pipe))
    finally:
        os.kill(os.getpid(), signal.SIGKILL)


def _outcome(answer: Callable[[Any], object], question: object) -> object:
    try:
        return answer(question)
    except Exception as error:
        return error


def main() -> None:
    """Compute grips until standard input is closed."""
    serve(solve_figures)


if __name__ == "__main__":  # by its full name: what it answers is pickled
    import_module("spiral_gripper_ros.planning.grip_worker").main()
