"""An executor that keeps its wait set: for nodes with many entities and messages that are urgent.

rclpy's own executor gathers all entities of all nodes anew for every callback, two or three times
over. With the services, actions and events that a lifecycle node has by itself that takes as long
as to plan a wrap, and ten nodes in one process keep a processor busy with nothing else
(``docs/node_benchmarks.md``).
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.executors import (
    ExternalShutdownException,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
)
from rclpy.node import Node

from spiral_gripper_ros.node.waited_entities import WaitedEntities

# While there is always another message or timer ready, everything else has its turn after so many
# rounds of them.
PATIENCE = 4


class QuickExecutor(SingleThreadedExecutor):  # type: ignore[misc]
    """Calls plain callbacks of subscriptions and timers directly, and leaves the rest to rclpy.

    The wait set is filled from lists that are made anew only when entities come or go. Services,
    actions, events and coroutines go through rclpy's own executor; while a coroutine awaits
    something, everything does. So every rule of callback groups is kept.

    Args:
        options: passed on to rclpy's executor.
    """

    def __init__(self, **options: Any) -> None:  # noqa: ANN401
        super().__init__(**options)
        self._waited: WaitedEntities | None = None
        self._is_outdated = True
        self._rounds = 0  # of messages and timers since everything else had its turn

    def wake(self) -> None:
        """Wake the executor because something has changed, such as the entities of a node."""
        self._is_outdated = True
        super().wake()

    def add_node(self, node: Node) -> bool:
        """Add a node whose callbacks are to be called; return whether it was not there yet."""
        self._is_outdated = True
        return bool(super().add_node(node))

    def remove_node(self, node: Node) -> None:
        """Leave a node alone from now on."""
        self._is_outdated = True
        super().remove_node(node)

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Call nothing any more, and let go of every entity."""
        self._let_go()
        return bool(super().shutdown(timeout_sec))

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait until something is ready, at most for a time [s], and call it.

        Raises:
            ExternalShutdownException: rclpy's context has been shut down.
            Exception: whatever a callback raises.
        """
        if self._is_shutdown or self._must_leave_it_to_rclpy():
            super().spin_once(timeout_sec)
            return
        waited = self._current()
        try:
            waited.wait(timeout_sec)
        except InvalidHandle:  # another thread has destroyed something a moment ago
            self._is_outdated = True
            return
        if not self._context.ok():
            raise ExternalShutdownException
        subscriptions, timers = waited.ready_subscriptions(), waited.ready_timers()
        for subscription in subscriptions:
            _deliver(subscription)
        for timer in timers:
            if timer.handle.is_timer_ready():  # it may have been canceled
                _call(self._take_timer(timer))
        self._rounds += 1
        if self._rounds >= PATIENCE or not (subscriptions or timers):
            self._serve()

    def _must_leave_it_to_rclpy(self) -> bool:
        """Return whether a coroutine has not ended, or a node has guard conditions of its own."""
        with self._tasks_lock:
            is_awaiting = any(not task.done() for task, _, _ in self._tasks)
        return is_awaiting or any(True for node in self.get_nodes() for _ in node.guards)

    def _current(self) -> WaitedEntities:
        """Return what there is to wait for now."""
        if self._waited is None or self._is_outdated:
            self._is_outdated = False  # first: what changes from here on is a change again
            self._let_go()
            own = (self._guard, self._sigint_gc)
            self._waited = WaitedEntities(self.get_nodes(), own, self._context.handle)
        return self._waited

    def _serve(self) -> None:
        """Call everything that is ready, in rclpy's own way."""
        self._rounds = 0
        try:
            while True:
                task, _, _ = self.wait_for_ready_callbacks(0.0)
                task()
                task.result()  # raises what the callback raised
        except (TimeoutException, ShutdownException):
            return  # that was all

    def _let_go(self) -> None:
        waited, self._waited = self._waited, None
        if waited is not None:
            waited.close()


def _deliver(subscription: Any) -> None:  # noqa: ANN401
    """Call the callback of a subscription with its message, unless something took that away."""
    try:
        with subscription.handle:
            taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
    except InvalidHandle:  # a callback before this one has destroyed it
        return
    if taken is not None:
        subscription.callback(taken[0])


def _call(taken: Callable[[], Coroutine[None, None, None]] | None) -> None:
    """Call what rclpy has taken from an entity; None where it is gone or nothing was there."""
    if taken is None:
        return
    try:
        taken().send(None)
    except StopIteration:  # at once: a plain callback awaits nothing
        return
