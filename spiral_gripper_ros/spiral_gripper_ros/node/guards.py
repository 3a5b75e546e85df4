"""Decorators that turn an exception in a callback into a log entry with traceback and a state.

rclpy swallows exceptions of lifecycle callbacks without a word, and an exception in any other
callback ends the executor: neither may happen to a node that holds an object.
"""

from __future__ import annotations

import functools
import traceback
from collections.abc import Callable
from typing import Any, Protocol, TypeVar, cast

from lifecycle_msgs.srv import ChangeState
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

from spiral_core.errors import SpiralError


class Guarded(Protocol):
    """What the decorators need of a node."""

    internal_errors: int

    def get_logger(self) -> Any:  # noqa: ANN401
        """Return the node's logger."""
        ...

    def fail(self, text: str) -> None:
        """Vent, and remember why."""
        ...


CallbackT = TypeVar("CallbackT", bound=Callable[..., None])
TransitionT = TypeVar("TransitionT", bound=Callable[..., TransitionCallbackReturn])


def guarded_callback(callback: CallbackT) -> CallbackT:
    """Return a subscription's or timer's callback that vents and logs instead of raising."""

    @functools.wraps(callback)
    def guarded(node: Guarded, *args: object) -> None:
        try:
            callback(node, *args)
        except Exception as error:
            report(node, callback.__name__, error)

    return cast("CallbackT", guarded)


def guarded_transition(callback: TransitionT) -> TransitionT:
    """Return a lifecycle callback that reports why it fails.

    An error of ours (a bad description file, a gripper that cannot coil) is a failure: the node
    stays where it was and may be tried again. Anything else is an error: the node vents and goes
    through error processing to "unconfigured".
    """

    @functools.wraps(callback)
    def guarded(node: Guarded, *args: object) -> TransitionCallbackReturn:
        try:
            return callback(node, *args)
        except SpiralError as error:
            node.get_logger().error(f"{callback.__name__}: {error}")
            return TransitionCallbackReturn.FAILURE
        except Exception as error:
            report(node, callback.__name__, error)
            return TransitionCallbackReturn.ERROR

    return cast("TransitionT", guarded)


def guarded(node: Guarded, callback: Callable[[], None]) -> Callable[[], None]:
    """Return a callback of no arguments that vents and logs instead of raising."""

    def safe() -> None:
        try:
            callback()
        except Exception as error:
            report(node, callback.__name__, error)

    return safe


def harmless(node: Guarded, callback: Callable[[], None]) -> Callable[[], None]:
    """Return a callback that only shows something: its exceptions are logged and do not vent."""

    def safe() -> None:
        try:
            callback()
        except Exception as error:
            node.internal_errors += 1
            _log(node, callback.__name__, error)

    return safe


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


def report(node: Guarded, where: str, error: Exception) -> None:
    """Log an exception with its traceback, and let the node vent."""
    node.internal_errors += 1
    _log(node, where, error)
    node.fail(f"internal error in {where}: {type(error).__name__}: {error}")


def _log(node: Guarded, where: str, error: Exception) -> None:
    node.get_logger().error(f"exception in {where}:\n{''.join(traceback.format_exception(error))}")
