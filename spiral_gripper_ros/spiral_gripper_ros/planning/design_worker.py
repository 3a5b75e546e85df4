# SPDX-License-Identifier: Apache-2.0
"""Designs in a separate process, with bounded memory and time, that ends with the node. No ROS.

A design takes seconds of Python; even in another thread it would delay the control loop.
"""

from __future__ import annotations

import os
import pickle
import resource
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from importlib import import_module
from pathlib import Path

from spiral_core.design.procedure import design_gripper
from spiral_core.design.report import DesignReport
from spiral_core.errors import SpiralError
from spiral_gripper import GripperDescription
from spiral_gripper_ros.planning.design_question import DesignQuestion, requirement_from_question

# A design with one tube and four angles takes seconds, and half a minute more where kernels are not
# compiled yet; the most processor time that is spent on one [s].
LONGEST_DESIGN = 300
# Memory that numpy, numba and the kernels do not reach by far [bytes].
LARGEST_MEMORY = 2_000_000_000
# The control loop comes first; yet a design ends on a computer whose processors are all in use,
# where a niceness of 19 leaves one part in seventy.
NICENESS = 5


class DesignEndedError(SpiralError):
    """A design was ended before it was done.

    Args:
        why: for people.
    """

    def __init__(self, why: str) -> None:
        super().__init__(f"no design: {why}")
        self.why = why

    def __reduce__(self) -> tuple[type[DesignEndedError], tuple[str]]:
        """Let it be pickled."""
        return DesignEndedError, (self.why,)


class DesignProcess:
    """One design in a separate process, which ends with this process in every case.

    Args:
        longest: processor time after which it is ended [s].
    """

    def __init__(self, longest: int = LONGEST_DESIGN) -> None:
        self._longest = longest
        self._why = ""
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()

    def answer(self, question: DesignQuestion, description: GripperDescription) -> DesignReport:
        """Return the report of a design; blocks until it is computed.

        Raises:
            SpiralError: the question cannot be answered, or the design was ended.
        """
        with self._lock:
            if self._why:
                raise DesignEndedError(self._why)
            process = self._process = subprocess.Popen(
                [sys.executable, "-m", __name__, str(self._longest)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C reaches every process of a terminal
            )
        try:
            return self._outcome(process, question, description)
        finally:
            process.kill()
            process.wait()

    def _outcome(
        self,
        process: subprocess.Popen[bytes],
        question: DesignQuestion,
        description: GripperDescription,
    ) -> DesignReport:
        # Its input stays open for as long as the answer is wanted.
        with process.stdin as asked, process.stdout as answered:  # type: ignore[union-attr]
            try:
                pickle.dump((question, description), asked)
                asked.flush()
                outcome = pickle.load(answered)
            except (OSError, EOFError, pickle.UnpicklingError):
                raise DesignEndedError(self._why or self._why_killed(process)) from None
        if isinstance(outcome, Exception):
            raise outcome
        report: DesignReport = outcome
        return report

    def _why_killed(self, process: subprocess.Popen[bytes]) -> str:
        process.kill()  # no effect on one that has ended
        if process.wait() == -signal.SIGXCPU:
            return f"not done within {self._longest} s of processor time"
        return "its process was killed"

    def end(self, why: str) -> None:
        """End the design at once, from any thread."""
        with self._lock:
            self._why = self._why or why
            if self._process is not None:
                self._process.kill()


def give_way() -> None:
    """Lower the priority of this process below that of the control loop.

    Linux divides the processor among sessions first, so the session's own niceness is set too.
    """
    os.nice(NICENESS)
    with suppress(OSError):
        Path("/proc/self/autogroup").write_text(str(NICENESS), encoding="ascii")


def main() -> None:
    """Answer the question on standard input, on standard output."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever else is printed
    give_way()
    longest = int(sys.argv[1])
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (longest, longest + 1))
    resource.setrlimit(resource.RLIMIT_DATA, (LARGEST_MEMORY, LARGEST_MEMORY))
    question, description = pickle.load(sys.stdin.buffer)
    threading.Thread(target=_end_with_parent, args=(sys.stdin.fileno(),), daemon=True).start()
    pickle.dump(_outcome(question, description), answers)
    answers.flush()


def _outcome(question: DesignQuestion, description: GripperDescription) -> DesignReport | Exception:
    try:
        return design_gripper(requirement_from_question(question, description))
    except MemoryError:
        return DesignEndedError(f"it needs more than {1e-9 * LARGEST_MEMORY:g} GB of memory")
    except Exception as error:
        return error


def _end_with_parent(pipe: int) -> None:
    """Wait until the process that asked has gone or no longer wants the answer; then end.

    Past Python's own reader: Python aborts at its end if a thread holds that.
    """
    os.read(pipe, 1)
    os.kill(os.getpid(), signal.SIGKILL)


if __name__ == "__main__":  # by its full name: what it answers is pickled
    import_module("spiral_gripper_ros.planning.design_worker").main()
