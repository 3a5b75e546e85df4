# SPDX-License-Identifier: Apache-2.0
"""Handling of exceptions in callbacks: all are logged; those of the control loop also vent.

rclpy drops exceptions of lifecycle callbacks without a log, and an exception in any other callback
ends the executor: neither may happen to a node that holds an object.
"""

from __future__ import annotations

import functools
import traceback
from collections.abc import Awaitable, Callable
from typing import Any, TypeVar, cast

from rclpy.lifecycle import TransitionCallbackReturn

from spiral_core.errors import SpiralError
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.process.guards import CallbackT, guarded
from spiral_gripper_ros.runtime.runtime import Runtime

TOO_LARGE = "the numbers of the request are too large to compute with: SI units are expected"
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


async def answered(
    runtime: Runtime,
    answer: Callable[[LoadedGripper], Awaitable[Any]],
    refuse: Callable[[str, Reason], Any],
) -> Any:  # noqa: ANN401
    """Return what is awaited of the loaded gripper; an exception becomes a refusal, and no vent."""
    try:
        if runtime.loaded is None:
            return refuse(runtime.not_configured, Reason.NOT_ACTIVE)
        return await answer(runtime.loaded)
    except SpiralError as error:
        return refuse(str(error), Reason.INVALID_REQUEST)
    except OverflowError:
        return refuse(TOO_LARGE, Reason.INVALID_REQUEST)
    except Exception as error:
        text = "".join(traceback.format_exception(error))
        runtime.logger.error(f"exception in a service:\n{text}")
        return refuse(f"internal error: {error!r}", Reason.INTERNAL_ERROR)
