# SPDX-License-Identifier: Apache-2.0
"""What the node's process does beside its commands: questions, garbage, escaped exceptions."""

import gc
import logging
import threading
import weakref
from unittest.mock import Mock

import pytest
import rclpy.executors
from rclpy.executors import ExternalShutdownException

from spiral_gripper_ros.node.garbage import GarbageFreezer
from spiral_gripper_ros.process.guards import LONGEST_FAILURE, ErrorLog, GuardedLoop
from spiral_gripper_ros.runtime.background import Background


def test_questions_that_wait_when_the_node_ends_are_dropped_without_a_word(caplog):
    background = Background()
    begun, end, begun_next = threading.Event(), threading.Event(), threading.Event()

    def first():
        begun.set()
        end.wait(60.0)

    executor = Mock(spec=rclpy.executors.Executor)
    background.plans.ask(executor, first)
    assert begun.wait(60.0)
    with caplog.at_level(logging.ERROR, logger="concurrent.futures"):
        waiting = background.plans.ask(executor, begun_next.set)
        assert not begun_next.wait(0.2)  # one at a time
        background.end()
        end.set()
    assert not waiting.done()
    assert not caplog.records


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
