# SPDX-License-Identifier: Apache-2.0
"""The loop of the node's process: what escapes from the executor."""

import pytest
from rclpy.executors import ExternalShutdownException

from spiral_gripper_ros.node.guarded_loop import LONGEST_FAILURE, GuardedLoop
from spiral_gripper_ros.node.guards import ErrorLog


class Node:
    """Stands for the node: remembers why it failed."""

    def __init__(self):
        self.failed = []
        self.logged = []
        self.errors = ErrorLog(self)

    def get_logger(self):
        return self

    def error(self, text):
        self.logged.append(text)

    def fail(self, text):
        self.failed.append(text)


class Executor:
    """Raises what it is given, one a turn."""

    def __init__(self, *errors):
        self.errors = list(errors)

    def spin_once(self, timeout_sec):
        error = self.errors.pop(0)
        if error is not None:
            raise error


def test_an_exception_that_escapes_from_the_executor_is_logged_and_not_the_end():
    node = Node()
    loop = GuardedLoop(node, Executor(RuntimeError("the client has gone"), None))
    loop.turn()
    loop.turn()
    assert node.errors.count == 1
    assert not node.failed
    assert "the client has gone" in node.logged[0]
    assert "Traceback" in node.logged[0]


def test_an_executor_that_fails_again_and_again_ends_the_process():
    node = Node()
    errors = [RuntimeError("broken")] * LONGEST_FAILURE
    loop = GuardedLoop(node, Executor(*errors[1:], None, *errors))
    for _ in range(2 * LONGEST_FAILURE - 1):
        loop.turn()
    with pytest.raises(RuntimeError, match="broken"):
        loop.turn()
    assert node.errors.count == 2 * LONGEST_FAILURE - 1
    assert len(node.logged) == 1


def test_a_shutdown_from_outside_is_no_failure():
    node = Node()
    with pytest.raises(ExternalShutdownException):
        GuardedLoop(node, Executor(ExternalShutdownException())).turn()
    assert not node.failed
