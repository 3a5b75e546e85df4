# SPDX-License-Identifier: Apache-2.0
"""Qualities of service: what is offered, and that the middleware tells when commands stop."""

import os
import signal

import pytest
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from ros.harness import FAST_RAMP, RunningNode
from std_msgs.msg import Float64

from spiral_gripper_ros.messages.qos import COMMAND_LEASE

LATCHED = (ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = (ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.VOLATILE)


class Watchful:
    """A regulator that asks to be told when its commands stop.

    One at a time: Fast DDS miscounts what is alive once one of two readers of a process is gone
    (https://github.com/eProsima/Fast-DDS/issues/4610).
    """

    def __init__(self, client, kind):
        self.alive = []
        self._client = client
        self._subscription = client.create_subscription(
            Float64,
            "pressure_command",
            lambda message: None,
            QoSProfile(
                depth=1,
                liveliness=kind,
                liveliness_lease_duration=Duration(seconds=COMMAND_LEASE),
            ),
            event_callbacks=SubscriptionEventCallbacks(
                liveliness=lambda event: self.alive.append(event.alive_count)
            ),
        )

    def wait_for(self, alive):
        self._client.wait_until(lambda: self.alive and self.alive[-1] == alive, f"{alive} alive")

    def end(self):
        self._client.destroy_subscription(self._subscription)


@pytest.fixture(params=[LivelinessPolicy.AUTOMATIC, LivelinessPolicy.MANUAL_BY_TOPIC])
def kind(request):
    """The kind of liveliness that a regulator asks for."""
    return request.param


@pytest.fixture
def watchful(active, kind):
    """A regulator that hears the shared node."""
    regulator = Watchful(active, kind)
    regulator.wait_for(1)
    yield regulator
    regulator.end()


def test_a_regulator_is_told_when_a_node_is_deactivated(active, watchful):
    assert active.transition("deactivate")
    watchful.wait_for(0)


def test_a_regulator_is_told_when_a_node_hangs_and_goes_on(shared_node, watchful):
    os.kill(shared_node.process_id, signal.SIGSTOP)
    watchful.wait_for(0)
    os.kill(shared_node.process_id, signal.SIGCONT)
    watchful.wait_for(1)


def test_a_regulator_is_told_when_a_node_is_killed(client, namespace, kind):
    regulator = Watchful(client, kind)
    with RunningNode(namespace, FAST_RAMP) as node:
        client.wait_until_active()
        regulator.wait_for(1)
        node.stop(signal.SIGKILL)
        regulator.wait_for(0)


def test_slow_commands_are_signs_of_life(client, namespace):
    regulator = Watchful(client, LivelinessPolicy.MANUAL_BY_TOPIC)
    with RunningNode(namespace, {"publish.rate": 1.0}):
        client.wait_until_active()
        client.wait_until(lambda: regulator.alive, "the first sign of life")
        client.pressures.clear()
        client.wait_until(lambda: len(client.pressures) >= 4, "some commands")
        assert regulator.alive == [1]


@pytest.mark.parametrize(
    ("topic", "qos"),
    [
        ("pressure_command", (ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)),
        ("status", LATCHED),
        ("wrap", LATCHED),
        ("backbone", LATCHED),
        ("measured_backbone", LATCHED),
        ("markers", LATCHED),
    ],
)
def test_what_is_published_is_reliable_and_all_but_commands_there_for_latecomers(
    active, topic, qos
):
    assert qos_of_the_node(active, active.get_publishers_info_by_topic, topic) == qos


@pytest.mark.parametrize("topic", ["object_radius", "gravity", "measured_pressure"])
def test_what_is_heard_may_be_best_effort(active, topic):
    assert qos_of_the_node(active, active.get_subscriptions_info_by_topic, topic) == BEST_EFFORT


def qos_of_the_node(client, ends, topic):
    """Return reliability and durability of the only end of a topic, once the graph shows it."""
    name = f"{client.get_namespace()}/{topic}"
    client.wait_until(lambda: len(ends(name)) == 1, topic)
    (end,) = ends(name)
    return end.qos_profile.reliability, end.qos_profile.durability
