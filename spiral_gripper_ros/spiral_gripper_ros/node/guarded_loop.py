# SPDX-License-Identifier: Apache-2.0
"""The loop of the node's process: exceptions of the executor are logged, the pressure stays."""

from __future__ import annotations

from rclpy.executors import Executor, ExternalShutdownException

from spiral_gripper_ros.runtime.guards import ErrorLog

# How long the executor may sleep before its process looks whether it was asked to stop [s].
LONGEST_SLEEP = 0.05
# After so many exceptions in a row from the executor itself the process ends, vented.
LONGEST_FAILURE = 10


class GuardedLoop:
    """Spins a node; its own callbacks raise nothing, but the middleware may.

    Args:
        errors: where exceptions are noted.
        executor: calls the callbacks of the node.
    """

    def __init__(self, errors: ErrorLog, executor: Executor) -> None:
        self._errors, self._executor = errors, executor
        self._failures = 0  # in a row

    def turn(self) -> None:
        """Wait for something to do, for a moment, and do it.

        Raises:
            Exception: whatever has escaped ``LONGEST_FAILURE`` times in a row.
        """
        try:
            self._executor.spin_once(timeout_sec=LONGEST_SLEEP)
        except ExternalShutdownException:
            raise
        except Exception as error:
            self._errors.note("the executor", error)
            self._failures += 1
            if self._failures >= LONGEST_FAILURE:
                raise
        else:
            self._failures = 0
