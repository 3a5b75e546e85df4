"""The executor: what rclpy's own does, whatever is created, destroyed or awaited meanwhile."""

import threading
import time

import pytest
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from spiral_gripper_ros.node.quick_executor import QuickExecutor

DEADLINE = 30.0


class Spinner:
    """A node on the executor, and another on the same to talk to it."""

    def __init__(self, namespace):
        self.executor = QuickExecutor()
        self.node = Node("served", namespace=namespace)
        self.peer = Node("peer", namespace=namespace)
        self.executor.add_node(self.node)
        self.executor.add_node(self.peer)
        self.heard = []

    def spin_until(self, condition, what="it"):
        end = time.monotonic() + DEADLINE
        while not condition():
            assert time.monotonic() < end, f"not within {DEADLINE} s: {what}"
            self.executor.spin_once(timeout_sec=0.02)

    def spin(self, duration):
        end = time.monotonic() + duration
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.01)

    def hear(self, callback=None, **options):
        """Subscribe, and return a publisher that is connected."""
        heard = callback or (lambda message: self.heard.append(message.data))
        subscription = self.node.create_subscription(Float64, "x", heard, 10, **options)
        publisher = self.peer.create_publisher(Float64, "x", 10)
        self.spin_until(lambda: publisher.get_subscription_count() > 0, "discovery")
        return subscription, publisher

    def serve(self, callback, **options):
        """Serve, and return a client that is connected."""
        self.node.create_service(Trigger, "ask", callback, **options)
        client = self.peer.create_client(Trigger, "ask")
        self.spin_until(client.service_is_ready, "discovery")
        return client

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        self.peer.destroy_node()


@pytest.fixture
def spinner(namespace):
    spinner = Spinner(namespace)
    yield spinner
    spinner.close()


def answer(_, response):
    response.success = True
    return response


def test_messages_timers_and_services_are_served(spinner):
    ticks = []
    spinner.node.create_timer(0.01, lambda: ticks.append(1))
    _, publisher = spinner.hear()
    client = spinner.serve(answer)
    future = client.call_async(Trigger.Request())
    publisher.publish(Float64(data=1.0))
    spinner.spin_until(lambda: future.done() and spinner.heard and len(ticks) > 3)
    assert spinner.heard == [1.0]
    assert future.result().success


def test_a_callback_may_want_to_know_about_its_message(spinner):
    _, publisher = spinner.hear(lambda message, info: spinner.heard.append((message.data, info)))
    publisher.publish(Float64(data=1.0))
    spinner.spin_until(lambda: spinner.heard)
    ((value, info),) = spinner.heard
    assert value == 1.0
    assert info["source_timestamp"] > 0


def test_a_timer_is_called_at_its_rate_and_not_after_it_is_canceled(spinner):
    ticks = []
    timer = spinner.node.create_timer(0.02, lambda: ticks.append(time.monotonic()))
    spinner.spin_until(lambda: len(ticks) == 20)
    assert ticks[-1] - ticks[0] > 0.9 * 19 * 0.02
    timer.cancel()
    spinner.spin(0.1)
    assert len(ticks) == 20


def test_services_are_answered_while_messages_keep_coming(spinner):
    publisher = spinner.peer.create_publisher(Float64, "x", 10)
    spinner.hear(publisher.publish)
    client = spinner.serve(answer)
    publisher.publish(Float64(data=1.0))  # from here on there is always one ready
    for _ in range(20):
        future = client.call_async(Trigger.Request())
        spinner.spin_until(future.done, "an answer")


def test_what_is_created_later_is_served_and_what_is_destroyed_is_not(spinner):
    subscription, publisher = spinner.hear()
    publisher.publish(Float64(data=1.0))
    spinner.spin_until(lambda: spinner.heard == [1.0])
    spinner.node.destroy_subscription(subscription)
    spinner.spin_until(lambda: publisher.get_subscription_count() == 0, "its end")
    publisher.publish(Float64(data=2.0))
    spinner.spin(0.05)
    _, again = spinner.hear()
    again.publish(Float64(data=3.0))
    spinner.spin_until(lambda: spinner.heard[1:] == [3.0])


def test_a_subscription_that_a_callback_destroys_is_not_called_though_it_was_ready_too(spinner):
    def first(message):
        spinner.heard.append(message.data)
        for subscription in subscriptions:
            spinner.node.destroy_subscription(subscription)

    publisher = spinner.peer.create_publisher(Float64, "x", 10)
    subscriptions = [spinner.node.create_subscription(Float64, "x", first, 10) for _ in range(2)]
    spinner.spin_until(lambda: publisher.get_subscription_count() == 2, "discovery")
    publisher.publish(Float64(data=1.0))
    time.sleep(0.1)  # both have it
    spinner.spin_until(lambda: spinner.heard)
    spinner.spin(0.1)
    assert spinner.heard == [1.0]


