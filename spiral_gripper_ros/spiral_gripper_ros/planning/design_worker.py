# SPDX-License-Identifier: Apache-2.0
"""Designs in a separate process, with bounded memory and time, that ends with the node. No ROS."""

from __future__ import annotations

import resource
import signal
import sys
from importlib import import_module

from spiral_core.design.procedure import design_gripper
from spiral_core.design.report import DesignReport
from spiral_gripper import GripperDescription
from spiral_gripper_ros.planning.design_question import DesignQuestion, requirement_from_question
from spiral_gripper_ros.planning.worker_process import EndedError, WorkerProcess, serve

# A design with one tube and four angles takes seconds, and half a minute more where kernels are not
# compiled yet; the most processor time that is spent on one [s].
LONGEST_DESIGN = 300
# Memory that numpy, numba and the kernels do not reach by far [bytes].
LARGEST_MEMORY = 2_000_000_000


class DesignProcess(WorkerProcess):
    """One design in a separate process, which ends with this process in every case.

    Args:
        longest: processor time after which it is ended [s].
    """

    def __init__(self, longest: int = LONGEST_DESIGN) -> None:
        super().__init__(__name__, "design", str(longest))
        self._longest = longest

    def answer(self, question: DesignQuestion, description: GripperDescription) -> DesignReport:
        """Return the report of a design; blocks until it is computed.

        Raises:
            SpiralError: the question cannot be answered, or the design was ended.
        """
        try:
            report: DesignReport = self.ask((question, description))
        finally:
            self.end("it is done")
        return report

    def why_ended(self, code: int) -> str:
        """Return why the process has ended by itself, from its exit code."""
        if code == -signal.SIGXCPU:
            return f"not done within {self._longest} s of processor time"
        return super().why_ended(code)


def design(asked: tuple[DesignQuestion, GripperDescription]) -> DesignReport | EndedError:
    """Return the report on a question for the gripper of a description; too little memory too."""
    try:
        return design_gripper(requirement_from_question(*asked))
    except MemoryError:
        return EndedError(f"no design: it needs more than {1e-9 * LARGEST_MEMORY:g} GB of memory")


def main() -> None:
    """Answer the questions on standard input, on standard output."""
    longest = int(sys.argv[1])
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (longest, longest + 1))
    resource.setrlimit(resource.RLIMIT_DATA, (LARGEST_MEMORY, LARGEST_MEMORY))
    serve(design)


if __name__ == "__main__":  # by its full name: what it answers is pickled
    import_module("spiral_gripper_ros.planning.design_worker").main()
