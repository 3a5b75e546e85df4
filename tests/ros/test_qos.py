# SPDX-License-Identifier: Apache-2.0
"""The middleware tells a regulator when commands stop."""

import os
import signal

from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import LivelinessPolicy, QoSProfile
from ros.harness import FAST_RAMP, RunningNode
from std_msgs.msg import Float64

from spiral_gripper_ros.messages.qos import COMMAND_LEASE


# One reader: Fast DDS miscounts what is alive once one of two readers of a process is gone
# (https://github.com/eProsima/Fast-DDS/issues/4610).
def test_a_regulator_is_told_when_a_node_hangs_is_deactivated_or_killed(client, namespace):
    told = []
    client.create_subscription(
        Float64,
        "pressure_command",
        lambda message: None,
        QoSProfile(
            depth=1,
            liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
            liveliness_lease_duration=Duration(seconds=COMMAND_LEASE),
        ),
        event_callbacks=SubscriptionEventCallbacks(
            liveliness=lambda event: told.append(event.alive_count)
        ),
    )

    def wait_for(alive):
        client.wait_until(lambda: told and told[-1] == alive, f"{alive} alive")

    with RunningNode(namespace, {**FAST_RAMP, "publish.rate": 1.0}) as node:
        client.wait_until_active()
        wait_for(1)
        client.pressures.clear()
        client.wait_until(lambda: len(client.pressures) >= 4, "slow commands")
        assert told == [1]  # signs of life
        os.kill(node.process_id, signal.SIGSTOP)
        wait_for(0)
        os.kill(node.process_id, signal.SIGCONT)
        wait_for(1)
        assert client.transition("deactivate")
        wait_for(0)
        assert client.transition("activate")
        wait_for(1)
        node.stop(signal.SIGKILL)
        wait_for(0)
