"""The entities of some nodes in one wait set, for :mod:`spiral_gripper_ros.node.quick_executor`."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.subscription import Subscription
from rclpy.utilities import timeout_sec_to_nsec
from rclpy.waitable import NumberOfEntities


class WaitedEntities:
    """Everything that can become ready; it is kept from being destroyed until :meth:`close`.

    Args:
        nodes: whose entities.
        guards: guard conditions of the executor.
        context: handle of rclpy's context.
    """

    def __init__(self, nodes: Sequence[Node], guards: Iterable[Any], context: Any) -> None:  # noqa: ANN401
        self._held = ExitStack()
        self._subscriptions = self._hold(s for node in nodes for s in node.subscriptions)
        self._timers = self._hold(t for node in nodes for t in node.timers)
        self._clients = self._hold(c for node in nodes for c in node.clients)
        self._services = self._hold(s for node in nodes for s in node.services)
        self._guards = self._hold(guards)
        self._plain = {
            entity.handle.pointer: entity
            for entity in (*filter(_takes_message_only, self._subscriptions), *self._timers)
            if not inspect.iscoroutinefunction(entity.callback)
        }
        self._waitables: list[Any] = []
        count = NumberOfEntities()
        for waitable in (w for node in nodes for w in node.waitables):
            try:
                self._held.enter_context(waitable)
            except InvalidHandle:
                continue
            self._waitables.append(waitable)
            count += waitable.get_num_entities()
        self._wait_set = rclpy_implementation.WaitSet(
            count.num_subscriptions + len(self._subscriptions),
            count.num_guard_conditions + len(self._guards),
            count.num_timers + len(self._timers),
            count.num_clients + len(self._clients),
            count.num_services + len(self._services),
            count.num_events,
            context,
        )

    def wait(self, timeout_sec: float | None) -> None:
        """Wait until something is ready, at most for a time [s]; None: as long as it takes.

        Raises:
            InvalidHandle: something has been destroyed meanwhile.
        """
        wait_set = self._wait_set
        wait_set.clear_entities()
        for subscription in self._subscriptions:
            wait_set.add_subscription(subscription.handle)
        for timer in self._timers:
            wait_set.add_timer(timer.handle)
        for client in self._clients:
            wait_set.add_client(client.handle)
        for service in self._services:
            wait_set.add_service(service.handle)
        for guard in self._guards:
            wait_set.add_guard_condition(guard.handle)
        for waitable in self._waitables:
            waitable.add_to_wait_set(wait_set)
        wait_set.wait(timeout_sec_to_nsec(timeout_sec))

    def ready_subscriptions(self) -> list[Any]:
        """Return the subscriptions with a message, of those with plain callbacks.

        Such a callback is no coroutine and wants the message only.
        """
        return self._ready("subscription")

    def ready_timers(self) -> list[Any]:
        """Return the timers that are due, of those whose callbacks are no coroutines."""
        return self._ready("timer")

    def close(self) -> None:
        """Let what has been destroyed meanwhile go."""
        self._held.close()

    def _hold(self, entities: Iterable[Any]) -> list[Any]:
        """Return those that still exist, and keep them in existence."""
        held = []
        for entity in entities:
            try:
                self._held.enter_context(entity.handle)
            except InvalidHandle:
                continue
            held.append(entity)
        return held

    def _ready(self, kind: str) -> list[Any]:
        pointers = self._wait_set.get_ready_entities(kind)
        return [self._plain[pointer] for pointer in pointers if pointer in self._plain]


def _takes_message_only(subscription: Subscription) -> bool:
    return subscription._callback_type is Subscription.CallbackType.MessageOnly
