# SPDX-License-Identifier: Apache-2.0
"""Exceptions of callbacks and of the executor: logged, answered, and not the end of a process."""

from __future__ import annotations

import functools
import time
import traceback
from collections.abc import Callable
from typing import Any, TypeVar, cast

from rcl_interfaces.msg import SetParametersResult
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter

# An exception that comes again is logged no more often than this [s].
LOG_PERIOD = 10.0
# How long the executor may sleep before its process looks whether it was asked to stop [s].
LONGEST_SLEEP = 0.05
# After so many exceptions in a row from the executor itself the process ends, vented.
LONGEST_FAILURE = 10

CallbackT = TypeVar("CallbackT", bound=Callable[..., None])


class ErrorLog:
    """Counts and logs exceptions with their tracebacks; repeated ones at a limited rate.

    Args:
        logger: of the node.
    """

    def __init__(self, logger: Any) -> None:  # noqa: ANN401
        self.count = 0
        self._logger = logger
        self._logged: dict[tuple[str, str], float] = {}

    def note(self, where: str, error: Exception) -> None:
        """Count an exception, and log it unless the same was logged a moment ago."""
        self.count += 1
        if self._is_new(where, error):
            text = "".join(traceback.format_exception(error))
            self._logger.error(f"exception in {where} ({self.count} in all):\n{text}")

    def note_refused(self, where: str, error: Exception) -> None:
        """Log a request that a caller got wrong; it counts as no exception of this process."""
        if self._is_new(where, error):
            self._logger.warning(f"{where} refused: {error}")

    def _is_new(self, where: str, error: Exception) -> bool:
        key, now = (where, type(error).__name__), time.monotonic()
        if now - self._logged.get(key, -LOG_PERIOD) < LOG_PERIOD:
            return False
        self._logged[key] = now
        return True


def guarded(callback: CallbackT, on_error: Callable[[str, Exception], object]) -> CallbackT:
    """Return a callback that has its name and its exception dealt with instead of raising."""

    @functools.wraps(callback)
    def call(*args: object) -> None:
        try:
            callback(*args)
        except Exception as error:
            on_error(callback.__name__, error)

    return cast("CallbackT", call)


def log_on_error(errors: ErrorLog, callback: CallbackT) -> CallbackT:
    """Return a display callback that logs instead of raising; the gripper keeps its pressure."""
    return guarded(callback, errors.note)


def guard_services(node: Node, errors: ErrorLog) -> None:
    """Let the services that rclpy itself serves refuse what it raises at.

    Values of no type and lifecycle transitions that a state does not have would end the executor,
    and leave their callers without an answer.

    Args:
        node: just made; services of its own that come later guard themselves.
        errors: where refusals are logged.
    """
    for service in node.services:
        service.callback = functools.partial(
            _answer, service.callback, errors, service.srv_name.rpartition("/")[2]
        )


def _answer(
    serve: Callable[..., Any],
    errors: ErrorLog,
    name: str,
    request: Any,  # noqa: ANN401
    response: Any,  # noqa: ANN401
) -> Any:  # noqa: ANN401
    is_list = hasattr(response, "results") and hasattr(request, "parameters")
    sets = is_list or isinstance(getattr(response, "result", None), SetParametersResult)
    try:
        for parameter in request.parameters if sets else ():  # all are read before one is set
            Parameter.from_parameter_msg(parameter)
        return serve(request, response)
    except Exception as error:
        errors.note_refused(name, error)
        response = type(response)()  # a transition's has no place for the reason
        if sets:
            refusal = SetParametersResult(successful=False, reason=f"{name} refused: {error}")
            if is_list:
                response.results = [refusal for _ in request.parameters]
            else:
                response.result = refusal
        return response


class GuardedLoop:
    """Spins the nodes of a process; their own callbacks raise nothing, but the middleware may.

    Args:
        errors: where exceptions are noted.
        executor: calls the callbacks of the nodes.
    """

    def __init__(self, errors: ErrorLog, executor: Executor) -> None:
        self._errors, self.executor = errors, executor
        self._failures = 0  # in a row

    def turn(self) -> None:
        """Wait for something to do, for a moment, and do it.

        Raises:
            Exception: whatever has escaped ``LONGEST_FAILURE`` times in a row.
        """
        try:
            self.executor.spin_once(timeout_sec=LONGEST_SLEEP)
        except ExternalShutdownException:
            raise
        except Exception as error:
            self._errors.note("the executor", error)
            self._failures += 1
            if self._failures >= LONGEST_FAILURE:
                raise
        else:
            self._failures = 0
