# SPDX-License-Identifier: Apache-2.0
"""A process that answers questions, with a lower priority; it ends with this one. No ROS.

An answer takes seconds of Python; even in another thread it would delay the control loop.
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
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, BinaryIO

from spiral_core.errors import SpiralError

# The control loop comes first; yet a design ends on a computer whose processors are all in use,
# where a niceness of 19 leaves one part in seventy.
NICENESS = 5


# How often an asker looks whether its answer is still wanted [s].
LOOK = 0.1


class EndedError(SpiralError):
    """A computation has ended without an answer; the message says why."""


class WorkerProcess:
    """A process that answers one question after the other, started with the first of them.

    Args:
        module: its program, which calls :func:`serve`.
        what: it computes, for messages.
        arguments: of the program.
    """

    def __init__(self, module: str, what: str, *arguments: str) -> None:
        self._command = [sys.executable, "-m", module, *arguments]
        self._what = what
        self._why = ""
        self._asking = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()

    def ask(self, question: object, is_wanted: Callable[[], bool] = lambda: True) -> Any:  # noqa: ANN401
        """Return the answer to a question; blocks until it is computed, or no longer wanted.

        Args:
            question: to be pickled.
            is_wanted: whether somebody still waits; if not, the process is replaced by a new one.

        Raises:
            SpiralError: there is none, or the process has ended.
        """
        with self._asking:
            if not is_wanted():
                raise self._unwanted()
            process = self._started()
            try:
                pickle.dump(question, process.stdin)  # type: ignore[arg-type]
                process.stdin.flush()  # type: ignore[union-attr]
                while not wait([process.stdout], LOOK):  # type: ignore[list-item]
                    if not is_wanted():
                        self._stop()
                        self._started()  # it loads while nothing is asked
                        raise self._unwanted()
                outcome = pickle.load(process.stdout)  # type: ignore[arg-type]
            except (OSError, EOFError, pickle.UnpicklingError, ValueError):
                self._stop()
                why = self._why or self.why_ended(process.wait())
                raise EndedError(f"no {self._what}: {why}") from None
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    def end(self, why: str = "the node has ended") -> None:
        """End the process at once, from any thread; it is not started again."""
        with self._lock:
            self._why = self._why or why
        self._stop()

    def why_ended(self, code: int) -> str:
        """Return why the process has ended by itself, from its exit code."""
        del code
        return "its process was killed"

    def _unwanted(self) -> EndedError:
        return EndedError(f"no {self._what}: nobody waits for it any more")

    def _started(self) -> subprocess.Popen[bytes]:
        with self._lock:
            if self._why:
                raise EndedError(f"no {self._what}: {self._why}")
            if self._process is None:
                self._process = subprocess.Popen(
                    self._command,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    start_new_session=True,  # Ctrl-C reaches every process of a terminal
                )
            return self._process

    def _stop(self) -> None:
        with self._lock:
            process, self._process = self._process, None
        if process is not None:
            process.kill()  # no effect on one that has ended
            process.wait()
            for pipe in (process.stdin, process.stdout):
                with suppress(OSError):  # its other end may be gone
                    pipe.close()  # type: ignore[union-attr]


def serve(answer: Callable[[Any], object]) -> None:
    """Answer the questions on standard input, on standard output, until that is closed.

    Linux divides the processor among sessions first, so the session's own niceness is set too.
    """
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever else is printed
    os.nice(NICENESS)
    with suppress(OSError):
        Path("/proc/self/autogroup").write_text(str(NICENESS), encoding="ascii")
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
