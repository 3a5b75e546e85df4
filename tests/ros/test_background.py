# SPDX-License-Identifier: Apache-2.0
"""What the node's process does beside its commands: garbage, escaped exceptions."""

import gc
import weakref
from unittest.mock import Mock

import pytest
from rclpy.executors import ExternalShutdownException

from spiral_gripper_ros.node.garbage import GarbageFreezer
from spiral_gripper_ros.process.guards import LONGEST_FAILURE, ErrorLog, GuardedLoop


class Loaded:
    def __init__(self):
        self.itself = self  # garbage that only a collection finds


def test_what_is_loaded_is_looked_at_once_and_what_was_loaded_before_is_collected():
    memory, loaded = GarbageFreezer(), Loaded()
    try:
        memory.freeze_for(None)
        assert gc.get_freeze_count() == 0
        memory.freeze_for(loaded)
        settled, gone = gc.get_freeze_count(), weakref.ref(loaded)
        assert settled > 1000
        later = [Loaded() for _ in range(10)]
        memory.freeze_for(loaded)
        assert gc.get_freeze_count() <= settled  # what is freed meanwhile counts no more
        loaded = later[0]
        memory.freeze_for(loaded)
        assert gone() is None
    finally:
        gc.unfreeze()


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
