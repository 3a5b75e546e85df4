# SPDX-License-Identifier: Apache-2.0
"""Handling of exceptions in callbacks: all are logged; those of the control loop also vent.

rclpy drops exceptions of lifecycle callbacks without a log, and an exception in any other callback
ends the executor: neither may happen to a node that holds an object.
"""

from __future__ import annotations

import functools
import time
import traceback
from collections.abc import Callable
from typing import Any, Protocol, TypeVar, cast

from lifecycle_msgs.srv import ChangeState
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

from spiral_core.errors import SpiralError

# An exception that comes again is logged no more often than this [s].
LOG_PERIOD = 10.0


class ErrorLog:
    """Counts and logs exceptions with their tracebacks; repeated ones at a limited rate.

    Args:
        logger: of the node.
    """

    def __init__(self, logger: Any) -> None:  # noqa: ANN401
        self.count = 0
        self._logger = logger
        self._logged: dict[tuple[str, str], tuple[float, int]] = {}  # when, and count then

    def note(self, where: str, error: Exception) -> None:
        """Count an exception, and log it unless the same was logged a moment ago."""
        self.count += 1
        key, now = (where, type(error).__name__), time.monotonic()
        at, _ = self._logged.get(key, (-LOG_PERIOD, 0))
        if now - at >= LOG_PERIOD:
            self._logged[key] = (now, self.count)
            text = "".join(traceback.format_exception(error))
            self._logger.error(f"exception in {where} ({self.count} in all):\n{text}")


class Guarded(Protocol):
    """The part of a runtime that the guards use."""

    errors: ErrorLog

    def fail(self, text: str) -> None:
        """Vent, and remember why."""
        ...


CallbackT = TypeVar("CallbackT", bound=Callable[..., None])
TransitionT = TypeVar("TransitionT", bound=Callable[..., TransitionCallbackReturn])


def vent_on_error(runtime: Guarded, callback: CallbackT) -> CallbackT:
    """Return a callback of the control loop that logs and vents instead of raising."""

    @functools.wraps(callback)
    def guarded(*args: object) -> None:
        try:
            callback(*args)
        except Exception as error:
            report(runtime, callback.__name__, error)

    return cast("CallbackT", guarded)


def log_on_error(errors: ErrorLog, callback: CallbackT) -> CallbackT:
    """Return a display callback that logs instead of raising; the gripper keeps its pressure."""

    @functools.wraps(callback)
    def guarded(*args: object) -> None:
        try:
            callback(*args)
        except Exception as error:
            errors.note(callback.__name__, error)

    return cast("CallbackT", guarded)


def guarded_transition(callback: TransitionT) -> TransitionT:
    """Return a lifecycle callback that reports why it fails.

    An error of ours (a bad description file, a gripper that cannot coil) is a failure: the node
    stays where it was and may be tried again. Anything else is an error: the node vents and goes
    through error processing to "unconfigured".
    """

    @functools.wraps(callback)
    def guarded(node: Any, *args: object) -> TransitionCallbackReturn:  # noqa: ANN401
        try:
            return callback(node, *args)
        except SpiralError as error:
            node.get_logger().error(f"{callback.__name__}: {error}")
            return TransitionCallbackReturn.FAILURE
        except Exception as error:
            report(node.runtime, callback.__name__, error)
            return TransitionCallbackReturn.ERROR

    return cast("TransitionT", guarded)


def answer_impossible_transitions(node: LifecycleNode) -> None:
    """Let the node refuse a lifecycle transition that its state does not have.

    rclpy raises instead, which would end the executor, and leaves the caller without an answer.
    """
    for service in node.services:
        if service.srv_type is ChangeState:
            service.callback = functools.partial(_change_state, node, service.callback)


def _change_state(node: LifecycleNode, change: Callable[..., Any], *call: Any) -> Any:  # noqa: ANN401
    try:
        return change(*call)
    except rclpy_implementation.RCLError as error:
        node.get_logger().warning(f"lifecycle transition refused: {error}")
        _, response = call
        response.success = False
        return response


def report(runtime: Guarded, where: str, error: Exception) -> None:
    """Log an exception with its traceback, and vent."""
    runtime.errors.note(where, error)
    runtime.fail(f"internal error in {where}: {type(error).__name__}: {error}")
