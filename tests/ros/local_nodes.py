# SPDX-License-Identifier: Apache-2.0
"""Nodes in this process: their parameters, what they hear, and what they publish."""

from rclpy.parameter import Parameter
from ros.harness import deliver
from std_msgs.msg import Float64


def parameters(**values):
    """Return parameters of rclpy; the dots of their names are written as two underscores."""
    return [Parameter(name.replace("__", "."), value=value) for name, value in values.items()]


def change(node, **values):
    """Set parameters, none of which may be refused."""
    assert all(result.successful for result in node.set_parameters(parameters(**values)))


def overhear(*nodes):
    """Return what nodes publish from now on, by its topic; no one else hears it."""
    told = {}
    for node in nodes:
        for publisher in node.publishers:
            topic = publisher.topic_name.removeprefix(f"{node.get_namespace()}/")
            publisher.publish = told.setdefault(topic, []).append
    return told


def offer(node, radius=0.02):
    """Let a gripper's node hear a radius [m]."""
    deliver(node, "object_radius", Float64(data=radius))


def state_of(node):
    """Return state and reason of a gripper's node."""
    snapshot = node.runtime.control.snapshot()
    return snapshot.state, snapshot.refusal.reason
