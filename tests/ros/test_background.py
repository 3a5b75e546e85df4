# SPDX-License-Identifier: Apache-2.0
"""Questions that wait when a node ends are dropped without a word."""

from __future__ import annotations

import logging
import threading
from unittest.mock import Mock

import pytest
import rclpy.executors

from spiral_gripper_ros.runtime.background import Background


def test_questions_that_wait_when_the_node_ends_are_dropped(
    caplog: pytest.LogCaptureFixture,
) -> None:
    background = Background()
    begun, end = threading.Event(), threading.Event()

    def first() -> None:
        begun.set()
        end.wait(60.0)

    executor = Mock(spec=rclpy.executors.Executor)
    background.plans.ask(executor, first)
    assert begun.wait(60.0)
    with caplog.at_level(logging.ERROR, logger="concurrent.futures"):
        waiting = background.plans.ask(executor, first)
        background.end()
        end.set()
    assert not waiting.done()
    assert not caplog.records
