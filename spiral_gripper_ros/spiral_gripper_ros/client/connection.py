# SPDX-License-Identifier: Apache-2.0
"""The ROS node of the Python client, spun within the client's calls."""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Callable
from functools import partial
from queue import SimpleQueue
from threading import Thread
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.exceptions import InvalidNamespaceException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.validate_namespace import validate_namespace

from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_positive
from spiral_gripper_ros.client.answers import NoAnswerError, RequestRefusedError

# The executor looks so often whether what it waits for has happened [s].
SPIN_PERIOD = 0.05
# rclpy's own Ctrl-C shuts ROS down a moment before Python raises KeyboardInterrupt [s].
INTERRUPT_DELAY = 0.2
_numbers = itertools.count(1)


class Connection:
    """A node that is spun within calls only; every wait has an end.

    It is spun in a thread of its own while its caller waits: Python's signal handlers run in the
    main thread, and a KeyboardInterrupt in the midst of rclpy's executor leaves entities behind
    that are never looked at again. Measured: after one Ctrl-C of 100 nothing was answered any more.
    The thread serves exit handlers too, which those of :mod:`concurrent.futures` do not; its queues
    are compiled code, which an interrupt cannot leave locked.

    If nobody has initialized rclpy, this does, in a context of its own, for as long as it is open.

    Args:
        namespace: of the node.
        answer_timeout: longest time that a question may take [s], > 0.
        missing: says what is missing when nobody answers.

    Attributes:
        node: the node.
        closed: whether it is closed, for good.
    """

    def __init__(self, namespace: str, answer_timeout: float, missing: Callable[[], str]) -> None:
        self._answer_timeout = require_positive("answer_timeout", answer_timeout)
        self._missing = missing
        try:  # before ROS warns about it
            validate_namespace(f"/{namespace.removeprefix('/')}")
        except (InvalidNamespaceException, AttributeError):
            requirement = 'a ROS namespace: letters, digits and "_", such as "/left"'
            raise InvalidInputError("namespace", namespace, requirement) from None
        self.closed = False
        self._own: Context | None = None
        if not rclpy.ok():
            self._own = Context()
            rclpy.init(context=self._own, signal_handler_options=SignalHandlerOptions.NO)
        name = f"spiral_gripper_client_{os.getpid()}_{next(_numbers)}"
        self.node = Node(name, namespace=namespace, context=self._own)
        self._executor = SingleThreadedExecutor(context=self._own)
        self._executor.add_node(self.node)
        self._asked: SimpleQueue[
            tuple[Callable[[], object], SimpleQueue[BaseException | None]] | None
        ]
        self._asked = SimpleQueue()
        self._spinner = Thread(target=self._spin, name="spiral_gripper_client", daemon=True)
        self._spinner.start()

    def close(self) -> None:
        """Destroy the node; once is enough."""
        if self.closed:
            return
        self.closed = True
        self._asked.put(None)
        self._spinner.join()
        self._executor.shutdown()
        self.node.destroy_node()
        if self._own is not None:
            rclpy.try_shutdown(context=self._own)  # rclpy's Ctrl-C shuts down every context

    def spin_until(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Handle what arrives until a condition holds; return whether it did in time [s]."""
        if self.closed:
            raise RequestRefusedError("the call", "this SpiralGripper is closed")
        deadline = time.monotonic() + timeout
        while not condition():
            remaining = deadline - time.monotonic()
            if not remaining > 0.0:
                return False
            self.run(partial(self._executor.spin_once, min(SPIN_PERIOD, remaining)))
        return True

    def run(self, function: Callable[[], object]) -> None:
        """Call a function in the thread that spins, after what was asked of it before."""
        done: SimpleQueue[BaseException | None] = SimpleQueue()
        self._asked.put((function, done))
        error = done.get()
        if isinstance(error, ExternalShutdownException):
            time.sleep(INTERRUPT_DELAY)
        if error is not None:
            raise error

    def _spin(self) -> None:
        while (asked := self._asked.get()) is not None:
            function, done = asked
            try:
                function()
            except BaseException as error:
                done.put(error)
            else:
                done.put(None)

    def require(self, condition: Callable[[], bool]) -> None:
        """Handle what arrives until a condition holds; raise what is missing if it does not."""
        if not self.spin_until(condition, self._answer_timeout):
            raise NoAnswerError(self._missing(), self._answer_timeout)

    def answer(self, future: Future, name: str, patience: float = 0.0) -> Any:  # noqa: ANN401
        """Return what a future will hold; waits ``patience`` [s] or as for any answer."""
        timeout = max(self._answer_timeout, patience)
        if not self.spin_until(future.done, timeout):
            raise NoAnswerError(f"{name} does not answer", timeout)
        return future.result()

    def call(self, client: Any, request: Any, patience: float = 0.0) -> Any:  # noqa: ANN401
        """Return a service's answer; it may take ``patience`` [s] or the time of any answer."""
        self.require(client.service_is_ready)
        return self.answer(client.call_async(request), client.srv_name, patience)
