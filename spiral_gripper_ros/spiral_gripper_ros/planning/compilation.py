# SPDX-License-Identifier: Apache-2.0
"""Compile the numerical kernels in a separate process, if they are not cached yet. No ROS.

The first compilation of an installation takes some 15 s or more. Inside the node it would block
services and signals for that time.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from importlib import import_module

from spiral_core.wrap.gripper import Gripper
from spiral_gripper import load_gripper
from spiral_gripper.files.catalog import available_grippers
from spiral_gripper.kernels import compile_kernels
from spiral_gripper_ros.planning.planner import GripperPlanner


class Compilation:
    """A process that compiles the kernels; it ends with this process."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__], stdin=subprocess.PIPE, start_new_session=True
        )

    def wait(self, timeout: float) -> bool:
        """Return whether the compilation has ended within a time [s]."""
        try:
            self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            return False
        return True

    def end(self) -> None:
        """End the process, even if it is not done."""
        self._process.kill()
        self._process.wait()
        if self._process.stdin is not None:
            self._process.stdin.close()


def main() -> None:
    """Compile; stop if the process that started this one ends."""
    watch = threading.Thread(target=_compile, daemon=True)
    watch.start()
    # Past Python's own reader: Python aborts at its end if a thread holds that.
    ended = threading.Thread(target=os.read, args=(sys.stdin.fileno(), 1), daemon=True)
    ended.start()
    while watch.is_alive() and ended.is_alive():
        watch.join(0.1)


def _compile() -> None:
    compile_kernels()
    gripper: Gripper = load_gripper(available_grippers()[0])
    GripperPlanner(gripper).warm_up()


if __name__ == "__main__":
    import_module("spiral_gripper_ros.planning.compilation").main()