@pytest.mark.parametrize("end", ["destroy", "cancel"])
def test_what_a_callback_ends_is_not_called_though_it_was_ready_too(spinner, end):
    called = []

    def first():
        called.append(1)
        for timer in timers:
            spinner.node.destroy_timer(timer) if end == "destroy" else timer.cancel()

    timers = [spinner.node.create_timer(0.01, first) for _ in range(3)]
    time.sleep(0.02)  # all are due
    spinner.spin_until(lambda: called)
    spinner.spin(0.1)
    assert called == [1]


def test_a_coroutine_is_awaited_and_wakes_the_executor(spinner):
    async def slow(_, response):
        future = Future(executor=spinner.executor)
        threading.Timer(0.05, lambda: (future.set_result(True), spinner.executor.wake())).start()
        response.success = await future
        return response

    client = spinner.serve(slow)
    future = client.call_async(Trigger.Request())
    spinner.spin_until(future.done, "the answer")
    assert future.result().success


def test_an_awaiting_coroutine_blocks_its_group_and_no_other(spinner):
    gate, waiting = Future(executor=spinner.executor), []

    async def waits(_, response):
        waiting.append(1)
        await gate
        return answer(_, response)

    group = MutuallyExclusiveCallbackGroup()
    client = spinner.serve(waits, callback_group=group)
    others = []
    spinner.node.create_timer(0.01, lambda: others.append(1))
    _, publisher = spinner.hear(callback_group=group)
    future = client.call_async(Trigger.Request())
    spinner.spin_until(lambda: waiting)
    publisher.publish(Float64(data=1.0))
    before = len(others)
    spinner.spin(0.1)
    spinner.spin_until(lambda: len(others) > before)
    assert not spinner.heard
    gate.set_result(True)
    spinner.spin_until(lambda: future.done() and spinner.heard == [1.0])


def test_a_coroutine_may_be_the_callback_of_a_subscription(spinner):
    gate, waiting = Future(executor=spinner.executor), []

    async def hear(message):
        waiting.append(1)
        await gate
        spinner.heard.append(message.data)

    _, publisher = spinner.hear(hear)
    publisher.publish(Float64(data=1.0))
    spinner.spin_until(lambda: waiting)
    spinner.spin(0.05)
    assert not spinner.heard
    gate.set_result(True)
    spinner.spin_until(lambda: spinner.heard == [1.0])


def test_a_guard_condition_of_a_node_wakes_the_executor(spinner):
    called = []
    guard = spinner.node.create_guard_condition(lambda: called.append(1))
    spinner.spin(0.05)
    start = time.monotonic()
    threading.Timer(0.05, guard.trigger).start()
    while not called:
        spinner.executor.spin_once(timeout_sec=DEADLINE)
    assert time.monotonic() - start < 0.5 * DEADLINE


@pytest.mark.parametrize("kind", ["subscription", "service"])
def test_an_exception_in_a_callback_is_raised(spinner, kind):
    def fails(*_):
        raise ValueError("on purpose")

    if kind == "subscription":
        spinner.hear(fails)[1].publish(Float64(data=1.0))
    else:
        spinner.serve(fails).call_async(Trigger.Request())
    with pytest.raises(ValueError, match="on purpose"):
        spinner.spin(DEADLINE)
    ticks = []
    spinner.node.create_timer(0.01, lambda: ticks.append(1))
    spinner.spin_until(lambda: ticks, "what comes after it")


def test_idle_it_sleeps(spinner):
    spinner.hear()
    spinner.spin(0.1)
    busy = time.thread_time()
    for _ in range(5):
        spinner.executor.spin_once(timeout_sec=0.1)
    # Each of the five takes some tenths of a millisecond; a busy loop would take all of the 0.5 s.
    assert time.thread_time() - busy < 0.2


def test_a_node_that_is_removed_is_left_alone(spinner):
    ticks = []
    spinner.node.create_timer(0.01, lambda: ticks.append(1))
    spinner.spin_until(lambda: ticks)
    spinner.executor.remove_node(spinner.node)
    ticks.clear()
    spinner.spin(0.05)
    assert not ticks


def test_a_shutdown_of_rclpy_ends_the_spinning():
    context = rclpy.Context()
    rclpy.init(context=context)
    node = Node("short_lived", context=context)
    executor = QuickExecutor(context=context)
    executor.add_node(node)
    for _ in range(5):  # what was to be done at first is done
        executor.spin_once(timeout_sec=0.0)
    threading.Timer(0.1, context.try_shutdown).start()
    with pytest.raises(ExternalShutdownException):
        executor.spin_once(timeout_sec=DEADLINE)
    executor.shutdown()
    node.destroy_node()
