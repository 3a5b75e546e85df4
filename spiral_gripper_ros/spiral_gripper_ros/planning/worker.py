# SPDX-License-Identifier: Apache-2.0
"""Computations in a separate process, with lower priority, that can be ended at any time. No ROS.

They take seconds of Python; even in another thread they would delay the control loop.
"""

from __future__ import annotations

import fcntl
import os
import resource
import signal
import sys
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar
from weakref import WeakSet

from spiral_core.errors import SpiralError
from spiral_core.grip.curve import GripCurve, GripQuestion

# The control loop comes first; yet a design ends on a computer whose processors are all in use,
# where a niceness of 19 leaves one part in seventy.
NICENESS = 5
# How often an asker looks whether its answer is still wanted [s].
LOOK = 0.1


class EndedError(SpiralError):
    """A computation has ended without an answer; the message says why."""


class Worker:
    """A process that computes one thing after the other, started with the first of them.

    It holds one end of a pipe and is ended by the kernel once the other, here, is closed: by
    :meth:`end`, or because this process has ended, in whatever way.

    Args:
        what: it computes, for messages.
    """

    def __init__(self, what: str) -> None:
        self._what, self._why = what, ""
        self._asking, self._lock = threading.Lock(), threading.Lock()
        self._pool: ProcessPoolExecutor | None = None
        self._link: Connection | None = None

    def submit(self, function: Callable[..., Any], *arguments: object) -> Future[Any]:
        """Return the future of a function's answer; a process that has died is replaced.

        Raises:
            EndedError: :meth:`end` has been called.
        """
        with self._lock:
            if self._why:
                raise self._ended()
            if self._pool is not None:
                with suppress(BrokenProcessPool):
                    return self._pool.submit(function, *arguments)
            context = get_context("spawn")  # a forked one would copy the locks of threads
            theirs, self._link = context.Pipe(duplex=False)
            self._pool = ProcessPoolExecutor(1, context, _begin, (theirs,))
            # It would run the program's main module again: without a guard a second node.
            main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
            try:
                return self._pool.submit(function, *arguments)
            finally:
                sys.modules["__main__"] = main

    def answer(
        self,
        function: Callable[..., Any],
        *arguments: object,
        is_wanted: Callable[[], bool] = lambda: True,
    ) -> Any:  # noqa: ANN401
        """Return a function's answer; blocks until it is computed, or no longer wanted.

        Args:
            function: what is computed.
            arguments: of the function.
            is_wanted: whether somebody still waits; if not, the process is replaced by a new one.

        Raises:
            SpiralError: there is none, nobody waits, or the process has ended.
        """
        with self._asking:
            unwanted = EndedError(f"no {self._what}: nobody waits for it any more")
            if not is_wanted():
                raise unwanted
            try:
                job = self.submit(function, *arguments)
                while not wait([job], LOOK).done:
                    if not is_wanted():
                        with self._lock:
                            self._stop()
                        self.submit(os.getpid)  # it loads while nothing is asked
                        raise unwanted
                return job.result()
            except (BrokenProcessPool, CancelledError):
                raise self._ended() from None

    def end(self, why: str = "the node has ended") -> None:
        """End the process at once, from any thread; it is not started again."""
        with self._lock:
            self._why = self._why or why
            self._stop()

    def _stop(self) -> None:
        """End the process."""
        if self._pool is not None and self._link is not None:
            self._link.close()
            ending = threading.Thread(target=self._pool.shutdown, kwargs={"cancel_futures": True})
            _ending.add(ending)
            ending.start()
            self._pool = None

    def _ended(self) -> EndedError:
        return EndedError(f"no {self._what}: {self._why or 'its process was killed'}")


# Those that close the pools of processes that were ended.
_ending: WeakSet[threading.Thread] = WeakSet()


def join_ended() -> None:
    """Wait until all that was started for processes that were ended has ended too.

    A program calls it last: a pool that closes while the interpreter ends may be woken just after
    its pipe was closed, and prints a traceback.
    """
    for thread in tuple(_ending):
        thread.join()


class SharedGrips:
    """A node's share in the one process that computes grips for all nodes of this program.

    One process for each of ten nodes would take the processors from their control loops.
    """

    _lock: ClassVar[threading.Lock] = threading.Lock()
    _worker: ClassVar[Worker]
    _users: ClassVar[set[SharedGrips]] = set()

    def __init__(self) -> None:
        with self._lock:
            if not self._users:
                SharedGrips._worker = Worker("grip")
            self._users.add(self)

    def answer(self, question: GripQuestion, is_wanted: Callable[[], bool]) -> GripCurve:
        """Return a grip; blocks until the questions before it are answered.

        Raises:
            SpiralError: see :meth:`Worker.answer`.
        """
        if self not in self._users:
            raise EndedError("no grip: the node has ended")
        figures: GripCurve = self._worker.answer(solve_grip, question, is_wanted=is_wanted)
        return figures

    def end(self) -> None:
        """Release this node's share; the process ends with the last one."""
        with self._lock:
            self._users.discard(self)
            if not self._users:
                self._worker.end()


def _begin(link: Connection) -> None:
    """Prepare the process that computes.

    Linux divides the processor among sessions first, so the session's own niceness is set too.
    """
    _held.append(link)
    # The kernel ends this process when the other end is closed, whatever it computes.
    fcntl.fcntl(link, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(link, fcntl.F_SETFL, fcntl.fcntl(link, fcntl.F_GETFL) | os.O_ASYNC)
    if link.poll():  # closed before that
        os.kill(os.getpid(), signal.SIGKILL)
    os.setsid()  # Ctrl-C reaches every process of a terminal
    os.nice(NICENESS)
    with suppress(OSError):
        Path("/proc/self/autogroup").write_text(str(NICENESS), encoding="ascii")
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


# This process's end of the pipe: were it collected, nothing would end the process.
_held: list[Connection] = []


def solve_grip(question: GripQuestion) -> GripCurve:
    """Return the grip that a question asks for, in seconds.

    Raises:
        SpiralError: the object cannot be held, or a state could not be certified.
    """
    from spiral_core.grip.tabulate import solve_curve  # the node needs none of it

    return solve_curve(question)
