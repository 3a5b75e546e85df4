# SPDX-License-Identifier: Apache-2.0
"""The loop of the node's process: what escapes from the executor."""

import pytest
from rclpy.executors import ExternalShutdownException

from spiral_gripper_ros.process.guards import LONGEST_FAILURE, ErrorLog, GuardedLoop


class Logger:
    """Remembers what is logged."""

    def __init__(self):
        self.logged = []

    def error(self, text):
        self.logged.append(text)


class Executor:
    """Raises what it is given, one a turn."""

    def __init__(self, *errors):
        self.errors = list(errors)

    def spin_once(self, timeout_sec):
        error = self.errors.pop(0)
        if error is not None:
            raise error


def test_an_exception_that_escapes_from_the_executor_is_logged_and_not_the_end():
    errors = ErrorLog(logger := Logger())
    loop = GuardedLoop(errors, Executor(RuntimeError("the client has gone"), None))
    loop.turn()
    loop.turn()
    assert errors.count == 1
    assert "the client has gone" in logger.logged[0]
    assert "Traceback" in logger.logged[0]


def test_an_executor_that_fails_again_and_again_ends_the_process():
    errors = ErrorLog(logger := Logger())
    failures = [RuntimeError("broken")] * LONGEST_FAILURE
    loop = GuardedLoop(errors, Executor(*failures[1:], None, *failures))
    for _ in range(2 * LONGEST_FAILURE - 1):
        loop.turn()
    with pytest.raises(RuntimeError, match="broken"):
        loop.turn()
    assert errors.count == 2 * LONGEST_FAILURE - 1
    assert len(logger.logged) == 1


def test_a_shutdown_from_outside_is_no_failure():
    errors = ErrorLog(Logger())
    with pytest.raises(ExternalShutdownException):
        GuardedLoop(errors, Executor(ExternalShutdownException())).turn()
    assert errors.count == 0
