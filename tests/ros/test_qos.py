# SPDX-License-Identifier: Apache-2.0
"""The middleware tells a regulator when commands stop, and a node what was latched before."""

import os
import signal

import pytest
from geometry_msgs.msg import Vector3, Vector3Stamped
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros.harness import FAST_RAMP, RunningNode
from std_msgs.msg import Float64

from spiral_gripper_ros.messages.qos import COMMAND


# One reader: Fast DDS miscounts what is alive once one of two readers of a process is gone
# (https://github.com/eProsima/Fast-DDS/issues/4610).
def test_a_regulator_is_told_when_a_node_hangs_is_deactivated_or_killed(client, namespace):
    told = []
    client.create_subscription(
        Float64,
        "pressure_command",
        lambda message: None,
        COMMAND,
        event_callbacks=SubscriptionEventCallbacks(
            liveliness=lambda event: told.append(event.alive_count)
        ),
    )

    def wait_for(alive):
        client.wait_until(lambda: told[-1:] == [alive], f"{alive} alive")

    with RunningNode(namespace, {**FAST_RAMP, "publish.rate": 1.0}) as node:
        client.wait_until_active()
        wait_for(1)
        client.pressures.clear()
        client.wait_until(lambda: len(client.pressures) >= 4, "slow commands")
        assert told == [1]  # signs of life
        for act, alive in (
            (lambda: os.kill(node.pid, signal.SIGSTOP), 0),
            (lambda: os.kill(node.pid, signal.SIGCONT), 1),
            (lambda: client.transition("deactivate"), 0),
            (lambda: client.transition("activate"), 1),
            (lambda: node.stop(signal.SIGKILL), 0),
        ):
            act()
            wait_for(alive)


# Where a subscription is incompatible, as the node's other one is, rclpy of Kilted calls a method
# of its own that is deprecated.
@pytest.mark.filterwarnings("ignore:Deprecated in favor of:DeprecationWarning")
def test_gravity_that_was_published_once_before_the_node_started_is_heard(client, namespace):
    gravity = Vector3Stamped(vector=Vector3(z=-9.80665))
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    client.create_publisher(Vector3Stamped, "gravity", latched).publish(gravity)
    with RunningNode(namespace):
        client.wait_until_active()
        given = {"gravity": [gravity.vector]}
        wanted = pytest.approx(client.plan_wrap(0.02, **given).figures[0].pressure, rel=1e-9)
        client.wait_until(lambda: client.plan_wrap(0.02).figures[0].pressure == wanted, "its plan")
