# SPDX-License-Identifier: Apache-2.0
"""What the node's process does at exceptions that escape."""

from unittest.mock import Mock

import pytest
from rclpy.executors import ExternalShutdownException

from spiral_gripper_ros.process.guards import LONGEST_FAILURE, ErrorLog, GuardedLoop


def test_an_executor_that_fails_is_logged_and_ends_the_process_only_if_it_fails_again_and_again():
    failures, logger = [RuntimeError("broken")] * LONGEST_FAILURE, Mock()
    turns = [*failures[1:], None, ExternalShutdownException(), *failures]
    log = ErrorLog(logger)
    loop = GuardedLoop(log, Mock(spin_once=Mock(side_effect=turns)))
    for end in (ExternalShutdownException, RuntimeError):  # a shutdown from outside is no failure
        for _ in failures[end is RuntimeError :]:
            loop.turn()
        with pytest.raises(end):
            loop.turn()
    assert log.count == 2 * LONGEST_FAILURE - 1
    (told,) = logger.error.call_args.args
    logger.error.assert_called_once()
    assert "Traceback" in told
