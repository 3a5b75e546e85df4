# SPDX-License-Identifier: Apache-2.0
"""Handling of exceptions in callbacks: all are logged; those of the control loop also vent.

rclpy drops exceptions of lifecycle callbacks without a log, and an exception in any other callback
ends the executor: neither may happen to a node that holds an object.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar, cast

from rclpy.lifecycle import TransitionCallbackReturn

from spiral_core.errors import SpiralError
from spiral_gripper_ros.process.guards import CallbackT, guarded
from spiral_gripper_ros.runtime.runtime import Runtime

TransitionT = TypeVar("TransitionT", bound=Callable[..., TransitionCallbackReturn])


def vent_on_error(runtime: Runtime, callback: CallbackT) -> CallbackT:
    """Return a callback of the control loop that logs and vents instead of raising."""
    return guarded(callback, functools.partial(report, runtime))


def guarded_transition(callback: TransitionT) -> TransitionT:
    """Return a lifecycle callback that reports why it fails.

    An error of ours (a bad description file, a gripper that cannot coil) is a failure: the node
    stays where it was and may be tried again. Anything else is an error: the node vents and goes
    through error processing to "unconfigured".
    """

    @functools.wraps(callback)
    def call(node: Any, *args: object) -> TransitionCallbackReturn:  # noqa: ANN401
        try:
            return callback(node, *args)
        except SpiralError as error:
            node.get_logger().error(f"{callback.__name__}: {error}")
            return TransitionCallbackReturn.FAILURE
        except Exception as error:
            report(node.runtime, callback.__name__, error)
            return TransitionCallbackReturn.ERROR

    return cast("TransitionT", call)


def report(runtime: Runtime, where: str, error: Exception) -> str:
    """Log an exception with its traceback, vent, and return why."""
    runtime.errors.note(where, error)
    text = f"internal error in {where}: {type(error).__name__}: {error}"
    runtime.fail(text)
    return text
